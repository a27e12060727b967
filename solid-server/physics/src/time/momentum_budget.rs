//! Momentum budget of a stage, and the maxima that limit the next step.

use std::ops::AddAssign;

use sph::coupling::ledger::{Account, Accounts, AngularBudget, StageBudget, axial, lifted};
use sph::coupling::stage::StageTime;
use sph::space::tensors::SpaceVector;
use sph::sums::ordered_sum;

use crate::particles::forces::ParticleTorques;
use crate::space::SolidSpace;
use crate::system::model::SolidModel;
use crate::system::state::{SolidState, StageMaxima};
use crate::system::workspace::Workspace;
use crate::time::limits::rigid_contact_frequency;

/// Sums over all particles that the budget needs.
#[derive(Clone, Copy, Default)]
struct BudgetSums<S: SolidSpace> {
    momentum_change: S::Vector,
    gross_momentum: f64,
    gross_force: f64,
    body_force: S::Vector,
    damping: S::Vector,
    wall_contact: S::Vector,
    angular_change: S::Spin,
    gross_angular: f64,
    torques: ParticleTorques<S>,
    largest_acceleration: f64,
    largest_contact_rate: f64,
    tangent_stiffness_ratio: f64,
}

impl<S: SolidSpace> AddAssign for BudgetSums<S> {
    /// Adds the sums and keeps the larger of each maximum.
    fn add_assign(&mut self, other: Self) {
        self.momentum_change += other.momentum_change;
        self.gross_momentum += other.gross_momentum;
        self.gross_force += other.gross_force;
        self.body_force += other.body_force;
        self.damping += other.damping;
        self.wall_contact += other.wall_contact;
        self.angular_change += other.angular_change;
        self.gross_angular += other.gross_angular;
        self.torques += other.torques;
        self.largest_acceleration = self.largest_acceleration.max(other.largest_acceleration);
        self.largest_contact_rate = self.largest_contact_rate.max(other.largest_contact_rate);
        self.tangent_stiffness_ratio = self.tangent_stiffness_ratio.max(other.tangent_stiffness_ratio);
    }
}

/// Momentum budget of the stage that has just moved `workspace.next`, and the maxima that limit the next step.
///
/// The scale of round-off counts each force by its origin: forces that cancel at rest still round.
pub fn momentum_budget<S: SolidSpace>(
    model: &SolidModel<S>,
    state: &SolidState<S>,
    workspace: &Workspace<S>,
    time: &StageTime,
) -> (StageBudget, StageMaxima) {
    let (start, end) = (&state.particles.position, &workspace.next.position);
    let (base, next) = (&state.particles.velocity, &workspace.next.velocity);
    let (duration, origin) = (time.duration(), model.domain.torque_origin());
    let sums: BudgetSums<S> = ordered_sum(model.len(), |i| {
        let mass = model.particles.mass[i];
        let forces = &workspace.mean_forces[i];
        let body = model.body_of(i);
        let stress = workspace.stress.view(&body.range);
        let change = next[i] - base[i];
        let (from, to) = (start[i] - origin, end[i] - origin);
        let gross_momentum = mass * (base[i].norm() + next[i].norm());
        let gross_force = forces.gross + workspace.fluid_force[i].norm();
        BudgetSums {
            momentum_change: change * mass,
            gross_momentum,
            gross_force,
            angular_change: (S::cross(&to, &next[i]) - S::cross(&from, &base[i])) * mass,
            gross_angular: from.norm().max(to.norm()) * (gross_momentum + duration * gross_force),
            torques: workspace.mean_torques[i],
            body_force: forces.body_force,
            damping: forces.damping,
            wall_contact: forces.walls,
            largest_acceleration: change.norm() / duration,
            largest_contact_rate: if body.formulation.is_rigid() {
                0.0
            } else {
                2.0 * forces.contact_stiffness / mass
            },
            tangent_stiffness_ratio: body.formulation.tangent_stiffness_ratio(&stress, i - body.range.start),
        }
    });
    let mut accounts = Accounts::default();
    accounts.add_force(Account::BodyForce, lifted(&sums.body_force));
    accounts.add_force(Account::Damping, lifted(&sums.damping));
    accounts.add_force(Account::WallContact, lifted(&sums.wall_contact));
    for reaction in workspace.reactions.iter().flatten() {
        accounts.add_force(Account::Supports, lifted(reaction));
    }
    let angular = model
        .torque_origin()
        .map(|_| angular_budget(&mut accounts, model, state, workspace, duration, &sums));
    let budget = StageBudget {
        interface: workspace.interface_sums,
        accounts,
        duration,
        momentum_change: lifted(&sums.momentum_change),
        gross_momentum: sums.gross_momentum + duration * sums.gross_force,
        angular,
    };
    let maxima = StageMaxima {
        largest_acceleration: sums.largest_acceleration,
        contact_frequency: sums.largest_contact_rate.sqrt().max(rigid_contact_frequency(
            model,
            &workspace.mean_forces,
            time,
        )),
        tangent_stiffness_ratio: sums.tangent_stiffness_ratio,
    };
    (budget, maxima)
}

/// Enters the torques in `accounts`; returns the change of the angular momentum of all particles and of the cells of rigid
/// bodies.
fn angular_budget<S: SolidSpace>(
    accounts: &mut Accounts,
    model: &SolidModel<S>,
    state: &SolidState<S>,
    workspace: &Workspace<S>,
    duration: f64,
    sums: &BudgetSums<S>,
) -> AngularBudget {
    let (torques, impulse) = (&sums.torques, &workspace.angular_impulse);
    for (account, torque) in [
        (Account::BodyForce, torques.body_force),
        (Account::Damping, torques.damping),
        (Account::WallContact, torques.walls),
        (Account::BodyContact, torques.contact),
        (Account::OwnForces, torques.own),
        (Account::Supports, impulse.supports / duration),
        (Account::TimeScheme, impulse.scheme / duration + torques.displaced),
    ] {
        accounts.add_torque(account, axial(torque));
    }
    let (mut change, mut gross) = (axial(sums.angular_change), sums.gross_angular);
    for (k, body) in model.bodies.iter().enumerate() {
        if let Some(inertia) = body.formulation.inertia() {
            let (before, after) = (state.rigid[k].angular_velocity, workspace.next_rigid[k].angular_velocity);
            let moment = |spin| axial(S::angular_momentum(inertia.cells, spin));
            change += moment(after - before);
            gross += moment(after - before).norm().max(moment(after + before).norm());
        }
    }
    AngularBudget { change, gross }
}
