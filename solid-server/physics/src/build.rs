//! From set-up data to model, state and workspace.

use std::ops::Range;

use sph::body_force::BodyForceField;
use sph::domain::Domain;
use sph::kernel::CubicSpline;
use sph::lanes::Arithmetic;
use sph::ledger::InterfaceSums;
use sph::setup::{
    BodyForce, BodySetup, ContactLaw, Formulation, InterfaceLaw, SolidParticles, SolidSetup, SolidStepping,
    SubstepCount,
};
use sph::stage::{StageTime, StepStage};
use sph::vector::{DIMENSIONS, Vector};

use crate::boundary::loads::Load;
use crate::boundary::supports::{build_supports, impose_velocities, wall_exemption};
use crate::boundary::walls::Walls;
use crate::contact::friction::TangentialSprings;
use crate::contact::repulsion::{DensityFields, Repulsion};
use crate::contact::sums::SumContact;
use crate::formulations::body::{Body, WaveLimits};
use crate::formulations::formulation::{AngularImpulse, BodyConstants, BodyFormulation};
use crate::formulations::pair_law::PairSums;
use crate::formulations::rigid::RigidBody;
use crate::formulations::total_lagrangian::TotalLagrangianBody;
use crate::formulations::updated_lagrangian::UpdatedLagrangianBody;
use crate::interface::fluid::FluidInterface;
use crate::neighbours::lists::{ContactLists, OwnLists};
use crate::particles::constants::ParticleConstants;
use crate::particles::fields::{Rates, StressFields};
use crate::particles::forces::{ContactForces, ParticleForces, ParticleTorques};
use crate::particles::variables::{Particles, RigidState, image_offset};
use crate::report::fields::best_fit_angle;
use crate::report::probes::build_probes;
use crate::system::model::{ContactModel, SolidModel};
use crate::system::state::{BodyContact, LastStage, SolidState};
use crate::system::workspace::Workspace;
use crate::time::limits::{
    total_lagrangian_stage_rule, total_lagrangian_substep, updated_lagrangian_stage_rule,
    updated_lagrangian_substep,
};

/// Skin of own-body lists in particle spacings: large enough for a hundred steps of a turning body.
const OWN_SKIN: f64 = 0.3;

/// Skin of contact lists in particle spacings: contact rows are short, rebuilding them is what costs.
const CONTACT_SKIN: f64 = 1.0;

/// Model and initial state of `setup`, or all that is wrong with it.
pub fn build(setup: SolidSetup, arithmetic: Arithmetic) -> Result<(SolidModel, SolidState), Vec<String>> {
    let ranges = check_arrays(&setup)?;
    let mut errors = Vec::new();
    let domain = setup.run.domain;
    let start_time = setup.run.time.start_time;
    let mut particles = Particles {
        position: setup.particles.position.iter().map(|x| domain.wrapped(x)).collect(),
        velocity: setup.particles.velocity.clone(),
        density: setup.particles.density.clone(),
        deviatoric_stress: setup.particles.deviatoric_stress.clone(),
    };
    let image_counts =
        initial_image_counts(&domain, &ranges, &setup.particles.reference_position, &particles.position);
    let walls = Walls::new(&setup, &mut errors);
    let contact = build_contact(&setup);
    let (mut bodies, rigid) = build_bodies(
        &setup,
        &ranges,
        arithmetic,
        (&walls, contact.clearance()),
        &image_counts,
        &mut particles,
        &mut errors,
    );
    let body_force = BodyForceField::new(&setup.run.body_force).unwrap_or_else(|error| {
        errors.push(error.to_string());
        BodyForceField::uniform(setup.run.body_force.gravity)
    });
    let probes = build_probes(&setup, &mut bodies, &mut errors);
    let SolidParticles { id, body, support, mass, reference_position, .. } = setup.particles;
    let model = SolidModel {
        domain,
        spacing: setup.particle_spacing,
        bodies,
        particles: ParticleConstants { id, body, support, mass, reference_position },
        contact,
        walls,
        body_force,
        damping: setup.damping,
        stepping: setup.stepping,
        probes,
        lost_particle_limit: setup.lost_particle_limit,
    };
    check_sums(&model, setup.run.coupling.as_ref().map(|coupling| coupling.law), &mut errors);
    check_periods(&model, &mut errors);
    if !errors.is_empty() {
        return Err(errors);
    }
    let state = initial_state(&model, particles, rigid, image_counts, start_time);
    let start = StageTime { at: StepStage::FIRST, step_start: start_time, time_step: 0.0 };
    crate::time::checks::check(&model, &state.particles, start.at)
        .and_then(|()| crate::time::checks::check_domain(&model, &state.particles, &start))
        .map_err(|divergence| vec![format!("the initial state is not usable: {divergence}")])?;
    Ok((model, state))
}

