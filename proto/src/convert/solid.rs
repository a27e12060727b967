//! The set-up of a solid solver.

use sph::setup::{
    Argument, BodySetup, Choice, ContactKind, ContactLaw, Formulation, FormulationKind, LoadLaw,
    ParameterSet, SolidParticles, SolidProbe, SolidSetup, SolidStepping, SubstepCount, Support, SurfaceLoad,
};
use sph::space::Space;

use super::arrays::{
    index_count, pack, pack_indices, unpack, unpack_ids, unpack_indices, unpack_indices_below,
    unpack_positive,
};
use super::parameters::{parameters_from_wire, parameters_to_wire, word};
use super::probes::check_references;
use super::run::{expressions_of, expressions_to_wire};
use super::walls::{release_time, wall_particles_from_wire, wall_particles_to_wire};
use super::{
    Convert, Path, WireError, flags_from_wire, flags_to_wire, list, name, optional, positive, required, text,
    vector_from_wire, vector_to_wire, wires,
};
use crate::wire;

impl<S: Space> Convert for SolidSetup<S> {
    type Wire = wire::SolidSetup;

    fn to_wire(&self) -> wire::SolidSetup {
        let Self {
            run,
            particle_spacing,
            bodies,
            particles,
            contact,
            walls,
            wall_particles,
            damping,
            stepping,
            probes,
            lost_particle_limit,
        } = self;
        wire::SolidSetup {
            run: Some(run.to_wire()),
            particle_spacing_m: Some(*particle_spacing),
            bodies: wires(bodies),
            particles: Some(particles_to_wire(particles)),
            contact: Some(contact.to_wire()),
            walls: wires(walls),
            wall_particles: Some(wall_particles_to_wire(wall_particles)),
            damping: damping.as_ref().map(Convert::to_wire),
            probes: wires(probes),
            escaped_particle_limit: *lost_particle_limit,
            substeps: substeps_to_wire(*stepping),
        }
    }

