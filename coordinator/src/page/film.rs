//! All frames of a run as one report can hold: thinned and quantised to a stated size.

use flate2::Compression;
use rayon::prelude::*;
use serde::Serialize;
use sph::coupling::solver::ParticleFields;

use super::folder::{CaseFacts, Moment, Snapshots};
use super::packing::{Column, Packer, as_text, columns};
use super::particles::{Group, Matter, Particles, Slot};
use super::scene::Scene;

/// Largest size of all frames as text of a page \[bytes\].
pub const LARGEST: usize = 12_000_000;
/// Most frames; of more, every second, third … is shown.
const MOST_FRAMES: usize = 400;
/// Bytes that a particle takes in a frame at least, as measured of moving water; the search for a fit starts there.
const BYTES_AT_LEAST: usize = 4;
/// Largest thinning: beyond it there is nothing to see.
const MOST_THINNED: u32 = 1 << 14;

/// A frame as it stands in a page.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Frame {
    /// Time \[s\].
    pub time: f64,
    /// Completed steps.
    pub step: u64,
    /// Number of particles.
    pub count: usize,
    /// How columns are packed, where that differs from the film's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub columns: Option<Vec<Column>>,
    /// The particles, compressed, as base64.
    #[serde(skip)]
    pub data: String,
}

/// A largest or smallest value of all particles at all times.
#[derive(Clone, Debug, PartialEq)]
pub struct Extreme {
    /// Whose.
    pub matter: Matter,
    /// Name of the field on the page.
    pub field: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// The value.
    pub value: f64,
    /// When \[s\].
    pub time: f64,
    /// Where \[m\].
    pub position: [f64; 3],
    /// Name of the group.
    pub group: String,
    /// Id of the particle.
    pub id: u32,
}

/// All frames of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    /// What they share.
    pub scene: Scene,
    /// How columns are packed.
    pub columns: Vec<Column>,
    /// The frames.
    pub frames: Vec<Frame>,
    /// Largest values of all particles, not only of those shown.
    pub extremes: Vec<Extreme>,
    /// What is not shown as it is, in words.
    pub notes: Vec<String>,
}

impl Film {
    /// The film of `snapshots`; `None` without any.
    ///
    /// # Errors
    /// When a snapshot cannot be read.
    pub fn of(case: &CaseFacts, snapshots: &Snapshots) -> Result<Option<Self>, String> {
        Self::within(case, snapshots, LARGEST)
    }

    /// As [`Film::of`], at most `largest` bytes of text.
    ///
    /// # Errors
    /// As [`Film::of`].
    pub fn within(case: &CaseFacts, snapshots: &Snapshots, largest: usize) -> Result<Option<Self>, String> {
        let stride = snapshots.moments.len().div_ceil(MOST_FRAMES).max(1);
        let last = snapshots.moments.len().saturating_sub(1);
        let shown = |(k, _): &(usize, &Moment)| k.is_multiple_of(stride) || *k == last;
        let moments: Vec<&Moment> =
            snapshots.moments.iter().enumerate().filter(shown).map(|(_, m)| m).collect();
        let Some(first) = moments.first() else { return Ok(None) };
        let mut groups: Vec<Group> = Vec::new();
        let count = snapshots.read(first, &case.walls, &mut groups, 1, |_, _| {})?.slots.len();
        // Text is 4/3 of the bytes.
        let mut every = 1u32;
        while count * moments.len() * BYTES_AT_LEAST / (every as usize) > largest / 4 * 3
            && every < MOST_THINNED
        {
            every *= 2;
        }
        let read = |moment: &&Moment| -> Result<(Particles, Vec<Group>, Vec<Extreme>), String> {
            let (mut groups, mut extremes) = (groups.clone(), Vec::new());
            let look = |fields: &ParticleFields, is_solid: bool| {
                look(fields, is_solid, &case.walls, moment.time, &mut extremes)
            };
            let particles = snapshots.read(moment, &case.walls, &mut groups, every, look)?;
            Ok((particles, groups, extremes))
        };
        let mut frames = Vec::new();
        let mut extremes: Vec<Extreme> = Vec::new();
        for read in moments.par_iter().map(read).collect::<Vec<_>>() {
            let (particles, seen, found) = read?;
            // A group that appears later comes last, so that earlier indices stay.
            if seen.len() > groups.len() {
                groups = seen;
            }
            frames.push(particles);
            found.into_iter().for_each(|extreme| keep(&mut extremes, extreme));
        }
        let mut bits = 16;
        loop {
            let film = Self::pack(case, &groups, &frames, every, bits).map_err(|e| e.to_string())?;
            let size: usize = film.frames.iter().map(|frame| frame.data.len()).sum();
            if size <= largest || every >= MOST_THINNED {
                return Ok(Some(film.with_notes(stride, extremes)));
            }
            if bits == 16 {
                bits = 8;
            } else {
                every *= 2;
                frames.iter_mut().for_each(|frame| frame.thin(every));
            }
        }
    }

