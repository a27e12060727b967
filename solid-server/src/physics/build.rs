//! From set-up data to model, state and workspace.

use std::ops::Range;

use sph::body_force::BodyForceField;
use sph::domain::Domain;
use sph::kernel::CubicSpline;
use sph::ledger::InterfaceSums;
use sph::motion::RigidMotion;
use sph::neighbours::CellGrid;
use sph::setup::{
    BodySetup, ContactLaw, Formulation, InterfaceLaw, SolidParticles, SolidProbeKind, SolidSetup, WallSetup,
};
use sph::stage::{StageTime, StepStage};
use sph::vector::{DIMENSIONS, Vector};

use super::contact_repulsion::{ContactSums, Repulsion};
use super::contact_sums::SumContact;
use super::coupling::FluidLink;
use super::formulation::{BodyConstants, BodyFormulation};
use super::lists::{ContactLists, OwnLists};
use super::material_point::MaterialPoint;
use super::model::{Body, ContactModel, ParticleConstants, Probe, SolidModel};
use super::pair_law::PairSums;
use super::particles::{Particles, RigidState, winding_offset};
use super::report::best_fit_angle;
use super::rigid::RigidBody;
use super::supports::{HeldParticle, PrescribedMotion, Support};
use super::updated_lagrangian::UpdatedLagrangianBody;
use super::walls::{Wall, Walls};
use super::workspace::{LastStage, ParticleForces, Rates, SolidState, StressFields, Workspace};

/// Skin of own-body lists in particle spacings: large enough for a hundred steps of a turning body.
const OWN_SKIN: f64 = 0.3;

/// Skin of contact lists in particle spacings: contact rows are short, rebuilding them is what costs.
const CONTACT_SKIN: f64 = 1.0;

/// Model and initial state of `setup`, or all that is wrong with it.
pub(super) fn build(setup: SolidSetup) -> Result<(SolidModel, SolidState), Vec<String>> {
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
    let windings = initial_windings(&domain, &ranges, &setup.particles.reference_position, &particles.position);
    let walls = build_walls(&setup, &mut errors);
    let contact = build_contact(&setup);
    let mut bodies = Vec::new();
    let mut rigid = Vec::new();
    for (body, range) in setup.bodies.iter().zip(&ranges) {
        let connected: Vec<Vector> = range
            .clone()
            .map(|i| particles.position[i] + winding_offset(&domain, &windings[i]))
            .collect();
        let members = &setup.particles.support[range.clone()];
        let supports = build_supports(body, members, &connected, start_time, &mut errors);
        hold_velocities(&supports, start_time, &mut particles.velocity[range.clone()]);
        let constants =
            BodyConstants { domain: &domain, mass: &setup.particles.mass[range.clone()], supports: &supports };
        let velocity = &particles.velocity[range.clone()];
        let (formulation, motion): (Box<dyn BodyFormulation>, _) = match &body.formulation {
            Formulation::UpdatedLagrangian(law) => (
                Box::new(UpdatedLagrangianBody::new(law, &body.material, setup.particle_spacing)),
                RigidState::default(),
            ),
            Formulation::Rigid => {
                let (body, motion) = RigidBody::new(&constants, &connected, velocity);
                body.place(&constants, &motion, &windings[range.clone()], particles.view_mut(range));
                (Box::new(body), motion)
            }
        };
        let wall_exemption = wall_exemption(&domain, &supports, &connected, &walls, contact.clearance());
        rigid.push(motion);
        bodies.push(Body {
            name: body.name.clone(),
            range: range.clone(),
            material: body.material,
            formulation,
            supports,
            wall_exemption,
            tracks_angle: false,
        });
    }
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
        probes,
        lost_particle_limit: setup.lost_particle_limit,
    };
    check_sums(&model, setup.run.coupling.as_ref().map(|coupling| coupling.law), &mut errors);
    check_periods(&model, &mut errors);
    if !errors.is_empty() {
        return Err(errors);
    }
    let state = initial_state(&model, particles, rigid, windings);
    let start = StageTime { at: StepStage::FIRST, step_start: start_time, time_step: 0.0 };
    super::checks::check(&model, &state.particles, start.at)
        .and_then(|()| super::checks::check_domain(&model, &state.particles, &start))
        .map_err(|divergence| vec![format!("the initial state is not usable: {divergence}")])?;
    Ok((model, state))
}

