//! The set-up of a fluid solver.

use sph::setup::{
    DensityDiffusion, FluidParticles, FluidProbe, FluidProbeKind, FluidScheme, FluidSetup, OrderControl,
    Outflow, ViscousForm,
};

use super::arrays::{
    index_count, pack, pack_indices, unpack, unpack_ids, unpack_indices_below, unpack_positive,
};
use super::run::{wall_particles_from_wire, wall_particles_to_wire};
use super::{
    Convert, Path, WireError, finite, flags_from_wire, flags_to_wire, index, length, list, name,
    not_negative, optional, positive, required, wires,
};
use crate::limits::MAX_LIST;
use crate::wire;

impl Convert for FluidSetup {
    type Wire = wire::FluidSetup;

    fn to_wire(&self) -> wire::FluidSetup {
        let Self {
            run,
            constants,
            diffusion,
            acoustic_damping,
            wall_repulsion,
            viscous_form,
            order,
            scheme,
            tension_limit,
            damping,
            regions,
            walls,
            particles,
            wall_particles,
            probes,
            outflow,
            lost_particle_limit,
        } = self;
        wire::FluidSetup {
            run: Some(run.to_wire()),
            constants: Some(constants.to_wire()),
            diffusion: diffusion_to_wire(*diffusion),
            damping: damping.as_ref().map(Convert::to_wire),
            regions: regions.clone(),
            walls: wires(walls),
            particles: Some(particles_to_wire(particles)),
            wall_particles: Some(wall_particles_to_wire(wall_particles)),
            probes: wires(probes),
            outflow: Some(wire::Outflow {
                lower: flags_to_wire(outflow.lower),
                upper: flags_to_wire(outflow.upper),
            }),
            escaped_particle_limit: *lost_particle_limit,
            wall_repulsion: Some(*wall_repulsion),
            acoustic_damping: Some(*acoustic_damping),
            viscous_stress: *viscous_form == ViscousForm::Stress,
            order: order.map(|order| wire::OrderControl {
                shifting: Some(order.shifting),
                tensile_control: order.tensile_control,
            }),
            tension_limit_pa: *tension_limit,
            leapfrog: *scheme == FluidScheme::Leapfrog,
        }
    }

    fn from_wire(wire: &wire::FluidSetup, at: &Path<'_>) -> Result<Self, WireError> {
        length(wire.regions.len(), MAX_LIST, &at.field("regions"))?;
        let regions: Vec<String> = wire
            .regions
            .iter()
            .enumerate()
            .map(|(k, region)| name(region, &at.item("regions", k)))
            .collect::<Result<_, _>>()?;
        let walls: Vec<_> = list(&wire.walls, at, "walls")?;
        let probes: Vec<FluidProbe> = list(&wire.probes, at, "probes")?;
        for (k, probe) in probes.iter().enumerate() {
            let at = at.item("probes", k);
            match probe.kind {
                FluidProbeKind::Region(Some(region)) => {
                    index(region, regions.len(), "regions", &at.field("region"))?;
                }
                FluidProbeKind::WallForce(wall) => {
                    index(wall, walls.len(), "walls", &at.field("wall_force"))?;
                }
                FluidProbeKind::Point(_)
                | FluidProbeKind::WaterLevel(_)
                | FluidProbeKind::Front
                | FluidProbeKind::Immersed
                | FluidProbeKind::Region(None) => {}
            }
        }
        let outflow = wire.outflow.clone().unwrap_or_default();
        Ok(Self {
            run: required(&wire.run, &at.field("run"))?,
            constants: required(&wire.constants, &at.field("constants"))?,
            diffusion: diffusion_from_wire(&wire.diffusion, &at.field("diffusion"))?,
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
            outflow: Outflow {
                lower: flags_from_wire(&outflow.lower, &at.field("outflow").field("lower"))?,
                upper: flags_from_wire(&outflow.upper, &at.field("outflow").field("upper"))?,
            },
            lost_particle_limit: wire.escaped_particle_limit,
            viscous_form: if wire.viscous_stress { ViscousForm::Stress } else { ViscousForm::Pairwise },
            order: wire.order.as_ref().map(|order| order_from_wire(order, &at.field("order"))).transpose()?,
            scheme: match wire.leapfrog {
                true => FluidScheme::Leapfrog,
                false => FluidScheme::PredictorCorrector,
            },
            tension_limit: wire
                .tension_limit_pa
                .map(|tension| positive(tension, &at.field("tension_limit_pa")))
                .transpose()?,
            wall_repulsion: not_negative(wire.wall_repulsion.or(Some(0.0)), &at.field("wall_repulsion"))?,
            acoustic_damping: not_negative(
                wire.acoustic_damping.or(Some(0.0)),
                &at.field("acoustic_damping"),
            )?,
        })
    }
}

