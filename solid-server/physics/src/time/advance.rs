//! Moving all bodies by one stage; supports and their reactions.

use sph::coupling::ledger::{EnergyAccount, EnergyValues, scheme_moment};
use sph::coupling::stage::{Stage, StageTime};
use sph::space::tensors::SpaceVector;
use sph::sums::ordered_sum;

use crate::boundary::supports::Support;
use crate::formulations::body::Body;
use crate::formulations::formulation::{AngularImpulse, BodyStep};
use crate::particles::variables::{Particles, image_offset};
use crate::space::SolidSpace;
use crate::system::model::SolidModel;
use crate::system::state::SolidState;
use crate::system::workspace::Workspace;
use crate::time::energy_budget::enter_stage;

/// Moves every body from φⁿ in `state` to `workspace.next`, supports included, Eq. (30) or (31).
pub fn move_bodies<S: SolidSpace>(
    model: &SolidModel<S>,
    state: &SolidState<S>,
    workspace: &mut Workspace<S>,
    time: &StageTime,
) {
    let Workspace {
        stage, stage_rigid, next, next_rigid, rates, total_force, angular_impulse, energy, ..
    } = workspace;
    *angular_impulse = AngularImpulse::default();
    *energy = EnergyValues::default();
    for (k, body) in model.bodies.iter().enumerate() {
        let range = &body.range;
        let step = BodyStep {
            constants: model.constants(body),
            time,
            base: state.particles.view(range),
            stage: stage.view(range),
            base_rigid: &state.rigid[k],
            stage_rigid: &stage_rigid[k],
            image_counts: &state.image_counts[range.clone()],
            force: &total_force[range.clone()],
            rates: rates.view(range),
        };
        *angular_impulse += body.formulation.advance(&step, next.view_mut(range), &mut next_rigid[k]);
    }
    let target = time.target_time();
    impose_supports(model, state, time, target, HeldQuantity::Positions, next);
    impose_supports(model, state, time, target, HeldQuantity::Velocities, next);
    take_reactions(model, state, workspace, time);
    if time.at.stage == Stage::Corrector {
        workspace.energy.add(EnergyAccount::Supports, workspace.angular_impulse.work);
        enter_stage(model, state, workspace, time);
    }
    if let Some(origin) = model.torque_origin() {
        let impulse = deformable_impulse(model, state, workspace, time, origin);
        workspace.angular_impulse += impulse;
    }
}

/// Change of the angular momentum of the deformable bodies by supports and scheme in a stage of Eq. (30)-(31).
fn deformable_impulse<S: SolidSpace>(
    model: &SolidModel<S>,
    state: &SolidState<S>,
    workspace: &Workspace<S>,
    time: &StageTime,
    origin: S::Vector,
) -> AngularImpulse<S> {
    let (base, next) = (&state.particles, &workspace.next);
    let mut impulse = AngularImpulse::default();
    for body in model.bodies.iter().filter(|body| !body.formulation.is_rigid()) {
        let range = &body.range;
        impulse.scheme += ordered_sum::<S::Spin, _>(range.len(), |k| {
            let i = range.start + k;
            let start = (&base.position[i], &base.velocity[i]);
            let end = (&next.position[i], &next.velocity[i]);
            scheme_moment::<S>(start, &workspace.stage.position[i], end) * model.particles.mass[i]
        });
        for support in body.supports.iter().filter(|support| support.acts(time)) {
            for held in &support.particles {
                let i = range.start + held.particle;
                let missing = (next.velocity[i] - base.velocity[i]) * model.particles.mass[i]
                    - workspace.total_force[i] * time.duration();
                let of_held = |axis: usize| if support.held[axis] { missing[axis] } else { 0.0 };
                let arm = workspace.stage.position[i] - origin;
                impulse.supports += S::cross(&arm, &S::vector(S::axes(of_held)));
            }
        }
    }
    impulse
}

/// Quantity that supports impose.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum HeldQuantity {
    Positions,
    Velocities,
}