/// Buffers for `model` in `state`.
pub(super) fn build_workspace(
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
        contact: vec![ContactSums::default(); n],
        forces: vec![ParticleForces::default(); n],
        total_force: vec![Vector::zeros(); n],
        own_lists: model.bodies.iter().map(own_list).collect(),
        contact_lists: ContactLists::new(model.contact.radius(), CONTACT_SKIN * model.spacing, n, walls),
        walls: model.walls.at_start(),
        wall_pressure: vec![0.0; walls],
        reactions: state.last.reactions.clone(),
        fluid: coupling.map(|coupling| {
            FluidLink::new(coupling, &model.domain, &model.body_force, &state.particles.position)
        }),
        interface_sums: InterfaceSums::default(),
        list_builds: 0,
    }
}

fn initial_state(
    model: &SolidModel,
    particles: Particles,
    rigid: Vec<RigidState>,
    windings: Vec<[i32; 2]>,
) -> SolidState {
    let mut state = SolidState {
        particles,
        rigid,
        windings,
        angles: vec![0.0; model.bodies.len()],
        last: LastStage {
            fluid_force: vec![Vector::zeros(); model.bodies.len()],
            reactions: model.bodies.iter().map(|b| vec![Vector::zeros(); b.supports.len()]).collect(),
            ..LastStage::default()
        },
    };
    for (k, body) in model.bodies.iter().enumerate() {
        state.angles[k] = best_fit_angle(model, body, &state.particles, &state.windings, 0.0);
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
fn initial_windings(
    domain: &Domain,
    ranges: &[Range<usize>],
    reference: &[Vector],
    position: &[Vector],
) -> Vec<[i32; 2]> {
    let period = domain.size();
    let mut windings = vec![[0; DIMENSIONS]; position.len()];
    for range in ranges {
        let first = range.start;
        for axis in (0..DIMENSIONS).filter(|axis| domain.periodic[*axis]) {
            // A saturating conversion of a small whole number.
            let turns = |distance: f64| (distance / period[axis]).round() as i32;
            windings[first][axis] = turns(reference[first][axis] - position[first][axis]);
            let displacement = position[first][axis] + f64::from(windings[first][axis]) * period[axis]
                - reference[first][axis];
            for i in range.clone().skip(1) {
                windings[i][axis] = turns(reference[i][axis] + displacement - position[i][axis]);
            }
        }
    }
    windings
}

fn build_supports(
    body: &BodySetup,
    members: &[u32],
    position: &[Vector],
    start_time: f64,
    errors: &mut Vec<String>,
) -> Vec<Support> {
    let build = |(k, setup): (u32, &sph::setup::Support)| {
        let motion = setup.motion.as_ref().and_then(|motion| match RigidMotion::new(motion) {
            Ok(parsed) => Some(PrescribedMotion::new(parsed, motion.pivot, start_time)),
            Err(error) => {
                errors.push(format!("support `{}` of body `{}`: {error}", setup.name, body.name));
                None
            }
        });
        let mut support = Support {
            held: setup.held,
            motion,
            release_time: setup.release_time.unwrap_or(f64::INFINITY),
            particles: Vec::new(),
        };
        support.particles = (0..members.len())
            .filter(|i| members[*i] == k)
            .map(|particle| HeldParticle { particle, origin: support.origin(&position[particle]) })
            .collect();
        support
    };
    (1u32..).zip(&body.supports).map(build).collect()
}

/// Gives held components the velocity of their support, so that the first step does not jolt them.
fn hold_velocities(supports: &[Support], start_time: f64, velocity: &mut [Vector]) {
    for support in supports.iter().filter(|support| support.release_time > start_time) {
        let target = support.target(start_time);
        for held in &support.particles {
            let mut place = held.origin;
            target.hold(&held.origin, &held.origin, &mut place, &mut velocity[held.particle]);
        }
    }
}

fn build_walls(setup: &SolidSetup, errors: &mut Vec<String>) -> Walls {
    let wall_of = setup.wall_particles.wall.clone();
    let build = |(k, wall): (u32, &WallSetup)| {
        let motion = wall.motion.as_ref().and_then(|motion| match RigidMotion::new(motion) {
            Ok(motion) => Some(motion),
            Err(error) => {
                errors.push(format!("wall `{}`: {error}", wall.name));
                None
            }
        });
        Wall {
            motion,
            release_time: wall.release_time.unwrap_or(f64::INFINITY),
            particles: (0..wall_of.len()).filter(|w| wall_of[*w] == k).collect(),
        }
    };
    let walls = (0u32..).zip(&setup.walls).map(build).collect();
    Walls { walls, wall_of, start: setup.wall_particles.position.clone() }
}

fn build_contact(setup: &SolidSetup) -> ContactModel {
    match setup.contact {
        ContactLaw::Repulsion { stiffness, distance, damping } => ContactModel::Repulsion(Repulsion {
            stiffness,
            distance: distance * setup.particle_spacing,
            damping,
        }),
        ContactLaw::Sums => {
            let support = |body: &BodySetup| match &body.formulation {
                Formulation::UpdatedLagrangian(law) => CubicSpline::new(law.smoothing_length).support_radius(),
                Formulation::Rigid => 0.0,
            };
            let support_radius = setup.bodies.iter().map(support).fold(0.0, f64::max);
            ContactModel::Sums(SumContact { support_radius })
        }
    }
}

/// Time until which each wall particle is left out of the contact with a body, see [`SolidModel::wall_acts_on`].
fn wall_exemption(
    domain: &Domain,
    supports: &[Support],
    position: &[Vector],
    walls: &Walls,
    radius: f64,
) -> Vec<f64> {
    if supports.is_empty() {
        return Vec::new();
    }
    let mut until = vec![f64::NEG_INFINITY; walls.len()];
    for support in supports.iter().filter(|support| support.holds_fully()) {
        let held: Vec<Vector> = support.particles.iter().map(|held| position[held.particle]).collect();
        let near = CellGrid::new(domain, &held, radius).list(domain, &walls.start, &held, radius, false);
        for w in (0..walls.len()).filter(|w| !near.of(*w).is_empty()) {
            until[w] = until[w].max(support.release_time);
        }
    }
    until
}

fn build_probes(setup: &SolidSetup, bodies: &mut [Body], errors: &mut Vec<String>) -> Vec<Probe> {
    let mut probes = Vec::new();
    for probe in &setup.probes {
        let name = &probe.name;
        let body = match &probe.kind {
            SolidProbeKind::MaterialPoint { body, .. } | SolidProbeKind::Reaction { body, .. } => Some(*body),
            SolidProbeKind::Motion(body) | SolidProbeKind::BodyForce(body) => Some(*body),
            SolidProbeKind::Sums(body) => *body,
        };
        let count = bodies.len();
        let Some(body) = body.map(|body| bodies.get_mut(body as usize)) else {
            probes.push(Probe::Plain(probe.kind.clone()));
            continue;
        };
        let Some(body) = body else {
            errors.push(format!("probe `{name}`: its body does not exist; there are {count}"));
            continue;
        };
        match &probe.kind {
            SolidProbeKind::MaterialPoint { reference_position: at, .. } => {
                let reference = &setup.particles.reference_position[body.range.clone()];
                match MaterialPoint::new(at, body.range.start, reference, setup.particle_spacing) {
                    Ok(point) => probes.push(Probe::MaterialPoint(point)),
                    Err(distance) => errors.push(format!(
                        "probe `{name}`: ({}, {}) m lies {distance:.3e} m from the nearest particle of body `{}`; it \
                         must lie in the undeformed body",
                        at.x, at.y, body.name
                    )),
                }
                continue;
            }
            SolidProbeKind::Motion(_) => body.tracks_angle = true,
            SolidProbeKind::Reaction { support, .. } if *support as usize >= body.supports.len() => {
                errors.push(format!("probe `{name}`: body `{}` has no support {support}", body.name));
            }
            _ => {}
        }
        probes.push(Probe::Plain(probe.kind.clone()));
    }
    probes
}

/// Bodies that take part in sums with others need a stress, and one kernel between them.
fn check_sums(model: &SolidModel, law: Option<InterfaceLaw>, errors: &mut Vec<String>) {
    let contact_sums = matches!(model.contact, ContactModel::Sums(_));
    let plain_sum = law == Some(InterfaceLaw::PlainSum);
    let mut first = None;
    for body in &model.bodies {
        let Some(law) = body.formulation.sum_law() else {
            for (used, what) in [(contact_sums, "contact through the sums"), (plain_sum, "the plain-sum interface")] {
                if used {
                    errors.push(format!(
                        "body `{}` is rigid and has no stress, which {what} needs; make it elastic or choose another law",
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

/// A pair may meet through one image only.
fn check_periods(model: &SolidModel, errors: &mut Vec<String>) {
    let own = model.bodies.iter().filter_map(|body| body.formulation.list_radius()).fold(0.0, f64::max);
    let needed = 2.0 * (own + OWN_SKIN * model.spacing).max(model.contact.radius() + CONTACT_SKIN * model.spacing);
    for axis in (0..DIMENSIONS).filter(|axis| model.domain.periodic[*axis]) {
        let period = model.domain.size()[axis];
        if period < needed {
            let name = ["x", "y"][axis];
            errors.push(format!("period of {period} m along {name} is too short: the solids need {needed:.4} m"));
        }
    }
}