    fn from_wire(wire: &wire::SolidSetup, at: &Path<'_>) -> Result<Self, WireError> {
        // First: what its dimensions are explains all that does not fit them.
        let run = required(&wire.run, &at.field("run"))?;
        let bodies: Vec<BodySetup<S>> = list(&wire.bodies, at, "bodies")?;
        let walls: Vec<_> = list(&wire.walls, at, "walls")?;
        let probes: Vec<SolidProbe<S>> = list(&wire.probes, at, "probes")?;
        let supports = |arguments: &[(&'static str, Argument<S>)]| {
            let body = arguments.iter().find_map(|argument| match argument {
                ("body", Argument::Index(body)) => usize::try_from(*body).ok(),
                _ => None,
            });
            body.and_then(|body| bodies.get(body)).map_or(0, |body| body.supports.len())
        };
        check_references(&probes, at, |name, arguments| match name {
            "support" => (supports(arguments), "supports of the body"),
            _ => (bodies.len(), "bodies"),
        })?;
        Ok(Self {
            run,
            particle_spacing: positive(wire.particle_spacing_m, &at.field("particle_spacing_m"))?,
            particles: particles_from_wire(&wire.particles, &bodies, &at.field("particles"))?,
            contact: required(&wire.contact, &at.field("contact"))?,
            wall_particles: wall_particles_from_wire(
                &wire.wall_particles,
                walls.len(),
                &at.field("wall_particles"),
            )?,
            bodies,
            walls,
            damping: optional(&wire.damping, &at.field("damping"))?,
            stepping: substeps_from_wire(wire.substeps.as_ref(), &at.field("substeps"))?,
            probes,
            lost_particle_limit: wire.escaped_particle_limit,
        })
    }
}

fn substeps_to_wire(stepping: SolidStepping) -> Option<wire::Substeps> {
    use wire::substeps::Count;
    let count = match stepping {
        SolidStepping::StageRule => return None,
        SolidStepping::Substeps(SubstepCount::Fixed(count)) => Count::Fixed(count),
        SolidStepping::Substeps(SubstepCount::Automatic) => Count::Automatic(wire::Unit {}),
    };
    Some(wire::Substeps { count: Some(count) })
}

fn substeps_from_wire(wire: Option<&wire::Substeps>, at: &Path<'_>) -> Result<SolidStepping, WireError> {
    use wire::substeps::Count;
    let Some(wire) = wire else { return Ok(SolidStepping::StageRule) };
    let count = match wire.count {
        Some(Count::Fixed(count)) if count > 0 && count % 2 == 0 => SubstepCount::Fixed(count),
        Some(Count::Fixed(count)) => {
            return Err(at.field("fixed").error(format!("is {count}, must be even and at least 2")));
        }
        Some(Count::Automatic(_)) => SubstepCount::Automatic,
        None => return Err(at.field("count").error("is missing or of a later version of the protocol")),
    };
    Ok(SolidStepping::Substeps(count))
}

fn particles_to_wire<S: Space>(particles: &SolidParticles<S>) -> wire::SolidParticles {
    wire::SolidParticles {
        ids: pack_indices(&particles.id),
        bodies: pack_indices(&particles.body),
        supports: pack_indices(&particles.support),
        masses_kg: pack(&particles.mass),
        reference_positions_m: pack(&particles.reference_position),
        positions_m: pack(&particles.position),
        velocities_m_per_s: pack(&particles.velocity),
        densities_kg_per_m3: pack(&particles.density),
        deviatoric_stresses_pa: pack(&particles.deviatoric_stress),
    }
}

fn particles_from_wire<S: Space>(
    wire: &Option<wire::SolidParticles>,
    bodies: &[BodySetup<S>],
    at: &Path<'_>,
) -> Result<SolidParticles<S>, WireError> {
    let Some(wire) = wire else { return Ok(SolidParticles::default()) };
    let count = index_count(&wire.ids, &at.field("ids"))?;
    let body = unpack_indices_below(&wire.bodies, count, bodies.len(), "bodies", &at.field("bodies"))?;
    if let Some(k) = body.windows(2).position(|pair| pair[0] > pair[1]) {
        let problem =
            format!("must be in the order of bodies, but particle number {k} is of body {}", body[k]);
        return Err(at.field("bodies").error(format!("{problem} and the next of {}", body[k + 1])));
    }
    let support = unpack_indices(&wire.supports, count, &at.field("supports"))?;
    for (k, (body, support)) in body.iter().zip(&support).enumerate() {
        let supports =
            usize::try_from(*body).ok().and_then(|b| bodies.get(b)).map_or(0, |b| b.supports.len());
        if usize::try_from(*support).map_or(true, |s| s > supports) {
            let problem =
                format!("of particle number {k} is {support}, but body {body} has {supports} supports");
            return Err(at.field("supports").error(problem));
        }
    }
    Ok(SolidParticles {
        id: unpack_ids(&wire.ids, count, &at.field("ids"))?,
        body,
        support,
        mass: unpack_positive(&wire.masses_kg, count, &at.field("masses_kg"))?,
        reference_position: unpack(&wire.reference_positions_m, count, &at.field("reference_positions_m"))?,
        position: unpack(&wire.positions_m, count, &at.field("positions_m"))?,
        velocity: unpack(&wire.velocities_m_per_s, count, &at.field("velocities_m_per_s"))?,
        density: unpack_positive(&wire.densities_kg_per_m3, count, &at.field("densities_kg_per_m3"))?,
        deviatoric_stress: unpack(&wire.deviatoric_stresses_pa, count, &at.field("deviatoric_stresses_pa"))?,
    })
}

impl<S: Space> Convert for BodySetup<S> {
    type Wire = wire::BodySetup;

    fn to_wire(&self) -> wire::BodySetup {
        let parameters = match &self.formulation {
            Formulation::UpdatedLagrangian(set) => parameters_to_wire(set.stated()),
            Formulation::TotalLagrangian(set) => parameters_to_wire(set.stated()),
            Formulation::Rigid => Vec::new(),
        };
        wire::BodySetup {
            name: self.name.clone(),
            material: parameters_to_wire(self.material.stated()),
            formulation: self.formulation.kind().name().to_owned(),
            parameters,
            supports: wires(&self.supports),
            acceleration_m_per_s2: self
                .acceleration
                .as_ref()
                .and_then(|texts| expressions_to_wire(texts.as_ref())),
            loads: wires(&self.loads),
        }
    }

