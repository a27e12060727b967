//! Snapshots as VTK XML PolyData (`.vtp`) with one collection (`.pvd`) per side.
//!
//! Arrays are appended raw in one block each, compressed by zlib; positions and vectors have three components with
//! z = 0, as VTK expects. Units stand in the arrays' `UNITS_LABEL`. Format: the VTK user's guide, "VTK XML formats".

use std::fmt::Write as _;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use flate2::Compression;
use flate2::write::ZlibEncoder;
use sph::coupling::solver::{Field, ParticleFields};

use super::error::OutputError;
use super::files::write_file;
use super::names::PARTIAL;
use super::state;

/// Bytes per compressed block: readers hold one at a time.
const BLOCK: usize = 1 << 18;

/// Snapshots of one side, in time order.
#[derive(Debug)]
pub struct Series {
    folder: PathBuf,
    side: String,
    /// File name and time of each complete snapshot.
    files: Vec<(String, f64)>,
}

impl Series {
    /// A series of `side`, `fluid` or `solid`, in `folder`.
    pub fn new(folder: &Path, side: impl ToString) -> Self {
        Self { folder: folder.to_path_buf(), side: side.to_string(), files: Vec::new() }
    }

    /// All complete snapshots.
    pub fn files(&self) -> &[(String, f64)] {
        &self.files
    }

    /// Path of the collection.
    pub fn collection(&self) -> PathBuf {
        self.folder.join(format!("{}.pvd", self.side))
    }

    /// The complete snapshots of steps before `step`.
    pub fn files_before(&self, step: u64) -> Vec<(String, f64)> {
        let bound = file_name(&self.side, step);
        // Names of one side are of one length: they order as their steps do.
        self.files.iter().filter(|(name, _)| *name < bound).cloned().collect()
    }

    /// Those of `files`, the snapshots of an earlier run, that are not there.
    fn missing<'a>(folder: &'a Path, files: &'a [(String, f64)]) -> impl Iterator<Item = &'a str> {
        files.iter().map(|(name, _)| name.as_str()).filter(|name| !folder.join(name).is_file())
    }

    /// That `files`, the snapshots of an earlier run, are there. Nothing is changed.
    ///
    /// # Errors
    /// When one is missing.
    pub fn examine(folder: &Path, files: &[(String, f64)]) -> Result<(), OutputError> {
        Self::missing(folder, files).next().map_or(Ok(()), |name| {
            let reason = "is missing, but was there at the checkpoint; put it back, or add `--accept-changed-outputs` to \
                          continue without the snapshots that are gone";
            Err(OutputError::content(&folder.join(name), reason))
        })
    }

    /// Continues after the snapshots `files` of an earlier run, as far as they are there; what that run wrote later is
    /// removed. Also answers which were not there.
    ///
    /// # Errors
    /// When the folder cannot be written.
    pub fn resume(
        folder: &Path,
        side: impl ToString,
        files: Vec<(String, f64)>,
    ) -> Result<(Self, Vec<String>), OutputError> {
        let missing: Vec<String> = Self::missing(folder, &files).map(String::from).collect();
        let files = files.into_iter().filter(|(name, _)| !missing.contains(name)).collect();
        let series = Self { folder: folder.to_path_buf(), side: side.to_string(), files };
        std::fs::create_dir_all(folder).map_err(|e| OutputError::file("create folder", folder, e))?;
        let failed = |e| OutputError::file("read", folder, e);
        for entry in std::fs::read_dir(folder).map_err(failed)? {
            let entry = entry.map_err(failed)?;
            let name = entry.file_name().to_string_lossy().into_owned();
            let known = series.files.iter().any(|(known, _)| *known == name);
            if is_snapshot_of(&series.side, &name) && !known {
                std::fs::remove_file(entry.path())
                    .map_err(|e| OutputError::file("remove", &entry.path(), e))?;
            }
        }
        if !series.files.is_empty() {
            series.write_collection()?;
        }
        Ok((series, missing))
    }

    /// Writes a snapshot, then the collection with it: at any moment the collection names complete files only.
    ///
    /// # Errors
    /// When a file cannot be written or the arrays of `particles` do not fit each other.
    pub fn write(&mut self, particles: &ParticleFields) -> Result<(), OutputError> {
        write_particles(&self.folder.join(file_name(&self.side, particles.step)), particles)?;
        self.add(particles.step, particles.time)
    }

    /// As [`Series::write`], the file at hand.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn write_bytes(&mut self, step: u64, time: f64, bytes: &[u8]) -> Result<(), OutputError> {
        write_file(&self.folder.join(file_name(&self.side, step)), |file| file.write_all(bytes))?;
        self.add(step, time)
    }

    fn add(&mut self, step: u64, time: f64) -> Result<(), OutputError> {
        let name = file_name(&self.side, step);
        // A run that is stopped at an output boundary reports it twice.
        if self.files.last().is_none_or(|(last, _)| *last != name) {
            self.files.push((name, time));
        }
        self.write_collection()
    }

    fn write_collection(&self) -> Result<(), OutputError> {
        let entry = |(name, time): &(String, f64)| (*time, 0, String::new(), name.clone());
        write_collection(&self.collection(), &self.files.iter().map(entry).collect::<Vec<_>>())
    }
}