fn diffusion_to_wire(diffusion: DensityDiffusion) -> Option<wire::DensityDiffusion> {
    match diffusion {
        DensityDiffusion::None => None,
        DensityDiffusion::Plain { delta } => {
            Some(wire::DensityDiffusion { delta: Some(delta), renormalised: false })
        }
        DensityDiffusion::Renormalised { delta } => {
            Some(wire::DensityDiffusion { delta: Some(delta), renormalised: true })
        }
    }
}

fn diffusion_from_wire(
    wire: &Option<wire::DensityDiffusion>,
    at: &Path<'_>,
) -> Result<DensityDiffusion, WireError> {
    let Some(wire) = wire else { return Ok(DensityDiffusion::None) };
    let delta = not_negative(wire.delta, &at.field("delta"))?;
    Ok(if wire.renormalised {
        DensityDiffusion::Renormalised { delta }
    } else {
        DensityDiffusion::Plain { delta }
    })
}

fn order_from_wire(wire: &wire::OrderControl, at: &Path<'_>) -> Result<OrderControl, WireError> {
    Ok(OrderControl {
        shifting: not_negative(wire.shifting, &at.field("shifting"))?,
        tensile_control: wire.tensile_control,
    })
}

fn particles_to_wire(particles: &FluidParticles) -> wire::FluidParticles {
    wire::FluidParticles {
        ids: pack_indices(&particles.id),
        regions: pack_indices(&particles.region),
        masses_kg: pack(&particles.mass),
        positions_m: pack(&particles.position),
        velocities_m_per_s: pack(&particles.velocity),
        densities_kg_per_m3: pack(&particles.density),
    }
}

fn particles_from_wire(
    wire: &Option<wire::FluidParticles>,
    regions: usize,
    at: &Path<'_>,
) -> Result<FluidParticles, WireError> {
    let Some(wire) = wire else { return Ok(FluidParticles::default()) };
    let count = index_count(&wire.ids, &at.field("ids"))?;
    Ok(FluidParticles {
        id: unpack_ids(&wire.ids, count, &at.field("ids"))?,
        region: unpack_indices_below(&wire.regions, count, regions, "regions", &at.field("regions"))?,
        mass: unpack_positive(&wire.masses_kg, count, &at.field("masses_kg"))?,
        position: unpack(&wire.positions_m, count, &at.field("positions_m"))?,
        velocity: unpack(&wire.velocities_m_per_s, count, &at.field("velocities_m_per_s"))?,
        density: unpack_positive(&wire.densities_kg_per_m3, count, &at.field("densities_kg_per_m3"))?,
    })
}

impl Convert for FluidProbe {
    type Wire = wire::FluidProbe;

    fn to_wire(&self) -> wire::FluidProbe {
        use wire::fluid_probe::Kind;
        let kind = match &self.kind {
            FluidProbeKind::Point(point) => Kind::PointM(point.to_wire()),
            FluidProbeKind::WaterLevel(x) => Kind::WaterLevelXM(*x),
            FluidProbeKind::Front => Kind::Front(wire::Unit {}),
            FluidProbeKind::Region(Some(region)) => Kind::Region(*region),
            FluidProbeKind::Region(None) => Kind::AllRegions(wire::Unit {}),
            FluidProbeKind::WallForce(wall) => Kind::WallForce(*wall),
            FluidProbeKind::Immersed => Kind::Immersed(wire::Unit {}),
        };
        wire::FluidProbe { name: self.name.clone(), kind: Some(kind) }
    }

    fn from_wire(wire: &wire::FluidProbe, at: &Path<'_>) -> Result<Self, WireError> {
        use wire::fluid_probe::Kind;
        let kind = match &wire.kind {
            Some(Kind::PointM(point)) => {
                FluidProbeKind::Point(Convert::from_wire(point, &at.field("point_m"))?)
            }
            Some(Kind::WaterLevelXM(x)) => {
                FluidProbeKind::WaterLevel(finite(*x, &at.field("water_level_x_m"))?)
            }
            Some(Kind::Front(_)) => FluidProbeKind::Front,
            Some(Kind::Region(region)) => FluidProbeKind::Region(Some(*region)),
            Some(Kind::AllRegions(_)) => FluidProbeKind::Region(None),
            Some(Kind::WallForce(wall)) => FluidProbeKind::WallForce(*wall),
            Some(Kind::Immersed(_)) => FluidProbeKind::Immersed,
            None => return Err(at.field("kind").error("is missing or of a later version of the protocol")),
        };
        Ok(Self { name: name(&wire.name, &at.field("name"))?, kind })
    }
}