/// Imposes the supports on the particles of deformable bodies, as they are to be at `target` \[s\]; returns by how much
/// that changes their angular momentum \[kg m/s\].
pub fn impose_supports<S: SolidSpace>(
    model: &SolidModel<S>,
    state: &SolidState<S>,
    time: &StageTime,
    target: f64,
    what: HeldQuantity,
    particles: &mut Particles<S>,
) -> S::Spin {
    let mut moment = S::Spin::default();
    for body in model.bodies.iter().filter(|body| !body.formulation.is_rigid()) {
        for support in body.supports.iter().filter(|support| support.acts(time)) {
            let target = support.target(target);
            for held in &support.particles {
                let i = body.range.start + held.particle;
                let offset = image_offset(&model.domain, &state.image_counts[i]);
                let base = state.particles.position[i] + offset;
                let (mut place, mut velocity) = (base, particles.velocity[i]);
                target.impose(&held.origin, &base, &mut place, &mut velocity);
                let before = (particles.position[i], particles.velocity[i]);
                for axis in (0..S::DIMENSIONS).filter(|axis| support.held[*axis]) {
                    match what {
                        HeldQuantity::Positions => particles.position[i][axis] = place[axis] - offset[axis],
                        HeldQuantity::Velocities => particles.velocity[i][axis] = velocity[axis],
                    }
                }
                let (x, v) = (particles.position[i] - model.domain.torque_origin(), particles.velocity[i]);
                moment += match what {
                    HeldQuantity::Positions => S::cross(&(particles.position[i] - before.0), &v),
                    HeldQuantity::Velocities => S::cross(&x, &(v - before.1)),
                } * model.particles.mass[i];
            }
        }
    }
    moment
}

/// Reactions of all supports \[N/m\]: the force beyond `workspace.total_force` that gives the held particles their
/// prescribed motion in the stage.
pub fn take_reactions<S: SolidSpace>(
    model: &SolidModel<S>,
    state: &SolidState<S>,
    workspace: &mut Workspace<S>,
    time: &StageTime,
) {
    let Workspace { next, total_force, reactions, .. } = workspace;
    for (body, reactions) in model.bodies.iter().zip(reactions) {
        let missing = |i: usize| {
            let i = body.range.start + i;
            let change = next.velocity[i] - state.particles.velocity[i];
            change * (model.particles.mass[i] / time.duration()) - total_force[i]
        };
        reactions.fill(S::Vector::zeros());
        if body.formulation.is_rigid() {
            rigid_reactions(body, time, missing, reactions);
            continue;
        }
        for (support, reaction) in
            body.supports.iter().zip(reactions).filter(|(support, _)| support.acts(time))
        {
            for held in &support.particles {
                let missing = missing(held.particle);
                for axis in (0..S::DIMENSIONS).filter(|axis| support.held[*axis]) {
                    reaction[axis] += missing[axis];
                }
            }
        }
    }
}

/// Distributes the resultant reaction on a rigid body among its supports, by the number of particles they hold; a pivot is
/// the only support of its body.
fn rigid_reactions<S: SolidSpace>(
    body: &Body<S>,
    time: &StageTime,
    missing: impl Fn(usize) -> S::Vector + Sync,
    reactions: &mut [S::Vector],
) {
    let acting =
        |axis: usize| body.supports.iter().enumerate().filter(move |(_, s)| s.binds(axis) && s.acts(time));
    let weight = |support: &Support<S>| support.particles.len().max(1);
    if (0..S::DIMENSIONS).all(|axis| acting(axis).next().is_none()) {
        return;
    }
    let missing: S::Vector = ordered_sum(body.range.len(), missing);
    for axis in 0..S::DIMENSIONS {
        let held: usize = acting(axis).map(|(_, support)| weight(support)).sum();
        for (k, support) in acting(axis) {
            reactions[k][axis] = missing[axis] * weight(support) as f64 / held as f64;
        }
    }
}
