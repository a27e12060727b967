//! Bodies of a set-up, their formulations and the law of contact between them.

use std::ops::Range;

use sph::kernel::CubicSpline;
use sph::lanes::Arithmetic;
use sph::prescribed::body_force::BodyForceField;
use sph::setup::{BodyForce, BodySetup, ContactLaw, Formulation, PlaneState, SolidSetup};
use sph::space::domain::Domain;
use sph::space::tensors::SpaceVector;

use crate::boundary::loads::Load;
use crate::boundary::supports::{build_supports, impose_velocities, wall_exemption};
use crate::boundary::walls::Walls;
use crate::contact::density_field::DensityFields;
use crate::contact::repulsion::Repulsion;
use crate::contact::sums::SumContact;
use crate::formulations::body::{Body, WaveLimits};
use crate::formulations::formulation::{BodyConstants, BodyFormulation};
use crate::formulations::rigid::RigidBody;
use crate::formulations::total_lagrangian::TotalLagrangianBody;
use crate::formulations::updated_lagrangian::UpdatedLagrangianBody;
use crate::particles::variables::{ParticleViewMut, Particles, RigidState, image_offset};
use crate::space::SolidSpace;
use crate::system::model::ContactModel;
use crate::time::limits::{
    total_lagrangian_stage_rule, total_lagrangian_substep, updated_lagrangian_stage_rule,
    updated_lagrangian_substep,
};

/// Bodies and their rigid motions; held velocities and the motion of rigid bodies are written to `particles`.
pub fn build_bodies<S: SolidSpace>(
    setup: &SolidSetup<S>,
    ranges: &[Range<usize>],
    arithmetic: Arithmetic,
    (walls, clearance): (&Walls<S>, f64),
    image_counts: &[S::Of<i32>],
    particles: &mut Particles<S>,
    errors: &mut Vec<String>,
) -> (Vec<Body<S>>, Vec<RigidState<S>>) {
    let domain = &setup.run.domain;
    let start_time = setup.run.time.start_time;
    let mut bodies = Vec::new();
    let mut rigid = Vec::new();
    for (body, range) in setup.bodies.iter().zip(ranges) {
        if S::IMPLIED_AXES == 0.0 && body.material.plane == PlaneState::Stress {
            errors.push(format!(
                "body `{}`: plane stress belongs to the plane; leave `plane` out, or give the body its thickness",
                body.name
            ));
        }
        if body.supports.iter().any(|support| support.pivot.is_some()) {
            if !matches!(body.formulation, Formulation::Rigid) {
                errors.push(format!(
                    "body `{}`: a pivot needs a rigid body; hold particles instead",
                    body.name
                ));
            } else if body.supports.len() > 1 {
                errors.push(format!("body `{}`: a pivot must be its only support", body.name));
            }
        }
        let connected: Vec<S::Vector> =
            range.clone().map(|i| particles.position[i] + image_offset(domain, &image_counts[i])).collect();
        let members = &setup.particles.support[range.clone()];
        let supports = build_supports(body, members, &connected, start_time, errors);
        impose_velocities(&supports, start_time, &mut particles.velocity[range.clone()]);
        let constants =
            BodyConstants { domain, mass: &setup.particles.mass[range.clone()], supports: &supports };
        let places = Places {
            reference: &setup.particles.reference_position[range.clone()],
            connected: &connected,
            image_counts: &image_counts[range.clone()],
        };
        let spacing = setup.particle_spacing;
        let (formulation, motion, wave_limits) = formulate(
            body,
            (spacing, start_time),
            arithmetic,
            &constants,
            &places,
            particles.view_mut(range),
        );
        let wall_exemption = wall_exemption(domain, &supports, &connected, &walls.start, clearance);
        rigid.push(motion);
        let largest_mass = constants.mass.iter().copied().fold(0.0, f64::max);
        bodies.push(Body {
            largest_mass,
            name: body.name.clone(),
            range: range.clone(),
            material: body.material,
            formulation,
            wave_limits,
            supports,
            acceleration: acceleration(body, errors),
            loads: loads(body, range.len(), errors),
            wall_exemption,
            self_contact: matches!(body.formulation, Formulation::TotalLagrangian(_)),
            tracks_rotation: false,
        });
    }
    (bodies, rigid)
}

/// Where the particles of one body are at the start of a run.
struct Places<'a, S: SolidSpace> {
    /// Position in the undeformed body \[m\].
    reference: &'a [S::Vector],
    /// Position, connected across periodic sides \[m\].
    connected: &'a [S::Vector],
    /// Whole periods from positions to these.
    image_counts: &'a [S::Of<i32>],
}

