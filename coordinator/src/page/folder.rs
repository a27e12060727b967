//! What the folder of a run holds, finished or running: its case, its snapshots, who broke down.

use std::io::Read;
use std::path::{Path, PathBuf};

use sph::coupling::solver::ParticleFields;

use super::particles::{Group, Particles, SOURCES};
use super::vtp;
use crate::results::files::open_regular;
use crate::results::names;
use crate::results::plots::projection::up_axis;
use crate::results::table::Table;

/// Longest text that is read: a case with inline shapes, a collection of many snapshots \[bytes\].
const LONGEST_TEXT: u64 = 64 << 20;
/// Collections of a folder; walls may have one of their own.
const COLLECTIONS: [&str; 3] = ["fluid.pvd", "solid.pvd", "walls.pvd"];

/// What the page needs of the case of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CaseFacts {
    /// Title.
    pub title: String,
    /// Number of dimensions.
    pub dimensions: usize,
    /// Axis that points against gravity.
    pub up_axis: usize,
    /// Names of walls.
    pub walls: Vec<String>,
    /// Particle spacings of fluid and solids \[m\].
    pub spacings: [Option<f64>; 2],
    /// Start and end \[s\].
    pub span: [f64; 2],
    /// Largest imbalance that the case allows \[-\].
    pub tolerance: Option<f64>,
}

impl CaseFacts {
    /// Of a case as resolved.
    ///
    /// # Errors
    /// When it is no TOML.
    pub fn of(resolved: &str) -> Result<Self, String> {
        let case: toml::Table = resolved.parse().map_err(|e: toml::de::Error| e.message().to_owned())?;
        let table = |name: &str| case.get(name).and_then(toml::Value::as_table);
        let number = |value: &toml::Value| value.as_float().or_else(|| value.as_integer().map(|n| n as f64));
        let get = |of: &str, key: &str| table(of).and_then(|t| t.get(key)).and_then(number);
        let gravity: Vec<f64> = table("body_force")
            .and_then(|t| t.get("gravity_m_s2")?.as_array())
            .map_or_else(Vec::new, |list| list.iter().filter_map(number).collect());
        let corner = table("domain").and_then(|t| t.get("lower_m")?.as_array());
        let walls = case.get("wall").and_then(toml::Value::as_array).map_or_else(Vec::new, |walls| {
            walls.iter().filter_map(|wall| Some(wall.get("name")?.as_str()?.to_owned())).collect()
        });
        Ok(Self {
            title: case.get("name").and_then(toml::Value::as_str).unwrap_or("run").to_owned(),
            dimensions: corner.map_or(2, Vec::len),
            up_axis: up_axis(&gravity),
            walls,
            spacings: ["fluid", "solid"].map(|side| get(side, "particle_spacing_m")),
            span: ["start_time_s", "end_time_s"].map(|key| get("time", key).unwrap_or(0.0)),
            tolerance: get("ledger", "balance_tolerance")
                .filter(|_| case.contains_key("fluid") && case.contains_key("solid")),
        })
    }

    /// Of the run in `folder`.
    ///
    /// # Errors
    /// When it holds no case.
    pub fn read(folder: &Path) -> Result<Self, String> {
        let text = text(&folder.join(names::CASE))?;
        Self::of(&text)
    }
}

/// The text of a file.
///
/// # Errors
/// When it cannot be read, or is too long for what it is.
pub fn text(path: &Path) -> Result<String, String> {
    let failed = |e: std::io::Error| format!("cannot read `{}`: {e}", path.display());
    let mut text = String::new();
    let (file, length) = open_regular(path).map_err(failed)?;
    if length > LONGEST_TEXT {
        return Err(format!("`{}` is longer than {} MiB", path.display(), LONGEST_TEXT >> 20));
    }
    file.take(LONGEST_TEXT).read_to_string(&mut text).map_err(failed)?;
    Ok(text)
}

/// Snapshots of one time.
#[derive(Clone, Debug, PartialEq)]
pub struct Moment {
    /// Time \[s\].
    pub time: f64,
    /// File of the fluid, of the solids and of the walls: that of this time, else the last before it.
    files: [Option<String>; 3],
}

/// The snapshots of a folder, in time order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Snapshots {
    folder: PathBuf,
    /// Their times.
    pub moments: Vec<Moment>,
}