/// Writes a collection of files, each with time \[s\], number and name of its part.
///
/// # Errors
/// When it cannot be written.
pub fn write_collection(path: &Path, entries: &[(f64, usize, String, String)]) -> Result<(), OutputError> {
    write_file(path, |file| {
        writeln!(file, "<?xml version=\"1.0\"?>")?;
        writeln!(file, "<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">")?;
        writeln!(file, "  <Collection>")?;
        for (time, part, name, path) in entries {
            let name = if name.is_empty() { String::new() } else { format!(" name=\"{name}\"") };
            writeln!(file, "    <DataSet timestep=\"{time:?}\" part=\"{part}\"{name} file=\"{path}\"/>")?;
        }
        writeln!(file, "  </Collection>")?;
        writeln!(file, "</VTKFile>")
    })
}

/// Files and times of the collection at `path`, as far as it can be read.
pub fn read_collection(path: &Path) -> Vec<(String, f64)> {
    let value = |line: &str, name: &str| {
        let (_, rest) = line.split_once(&format!(" {name}=\""))?;
        rest.split_once('"').map(|(value, _)| value.to_owned())
    };
    let entry = |line: &str| {
        let name = value(line, "file").filter(|name| !name.contains(['/', '\\']))?;
        Some((name, value(line, "timestep")?.parse().ok()?))
    };
    std::fs::read_to_string(path).unwrap_or_default().lines().filter_map(entry).collect()
}

/// Whether `name` is that of the collection or of a complete snapshot of `side`.
pub(super) fn is_of(side: &str, name: &str) -> bool {
    name.strip_prefix(side) == Some(".pvd") || is_snapshot_of(side, name) && !name.ends_with(PARTIAL)
}

fn file_name(side: &str, step: u64) -> String {
    format!("{side}_{step:08}.vtp")
}

/// Whether a run gives `name` to a snapshot of `side`, complete or not.
fn is_snapshot_of(side: &str, name: &str) -> bool {
    let name = name.strip_suffix(PARTIAL).unwrap_or(name);
    let digits = name.strip_prefix(side).and_then(|rest| rest.strip_prefix('_')?.strip_suffix(".vtp"));
    digits.is_some_and(|digits| !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit()))
}

/// Writes `particles` as one `.vtp` file.
///
/// # Errors
/// When the file cannot be written, there is no `position`, or the arrays do not fit each other.
pub fn write_particles(path: &Path, particles: &ParticleFields) -> Result<(), OutputError> {
    let bytes = encoded(particles, true).map_err(|reason| OutputError::content(path, reason))?;
    write_file(path, |file| file.write_all(&bytes))
}

/// The file of `particles` without time and step: that of particles that do not move stays the same.
///
/// # Errors
/// When there is no `position`, or the arrays do not fit each other.
pub fn untimed(particles: &ParticleFields) -> Result<Vec<u8>, String> {
    encoded(particles, false)
}

fn encoded(particles: &ParticleFields, timed: bool) -> Result<Vec<u8>, String> {
    state::check(particles)?;
    let position = particles
        .field("position")
        .filter(|field| (1..=3).contains(&field.components))
        .ok_or("the particles have no `position` of 1 to 3 components")?;
    let mut appended = Appended::default();
    let header = header(particles, position, timed, &mut appended).map_err(|e| e.to_string())?;
    let mut bytes = header.into_bytes();
    bytes.extend(b"  <AppendedData encoding=\"raw\">\n    _");
    bytes.append(&mut appended.bytes);
    bytes.extend(b"\n  </AppendedData>\n</VTKFile>\n");
    Ok(bytes)
}