/// Formulation, rigid motion and wave limits of `body` of particles of `spacing` \[m\] at `start_time` \[s\]; the motion of a
/// rigid body is written to `particles`.
fn formulate<S: SolidSpace>(
    body: &BodySetup<S>,
    (spacing, start_time): (f64, f64),
    arithmetic: Arithmetic,
    constants: &BodyConstants<'_, S>,
    places: &Places<'_, S>,
    particles: ParticleViewMut<'_, S>,
) -> (Box<dyn BodyFormulation<S>>, RigidState<S>, WaveLimits) {
    let material = &body.material;
    let speed = material.longitudinal_speed();
    match &body.formulation {
        Formulation::UpdatedLagrangian(law) => {
            let smoothing_length = law.smoothing_length(spacing);
            let limits = WaveLimits {
                stage_rule: updated_lagrangian_stage_rule::<S>(smoothing_length, speed, law.viscosity_a),
                substep: updated_lagrangian_substep::<S>(smoothing_length, speed, law.viscosity_a),
            };
            let body = UpdatedLagrangianBody::new(law, material, spacing, arithmetic);
            (Box::new(body), RigidState::default(), limits)
        }
        Formulation::TotalLagrangian(law) => {
            let body =
                TotalLagrangianBody::new(law, material, constants, places.reference, spacing, arithmetic);
            let limits = WaveLimits {
                stage_rule: total_lagrangian_stage_rule::<S>(spacing, speed, law.viscosity_a),
                substep: total_lagrangian_substep::<S>(body.largest_frequency, law.viscosity_a),
            };
            (Box::new(body), RigidState::default(), limits)
        }
        Formulation::Rigid => {
            let (body, motion) = RigidBody::new(
                constants,
                start_time,
                places.connected,
                particles.velocity,
                particles.density,
            );
            body.place(constants, &motion, places.image_counts, particles);
            (Box::new(body), motion, WaveLimits::NONE)
        }
    }
}

/// The acceleration of `body` alone.
fn acceleration<S: SolidSpace>(body: &BodySetup<S>, errors: &mut Vec<String>) -> Option<BodyForceField<S>> {
    let expressions = body.acceleration.clone()?;
    BodyForceField::new(&BodyForce { gravity: S::Vector::zeros(), expressions: Some(expressions) })
        .map_err(|error| errors.push(format!("body `{}`: {error}", body.name)))
        .ok()
}

/// The loads on `body` of `count` particles.
fn loads<S: SolidSpace>(body: &BodySetup<S>, count: usize, errors: &mut Vec<String>) -> Vec<Load<S>> {
    let mut loads = Vec::new();
    for setup in &body.loads {
        let mut refuse = |problem: &str| {
            errors.push(format!("load `{}` of body `{}`: {problem}", setup.name, body.name));
        };
        if setup.particles.iter().any(|i| *i as usize >= count) || setup.particles.len() != setup.areas.len()
        {
            refuse("its faces do not fit the body's particles");
            continue;
        }
        match Load::new(setup) {
            Ok(load) if load.follows() && !matches!(body.formulation, Formulation::TotalLagrangian(_)) => {
                refuse(
                    "a pressure follows the deformed surface, which only a total-Lagrangian body knows; give a traction",
                );
            }
            Ok(load) => loads.push(load),
            Err(error) => refuse(&error.to_string()),
        }
    }
    loads
}

/// Whole periods that connect each body to itself and to the image of its reference nearest to its first particle.
pub fn initial_image_counts<S: SolidSpace>(
    domain: &Domain<S>,
    ranges: &[Range<usize>],
    reference: &[S::Vector],
    position: &[S::Vector],
) -> Vec<S::Of<i32>> {
    let period = domain.size();
    let mut image_counts = vec![S::splat(0); position.len()];
    for range in ranges {
        let first = range.start;
        for axis in (0..S::DIMENSIONS).filter(|axis| domain.periodic[*axis]) {
            // A saturating conversion of a small whole number.
            let turns = |distance: f64| (distance / period[axis]).round() as i32;
            image_counts[first][axis] = turns(reference[first][axis] - position[first][axis]);
            let displacement = position[first][axis] + f64::from(image_counts[first][axis]) * period[axis]
                - reference[first][axis];
            for i in range.clone().skip(1) {
                image_counts[i][axis] = turns(reference[i][axis] + displacement - position[i][axis]);
            }
        }
    }
    image_counts
}

/// The law of contact of `setup`.
pub fn build_contact<S: SolidSpace>(setup: &SolidSetup<S>) -> ContactModel {
    match setup.contact {
        ContactLaw::Repulsion(law) => {
            let fields = DensityFields::new::<S>(setup, law.distance);
            let self_contact_distance = law.self_contact.then(|| fields.self_contact_distance::<S>());
            ContactModel::Repulsion(Box::new(Repulsion {
                stiffness: law.stiffness,
                damping: law.damping,
                friction: law.friction,
                fields,
                spacing: setup.particle_spacing,
                wet: law.wet,
                self_contact_distance,
                start: Vec::new(),
            }))
        }
        ContactLaw::Sums => {
            let support = |body: &BodySetup<S>| match &body.formulation {
                Formulation::UpdatedLagrangian(law) => {
                    CubicSpline::<S>::new(law.smoothing_length(setup.particle_spacing)).support_radius()
                }
                Formulation::TotalLagrangian(_) | Formulation::Rigid => 0.0,
            };
            let support_radius = setup.bodies.iter().map(support).fold(0.0, f64::max);
            ContactModel::Sums(SumContact { support_radius })
        }
    }
}
