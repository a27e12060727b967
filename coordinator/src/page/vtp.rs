//! Reads the particle files that `results::vtk` writes; nothing else need be readable.

use std::io::Read;
use std::path::Path;

use flate2::read::ZlibDecoder;
use sph::coupling::solver::{Field, ParticleFields};

use crate::results::files::open_regular;

/// Longest file that is read \[bytes\].
const LONGEST: u64 = 4 << 30;
/// Most particles in a file.
const MOST_PARTICLES: usize = 50_000_000;
/// Longest text before the data \[bytes\].
const LONGEST_HEADER: usize = 1 << 20;

/// An array of a file: what its element says of it.
#[derive(Debug)]
struct Entry<'a> {
    kind: &'a str,
    name: &'a str,
    components: usize,
    unit: &'a str,
    offset: usize,
}

/// The particles of the file at `path`, with `position` and those of `wanted` that it has. Vectors have three components.
///
/// # Errors
/// In words, when it cannot be read or is no such file.
pub fn read(path: &Path, wanted: &[&str]) -> Result<ParticleFields, String> {
    let mut bytes = Vec::new();
    let (file, length) = open_regular(path).map_err(|e| e.to_string())?;
    if length > LONGEST {
        return Err(format!("it is longer than {} GiB", LONGEST >> 30));
    }
    file.take(LONGEST).read_to_end(&mut bytes).map_err(|e| e.to_string())?;
    parse(&bytes, wanted)
}

/// As [`read`], of the content of a file.
///
/// # Errors
/// In words, when it is no such file.
pub fn parse(bytes: &[u8], wanted: &[&str]) -> Result<ParticleFields, String> {
    const MARK: &[u8] = b"<AppendedData encoding=\"raw\">";
    let head = &bytes[..bytes.len().min(LONGEST_HEADER)];
    let mark =
        head.windows(MARK.len()).position(|window| window == MARK).ok_or("it holds no appended data")?;
    let xml = std::str::from_utf8(&bytes[..mark]).map_err(|_| "its header is no text")?;
    let rest = &bytes[mark + MARK.len()..];
    let start =
        rest.iter().take(64).position(|byte| *byte == b'_').ok_or("its appended data do not begin")?;
    let data = &rest[start + 1..];
    let n: usize = attribute(xml, "NumberOfPoints").and_then(|n| n.parse().ok()).ok_or("it has no points")?;
    if n > MOST_PARTICLES {
        return Err(format!("it holds more than {MOST_PARTICLES} particles"));
    }
    let entries: Vec<Entry> = xml.split("<DataArray ").skip(1).filter_map(entry).collect();
    let find = |name: &str| entries.iter().find(|entry| entry.name == name);
    let numbers = |name: &str, width: usize, count: usize| -> Result<Vec<u8>, String> {
        let entry = find(name).ok_or_else(|| format!("it has no array `{name}`"))?;
        array(data, entry.offset, count.saturating_mul(width)).map_err(|why| format!("array `{name}`: {why}"))
    };
    let whole = |name: &str| -> Result<Vec<u32>, String> {
        Ok(numbers(name, 4, n)?.as_chunks::<4>().0.iter().map(|b| u32::from_le_bytes(*b)).collect())
    };
    // Walls that stand have one file for all times.
    let at = |name: &str| find(name).map_or(Ok(Vec::new()), |_| numbers(name, 8, 1));
    let (time, step) = (at("TimeValue")?, at("step")?);
    let mut fields = Vec::new();
    for entry in &entries {
        let name = if entry.name == "Points" { "position" } else { entry.name };
        if entry.kind != "Float64" || !(name == "position" || wanted.contains(&name)) {
            continue;
        }
        let values = numbers(entry.name, 8, n.saturating_mul(entry.components))?;
        fields.push(Field {
            name: name.to_owned(),
            unit: entry.unit.to_owned(),
            components: entry.components,
            values: doubles(&values),
        });
    }
    let particles = ParticleFields {
        step: step.first_chunk().map_or(0, |b| u64::from_le_bytes(*b)),
        time: time.first_chunk().map_or(0.0, |b| f64::from_le_bytes(*b)),
        id: whole("id")?,
        group: whole("group")?,
        group_names: group_names(xml),
        fields,
    };
    if particles.field("position").is_none() { Err("it has no positions".into()) } else { Ok(particles) }
}

fn doubles(bytes: &[u8]) -> Vec<f64> {
    bytes.as_chunks::<8>().0.iter().map(|b| f64::from_le_bytes(*b)).collect()
}