/// The XML part; fills `appended` with what it refers to.
fn header(
    particles: &ParticleFields,
    position: &Field,
    timed: bool,
    appended: &mut Appended,
) -> io::Result<String> {
    let n = particles.id.len();
    let mut xml = String::new();
    xml.push_str(
        "<?xml version=\"1.0\"?>\n\
         <VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\" \
         compressor=\"vtkZLibDataCompressor\">\n  <PolyData>\n    <FieldData>\n",
    );
    let tuple = "NumberOfTuples=\"1\"";
    if timed {
        let time = appended.add(particles.time.to_le_bytes())?;
        array(&mut xml, "Float64", "TimeValue", tuple, time, "s");
        let step = appended.add(particles.step.to_le_bytes())?;
        array(&mut xml, "UInt64", "step", tuple, step, "");
    }
    // A string array holds the characters' codes, each string closed by 0.
    let _ = write!(
        xml,
        "      <Array type=\"String\" Name=\"group_names\" NumberOfTuples=\"{}\" format=\"ascii\">",
        particles.group_names.len()
    );
    for byte in particles.group_names.iter().flat_map(|name| name.bytes().chain([0])) {
        let _ = write!(xml, " {byte}");
    }
    xml.push_str(" </Array>\n    </FieldData>\n");
    let _ = writeln!(
        xml,
        "    <Piece NumberOfPoints=\"{n}\" NumberOfVerts=\"{n}\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">"
    );
    xml.push_str("      <PointData>\n");
    for (name, numbers) in [("id", &particles.id), ("group", &particles.group)] {
        let offset = appended.add(numbers.iter().flat_map(|number| number.to_le_bytes()))?;
        array(&mut xml, "UInt32", name, "", offset, "");
    }
    for field in particles.fields.iter().filter(|field| field.name != position.name) {
        let offset = appended.add(padded(field))?;
        array(&mut xml, "Float64", &field.name, &components(field), offset, &field.unit);
    }
    xml.push_str("      </PointData>\n      <Points>\n");
    let triples = position
        .values
        .chunks(position.components)
        .flat_map(|x| (0..3).flat_map(|axis| x.get(axis).copied().unwrap_or(0.0).to_le_bytes()));
    let offset = appended.add(triples)?;
    array(&mut xml, "Float64", "Points", "NumberOfComponents=\"3\"", offset, &position.unit);
    xml.push_str("      </Points>\n      <Verts>\n");
    // One vertex per particle: viewers draw cells, not bare points.
    let offset = appended.add((0u64..).take(n).flat_map(u64::to_le_bytes))?;
    array(&mut xml, "Int64", "connectivity", "", offset, "");
    let offset = appended.add((1u64..).take(n).flat_map(u64::to_le_bytes))?;
    array(&mut xml, "Int64", "offsets", "", offset, "");
    xml.push_str("      </Verts>\n    </Piece>\n  </PolyData>\n");
    Ok(xml)
}

/// Values of a field, two components padded to three.
fn padded(field: &Field) -> impl Iterator<Item = u8> {
    let padding: &[f64] = if field.components == 2 { &[0.0] } else { &[] };
    field
        .values
        .chunks(field.components)
        .flat_map(move |values| values.iter().chain(padding))
        .flat_map(|value| value.to_le_bytes())
}

/// Number and, where they are no axes, names of the components.
fn components(field: &Field) -> String {
    let names = if field.components == 3 && field.name.contains("stress") {
        " ComponentName0=\"xx\" ComponentName1=\"yy\" ComponentName2=\"xy\""
    } else {
        ""
    };
    let count = if field.components == 2 { 3 } else { field.components };
    format!("NumberOfComponents=\"{count}\"{names}")
}

/// One `DataArray` element that refers to appended data.
fn array(xml: &mut String, kind: &str, name: &str, attributes: &str, offset: usize, unit: &str) {
    let name = escaped(name);
    let _ = write!(xml, "        <DataArray type=\"{kind}\" Name=\"{name}\" {attributes} ");
    let _ = write!(xml, "format=\"appended\" offset=\"{offset}\"");
    if unit.is_empty() {
        xml.push_str("/>\n");
    } else {
        let key = "InformationKey name=\"UNITS_LABEL\" location=\"vtkDataArray\"";
        let _ = writeln!(xml, "><{key}>{}</InformationKey></DataArray>", escaped(unit));
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Appended data: per array a header of `u64` (blocks, block size, size of a last partial block, compressed sizes)
/// and the compressed blocks.
#[derive(Default)]
struct Appended {
    bytes: Vec<u8>,
    block: Vec<u8>,
}

impl Appended {
    /// Adds an array and returns its offset.
    fn add(&mut self, values: impl IntoIterator<Item = u8>) -> io::Result<usize> {
        let offset = self.bytes.len();
        let mut values = values.into_iter();
        let mut sizes: Vec<usize> = Vec::new();
        let mut compressed = Vec::new();
        let mut last = 0;
        loop {
            self.block.clear();
            self.block.extend(values.by_ref().take(BLOCK));
            if self.block.is_empty() {
                break;
            }
            let before = compressed.len();
            let mut encoder = ZlibEncoder::new(&mut compressed, Compression::fast());
            encoder.write_all(&self.block)?;
            encoder.finish()?;
            sizes.push(compressed.len() - before);
            last = self.block.len();
        }
        let partial = if last == BLOCK { 0 } else { last };
        for number in [sizes.len(), BLOCK, partial].into_iter().chain(sizes) {
            // A usize fits in 64 bits on every platform that Rust supports.
            self.bytes.extend((number as u64).to_le_bytes());
        }
        self.bytes.append(&mut compressed);
        Ok(offset)
    }
}

#[cfg(test)]
mod tests;
