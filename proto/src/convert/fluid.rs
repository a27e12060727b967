//! The set-up of a fluid solver.

use sph::setup::{FluidParticles, FluidProbe, FluidSetup, Outflow, ParameterSet};
use sph::space::Space;

use super::arrays::{
    index_count, pack, pack_indices, unpack, unpack_ids, unpack_indices_below, unpack_positive,
};
use super::parameters::{parameters_from_wire, parameters_to_wire};
use super::probes::check_references;
use super::walls::{wall_particles_from_wire, wall_particles_to_wire};
use super::{
    Convert, Path, WireError, flags_from_wire, flags_to_wire, length, list, name, optional, required, wires,
};
use crate::limits::MAX_LIST;
use crate::wire;

impl<S: Space> Convert for FluidSetup<S> {
    type Wire = wire::FluidSetup;

    fn to_wire(&self) -> wire::FluidSetup {
        let Self { run, parameters, damping, regions, walls, particles, wall_particles, probes, outflow } =
            self;
        wire::FluidSetup {
            run: Some(run.to_wire()),
            parameters: parameters_to_wire(parameters.stated()),
            damping: damping.as_ref().map(Convert::to_wire),
            regions: regions.clone(),
            walls: wires(walls),
            particles: Some(particles_to_wire(particles)),
            wall_particles: Some(wall_particles_to_wire(wall_particles)),
            probes: wires(probes),
            outflow: Some(outflow.to_wire()),
        }
    }

    fn from_wire(wire: &wire::FluidSetup, at: &Path<'_>) -> Result<Self, WireError> {
        // First: what its dimensions are explains all that does not fit them.
        let run = required(&wire.run, &at.field("run"))?;
        length(wire.regions.len(), MAX_LIST, &at.field("regions"))?;
        let regions: Vec<String> = wire
            .regions
            .iter()
            .enumerate()
            .map(|(k, region)| name(region, &at.item("regions", k)))
            .collect::<Result<_, _>>()?;
        let walls: Vec<_> = list(&wire.walls, at, "walls")?;
        let probes: Vec<FluidProbe<S>> = list(&wire.probes, at, "probes")?;
        check_references(&probes, at, |name, _| match name {
            "region" => (regions.len(), "regions"),
            "axis" => (S::DIMENSIONS, "axes"),
            _ => (walls.len(), "walls"),
        })?;
        Ok(Self {
            run,
            parameters: parameters_from_wire(&wire.parameters, |_| true, &at.field("parameters"))?,
            damping: optional(&wire.damping, &at.field("damping"))?,
            particles: particles_from_wire(&wire.particles, regions.len(), &at.field("particles"))?,
            wall_particles: wall_particles_from_wire(
                &wire.wall_particles,
                walls.len(),
                &at.field("wall_particles"),
            )?,
            regions,
            walls,
            probes,
            outflow: optional(&wire.outflow, &at.field("outflow"))?.unwrap_or_default(),
        })
    }
}

impl<S: Space> Convert for Outflow<S> {
    type Wire = wire::Outflow;

    fn to_wire(&self) -> wire::Outflow {
        let flags = |side: &S::Of<bool>| {
            let flags: Vec<bool> = (0..S::DIMENSIONS).map(|axis| side[axis]).collect();
            flags_to_wire(&flags)
        };
        wire::Outflow { lower: flags(&self.lower), upper: flags(&self.upper) }
    }

    fn from_wire(wire: &wire::Outflow, at: &Path<'_>) -> Result<Self, WireError> {
        let flags = |side: &Option<wire::Flags>, name| {
            let flags = flags_from_wire(side, S::DIMENSIONS, &at.field(name))?;
            Ok(S::axes(|axis| flags[axis]))
        };
        Ok(Self { lower: flags(&wire.lower, "lower")?, upper: flags(&wire.upper, "upper")? })
    }
}

fn particles_to_wire<S: Space>(particles: &FluidParticles<S>) -> wire::FluidParticles {
    wire::FluidParticles {
        ids: pack_indices(&particles.id),
        regions: pack_indices(&particles.region),
        masses_kg: pack(&particles.mass),
        positions_m: pack(&particles.position),
        velocities_m_per_s: pack(&particles.velocity),
        densities_kg_per_m3: pack(&particles.density),
        relaxation_pressures_pa: pack(&particles.relaxation),
    }
}

fn particles_from_wire<S: Space>(
    wire: &Option<wire::FluidParticles>,
    regions: usize,
    at: &Path<'_>,
) -> Result<FluidParticles<S>, WireError> {
    let Some(wire) = wire else { return Ok(FluidParticles::default()) };
    let count = index_count(&wire.ids, &at.field("ids"))?;
    let relaxing = if wire.relaxation_pressures_pa.is_empty() { 0 } else { count };
    Ok(FluidParticles {
        id: unpack_ids(&wire.ids, count, &at.field("ids"))?,
        region: unpack_indices_below(&wire.regions, count, regions, "regions", &at.field("regions"))?,
        mass: unpack_positive(&wire.masses_kg, count, &at.field("masses_kg"))?,
        position: unpack(&wire.positions_m, count, &at.field("positions_m"))?,
        velocity: unpack(&wire.velocities_m_per_s, count, &at.field("velocities_m_per_s"))?,
        density: unpack_positive(&wire.densities_kg_per_m3, count, &at.field("densities_kg_per_m3"))?,
        relaxation: unpack(&wire.relaxation_pressures_pa, relaxing, &at.field("relaxation_pressures_pa"))?,
    })
}