    fn from_wire(wire: &wire::BodySetup, at: &Path<'_>) -> Result<Self, WireError> {
        let set = at.field("parameters");
        let acceleration = at.field("acceleration_m_per_s2");
        let formulation = match word(&wire.formulation, &at.field("formulation"))? {
            FormulationKind::UpdatedLagrangian => {
                Formulation::UpdatedLagrangian(parameters_from_wire(&wire.parameters, |_| true, &set)?)
            }
            FormulationKind::TotalLagrangian => {
                Formulation::TotalLagrangian(parameters_from_wire(&wire.parameters, |_| true, &set)?)
            }
            FormulationKind::Rigid => Formulation::Rigid,
        };
        Ok(Self {
            name: name(&wire.name, &at.field("name"))?,
            material: parameters_from_wire(&wire.material, |_| true, &at.field("material"))?,
            formulation,
            supports: list(&wire.supports, at, "supports")?,
            acceleration: wire
                .acceleration_m_per_s2
                .as_ref()
                .map(|texts| expressions_of::<S>(texts, &acceleration))
                .transpose()?,
            loads: list(&wire.loads, at, "loads")?,
        })
    }
}

impl<S: Space> Convert for SurfaceLoad<S> {
    type Wire = wire::SurfaceLoad;

    fn to_wire(&self) -> wire::SurfaceLoad {
        use wire::surface_load::Law;
        let law = match &self.law {
            LoadLaw::Pressure(pressure) => Some(Law::PressurePa(pressure.clone())),
            LoadLaw::Traction(traction) => expressions_to_wire(traction.as_ref()).map(Law::TractionPa),
        };
        wire::SurfaceLoad {
            name: self.name.clone(),
            law,
            particles: pack_indices(&self.particles),
            areas_m2: pack(&self.areas),
        }
    }

    fn from_wire(wire: &wire::SurfaceLoad, at: &Path<'_>) -> Result<Self, WireError> {
        use wire::surface_load::Law;
        let law = match &wire.law {
            Some(Law::PressurePa(pressure)) => LoadLaw::Pressure(text(pressure, &at.field("pressure_pa"))?),
            Some(Law::TractionPa(traction)) => {
                LoadLaw::Traction(expressions_of::<S>(traction, &at.field("traction_pa"))?)
            }
            None => return Err(at.field("law").error("is missing or of a later version of the protocol")),
        };
        let count = index_count(&wire.particles, &at.field("particles"))?;
        Ok(Self {
            name: name(&wire.name, &at.field("name"))?,
            law,
            particles: unpack_indices(&wire.particles, count, &at.field("particles"))?,
            areas: unpack(&wire.areas_m2, count, &at.field("areas_m2"))?,
        })
    }
}

impl<S: Space> Convert for Support<S> {
    type Wire = wire::Support;

    fn to_wire(&self) -> wire::Support {
        wire::Support {
            name: self.name.clone(),
            held: flags_to_wire(self.held.as_ref()),
            motion: self.motion.as_ref().map(Convert::to_wire),
            release_time_s: self.release_time,
            pivot_m: self.pivot.as_ref().and_then(vector_to_wire),
        }
    }

    fn from_wire(wire: &wire::Support, at: &Path<'_>) -> Result<Self, WireError> {
        let held = flags_from_wire(&wire.held, S::DIMENSIONS, &at.field("held"))?;
        Ok(Self {
            name: name(&wire.name, &at.field("name"))?,
            held: S::per_axis(|axis| held[axis]),
            motion: optional(&wire.motion, &at.field("motion"))?,
            pivot: match wire.pivot_m {
                Some(_) => Some(vector_from_wire(&wire.pivot_m, &at.field("pivot_m"))?),
                None => None,
            },
            release_time: release_time(wire.release_time_s, at)?,
        })
    }
}

impl Convert for ContactLaw {
    type Wire = wire::ContactLaw;

    fn to_wire(&self) -> wire::ContactLaw {
        let parameters = match self {
            ContactLaw::Repulsion(set) => parameters_to_wire(set.stated()),
            ContactLaw::Sums => Vec::new(),
        };
        wire::ContactLaw { law: self.kind().name().to_owned(), parameters }
    }

    fn from_wire(wire: &wire::ContactLaw, at: &Path<'_>) -> Result<Self, WireError> {
        Ok(match word(&wire.law, &at.field("law"))? {
            ContactKind::Repulsion => {
                Self::Repulsion(parameters_from_wire(&wire.parameters, |_| true, &at.field("parameters"))?)
            }
            ContactKind::Sums => Self::Sums,
        })
    }
}