impl Snapshots {
    /// Those that the collections of the run in `folder` name. While it `is_running`, a time that one side has not reached
    /// is left out.
    pub fn list(folder: &Path, is_running: bool) -> Self {
        let folder = folder.join(names::SNAPSHOTS);
        let sides = COLLECTIONS.map(|name| collection(&folder.join(name)));
        let mut times: Vec<f64> = sides[..2].iter().flatten().map(|(time, _)| *time).collect();
        times.sort_by(f64::total_cmp);
        times.dedup();
        let at = |time: f64| Moment {
            time,
            files: sides.each_ref().map(|side| {
                let count = side.partition_point(|(other, _)| *other <= time);
                side.get(count.saturating_sub(1)).filter(|_| count > 0).map(|(_, name)| name.clone())
            }),
        };
        let reached = |time: &f64| {
            let mut present = sides[..2].iter().filter(|side| !side.is_empty());
            present.all(|side| side.last().is_some_and(|(last, _)| last >= time))
        };
        let moments = times.into_iter().filter(|time| !is_running || reached(time)).map(at).collect();
        Self { folder, moments }
    }

    /// The files of a moment: each with whether it is of the solids; of the walls all groups are walls.
    fn read_files(&self, moment: &Moment) -> Result<Vec<(ParticleFields, usize)>, String> {
        let mut list = Vec::new();
        for (k, name) in moment.files.iter().enumerate() {
            let Some(name) = name else { continue };
            let path = self.folder.join(name);
            let fields = vtp::read(&path, &SOURCES).map_err(|why| format!("`{}`: {why}", path.display()))?;
            list.push((fields, k));
        }
        Ok(list)
    }

    /// The particles of a moment, about one in `every`, and what `look` sees of all of them first.
    ///
    /// # Errors
    /// When a file cannot be read.
    pub fn read(
        &self,
        moment: &Moment,
        walls: &[String],
        groups: &mut Vec<Group>,
        every: u32,
        mut look: impl FnMut(&ParticleFields, bool),
    ) -> Result<Particles, String> {
        let mut particles = Particles { time: moment.time, ..Particles::default() };
        for (mut fields, k) in self.read_files(moment)? {
            if k == 2 {
                particles.add(&fields, false, &fields.group_names, groups, every);
                continue;
            }
            particles.step = particles.step.max(fields.step);
            // In the plane all files have z = 0.
            let is_solid = k == 1;
            look(&fields, is_solid);
            particles.add(&fields, is_solid, walls, groups, every);
            fields.fields.clear();
        }
        particles.sort();
        Ok(particles)
    }
}

/// File names and times of a collection, in time order; empty where there is none.
fn collection(path: &Path) -> Vec<(f64, String)> {
    let text = text(path).unwrap_or_default();
    let value = |line: &str, name: &str| Some(line.split(name).nth(1)?.split('"').nth(1)?.to_owned());
    let entry = |line: &str| {
        let (time, file) = (value(line, "timestep=")?.parse().ok()?, value(line, "file=")?);
        // Files beside the collection only.
        let is_plain = !file.contains(['/', '\\']) && file.ends_with(".vtp");
        is_plain.then_some((time, file))
    };
    let mut list: Vec<(f64, String)> =
        text.lines().filter(|line| line.contains("<DataSet")).filter_map(entry).collect();
    list.sort_by(|a, b| a.0.total_cmp(&b.0));
    list
}

/// The particle that ended a run.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Culprit {
    /// Its id.
    pub id: u32,
    /// Where it was \[m\].
    pub position: Vec<f64>,
}

/// The particle that broke down in the run of `folder`, if one did.
pub fn culprit(folder: &Path) -> Option<Culprit> {
    let table = Table::read(&folder.join(names::DIVERGENCE)).ok()?;
    let first = |name: &str| table.column(name)?.first().copied();
    let axes = ["position_0_m", "position_1_m", "position_2_m"];
    let position: Vec<f64> = axes.iter().map_while(|name| first(name)).collect();
    // Ids are whole numbers far below 2^32.
    Some(Culprit { id: first("id")? as u32, position })
}

/// Whether a run writes into `folder`, or was killed while it did.
pub fn is_unfinished(folder: &Path) -> bool {
    folder.join(names::MARKER).exists()
}
