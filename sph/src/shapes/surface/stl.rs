//! Files of the kind STL, binary and in words.

use nalgebra::Vector3;
use thiserror::Error;

use super::Surface;
use super::triangle::Triangle;

/// Bytes of a binary file before its facets, and of each facet.
const HEADER: usize = 84;
const FACET: usize = 50;

/// Bytes in which words of the format are looked for.
const START: usize = 4096;

/// A surface as read from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Stl {
    /// The surface, scaled.
    pub surface: Surface,
    /// Whether the file was binary.
    pub binary: bool,
    /// Names of the solids in a file in words.
    pub solids: Vec<String>,
    /// What the file has that others have not, in words.
    pub remarks: Vec<String>,
}

/// Why a file gives no surface.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum StlError {
    /// No facet.
    #[error("the file holds no facet: export the surface again")]
    Empty,
    /// Neither of both forms.
    #[error(
        "the file is no STL: {length} bytes, neither `solid` with facets in words nor a binary header with facets"
    )]
    Unknown {
        /// Bytes of the file.
        length: usize,
    },
    /// A binary file that ends too early.
    #[error(
        "the file is cut off: its header states {stated} facets, but it holds {held}; copy or export it again"
    )]
    Truncated {
        /// Facets according to the header.
        stated: u64,
        /// Facets in the file.
        held: usize,
    },
    /// A file in words that ends too early.
    #[error("the file is cut off after line {line}: `endsolid` is missing; copy or export it again")]
    Unfinished {
        /// The last line.
        line: usize,
    },
    /// A line that does not belong.
    #[error("line {line}: {problem}")]
    Line {
        /// Its number, from one.
        line: usize,
        /// What is wrong.
        problem: String,
    },
    /// A facet that is none.
    #[error(
        "facet {facet} (byte {byte}) has a coordinate that is no finite number: export the surface again"
    )]
    Number {
        /// Its number, from one.
        facet: usize,
        /// Where it begins.
        byte: usize,
    },
    /// The scale.
    #[error("scale = {scale}: must be a positive finite number, such as 0.001 for a file in millimetres")]
    Scale {
        /// As given.
        scale: String,
    },
    /// What makes no surface.
    #[error("{0}")]
    Surface(String),
}

impl Stl {
    /// Reads the `bytes` of a file whose unit of length is `scale` \[m\].
    ///
    /// A file is binary if its length is that of the facets that it states, whatever its header says.
    ///
    /// # Errors
    /// A file that is cut off, lines or numbers that are none, no facet.
    pub fn read(bytes: &[u8], scale: f64) -> Result<Self, StlError> {
        if !(scale > 0.0 && scale.is_finite()) {
            return Err(StlError::Scale { scale: scale.to_string() });
        }
        let stated =
            bytes.get(HEADER - 4..HEADER).and_then(|count| count.try_into().ok()).map(u32::from_le_bytes);
        let exact =
            stated.is_some_and(|count| bytes.len() as u64 == HEADER as u64 + FACET as u64 * u64::from(count));
        let mut remarks = Vec::new();
        let mut solids = Vec::new();
        let binary = exact && stated != Some(0) || !is_in_words(bytes);
        let corners = if binary {
            let Some(stated) = stated else { return Err(StlError::Unknown { length: bytes.len() }) };
            from_binary(bytes, stated, &mut remarks)?
        } else {
            from_words(bytes, &mut solids)?
        };
        if corners.is_empty() {
            return Err(StlError::Empty);
        }
        let corners: Vec<Triangle> = corners.into_iter().map(|t| t.map(|x| x * scale)).collect();
        let surface = Surface::new(&corners).map_err(StlError::Surface)?;
        Ok(Self { surface, binary, solids, remarks })
    }
}

fn is_in_words(bytes: &[u8]) -> bool {
    let start = String::from_utf8_lossy(&bytes[..bytes.len().min(START)]).to_ascii_lowercase();
    let words = start.trim_start_matches('\u{feff}').trim_start();
    words.starts_with("solid") && (words.contains("facet") || words.contains("endsolid"))
}

