//! Gathers the evidence from what a run left.

use sph::coupling::solver::ParticleFields;
use sph::in_space;
use sph::kernel::CubicSpline;
use sph::setup::{AnyFluidSetup, FluidProbeKind, FluidSetup, ProbeKind as _, SolidProbeKind};
use sph::space::Space;
use sph::space::components::Components as _;
use sph::space::tensors::SpaceVector;

use super::Evidence;
use super::loads::noise;
use super::volume::Cloud;
use crate::case::{Case, Probes};
use crate::results::table::Table;

/// Gathers the evidence of a run.
pub struct Sampler {
    setup: Option<AnyFluidSetup>,
    /// Columns of the loads of the water, by load.
    loads: Vec<Vec<String>>,
    /// Whether the water fills its container, as its first particles say.
    is_full: Option<bool>,
    evidence: Evidence,
}

impl Sampler {
    /// For a run of `case`.
    pub fn new(case: &Case) -> Self {
        let loads = in_space!(case.probes(), probes => loads(probes));
        let evidence = Evidence {
            particles_across: case.least_across().map(|across| across as f64),
            step_over_limit: Some(case.summary().ratio_to_limit),
            ..Evidence::default()
        };
        Self { setup: case.fluid_setup(), loads, is_full: None, evidence }
    }

    /// Takes the particles of the water and its walls, and of the solids, at one time.
    pub fn take(&mut self, fluid: &ParticleFields, solid: Option<&ParticleFields>) {
        let Some(setup) = &self.setup else { return };
        in_space!(setup, setup => sample(setup, (fluid, solid), &mut self.evidence, &mut self.is_full));
    }

    /// The evidence, with the histories of `probes`, where they can be read, and the particles that `escaped`.
    pub fn finish(mut self, probes: Option<&Table>, escaped: u64) -> Evidence {
        if let (Some(setup), Some(probes)) = (&self.setup, probes)
            && let Some(times) = probes.column("t_s")
        {
            let window = in_space!(setup, setup => crossing_time(setup));
            for load in &self.loads {
                let Some(columns) = load.iter().map(|name| probes.column(name)).collect::<Option<Vec<_>>>()
                else {
                    continue;
                };
                let row = |k: usize| columns.iter().map(|column| column[k]).collect();
                let rows: Vec<(f64, Vec<f64>)> =
                    times.iter().enumerate().map(|(k, t)| (*t, row(k))).collect();
                if let Some(found) = noise(&rows, window) {
                    raise(&mut self.evidence.load_noise, found);
                }
            }
        }
        // Counts far below 2^53.
        self.evidence.escaped = Some(escaped as f64);
        self.evidence
    }
}

/// Columns of the forces on each wall and body that a probe reports.
fn loads<S: Space>(probes: &Probes<S>) -> Vec<Vec<String>> {
    let forces = |name: &str, columns: &[&str]| -> Vec<String> {
        let force = columns.iter().filter(|column| column.starts_with("force_"));
        force.map(|column| format!("{name}_{column}")).collect()
    };
    let of_walls = probes.fluid.iter().filter(|p| matches!(p.kind, FluidProbeKind::WallForce(_)));
    let of_bodies = probes.solid.iter().filter(|p| matches!(p.kind, SolidProbeKind::BodyForce(_)));
    of_walls
        .map(|probe| forces(&probe.name, probe.kind.columns()))
        .chain(of_bodies.map(|probe| forces(&probe.name, probe.kind.columns())))
        .collect()
}

/// Adds what the particles of `fluid` and `solid` at one time say.
fn sample<S: Space>(
    setup: &FluidSetup<S>,
    (fluid, solid): (&ParticleFields, Option<&ParticleFields>),
    evidence: &mut Evidence,
    is_full: &mut Option<bool>,
) {
    // A solver that sends no such fields leaves the figures out.
    let Some(cloud) = cloud(setup, fluid, solid) else { return };
    let filling = cloud.filling();
    // The start is no answer: a lattice that round walls cut leaves a gap beside them, which the water fills at once.
    if let Some(excess) = filling.excess.filter(|_| fluid.step > 0) {
        let larger = evidence.volume_excess.filter(|before| before.abs() >= excess.abs());
        evidence.volume_excess = Some(larger.unwrap_or(excess));
    }
    if *is_full.get_or_insert(filling.is_full) {
        raise(&mut evidence.cavity, cloud.cavity());
    }
    let (sound, rest) = (setup.parameters.sound_speed, setup.parameters.rest_density);
    if let Some(velocity) = vectors::<S>(fluid, "velocity") {
        let speeds = velocity[..cloud.water].iter().map(|v| v.norm() / sound);
        raise(&mut evidence.mach, speeds.fold(0.0, f64::max));
    }
    if let Some(density) = fluid.field("density") {
        let departures = density.values[..cloud.water].iter().map(|density| (density / rest - 1.0).abs());
        raise(&mut evidence.density_variation, departures.fold(0.0, f64::max));
    }
}