/// Value of an attribute, the first of that name.
fn attribute<'a>(text: &'a str, name: &str) -> Option<&'a str> {
    let mut rest = text;
    loop {
        let at = rest.find(name)?;
        let (before, after) = (&rest[..at], &rest[at + name.len()..]);
        let begins = before.is_empty() || before.ends_with([' ', '\n']);
        if let Some(value) = after.strip_prefix("=\"").filter(|_| begins) {
            return value.split('"').next();
        }
        rest = after;
    }
}

/// What follows `<DataArray `.
fn entry(text: &str) -> Option<Entry<'_>> {
    let head = text.split('>').next()?;
    let unit = text.split("UNITS_LABEL").nth(1).and_then(|rest| rest.split('>').nth(1)?.split('<').next());
    // A vector stands for itself; what has no number of components has one.
    let components = attribute(head, "NumberOfComponents").map_or(Some(1), |c| c.parse().ok())?;
    Some(Entry {
        kind: attribute(head, "type")?,
        name: attribute(head, "Name")?,
        components: Some(components).filter(|c| (1..=9).contains(c))?,
        unit: unit.unwrap_or(""),
        offset: attribute(head, "offset")?.parse().ok()?,
    })
}

/// Names, each closed by 0, as the codes of their characters.
fn group_names(xml: &str) -> Vec<String> {
    let codes =
        xml.split("Name=\"group_names\"").nth(1).and_then(|rest| rest.split('>').nth(1)?.split('<').next());
    let bytes: Vec<u8> =
        codes.unwrap_or("").split_whitespace().filter_map(|code| code.parse().ok()).collect();
    let names = bytes.strip_suffix(&[0]).unwrap_or(&bytes).split(|byte| *byte == 0);
    names.map(|name| String::from_utf8_lossy(name).into_owned()).collect()
}

/// An array of `length` bytes: a header of `u64` and compressed blocks.
fn array(data: &[u8], offset: usize, length: usize) -> Result<Vec<u8>, String> {
    const SHORT: &str = "the file ends before it";
    let word = |at: usize| -> Result<usize, String> {
        let bytes = data.get(at..).and_then(|rest| rest.first_chunk::<8>()).ok_or(SHORT)?;
        usize::try_from(u64::from_le_bytes(*bytes)).map_err(|_| SHORT.to_owned())
    };
    let blocks = word(offset)?;
    if blocks > data.len() {
        return Err(SHORT.into());
    }
    let mut at = offset.saturating_add(24).saturating_add(blocks.saturating_mul(8));
    let mut bytes = Vec::new();
    for k in 0..blocks {
        let size = word(offset + 24 + 8 * k)?;
        let block = data.get(at..at.saturating_add(size)).ok_or(SHORT)?;
        // No more than what must be there, whatever the block claims.
        let room = length.saturating_sub(bytes.len()) as u64;
        ZlibDecoder::new(block).take(room + 1).read_to_end(&mut bytes).map_err(|e| e.to_string())?;
        at += size;
    }
    if bytes.len() == length { Ok(bytes) } else { Err(format!("{} bytes in place of {length}", bytes.len())) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::vtk::write_particles;

    #[test]
    fn what_a_run_writes_is_read_back_and_damage_is_no_panic() {
        let field = |name: &str, unit: &str, components, values| Field {
            name: name.into(),
            unit: unit.into(),
            components,
            values,
        };
        let state = ParticleFields {
            step: 7,
            time: 0.25,
            id: vec![3, 9],
            group: vec![1, 0],
            group_names: vec!["water".into(), "tänk".into()],
            fields: vec![
                field("position", "m", 2, vec![0.1, 0.2, 0.3, f64::NAN]),
                field("velocity", "m/s", 2, vec![1.0, 2.0, 3.0, 4.0]),
                field("pressure", "Pa", 1, vec![-5.0, 6.0]),
                field("mass", "kg/m", 1, vec![1.0, 1.0]),
            ],
        };
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("fluid_00000007.vtp");
        write_particles(&path, &state).unwrap();
        let read = read(&path, &["pressure", "velocity", "nothing"]).unwrap();
        assert_eq!((read.step, read.time, &read.id, &read.group), (7, 0.25, &state.id, &state.group));
        assert_eq!(read.group_names, state.group_names);
        assert_eq!(read.field("velocity").unwrap().values, [1.0, 2.0, 0.0, 3.0, 4.0, 0.0]);
        assert_eq!(read.field("pressure").unwrap(), &state.fields[2]);
        assert!(read.field("mass").is_none());
        assert!(read.field("position").unwrap().values[4].is_nan());
        let bytes = std::fs::read(&path).unwrap();
        for cut in 0..bytes.len() {
            drop(parse(&bytes[..cut], &["pressure"]));
        }
        for place in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[place] ^= 0x55;
            drop(parse(&damaged, &["pressure"]));
        }
    }
}