fn from_binary(bytes: &[u8], stated: u32, remarks: &mut Vec<String>) -> Result<Vec<Triangle>, StlError> {
    let rest = bytes.len() - HEADER;
    let (held, left) = (rest / FACET, rest % FACET);
    let stated = u64::from(stated);
    let count = if (stated == 0 || stated == u64::from(u32::MAX)) && held > 0 && left == 0 {
        remarks.push(format!("the header states {stated} facets; the {held} that the file holds are read"));
        held
    } else if stated > held as u64 {
        return Err(StlError::Truncated { stated, held });
    } else {
        // No more than are held.
        stated as usize
    };
    let beyond = rest - count * FACET;
    if beyond > 0 {
        remarks.push(format!("{beyond} bytes after the last facet are left out"));
    }
    let mut corners = Vec::with_capacity(count);
    for (k, record) in bytes[HEADER..].chunks_exact(FACET).take(count).enumerate() {
        let number = |i: usize| {
            f64::from(f32::from_le_bytes([record[i], record[i + 1], record[i + 2], record[i + 3]]))
        };
        // The normal comes first; that of the corners is used.
        let corner = |i: usize| Vector3::new(number(i), number(i + 4), number(i + 8));
        let t = [corner(12), corner(24), corner(36)];
        if !t.iter().all(|x| x.iter().all(|coordinate| coordinate.is_finite())) {
            return Err(StlError::Number { facet: k + 1, byte: HEADER + k * FACET });
        }
        corners.push(t);
    }
    Ok(corners)
}

fn from_words(bytes: &[u8], solids: &mut Vec<String>) -> Result<Vec<Triangle>, StlError> {
    let mut corners = Vec::new();
    let mut loop_corners: Vec<Vector3<f64>> = Vec::with_capacity(4);
    let (mut open, mut last) = (false, 0);
    for (k, bytes) in bytes.split(|byte| *byte == b'\n').enumerate() {
        let text = String::from_utf8_lossy(bytes);
        let text = text.trim_start_matches('\u{feff}').trim();
        let wrong = |problem: String| StlError::Line { line: k + 1, problem };
        let mut words = text.split_ascii_whitespace();
        let Some(first) = words.next() else { continue };
        last = k + 1;
        match first.to_ascii_lowercase().as_str() {
            "solid" => {
                open = true;
                solids.push(words.collect::<Vec<_>>().join(" "));
            }
            "endsolid" => open = false,
            "vertex" => loop_corners.push(vertex(words).map_err(wrong)?),
            "endloop" => {
                let Ok(t) = Triangle::try_from(loop_corners.as_slice()) else {
                    return Err(wrong(format!(
                        "the facet has {} corners: make it of triangles",
                        loop_corners.len()
                    )));
                };
                corners.push(t);
                loop_corners.clear();
            }
            "facet" | "outer" | "endfacet" => {}
            other => {
                let shown: String = other.chars().take(20).collect();
                return Err(wrong(format!("`{shown}` is no word of the format")));
            }
        }
    }
    if open || !loop_corners.is_empty() {
        return Err(StlError::Unfinished { line: last });
    }
    Ok(corners)
}

fn vertex<'a>(mut words: impl Iterator<Item = &'a str>) -> Result<Vector3<f64>, String> {
    let mut x = Vector3::zeros();
    for axis in 0..3 {
        let word = words.next().ok_or_else(|| "a vertex needs three coordinates".to_owned())?;
        let shown: String = word.chars().take(20).collect();
        let value: f64 = word.parse().map_err(|_| format!("the coordinate `{shown}` is no number"))?;
        if !value.is_finite() {
            return Err(format!("the coordinate `{shown}` is no finite number: export the surface again"));
        }
        x[axis] = value;
    }
    Ok(x)
}
