//! Reading back the particle snapshots that a run writes: VTK XML PolyData with appended raw blocks.

use std::io::Read;
use std::path::{Path, PathBuf};

use flate2::read::ZlibDecoder;
use sph::space::Vector;

/// What figures need of a snapshot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Snapshot {
    /// Group of each particle: regions first, then walls.
    pub group: Vec<u32>,
    /// Positions \[m\].
    pub position: Vec<Vector>,
    /// Velocities \[m/s\].
    pub velocity: Vec<Vector>,
    /// Pressures \[Pa\].
    pub pressure: Vec<f64>,
    /// Masses per depth \[kg/m\].
    pub mass: Vec<f64>,
    /// Densities \[kg/m³\].
    pub density: Vec<f64>,
}

/// Times \[s\] and files of the collection at `path`.
///
/// # Errors
/// When it cannot be read.
pub fn series(path: &Path) -> Result<Vec<(f64, PathBuf)>, String> {
    let text = std::fs::read_to_string(path).map_err(|e| format!("`{}`: {e}", path.display()))?;
    let folder = path.parent().unwrap_or(Path::new("."));
    text.lines()
        .filter(|line| line.contains("<DataSet"))
        .map(|line| {
            let time = attribute(line, "timestep").and_then(|t| t.parse().ok());
            let file = attribute(line, "file").map(|name| folder.join(name));
            time.zip(file).ok_or_else(|| format!("`{}`: cannot read `{line}`", path.display()))
        })
        .collect()
}

/// A snapshot file whose arrays can be read by name.
pub struct Arrays {
    path: PathBuf,
    header: String,
    data: Vec<u8>,
}

impl Arrays {
    /// Opens the snapshot at `path`.
    ///
    /// # Errors
    /// When it is no snapshot that this program wrote.
    pub fn open(path: &Path) -> Result<Self, String> {
        let bad = |reason: &str| format!("`{}`: {reason}", path.display());
        let bytes = std::fs::read(path).map_err(|e| bad(&e.to_string()))?;
        let mark: &[u8] = b"<AppendedData encoding=\"raw\">\n    _";
        let start =
            bytes.windows(mark.len()).position(|w| w == mark).ok_or_else(|| bad("no appended data"))?;
        Ok(Self {
            path: path.to_path_buf(),
            header: String::from_utf8_lossy(&bytes[..start]).into_owned(),
            data: bytes[start + mark.len()..].to_vec(),
        })
    }

    /// All numbers of the array `name`, particle by particle; vectors have three components.
    ///
    /// # Errors
    /// When there is no such array.
    pub fn numbers(&self, name: &str) -> Result<Vec<f64>, String> {
        Ok(f64s(&self.bytes(name)?))
    }

    /// All whole numbers of the array `name`, such as `group`, particle by particle.
    ///
    /// # Errors
    /// When there is no such array.
    pub fn integers(&self, name: &str) -> Result<Vec<u32>, String> {
        let bytes = self.bytes(name)?;
        Ok(bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect())
    }

    fn bytes(&self, name: &str) -> Result<Vec<u8>, String> {
        let bad = |reason: &str| format!("`{}`: {reason}", self.path.display());
        let quoted = format!("Name=\"{name}\"");
        let line = self.header.lines().find(|line| line.contains(&quoted)).ok_or_else(|| bad(name))?;
        let offset = attribute(line, "offset").and_then(|o| o.parse().ok()).ok_or_else(|| bad(name))?;
        block(&self.data, offset).ok_or_else(|| bad(&format!("array `{name}` is damaged")))
    }
}

impl Snapshot {
    /// Reads the fluid particles of the snapshot at `path`; `regions` is the number of fluid regions.
    ///
    /// # Errors
    /// When it is no snapshot that this program wrote.
    pub fn read(path: &Path, regions: u32) -> Result<Self, String> {
        let arrays = Arrays::open(path)?;
        let vectors = |name: &str| -> Result<Vec<Vector>, String> {
            Ok(arrays.numbers(name)?.chunks(3).map(|x| Vector::new(x[0], x[1])).collect())
        };
        let group = arrays.integers("group")?;
        let fluid = group.iter().filter(|group| **group < regions).count();
        let mut snapshot = Self {
            position: vectors("Points")?,
            velocity: vectors("velocity")?,
            pressure: arrays.numbers("pressure")?,
            mass: arrays.numbers("mass")?,
            density: arrays.numbers("density")?,
            group,
        };
        // The fluid comes first.
        snapshot.group.truncate(fluid);
        snapshot.position.truncate(fluid);
        snapshot.velocity.truncate(fluid);
        snapshot.pressure.truncate(fluid);
        snapshot.mass.truncate(fluid);
        snapshot.density.truncate(fluid);
        Ok(snapshot)
    }
}

fn attribute<'a>(line: &'a str, name: &str) -> Option<&'a str> {
    let (_, rest) = line.split_once(&format!(" {name}=\""))?;
    rest.split_once('"').map(|(value, _)| value)
}

fn u64_at(data: &[u8], at: usize) -> Option<usize> {
    let bytes = data.get(at..at + 8)?.try_into().ok()?;
    usize::try_from(u64::from_le_bytes(bytes)).ok()
}

/// The array at `offset`: number of blocks, block size, size of the last, compressed sizes, blocks.
fn block(data: &[u8], offset: usize) -> Option<Vec<u8>> {
    let blocks = u64_at(data, offset)?;
    let mut at = offset + 8 * (3 + blocks);
    let mut values = Vec::new();
    for k in 0..blocks {
        let size = u64_at(data, offset + 8 * (3 + k))?;
        ZlibDecoder::new(data.get(at..at + size)?).read_to_end(&mut values).ok()?;
        at += size;
    }
    Some(values)
}

fn f64s(bytes: &[u8]) -> Vec<f64> {
    let number = |b: &[u8]| f64::from_le_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]]);
    bytes.chunks_exact(8).map(number).collect()
}

#[cfg(test)]
mod tests {
    use coordinator::results::vtk::write_particles;
    use sph::coupling::solver::{Field, ParticleFields};

    use super::*;

    #[test]
    fn what_a_run_writes_reads_back() {
        let field = |name: &str, components: usize, values: Vec<f64>| Field {
            name: name.into(),
            unit: "x".into(),
            components,
            values,
        };
        let particles = ParticleFields {
            id: vec![0, 1, 2],
            group: vec![0, 1, 2],
            group_names: vec!["a".into(), "b".into(), "wall".into()],
            fields: vec![
                field("position", 2, vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0]),
                field("velocity", 2, vec![0.1, 0.2, 0.3, 0.4, 0.5, 0.6]),
                field("pressure", 1, vec![7.0, 8.0, 9.0]),
                field("mass", 1, vec![1.0, 2.0, 3.0]),
                field("density", 1, vec![4.0, 5.0, 6.0]),
            ],
            ..ParticleFields::default()
        };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("fluid_00000001.vtp");
        write_particles(&path, &particles).unwrap();
        let read = Snapshot::read(&path, 2).unwrap();
        assert_eq!(read.position, [Vector::new(1.0, 2.0), Vector::new(3.0, 4.0)]);
        assert_eq!((read.pressure, read.density), (vec![7.0, 8.0], vec![4.0, 5.0]));
    }
}
