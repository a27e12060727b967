//! The set-up of a solid solver.

use sph::setup::{
    BodySetup, ContactLaw, ElasticMaterial, Formulation, HyperelasticLaw, LoadLaw, SolidParticles,
    SolidProbe, SolidProbeKind, SolidSetup, SolidStepping, SubstepCount, Support, SurfaceLoad,
    TotalLagrangian, UpdatedLagrangian,
};

use super::arrays::{
    index_count, pack, pack_indices, unpack, unpack_ids, unpack_indices, unpack_indices_below,
    unpack_positive,
};
use super::run::{release_time, wall_particles_from_wire, wall_particles_to_wire};
use super::{
    Choice, Convert, Path, WireError, choice, flags_from_wire, flags_to_wire, index, list, name,
    not_negative, optional, positive, required, text, wires,
};
use crate::wire;

impl Convert for SolidSetup {
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
        let bodies: Vec<BodySetup> = list(&wire.bodies, at, "bodies")?;
        let walls: Vec<_> = list(&wire.walls, at, "walls")?;
        let probes: Vec<SolidProbe> = list(&wire.probes, at, "probes")?;
        for (k, probe) in probes.iter().enumerate() {
            check_probe(probe, &bodies, &at.item("probes", k))?;
        }
        Ok(Self {
            run: required(&wire.run, &at.field("run"))?,
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

/// Checks that a probe points at a body, and a support, that exists.
fn check_probe(probe: &SolidProbe, bodies: &[BodySetup], at: &Path<'_>) -> Result<(), WireError> {
    let of_body = |body: u32| index(body, bodies.len(), "bodies", &at.field("body"));
    match &probe.kind {
        SolidProbeKind::MaterialPoint { body, .. }
        | SolidProbeKind::Motion(body)
        | SolidProbeKind::BodyForce(body)
        | SolidProbeKind::Gap(Some(body))
        | SolidProbeKind::Contact(Some(body))
        | SolidProbeKind::Sums(Some(body)) => of_body(*body).map(drop),
        SolidProbeKind::Sums(None) | SolidProbeKind::Gap(None) | SolidProbeKind::Contact(None) => Ok(()),
        SolidProbeKind::Reaction { body, support } => {
            of_body(*body)?;
            let supports =
                usize::try_from(*body).ok().and_then(|b| bodies.get(b)).map_or(0, |b| b.supports.len());
            index(*support, supports, "supports of the body", &at.field("support")).map(drop)
        }
    }
}

fn particles_to_wire(particles: &SolidParticles) -> wire::SolidParticles {
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

fn particles_from_wire(
    wire: &Option<wire::SolidParticles>,
    bodies: &[BodySetup],
    at: &Path<'_>,
) -> Result<SolidParticles, WireError> {
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

impl Convert for BodySetup {
    type Wire = wire::BodySetup;

    fn to_wire(&self) -> wire::BodySetup {
        use wire::body_setup::Formulation as Wire;
        let formulation = match &self.formulation {
            Formulation::UpdatedLagrangian(constants) => Wire::UpdatedLagrangian(constants.to_wire()),
            Formulation::TotalLagrangian(constants) => Wire::TotalLagrangian(constants.to_wire()),
            Formulation::Rigid => Wire::Rigid(wire::Unit {}),
        };
        wire::BodySetup {
            name: self.name.clone(),
            material: Some(self.material.to_wire()),
            formulation: Some(formulation),
            supports: wires(&self.supports),
            acceleration_m_per_s2: self.acceleration.as_ref().map(Convert::to_wire),
            loads: wires(&self.loads),
        }
    }

    fn from_wire(wire: &wire::BodySetup, at: &Path<'_>) -> Result<Self, WireError> {
        use wire::body_setup::Formulation as Wire;
        let formulation = match &wire.formulation {
            Some(Wire::UpdatedLagrangian(constants)) => Formulation::UpdatedLagrangian(
                UpdatedLagrangian::from_wire(constants, &at.field("updated_lagrangian"))?,
            ),
            Some(Wire::TotalLagrangian(constants)) => Formulation::TotalLagrangian(
                TotalLagrangian::from_wire(constants, &at.field("total_lagrangian"))?,
            ),
            Some(Wire::Rigid(_)) => Formulation::Rigid,
            None => {
                let at = at.field("formulation");
                return Err(at.error("is missing or of a later version of the protocol"));
            }
        };
        Ok(Self {
            name: name(&wire.name, &at.field("name"))?,
            material: required(&wire.material, &at.field("material"))?,
            formulation,
            supports: list(&wire.supports, at, "supports")?,
            acceleration: optional(&wire.acceleration_m_per_s2, &at.field("acceleration_m_per_s2"))?,
            loads: list(&wire.loads, at, "loads")?,
        })
    }
}

impl Convert for SurfaceLoad {
    type Wire = wire::SurfaceLoad;

    fn to_wire(&self) -> wire::SurfaceLoad {
        use wire::surface_load::Law;
        let law = match &self.law {
            LoadLaw::Pressure(pressure) => Law::PressurePa(pressure.clone()),
            LoadLaw::Traction(traction) => Law::TractionPa(traction.to_wire()),
        };
        wire::SurfaceLoad {
            name: self.name.clone(),
            law: Some(law),
            particles: pack_indices(&self.particles),
            areas_m2: pack(&self.areas),
        }
    }

    fn from_wire(wire: &wire::SurfaceLoad, at: &Path<'_>) -> Result<Self, WireError> {
        use wire::surface_load::Law;
        let law = match &wire.law {
            Some(Law::PressurePa(pressure)) => LoadLaw::Pressure(text(pressure, &at.field("pressure_pa"))?),
            Some(Law::TractionPa(traction)) => {
                LoadLaw::Traction(<[String; 2]>::from_wire(traction, &at.field("traction_pa"))?)
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

impl Convert for ElasticMaterial {
    type Wire = wire::ElasticMaterial;

    fn to_wire(&self) -> wire::ElasticMaterial {
        wire::ElasticMaterial {
            density_kg_per_m3: Some(self.density),
            bulk_modulus_pa: Some(self.bulk_modulus),
            shear_modulus_pa: Some(self.shear_modulus),
        }
    }

    fn from_wire(wire: &wire::ElasticMaterial, at: &Path<'_>) -> Result<Self, WireError> {
        Ok(Self {
            density: positive(wire.density_kg_per_m3, &at.field("density_kg_per_m3"))?,
            bulk_modulus: positive(wire.bulk_modulus_pa, &at.field("bulk_modulus_pa"))?,
            shear_modulus: not_negative(wire.shear_modulus_pa, &at.field("shear_modulus_pa"))?,
        })
    }
}

impl Convert for UpdatedLagrangian {
    type Wire = wire::UpdatedLagrangian;

    fn to_wire(&self) -> wire::UpdatedLagrangian {
        wire::UpdatedLagrangian {
            smoothing_length_m: Some(self.smoothing_length),
            gradient_correction: self.gradient_correction,
            viscosity_a: Some(self.viscosity_a),
            viscosity_b: Some(self.viscosity_b),
            lambda: Some(self.lambda),
            artificial_stress: Some(self.artificial_stress),
            artificial_stress_exponent: Some(self.artificial_stress_exponent),
        }
    }

    fn from_wire(wire: &wire::UpdatedLagrangian, at: &Path<'_>) -> Result<Self, WireError> {
        Ok(Self {
            smoothing_length: positive(wire.smoothing_length_m, &at.field("smoothing_length_m"))?,
            gradient_correction: wire.gradient_correction,
            viscosity_a: not_negative(wire.viscosity_a, &at.field("viscosity_a"))?,
            viscosity_b: not_negative(wire.viscosity_b, &at.field("viscosity_b"))?,
            lambda: not_negative(wire.lambda, &at.field("lambda"))?,
            artificial_stress: not_negative(wire.artificial_stress, &at.field("artificial_stress"))?,
            artificial_stress_exponent: not_negative(
                wire.artificial_stress_exponent,
                &at.field("artificial_stress_exponent"),
            )?,
        })
    }
}

choices!(HyperelasticLaw = wire::HyperelasticLaw { StVenantKirchhoff, NeoHookean });

impl Convert for TotalLagrangian {
    type Wire = wire::TotalLagrangian;

    fn to_wire(&self) -> wire::TotalLagrangian {
        wire::TotalLagrangian {
            smoothing_length_m: Some(self.smoothing_length),
            law: self.law.code(),
            hourglass: Some(self.hourglass),
            viscosity_a: Some(self.viscosity_a),
            viscosity_b: Some(self.viscosity_b),
        }
    }

    fn from_wire(wire: &wire::TotalLagrangian, at: &Path<'_>) -> Result<Self, WireError> {
        Ok(Self {
            smoothing_length: positive(wire.smoothing_length_m, &at.field("smoothing_length_m"))?,
            law: choice(wire.law, &at.field("law"))?,
            hourglass: not_negative(wire.hourglass, &at.field("hourglass"))?,
            viscosity_a: not_negative(wire.viscosity_a, &at.field("viscosity_a"))?,
            viscosity_b: not_negative(wire.viscosity_b, &at.field("viscosity_b"))?,
        })
    }
}

impl Convert for Support {
    type Wire = wire::Support;

    fn to_wire(&self) -> wire::Support {
        wire::Support {
            name: self.name.clone(),
            held: flags_to_wire(self.held),
            motion: self.motion.as_ref().map(Convert::to_wire),
            release_time_s: self.release_time,
        }
    }

    fn from_wire(wire: &wire::Support, at: &Path<'_>) -> Result<Self, WireError> {
        Ok(Self {
            name: name(&wire.name, &at.field("name"))?,
            held: flags_from_wire(&wire.held, &at.field("held"))?,
            motion: optional(&wire.motion, &at.field("motion"))?,
            release_time: release_time(wire.release_time_s, at)?,
        })
    }
}

impl Convert for ContactLaw {
    type Wire = wire::ContactLaw;

    fn to_wire(&self) -> wire::ContactLaw {
        use wire::contact_law::Law;
        let law = match *self {
            ContactLaw::Repulsion { stiffness, distance, damping, friction, self_contact } => {
                Law::Repulsion(wire::Repulsion {
                    stiffness: Some(stiffness),
                    distance: Some(distance),
                    damping: Some(damping),
                    friction: Some(friction),
                    self_contact,
                })
            }
            ContactLaw::Sums => Law::Sums(wire::Unit {}),
        };
        wire::ContactLaw { law: Some(law) }
    }

    fn from_wire(wire: &wire::ContactLaw, at: &Path<'_>) -> Result<Self, WireError> {
        use wire::contact_law::Law;
        match &wire.law {
            Some(Law::Repulsion(law)) => {
                let at = at.field("repulsion");
                Ok(Self::Repulsion {
                    stiffness: not_negative(law.stiffness, &at.field("stiffness"))?,
                    distance: not_negative(law.distance, &at.field("distance"))?,
                    damping: not_negative(law.damping, &at.field("damping"))?,
                    friction: not_negative(law.friction.or(Some(0.0)), &at.field("friction"))?,
                    self_contact: law.self_contact,
                })
            }
            Some(Law::Sums(_)) => Ok(Self::Sums),
            None => Err(at.field("law").error("is missing or of a later version of the protocol")),
        }
    }
}

impl Convert for SolidProbe {
    type Wire = wire::SolidProbe;

    fn to_wire(&self) -> wire::SolidProbe {
        use wire::solid_probe::Kind;
        let kind = match &self.kind {
            SolidProbeKind::MaterialPoint { body, reference_position } => {
                Kind::MaterialPoint(wire::MaterialPoint {
                    body: *body,
                    reference_position_m: Some(reference_position.to_wire()),
                })
            }
            SolidProbeKind::Motion(body) => Kind::Motion(*body),
            SolidProbeKind::BodyForce(body) => Kind::BodyForce(*body),
            SolidProbeKind::Reaction { body, support } => {
                Kind::Reaction(wire::Reaction { body: *body, support: *support })
            }
            SolidProbeKind::Sums(Some(body)) => Kind::Sums(*body),
            SolidProbeKind::Sums(None) => Kind::AllSums(wire::Unit {}),
            SolidProbeKind::Gap(Some(body)) => Kind::Gap(*body),
            SolidProbeKind::Gap(None) => Kind::AllGaps(wire::Unit {}),
            SolidProbeKind::Contact(Some(body)) => Kind::Contact(*body),
            SolidProbeKind::Contact(None) => Kind::AllContacts(wire::Unit {}),
        };
        wire::SolidProbe { name: self.name.clone(), kind: Some(kind) }
    }

    fn from_wire(wire: &wire::SolidProbe, at: &Path<'_>) -> Result<Self, WireError> {
        use wire::solid_probe::Kind;
        let kind = match &wire.kind {
            Some(Kind::MaterialPoint(point)) => SolidProbeKind::MaterialPoint {
                body: point.body,
                reference_position: required(&point.reference_position_m, &at.field("reference_position_m"))?,
            },
            Some(Kind::Motion(body)) => SolidProbeKind::Motion(*body),
            Some(Kind::BodyForce(body)) => SolidProbeKind::BodyForce(*body),
            Some(Kind::Reaction(reaction)) => {
                SolidProbeKind::Reaction { body: reaction.body, support: reaction.support }
            }
            Some(Kind::Sums(body)) => SolidProbeKind::Sums(Some(*body)),
            Some(Kind::AllSums(_)) => SolidProbeKind::Sums(None),
            Some(Kind::Gap(body)) => SolidProbeKind::Gap(Some(*body)),
            Some(Kind::AllGaps(_)) => SolidProbeKind::Gap(None),
            Some(Kind::Contact(body)) => SolidProbeKind::Contact(Some(*body)),
            Some(Kind::AllContacts(_)) => SolidProbeKind::Contact(None),
            None => return Err(at.field("kind").error("is missing or of a later version of the protocol")),
        };
        Ok(Self { name: name(&wire.name, &at.field("name"))?, kind })
    }
}
