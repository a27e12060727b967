//! Moving all bodies by one stage, and the books of it.

use std::ops::AddAssign;

use sph::ledger::{Account, Accounts, StageBooks};
use sph::stage::StageTime;
use sph::sums::ordered_sum;
use sph::vector::{DIMENSIONS, Vector};

use super::formulation::BodyStep;
use super::model::{Body, SolidModel};
use super::particles::winding_offset;
use super::workspace::{SolidState, Workspace};

/// Moves every body from φⁿ in `state` to `workspace.next`, supports included, Eq. (30) or (31).
pub(super) fn move_bodies(
    model: &SolidModel,
    state: &SolidState,
    workspace: &mut Workspace,
    time: &StageTime,
) {
    let Workspace { stage, stage_rigid, next, next_rigid, rates, total_force, reactions, .. } = workspace;
    for (k, body) in model.bodies.iter().enumerate() {
        let range = &body.range;
        let step = BodyStep {
            constants: model.constants(body),
            time,
            base: state.particles.view(range),
            stage: stage.view(range),
            base_rigid: &state.rigid[k],
            stage_rigid: &stage_rigid[k],
            windings: &state.windings[range.clone()],
            force: &total_force[range.clone()],
            rates: rates.view(range),
        };
        body.formulation.advance(&step, next.view_mut(range), &mut next_rigid[k]);
        let next_velocity = &mut next.velocity[range.clone()];
        if body.formulation.is_rigid() {
            rigid_reactions(body, &step, next_velocity, &mut reactions[k]);
        } else {
            hold(body, &step, &mut next.position[range.clone()], next_velocity, &mut reactions[k]);
        }
    }
}

/// Imposes the supports on the particles of a deformable body, and takes their reactions \[N/m\].
///
/// The reaction is what the support adds to all other forces to give the particle its prescribed motion.
fn hold(
    body: &Body,
    step: &BodyStep<'_>,
    position: &mut [Vector],
    velocity: &mut [Vector],
    reactions: &mut [Vector],
) {
    for (support, reaction) in body.supports.iter().zip(reactions) {
        *reaction = Vector::zeros();
        if !support.acts(step.time) {
            continue;
        }
        let target = support.target(step.time.target_time());
        for held in &support.particles {
            let i = held.particle;
            let offset = winding_offset(step.constants.domain, &step.windings[i]);
            let base = step.base.position[i] + offset;
            let mut place = position[i] + offset;
            target.hold(&held.origin, &base, &mut place, &mut velocity[i]);
            let missing = missing_force(step, i, &velocity[i]);
            for axis in (0..DIMENSIONS).filter(|axis| support.held[*axis]) {
                position[i][axis] = place[axis] - offset[axis];
                reaction[axis] += missing[axis];
            }
        }
    }
}

/// Shares what supports add to the resultant of a rigid body among them, by the number of particles they hold.
fn rigid_reactions(body: &Body, step: &BodyStep<'_>, velocity: &[Vector], reactions: &mut [Vector]) {
    reactions.fill(Vector::zeros());
    let acting = |axis: usize| {
        body.supports.iter().enumerate().filter(move |(_, s)| s.held[axis] && s.acts(step.time))
    };
    if (0..DIMENSIONS).all(|axis| acting(axis).next().is_none()) {
        return;
    }
    let missing: Vector = ordered_sum(velocity.len(), |i| missing_force(step, i, &velocity[i]));
    for axis in 0..DIMENSIONS {
        let held: usize = acting(axis).map(|(_, support)| support.particles.len()).sum();
        for (k, support) in acting(axis) {
            reactions[k][axis] = missing[axis] * support.particles.len() as f64 / held as f64;
        }
    }
}

/// Force \[N/m\] that particle `i` lacks to arrive at `velocity`.
fn missing_force(step: &BodyStep<'_>, i: usize, velocity: &Vector) -> Vector {
    (velocity - step.base.velocity[i]) * (step.constants.mass[i] / step.time.duration()) - step.force[i]
}

/// Sums over all particles that the books need.
#[derive(Clone, Copy, Default)]
struct BookSums {
    momentum_change: Vector,
    gross_momentum: f64,
    gross_force: f64,
    body_force: Vector,
    damping: Vector,
    wall_contact: Vector,
    largest_acceleration: f64,
    largest_contact_rate: f64,
}

impl AddAssign for BookSums {
    /// Adds the sums and keeps the larger of each maximum.
    fn add_assign(&mut self, other: Self) {
        self.momentum_change += other.momentum_change;
        self.gross_momentum += other.gross_momentum;
        self.gross_force += other.gross_force;
        self.body_force += other.body_force;
        self.damping += other.damping;
        self.wall_contact += other.wall_contact;
        self.largest_acceleration = self.largest_acceleration.max(other.largest_acceleration);
        self.largest_contact_rate = self.largest_contact_rate.max(other.largest_contact_rate);
    }
}

/// Books of the stage that has just moved `workspace.next`, with what the next step is judged by.
pub(super) struct StageRecord {
    pub books: StageBooks,
    /// Largest acceleration of a particle \[m/s²\].
    pub largest_acceleration: f64,
    /// Largest frequency of a particle on its contacts \[rad/s\].
    pub contact_frequency: f64,
}

/// Takes the books of a stage.
///
/// The scale of round-off counts each force by its origin: forces that cancel at rest still round.
pub(super) fn record(
    model: &SolidModel,
    state: &SolidState,
    workspace: &Workspace,
    time: &StageTime,
) -> StageRecord {
    let (base, next) = (&state.particles.velocity, &workspace.next.velocity);
    let sums: BookSums = ordered_sum(model.len(), |i| {
        let mass = model.particles.mass[i];
        let (forces, contact) = (&workspace.forces[i], &workspace.contact[i]);
        let change = next[i] - base[i];
        BookSums {
            momentum_change: change * mass,
            gross_momentum: mass * (base[i].norm() + next[i].norm()),
            gross_force: workspace.sums[i].force.norm()
                + contact.bodies.norm()
                + contact.walls.norm()
                + forces.fluid.norm()
                + forces.body_force.norm()
                + forces.damping.norm(),
            body_force: forces.body_force,
            damping: forces.damping,
            wall_contact: contact.walls,
            largest_acceleration: change.norm() / time.duration(),
            largest_contact_rate: 2.0 * contact.stiffness / mass,
        }
    });
    let mut accounts = Accounts::default();
    accounts.add(Account::BodyForce, sums.body_force);
    accounts.add(Account::Damping, sums.damping);
    accounts.add(Account::WallContact, sums.wall_contact);
    for reaction in workspace.reactions.iter().flatten() {
        accounts.add(Account::Supports, *reaction);
    }
    let duration = time.duration();
    StageRecord {
        books: StageBooks {
            interface: workspace.interface_sums,
            accounts,
            duration,
            momentum_change: sums.momentum_change,
            gross_momentum: sums.gross_momentum + duration * sums.gross_force,
        },
        largest_acceleration: sums.largest_acceleration,
        contact_frequency: sums.largest_contact_rate.sqrt(),
    }
}