fn raise(largest: &mut Option<f64>, value: f64) {
    *largest = Some(largest.map_or(value, |largest| largest.max(value)));
}

/// Time that sound takes across the water \[s\]: the side of a cube of its volume over c₀.
fn crossing_time<S: Space>(setup: &FluidSetup<S>) -> f64 {
    let volume = setup.particles.mass.iter().sum::<f64>() / setup.parameters.rest_density;
    volume.powf(1.0 / S::DIMENSIONS as f64) / setup.parameters.sound_speed
}

/// Vectors of the field `name`.
fn vectors<S: Space>(fields: &ParticleFields, name: &str) -> Option<Vec<S::Vector>> {
    let field = fields.field(name).filter(|field| field.components == S::DIMENSIONS)?;
    let vectors: Option<Vec<S::Vector>> = field.values.chunks(S::DIMENSIONS).map(S::Vector::of_row).collect();
    vectors.filter(|vectors| vectors.len() == fields.id.len())
}

/// The particles as the figures of the volume need them; `None` where a field is missing.
fn cloud<S: Space>(
    setup: &FluidSetup<S>,
    fluid: &ParticleFields,
    solid: Option<&ParticleFields>,
) -> Option<Cloud<S>> {
    let parameters = &setup.parameters;
    let (spacing, regions) = (parameters.particle_spacing, setup.regions.len());
    let volumes = |fields: &ParticleFields| -> Option<Vec<f64>> {
        let (mass, density) = (fields.field("mass")?, fields.field("density")?);
        let same = mass.values.len() == fields.id.len() && density.values.len() == fields.id.len();
        same.then(|| mass.values.iter().zip(&density.values).map(|(mass, density)| mass / density).collect())
    };
    let (mut position, mut volume) = (vectors::<S>(fluid, "position")?, volumes(fluid)?);
    // The water comes first, then the walls by their names.
    let wall = |group: u32| (group as usize).checked_sub(regions);
    let water = fluid.group.iter().position(|group| wall(*group).is_some()).unwrap_or(fluid.group.len());
    volume[water..].fill(S::cell_volume(spacing));
    // A wall that has been released acts no more.
    let acts = |group: &u32| {
        let release = wall(*group).and_then(|wall| setup.walls.get(wall)?.release_time);
        release.is_none_or(|release| fluid.time < release)
    };
    let mut kept = fluid.group.iter().map(acts);
    position.retain(|_| kept.next().unwrap_or(true));
    let mut kept = fluid.group.iter().map(acts);
    volume.retain(|_| kept.next().unwrap_or(true));
    let walls = position.len();
    if let Some(solid) = solid {
        position.extend(vectors::<S>(solid, "position")?);
        volume.extend(volumes(solid)?);
    }
    let solids = position.len() - walls;
    if !position.iter().all(|x| x.norm().is_finite()) || !volume.iter().all(|v| v.is_finite()) {
        return None;
    }
    let kernel = CubicSpline::new(parameters.smoothing_length());
    Some(Cloud { domain: setup.run.domain, kernel, spacing, position, volume, water, solids })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use sph::coupling::solver::Field;

    use super::*;
    use crate::case::load;

    #[test]
    fn the_volume_of_the_start_is_not_judged() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../cases/validation/still_water.toml");
        let case = load(&path, &|_| Err(String::new())).unwrap_or_else(|errors| panic!("{errors}"));
        let AnyFluidSetup::Plane(setup) = case.fluid_setup().unwrap() else { unreachable!() };
        let (water, walls) = (&setup.particles, &setup.wall_particles);
        let place = water.position.iter().chain(&walls.position);
        let group = walls.wall.iter().map(|wall| wall + setup.regions.len() as u32);
        let of_all = |column: &[f64]| column.iter().copied().chain(walls.wall.iter().map(|_| 1.0)).collect();
        let field = |name: &str, components, values| Field {
            name: name.into(),
            unit: String::new(),
            components,
            values,
        };
        // Each particle claims 5 % more than its cell.
        let mass: Vec<f64> = water.mass.iter().map(|mass| 1.05 * mass).collect();
        let mut fields = ParticleFields {
            id: (0..(water.id.len() + walls.wall.len()) as u32).collect(),
            group: water.region.iter().copied().chain(group).collect(),
            fields: vec![
                field("position", 2, place.flat_map(|x| [x.x, x.y]).collect()),
                field("mass", 1, of_all(&mass)),
                field("density", 1, of_all(&water.density)),
            ],
            ..ParticleFields::default()
        };
        let excess = |fields: &ParticleFields| {
            let mut sampler = Sampler::new(&case);
            sampler.take(fields, None);
            sampler.finish(None, 0).volume_excess
        };
        assert_eq!(excess(&fields), None);
        fields.step = 1;
        // Compression of still water and what is counted at its rim: 0.3 %.
        assert!((excess(&fields).unwrap() - 0.05).abs() < 0.005, "{:?}", excess(&fields));
    }
}