    fn pack(
        case: &CaseFacts,
        groups: &[Group],
        frames: &[Particles],
        every: u32,
        bits: u32,
    ) -> std::io::Result<Self> {
        let scene = Scene::of(case, groups.to_vec(), frames, every);
        let columns = columns(frames.iter(), case.dimensions > 2, bits);
        let mut slots: Vec<Slot> = frames.iter().flat_map(|frame| frame.slots.iter().copied()).collect();
        slots.sort_unstable();
        slots.dedup();
        let count = slots.len();
        let mut packer = Packer::new(columns.clone(), slots, Compression::default());
        let pack = |particles: &Particles| {
            let data = as_text(&packer.pack(particles)?);
            Ok(Frame { time: particles.time, step: particles.step, count, columns: None, data })
        };
        let frames = frames.iter().map(pack).collect::<std::io::Result<_>>()?;
        Ok(Self { scene, columns, frames, extremes: Vec::new(), notes: Vec::new() })
    }

    fn with_notes(mut self, stride: usize, extremes: Vec<Extreme>) -> Self {
        self.extremes = extremes;
        if self.scene.every > 1 {
            self.notes.push(format!("about one particle in {} is shown", self.scene.every));
        }
        if stride > 1 {
            self.notes.push(format!("one snapshot in {stride} is shown"));
        }
        self
    }
}

/// One frame that stands alone, and what was seen of all particles.
#[derive(Debug)]
pub struct Single {
    /// The frame.
    pub frame: Frame,
    /// Its particles.
    pub particles: Particles,
    /// Largest values.
    pub extremes: Vec<Extreme>,
    /// Mean volume of a mass of water, Σ m/ρ over Σ m \[m³/kg\].
    pub specific_volume: Option<f64>,
}

/// A frame for a page that is served: about one particle in `every`.
///
/// # Errors
/// When a snapshot cannot be read.
pub fn single(
    case: &CaseFacts,
    snapshots: &Snapshots,
    moment: &Moment,
    groups: &mut Vec<Group>,
    every: u32,
) -> Result<Single, String> {
    let (mut extremes, mut specific_volume) = (Vec::new(), None);
    let see = |fields: &ParticleFields, is_solid: bool| {
        look(fields, is_solid, &case.walls, moment.time, &mut extremes);
        if !is_solid {
            specific_volume = mean_volume(fields, &case.walls);
        }
    };
    let particles = snapshots.read(moment, &case.walls, groups, every, see)?;
    let columns = columns(std::iter::once(&particles), case.dimensions > 2, 16);
    let mut packer = Packer::new(columns.clone(), particles.slots.clone(), Compression::fast());
    let data = as_text(&packer.pack(&particles).map_err(|e| e.to_string())?);
    let count = particles.slots.len();
    let frame = Frame { time: particles.time, step: particles.step, count, columns: Some(columns), data };
    Ok(Single { frame, particles, extremes, specific_volume })
}

fn mean_volume(fields: &ParticleFields, walls: &[String]) -> Option<f64> {
    let (mass, density) = (&fields.field("mass")?.values, &fields.field("density")?.values);
    let is_water =
        |group: &u32| fields.group_names.get(*group as usize).is_some_and(|name| !walls.contains(name));
    let water = fields.group.iter().zip(mass.iter().zip(density)).filter(|(group, _)| is_water(group));
    let (volume, sum) = water.fold((0.0, 0.0), |(volume, sum), (_, (m, rho))| (volume + m / rho, sum + m));
    (sum > 0.0).then(|| volume / sum)
}

/// The largest values of one side at one time.
fn look(fields: &ParticleFields, is_solid: bool, walls: &[String], time: f64, found: &mut Vec<Extreme>) {
    let Some(position) = fields.field("position") else { return };
    let matter = if is_solid { Matter::Solid } else { Matter::Fluid };
    let wanted: &[(&str, &'static str, &'static str)] = match is_solid {
        true => &[("von_mises", "von Mises stress", "Pa"), ("velocity", "speed", "m/s")],
        false => &[("pressure", "pressure", "Pa"), ("velocity", "speed", "m/s")],
    };
    for (name, label, unit) in wanted {
        let Some(field) = fields.field(name) else { continue };
        let mut best: Option<(f64, usize)> = None;
        for (i, values) in field.values.chunks(field.components).enumerate() {
            let group = fields.group.get(i).and_then(|group| fields.group_names.get(*group as usize));
            if !is_solid && group.is_some_and(|group| walls.contains(group)) {
                continue;
            }
            let value =
                if let [value] = values { *value } else { values.iter().map(|v| v * v).sum::<f64>().sqrt() };
            if value.is_finite() && best.is_none_or(|(most, _)| value > most) {
                best = Some((value, i));
            }
        }
        let Some((value, i)) = best else { continue };
        let part = |k: usize| position.values.get(i * position.components + k).copied().unwrap_or(0.0);
        let group = fields.group.get(i).and_then(|group| fields.group_names.get(*group as usize));
        let extreme = Extreme {
            matter,
            field: label,
            unit,
            value,
            time,
            position: [part(0), part(1), if position.components > 2 { part(2) } else { 0.0 }],
            group: group.cloned().unwrap_or_default(),
            id: fields.id[i],
        };
        keep(found, extreme);
    }
}

/// Keeps the larger of two of a kind.
pub fn keep(all: &mut Vec<Extreme>, extreme: Extreme) {
    let known = all.iter_mut().find(|other| (other.matter, other.field) == (extreme.matter, extreme.field));
    match known {
        Some(known) if known.value < extreme.value => *known = extreme,
        Some(_) => {}
        None => all.push(extreme),
    }
}
