//! Bodies of a set-up, their formulations and the law of contact between them.

use std::ops::Range;

use sph::kernel::CubicSpline;
use sph::lanes::Arithmetic;
use sph::prescribed::body_force::BodyForceField;
use sph::setup::{BodyForce, BodySetup, ContactLaw, Formulation, SolidSetup, UpdatedLagrangian};
use sph::space::domain::Domain;
use sph::space::{DIMENSIONS, Plane, Vector};

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
use crate::particles::variables::{Particles, RigidState, image_offset};
use crate::system::model::ContactModel;
use crate::time::limits::{
    total_lagrangian_stage_rule, total_lagrangian_substep, updated_lagrangian_stage_rule,
    updated_lagrangian_substep,
};

/// Bodies and their rigid motions; held velocities and the motion of rigid bodies are written to `particles`.
pub fn build_bodies(
    setup: &SolidSetup,
    ranges: &[Range<usize>],
    arithmetic: Arithmetic,
    (walls, clearance): (&Walls, f64),
    image_counts: &[[i32; 2]],
    particles: &mut Particles,
    errors: &mut Vec<String>,
) -> (Vec<Body>, Vec<RigidState>) {
    let domain = &setup.run.domain;
    let start_time = setup.run.time.start_time;
    let mut bodies = Vec::new();
    let mut rigid = Vec::new();
    for (body, range) in setup.bodies.iter().zip(ranges) {
        let connected: Vec<Vector> =
            range.clone().map(|i| particles.position[i] + image_offset(domain, &image_counts[i])).collect();
        let members = &setup.particles.support[range.clone()];
        let supports = build_supports(body, members, &connected, start_time, errors);
        impose_velocities(&supports, start_time, &mut particles.velocity[range.clone()]);
        let constants =
            BodyConstants { domain, mass: &setup.particles.mass[range.clone()], supports: &supports };
        let velocity = &particles.velocity[range.clone()];
        let speed = body.material.longitudinal_speed();
        let smoothing_length = |law: &UpdatedLagrangian| law.smoothing_length(setup.particle_spacing);
        let (formulation, motion, wave_limits): (Box<dyn BodyFormulation>, _, _) = match &body.formulation {
            Formulation::UpdatedLagrangian(law) => (
                Box::new(UpdatedLagrangianBody::new(law, &body.material, setup.particle_spacing, arithmetic)),
                RigidState::default(),
                WaveLimits {
                    stage_rule: updated_lagrangian_stage_rule(smoothing_length(law), speed, law.viscosity_a),
                    substep: updated_lagrangian_substep(smoothing_length(law), speed, law.viscosity_a),
                },
            ),
            Formulation::TotalLagrangian(law) => {
                let reference = &setup.particles.reference_position[range.clone()];
                let spacing = setup.particle_spacing;
                let material = &body.material;
                let body =
                    TotalLagrangianBody::new(law, material, &constants, reference, spacing, arithmetic);
                let limits = WaveLimits {
                    stage_rule: total_lagrangian_stage_rule(spacing, speed, law.viscosity_a),
                    substep: total_lagrangian_substep(body.largest_frequency, law.viscosity_a),
                };
                (Box::new(body), RigidState::default(), limits)
            }
            Formulation::Rigid => {
                let (body, motion) =
                    RigidBody::new(&constants, &connected, velocity, &particles.density[range.clone()]);
                body.place(&constants, &motion, &image_counts[range.clone()], particles.view_mut(range));
                (Box::new(body), motion, WaveLimits::NONE)
            }
        };
        let wall_exemption = wall_exemption(domain, &supports, &connected, &walls.start, clearance);
        rigid.push(motion);
        bodies.push(Body {
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
            tracks_angle: false,
        });
    }
    (bodies, rigid)
}

/// The acceleration of `body` alone.
fn acceleration(body: &BodySetup, errors: &mut Vec<String>) -> Option<BodyForceField> {
    let expressions = body.acceleration.clone()?;
    BodyForceField::new(&BodyForce { gravity: Vector::zeros(), expressions: Some(expressions) })
        .map_err(|error| errors.push(format!("body `{}`: {error}", body.name)))
        .ok()
}

/// The loads on `body` of `count` particles.
fn loads(body: &BodySetup, count: usize, errors: &mut Vec<String>) -> Vec<Load> {
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
pub fn initial_image_counts(
    domain: &Domain,
    ranges: &[Range<usize>],
    reference: &[Vector],
    position: &[Vector],
) -> Vec<[i32; 2]> {
    let period = domain.size();
    let mut image_counts = vec![[0; DIMENSIONS]; position.len()];
    for range in ranges {
        let first = range.start;
        for axis in (0..DIMENSIONS).filter(|axis| domain.periodic[*axis]) {
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
pub fn build_contact(setup: &SolidSetup) -> ContactModel {
    match setup.contact {
        ContactLaw::Repulsion(law) => {
            let fields = DensityFields::new::<Plane>(setup, law.distance);
            let self_contact_distance = law.self_contact.then(|| fields.self_contact_distance::<Plane>());
            ContactModel::Repulsion(Repulsion {
                stiffness: law.stiffness,
                damping: law.damping,
                friction: law.friction,
                fields,
                self_contact_distance,
            })
        }
        ContactLaw::Sums => {
            let support = |body: &BodySetup| match &body.formulation {
                Formulation::UpdatedLagrangian(law) => {
                    CubicSpline::<Plane>::new(law.smoothing_length(setup.particle_spacing)).support_radius()
                }
                Formulation::TotalLagrangian(_) | Formulation::Rigid => 0.0,
            };
            let support_radius = setup.bodies.iter().map(support).fold(0.0, f64::max);
            ContactModel::Sums(SumContact { support_radius })
        }
    }
}