/// Bodies and their rigid motions; held velocities and the motion of rigid bodies are written to `particles`.
fn build_bodies(
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
        let (formulation, motion, wave_limits): (Box<dyn BodyFormulation>, _, _) = match &body.formulation {
            Formulation::UpdatedLagrangian(law) => (
                Box::new(UpdatedLagrangianBody::new(law, &body.material, setup.particle_spacing, arithmetic)),
                RigidState::default(),
                WaveLimits {
                    stage_rule: updated_lagrangian_stage_rule(law.smoothing_length, speed, law.viscosity_a),
                    substep: updated_lagrangian_substep(law.smoothing_length, speed, law.viscosity_a),
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
                (Box::new(body), motion, WaveLimits { stage_rule: f64::INFINITY, substep: f64::INFINITY })
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

/// Buffers for `model` in `state`.
pub fn build_workspace(
    model: &SolidModel,
    state: &SolidState,
    coupling: Option<&sph::setup::Coupling>,
) -> Workspace {
    let (n, walls) = (model.len(), model.walls.len());
    let own_list = |body: &Body| {
        body.formulation.list_radius().map(|radius| OwnLists::new(radius, OWN_SKIN * model.spacing))
    };
    Workspace {
        stage: state.particles.clone(),
        stage_rigid: state.rigid.clone(),
        next: state.particles.clone(),
        next_rigid: state.rigid.clone(),
        stress: StressFields::new(n),
        sums: vec![PairSums::default(); n],
        rates: Rates::new(n),
        contact: vec![ContactForces::default(); n],
        contacts: Vec::new(),
        springs: state.springs.clone(),
        start_springs: state.springs.clone(),
        loads: if model.bodies.iter().any(|body| body.acceleration.is_some() || !body.loads.is_empty()) {
            vec![Vector::zeros(); n]
        } else {
            Vec::new()
        },
        forces: vec![ParticleForces::default(); n],
        start_forces: vec![ParticleForces::default(); n],
        mean_forces: vec![ParticleForces::default(); n],
        mean_torques: vec![ParticleTorques::default(); n],
        angular_impulse: AngularImpulse::default(),
        exchange_position: Vec::new(),
        fluid_force: vec![Vector::zeros(); n],
        total_force: vec![Vector::zeros(); n],
        velocity_gain: vec![Vector::zeros(); n],
        own_lists: model.bodies.iter().map(own_list).collect(),
        contact_lists: ContactLists::new(model.contact.radius(), CONTACT_SKIN * model.spacing, n, walls),
        walls: model.walls.at_start(),
        wall_pressure: vec![0.0; walls],
        reactions: state.last.reactions.clone(),
        fluid: coupling.map(|coupling| {
            FluidInterface::new(coupling, &model.domain, &model.body_force, &state.particles.position)
        }),
        interface_sums: InterfaceSums::default(),
        list_builds: 0,
        substeps: 0,
    }
}

fn initial_state(
    model: &SolidModel,
    particles: Particles,
    rigid: Vec<RigidState>,
    image_counts: Vec<[i32; 2]>,
    start_time: f64,
) -> SolidState {
    let mut state = SolidState {
        particles,
        rigid,
        image_counts,
        angles: vec![0.0; model.bodies.len()],
        springs: TangentialSprings { time: start_time, entries: Vec::new() },
        last: LastStage {
            fluid_force: vec![Vector::zeros(); model.bodies.len()],
            reactions: model.bodies.iter().map(|b| vec![Vector::zeros(); b.supports.len()]).collect(),
            contacts: vec![BodyContact::default(); model.bodies.len()],
            ..LastStage::default()
        },
    };
    for (k, body) in model.bodies.iter().enumerate() {
        state.angles[k] = best_fit_angle(model, body, &state.particles, &state.image_counts, 0.0);
    }
    state
}

/// Ranges of the bodies' particles, or what is wrong with the arrays.
fn check_arrays(setup: &SolidSetup) -> Result<Vec<Range<usize>>, Vec<String>> {
    let p = &setup.particles;
    let n = p.id.len();
    let lengths = [
        ("body", p.body.len()),
        ("support", p.support.len()),
        ("mass", p.mass.len()),
        ("reference_position", p.reference_position.len()),
        ("position", p.position.len()),
        ("velocity", p.velocity.len()),
        ("density", p.density.len()),
        ("deviatoric_stress", p.deviatoric_stress.len()),
    ];
    let mut errors: Vec<String> = lengths
        .iter()
        .filter(|(_, length)| *length != n)
        .map(|(name, length)| format!("solid particles: `{name}` has {length} entries, `id` has {n}"))
        .collect();
    if setup.wall_particles.wall.len() != setup.wall_particles.position.len() {
        errors.push("wall particles: `wall` and `position` differ in length".into());
    }
    if let Some(wall) = setup.wall_particles.wall.iter().find(|w| **w as usize >= setup.walls.len()) {
        errors.push(format!("wall particles: wall {wall} does not exist; there are {}", setup.walls.len()));
    }
    if !p.id.windows(2).all(|pair| pair[0] < pair[1]) {
        errors.push("solid particles: `id` must ascend".into());
    }
    if !p.body.is_sorted() {
        errors.push("solid particles: particles of a body must be contiguous, bodies in order".into());
    }
    if !errors.is_empty() {
        return Err(errors);
    }
    let mut ranges = Vec::new();
    for (k, body) in (0u32..).zip(&setup.bodies) {
        let range = p.body.partition_point(|b| *b < k)..p.body.partition_point(|b| *b <= k);
        if range.is_empty() {
            errors.push(format!("body `{}` has no particles", body.name));
        }
        if let Some(i) = range.clone().find(|i| p.support[*i] as usize > body.supports.len()) {
            let (support, count) = (p.support[i], body.supports.len());
            errors.push(format!("body `{}`: support {support} does not exist; there are {count}", body.name));
        }
        ranges.push(range);
    }
    if p.body.last().is_some_and(|last| *last as usize >= setup.bodies.len()) {
        errors.push(format!("solid particles: body index beyond the {} bodies", setup.bodies.len()));
    }
    if errors.is_empty() { Ok(ranges) } else { Err(errors) }
}

/// Whole periods that connect each body to itself and to the image of its reference nearest to its first particle.
fn initial_image_counts(
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

fn build_contact(setup: &SolidSetup) -> ContactModel {
    match setup.contact {
        ContactLaw::Repulsion { stiffness, distance, damping, friction, self_contact } => {
            let fields = DensityFields::new(setup, distance);
            ContactModel::Repulsion(Repulsion::new(stiffness, damping, friction, fields, self_contact))
        }
        ContactLaw::Sums => {
            let support = |body: &BodySetup| match &body.formulation {
                Formulation::UpdatedLagrangian(law) => {
                    CubicSpline::new(law.smoothing_length).support_radius()
                }
                Formulation::TotalLagrangian(_) | Formulation::Rigid => 0.0,
            };
            let support_radius = setup.bodies.iter().map(support).fold(0.0, f64::max);
            ContactModel::Sums(SumContact { support_radius })
        }
    }
}

/// Bodies that take part in sums with others need a stress, and one kernel between them.
fn check_sums(model: &SolidModel, law: Option<InterfaceLaw>, errors: &mut Vec<String>) {
    let contact_sums = matches!(model.contact, ContactModel::Sums(_));
    let plain_sum = law == Some(InterfaceLaw::PlainSum);
    if plain_sum && model.stepping != SolidStepping::StageRule {
        errors.push(
            "the plain-sum interface needs the stage rule: the fluid takes part in the stress of the solid, which can \
             not be frozen over sub-steps"
                .into(),
        );
    }
    if matches!(model.stepping, SolidStepping::Substeps(SubstepCount::Fixed(count)) if count == 0 || count % 2 > 0)
    {
        errors.push("the number of sub-steps must be even and at least 2".into());
    }
    let mut first = None;
    for body in &model.bodies {
        let Some(law) = body.formulation.sum_law() else {
            for (used, what) in
                [(contact_sums, "contact through the sums"), (plain_sum, "the plain-sum interface")]
            {
                if used {
                    errors.push(format!(
                        "body `{}` is not updated-Lagrangian, which {what} needs; make it so or choose another law",
                        body.name
                    ));
                }
            }
            continue;
        };
        let (kernel, exponent) = *first.get_or_insert((law.kernel, law.exponent));
        if contact_sums && (law.kernel != kernel || law.exponent != exponent) {
            errors.push(format!(
                "body `{}`: contact through the sums needs the same smoothing length and artificial-stress exponent in \
                 all bodies",
                body.name
            ));
        }
    }
}

/// A pair may interact through one periodic image only.
fn check_periods(model: &SolidModel, errors: &mut Vec<String>) {
    let own = model.bodies.iter().filter_map(|body| body.formulation.list_radius()).fold(0.0, f64::max);
    let needed =
        2.0 * (own + OWN_SKIN * model.spacing).max(model.contact.radius() + CONTACT_SKIN * model.spacing);
    for axis in (0..DIMENSIONS).filter(|axis| model.domain.periodic[*axis]) {
        let period = model.domain.size()[axis];
        if period < needed {
            let name = ["x", "y"][axis];
            errors.push(format!(
                "period of {period} m along {name} is too short: the solids need {needed:.4} m"
            ));
        }
    }
}
