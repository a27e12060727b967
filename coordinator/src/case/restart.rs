//! Start from the final state of another run.

use std::collections::HashMap;
use std::path::Path;

use sph::coupling::solver::{Field, ParticleFields, RELAXATION_PRESSURE};
use sph::setup::{FluidParticles, SolidParticles};
use sph::space::Space;
use sph::space::components::Components;

use super::errors::{CaseError, ErrorList};
use super::file::CaseFile;
use super::scene::{MOST_PARTICLES, Scene};
use crate::quote;

/// Reads the final state of one side from `DIR/final/fluid.state` or `DIR/final/solid.state`.
pub type Loader<'a> = &'a dyn Fn(&Path) -> Result<ParticleFields, String>;

/// Largest file of a final state \[bytes\]: the most particles with fifty numbers each.
const LARGEST_STATE: u64 = 400 * MOST_PARTICLES as u64;

/// The state at `path`, unless the file there cannot be one: a device or pipe never ends.
fn read(path: &Path, load: Loader<'_>) -> Result<ParticleFields, String> {
    match std::fs::metadata(path) {
        Ok(facts) if !facts.is_file() => Err(format!("{} is not a regular file", quote::path(path))),
        Ok(facts) if facts.len() > LARGEST_STATE => {
            let (quoted, length) = (quote::path(path), facts.len());
            Err(format!("{quoted} has {length} bytes; a final state has at most {LARGEST_STATE}"))
        }
        _ => load(path),
    }
}

/// Replaces the particles of regions and bodies that both runs have by their final state.
///
/// Regions take over whatever particles they have then. Bodies must have the same particles; their supports stay
/// those of this case. Names that only this case has start as it says.
pub fn apply<S: Space>(file: &CaseFile, scene: &mut Scene<S>, load: Loader<'_>, errors: &ErrorList) {
    let Some(folder) = &file.start_from else { return };
    let directory = Path::new(&folder.value).join("final");
    let mut taken = 0;
    let mut report = |side: &str, result: Result<usize, String>| match result {
        Ok(count) => taken += count,
        Err(problem) => {
            let error = CaseError::new(&folder.place, format!("{side}: {problem}")).value(&folder.value);
            errors.add(error.hint("name the output folder of a run that ended, with a matching case"));
        }
    };
    if let Some(fluid) = &file.fluid {
        let names: Vec<&str> = fluid.regions.iter().map(|region| region.name.value.as_str()).collect();
        let state = read(&directory.join("fluid.state"), load);
        report("fluid", state.and_then(|state| restore_fluid::<S>(&names, &state, &mut scene.fluid)));
    }
    if let Some(solid) = &file.solid {
        let names: Vec<&str> = solid.bodies.iter().map(|body| body.name.value.as_str()).collect();
        let state = read(&directory.join("solid.state"), load);
        report("solid", state.and_then(|state| restore_solid::<S>(&names, &state, &mut scene.solid)));
    }
    if taken == 0 && errors.count() == 0 {
        let error = CaseError::new(&folder.place, "no region or body of this case has a name of that run");
        errors.add(error.value(&folder.value).hint("use the same names in both cases"));
    }
}

/// Values of a field that must be there with `components` numbers per particle, all finite.
fn field<'a>(state: &'a ParticleFields, name: &str, components: usize) -> Result<&'a Field, String> {
    let field = state.field(name).ok_or_else(|| format!("the state has no field `{name}`"))?;
    if field.components != components || field.values.len() != components * state.id.len() {
        return Err(format!("field `{name}` must have {components} numbers per particle"));
    }
    match field.values.iter().all(|value| value.is_finite()) {
        true => Ok(field),
        false => Err(format!("field `{name}` holds numbers that are not finite")),
    }
}

/// The quantity of `particle`, of a field whose number of components was checked.
fn quantity<C: Components + Default>(field: &Field, particle: usize) -> C {
    C::of_row(&field.values[C::COUNT * particle..C::COUNT * (particle + 1)]).unwrap_or_default()
}

