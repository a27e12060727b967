//! The snapshots of a run: one collection each for fluid, solids and walls, and one of all of them.
//!
//! Walls are geometry. They have files of their own, of which there is one until the walls move, are released or removed.
//! `all.pvd` names for each time the particles of all sides; `view.py` shows it in ParaView.

use std::io::Write;
use std::path::{Path, PathBuf};

use sph::coupling::solver::{Field, ParticleFields, Role};

use super::error::OutputError;
use super::files::write_file;
use super::names;
use super::vtk::{self, Series};
use crate::case::Case;

/// Name of the collection of all sides.
const ALL: &str = "all.pvd";
/// Name of the script for ParaView.
const VIEW: &str = "view.py";
/// The script.
const VIEW_SCRIPT: &str = include_str!("../../assets/view.py");

/// Snapshots of all sides.
#[derive(Debug)]
pub struct Snapshots {
    folder: PathBuf,
    /// Of fluid and solids.
    sides: [Series; 2],
    walls: Walls,
    /// Names of the walls, which are groups of the fluid's particles.
    wall_names: Vec<String>,
    /// Spacing of fluid and walls, and of solids \[m\].
    spacing: [f64; 2],
    takes_part: [bool; 2],
}

/// The files of walls: one for each time at which they changed.
#[derive(Debug)]
struct Walls {
    series: Series,
    /// The last file.
    last: Option<Vec<u8>>,
}

impl Snapshots {
    /// No snapshots in `folder` for a run of `case` by `roles`; those that a lost attempt left are removed.
    ///
    /// # Errors
    /// When the folder cannot be written.
    pub fn create(folder: &Path, case: &Case, roles: &[Role]) -> Result<Self, OutputError> {
        Self::resume(folder, case, roles, &[Vec::new(), Vec::new()]).map(|(snapshots, _)| snapshots)
    }

    /// That the snapshots `files` of fluid and solids are in `folder`. Nothing is changed.
    ///
    /// # Errors
    /// When one is missing.
    pub fn examine(folder: &Path, files: &[Vec<(String, f64)>; 2]) -> Result<(), OutputError> {
        files.iter().try_for_each(|files| Series::examine(folder, files))
    }

    /// Continues after the snapshots `files` of fluid and solids, as far as they are there; what was written later is removed.
    /// Also answers which were not there.
    ///
    /// # Errors
    /// When the folder cannot be written.
    pub fn resume(
        folder: &Path,
        case: &Case,
        roles: &[Role],
        files: &[Vec<(String, f64)>; 2],
    ) -> Result<(Self, Vec<String>), OutputError> {
        let [fluid, solid] = files.clone();
        // The walls are those of the fluid's snapshots that remain.
        let known = vtk::read_collection(&folder.join("walls.pvd"));
        let there = |file: &(String, f64)| folder.join(&file.0).is_file();
        let wall_files = known
            .into_iter()
            .filter(|file| fluid.iter().any(|kept| kept.1 == file.1) && there(file))
            .collect();
        let (fluid, mut missing) = Series::resume(folder, Role::Fluid, fluid)?;
        let (solid, more) = Series::resume(folder, Role::Solid, solid)?;
        missing.extend(more);
        let (walls, _) = Series::resume(folder, "walls", wall_files)?;
        let last = walls.files().last().and_then(|(name, _)| std::fs::read(folder.join(name)).ok());
        let file = case.file();
        let solid_spacing = file.solid.as_ref().map(|solid| solid.particle_spacing_m.value);
        let fluid_spacing = file.fluid.as_ref().map(|fluid| fluid.parameters.particle_spacing);
        let spacing = [fluid_spacing.or(solid_spacing), solid_spacing.or(fluid_spacing)];
        let snapshots = Self {
            folder: folder.to_owned(),
            sides: [fluid, solid],
            walls: Walls { series: walls, last },
            wall_names: file.walls.iter().map(|wall| wall.name.value.clone()).collect(),
            spacing: spacing.map(Option::unwrap_or_default),
            takes_part: [Role::Fluid, Role::Solid].map(|role| roles.contains(&role)),
        };
        Ok((snapshots, missing))
    }

    /// The complete snapshots of fluid and solids of steps before `step`.
    pub fn files_before(&self, step: u64) -> [Vec<(String, f64)>; 2] {
        self.sides.each_ref().map(|series| series.files_before(step))
    }

    /// Writes a snapshot of the side of `role`: at any moment all collections name complete files only.
    ///
    /// # Errors
    /// When a file cannot be written or the arrays of `particles` do not fit each other.
    pub fn write(&mut self, role: Role, particles: &ParticleFields) -> Result<(), OutputError> {
        let spacing = self.spacing[role.index()];
        let is_wall: Vec<bool> =
            particles.group_names.iter().map(|name| self.wall_names.contains(name)).collect();
        if role == Role::Fluid && is_wall.contains(&true) {
            let (own, walls) = split(particles, &is_wall);
            if !walls.id.is_empty() {
                self.walls.write(&with_sizes(&walls, spacing, Sizes::Spacing))?;
            }
            self.sides[role.index()].write(&with_sizes(&own, spacing, Sizes::Volume))?;
        } else {
            self.sides[role.index()].write(&with_sizes(particles, spacing, Sizes::Volume))?;
        }
        self.write_all()
    }