/// Particles of `state` by the name of their group, each by ascending id.
fn members(state: &ParticleFields) -> HashMap<&str, Vec<usize>> {
    let mut of_group = vec![Vec::new(); state.group_names.len()];
    for (k, group) in state.group.iter().enumerate() {
        if let Some(members) = of_group.get_mut(*group as usize) {
            members.push(k);
        }
    }
    let mut found = HashMap::new();
    for (name, mut members) in state.group_names.iter().zip(of_group) {
        members.sort_by_key(|k| state.id[*k]);
        // Of groups with one name the first counts.
        found.entry(name.as_str()).or_insert(members);
    }
    found
}

fn check_size(state: &ParticleFields) -> Result<(), String> {
    if state.id.len() > MOST_PARTICLES || state.group.len() != state.id.len() {
        return Err("the state has too many particles or lacks their groups".to_owned());
    }
    Ok(())
}

fn restore_fluid<S: Space>(
    names: &[&str],
    state: &ParticleFields,
    particles: &mut FluidParticles<S>,
) -> Result<usize, String> {
    check_size(state)?;
    let position = field(state, "position", S::DIMENSIONS)?;
    let velocity = field(state, "velocity", S::DIMENSIONS)?;
    let density = field(state, "density", 1)?;
    let mass = field(state, "mass", 1)?;
    let relaxation = match state.field(RELAXATION_PRESSURE) {
        Some(_) => Some(field(state, RELAXATION_PRESSURE, 1)?),
        None => None,
    };
    let laid = std::mem::take(particles);
    let mut members = members(state);
    let mut taken = 0;
    for (region, name) in (0u32..).zip(names) {
        let found = members.remove(*name).unwrap_or_default();
        taken += found.len();
        let mut add = |m: f64, x: S::Vector, v: S::Vector, rho: f64, q: f64| {
            particles.region.push(region);
            particles.mass.push(m);
            particles.position.push(x);
            particles.velocity.push(v);
            particles.density.push(rho);
            particles.relaxation.push(q);
        };
        if found.is_empty() {
            // Regions follow each other.
            let start = laid.region.partition_point(|other| *other < region);
            for k in start..laid.region.partition_point(|other| *other <= region) {
                add(laid.mass[k], laid.position[k], laid.velocity[k], laid.density[k], 0.0);
            }
        }
        for k in found {
            if !(mass.values[k] > 0.0 && density.values[k] > 0.0) {
                return Err(format!("particle {} of `{name}` has no mass or density", state.id[k]));
            }
            let q = relaxation.map_or(0.0, |q| q.values[k]);
            add(mass.values[k], quantity(position, k), quantity(velocity, k), density.values[k], q);
        }
    }
    particles.id = (0u32..).take(particles.mass.len()).collect();
    if relaxation.is_none() {
        particles.relaxation.clear();
    }
    Ok(taken)
}

fn restore_solid<S: Space>(
    names: &[&str],
    state: &ParticleFields,
    particles: &mut SolidParticles<S>,
) -> Result<usize, String> {
    check_size(state)?;
    let position = field(state, "position", S::DIMENSIONS)?;
    let velocity = field(state, "velocity", S::DIMENSIONS)?;
    let density = field(state, "density", 1)?;
    let stress = field(state, "deviatoric_stress", S::SymmetricTensor::COUNT)?;
    let reference = field(state, "reference_position", S::DIMENSIONS).ok();
    let mut members = members(state);
    let mut taken = 0;
    for (body, name) in (0u32..).zip(names) {
        let found = members.remove(*name).unwrap_or_default();
        let bodies = &particles.body;
        let own = bodies.partition_point(|b| *b < body)..bodies.partition_point(|b| *b <= body);
        if found.is_empty() {
            continue;
        }
        if found.len() != own.len() {
            return Err(format!("body `{name}` has {} particles there and {} here", found.len(), own.len()));
        }
        taken += found.len();
        for (k, s) in own.zip(found) {
            if let Some(reference) = reference {
                particles.reference_position[k] = quantity(reference, s);
            }
            particles.position[k] = quantity(position, s);
            particles.velocity[k] = quantity(velocity, s);
            particles.density[k] = density.values[s];
            particles.deviatoric_stress[k] = quantity(stress, s);
        }
    }
    Ok(taken)
}