    /// Writes the collection of all sides, at the times at which all that take part have a snapshot.
    fn write_all(&self) -> Result<(), OutputError> {
        let taking: Vec<&Series> = self
            .sides
            .iter()
            .zip(self.takes_part)
            .filter(|(_, takes)| *takes)
            .map(|(side, _)| side)
            .collect();
        let Some((first, others)) = taking.split_first() else { return Ok(()) };
        let mut entries: Vec<(f64, usize, String, String)> = Vec::new();
        for (name, time) in first.files() {
            let of = |series: &&Series| series.files().iter().find(|file| file.1 == *time).cloned();
            let rest: Option<Vec<(String, f64)>> = others.iter().map(of).collect();
            let Some(rest) = rest else { continue };
            let wall = self.walls.series.files().iter().rev().find(|file| file.1 <= *time);
            let all = std::iter::once((name.clone(), *time)).chain(rest).chain(wall.cloned());
            for (part, (name, _)) in all.enumerate() {
                let side = name.split_once('_').map_or("", |(side, _)| side).to_owned();
                entries.push((*time, part, side, name));
            }
        }
        vtk::write_collection(&self.folder.join(ALL), &entries)?;
        let view = self.folder.join(VIEW);
        if !view.is_file() {
            write_file(&view, |out| out.write_all(VIEW_SCRIPT.as_bytes()))?;
        }
        Ok(())
    }
}

impl Walls {
    /// Writes `walls` unless they are as before.
    fn write(&mut self, walls: &ParticleFields) -> Result<(), OutputError> {
        let bytes =
            vtk::untimed(walls).map_err(|reason| OutputError::content(&self.series.collection(), reason))?;
        if self.last.as_ref() == Some(&bytes) {
            return Ok(());
        }
        self.series.write_bytes(walls.step, walls.time, &bytes)?;
        self.last = Some(bytes);
        Ok(())
    }
}

/// The fluid's own particles, and those of walls, of which only ids, groups and positions are kept: their pressures and
/// velocities are those that the water beside them sees.
fn split(particles: &ParticleFields, is_wall: &[bool]) -> (ParticleFields, ParticleFields) {
    let of_wall = |k: &usize| is_wall.get(particles.group[*k] as usize).copied().unwrap_or(false);
    let (walls, own): (Vec<usize>, Vec<usize>) = (0..particles.id.len()).partition(of_wall);
    let names_of = |walls: bool| -> Vec<(usize, &String)> {
        let names = particles.group_names.iter().enumerate();
        names.filter(|(group, _)| is_wall[*group] == walls).collect()
    };
    let chosen = |places: &[usize], names: Vec<(usize, &String)>, fields: Vec<&Field>| ParticleFields {
        step: particles.step,
        time: particles.time,
        id: places.iter().map(|k| particles.id[*k]).collect(),
        group: places
            .iter()
            .map(|k| {
                let place = names.iter().position(|(group, _)| *group == particles.group[*k] as usize);
                // Groups are counted by u32.
                place.unwrap_or_default() as u32
            })
            .collect(),
        group_names: names.iter().map(|(_, name)| (*name).clone()).collect(),
        fields: fields.into_iter().map(|field| rows(field, places)).collect(),
    };
    let positions = particles.fields.iter().filter(|field| field.name == "position").collect();
    (
        chosen(&own, names_of(false), particles.fields.iter().collect()),
        chosen(&walls, names_of(true), positions),
    )
}

/// The values of `field` at `places`.
fn rows(field: &Field, places: &[usize]) -> Field {
    let row = |k: &usize| field.values[k * field.components..(k + 1) * field.components].iter().copied();
    Field { values: places.iter().flat_map(row).collect(), ..field.clone() }
}

/// What the size of a particle is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sizes {
    /// Its mass over its density.
    Volume,
    /// The spacing alone.
    Spacing,
}

/// `particles` with `particle_spacing`, `volume` and `point_radius`, half of the side of a square or cube of that volume.
fn with_sizes(particles: &ParticleFields, spacing: f64, sizes: Sizes) -> ParticleFields {
    let count = particles.id.len();
    let dimensions = particles.field("position").map_or(2, |position| position.components);
    let power = i32::try_from(dimensions).unwrap_or(2);
    let (mass, density) = (particles.field("mass"), particles.field("density"));
    let volume: Vec<f64> = match (sizes, mass, density) {
        (Sizes::Volume, Some(mass), Some(density)) => {
            mass.values.iter().zip(&density.values).map(|(m, rho)| m / rho).collect()
        }
        _ => vec![spacing.powi(power); count],
    };
    let radius = volume.iter().map(|volume| 0.5 * volume.powf(1.0 / f64::from(power))).collect();
    let field = |name: &str, unit: &str, values: Vec<f64>| Field {
        name: name.to_owned(),
        unit: unit.to_owned(),
        components: 1,
        values,
    };
    let mut particles = particles.clone();
    particles.fields.extend([
        field("particle_spacing", "m", vec![spacing; count]),
        field("volume", if power == 3 { "m3" } else { "m2" }, volume),
        field("point_radius", "m", radius),
    ]);
    particles
}

/// Whether a run gives `name` to a file in its snapshot folder.
pub(super) fn is_ours(name: &str) -> bool {
    let complete = name.strip_suffix(names::PARTIAL).unwrap_or(name);
    [ALL, VIEW].contains(&complete)
        || ["fluid", "solid", "walls"].iter().any(|side| vtk::is_of(side, complete))
}

#[cfg(test)]
mod tests;
