//! Advances the state by the rates and closes the momentum budget of a stage.

use sph::coupling::ledger::{Account, Accounts, AngularBudget, StageBooks, TorqueAccount, Torques};
use sph::coupling::stage::{Stage, StageTime};
use sph::space::Vector;

use super::momentum_budget::{AngularBudgetSums, MomentumBudget};
use super::movement::{MotionSlices, Movement, StageSlices, Step};
use super::stage::Workspace;
use super::state_scan::StateScan;
use crate::rates::particle_rates::{ExternalForces, StagePart};
use crate::system::model::FluidModel;
use crate::system::state::FluidState;
use crate::system::tasks::{for_each_task, per_task};

/// Moves the state by the rates in `workspace`, scans the new one, and returns the momentum budget.
///
/// As in the source paper:
/// ```text
/// φⁿ⁺¹ᐟ² = φⁿ + Δt/2 F(φⁿ)                                        Eq. (30)
/// φⁿ⁺¹   = φⁿ + Δt F(φⁿ⁺¹ᐟ²)                                      Eq. (31)
/// ```
/// Leapfrog, with R of Eq. (17) and D of Eq. (18); of second order too, and neutral in energy up to its limit of
/// stability:
/// ```text
/// xⁿ⁺¹ᐟ² = xⁿ + Δt/2 vⁿ
/// ρⁿ⁺¹ᐟ² = ρⁿ⁻¹ᐟ² + Δt̄ R(xⁿ, vⁿ),  Δt̄ between the middles of the steps
/// vⁿ⁺¹   = vⁿ + Δt a(xⁿ⁺¹ᐟ², ρⁿ⁺¹ᐟ², vⁿ + Δt/2 aⁿ⁻¹ᐟ²)
/// xⁿ⁺¹   = xⁿ + Δt/2 (vⁿ + vⁿ⁺¹) + Δt δu
/// ρⁿ⁺¹   = ρⁿ⁺¹ᐟ² + Δt D + Δt/2 R(xⁿ, vⁿ)
/// ```
/// The last serves outputs and the other sums at the step boundary: the next step subtracts its part of R again.
pub fn advance(
    model: &FluidModel,
    state: &mut FluidState,
    workspace: &mut Workspace,
    time: &StageTime,
) -> StageBooks {
    let Workspace {
        base, fluid, rates, interface, external, budget, findings, part, current, energies, ..
    } = workspace;
    let n = state.len();
    if *part == StagePart::Whole {
        base.resize(n);
    }
    let FluidState { position, velocity, density, density_rate, acceleration, mass, list_origin, .. } = state;
    let step = Step {
        part: *part,
        stage: time.at.stage,
        duration: time.duration(),
        half: 0.5 * time.time_step,
        density_age: state.density_age,
        damping: model.damping_rate(time.state_time()),
        inverse_h: 1.0 / model.constants.smoothing_length(),
        gravity: model.body_force.gravity(),
        origin: (!model.domain.is_periodic()).then(|| model.domain.torque_origin()),
        equation_of_state: model.equation_of_state,
        rates,
        mass,
    };
    let slices = StageSlices {
        motion: MotionSlices { position, velocity, density },
        density_rate,
        acceleration,
        base: MotionSlices {
            position: &mut base.position,
            velocity: &mut base.velocity,
            density: &mut base.density,
        },
        fluid,
        budget: per_task(budget, n),
        findings: per_task(findings, n),
    };
    let scan = StateScan::new(model, list_origin.as_ref());
    for_each_task(n, slices, &|particles, slices| {
        model.arithmetic.run(Movement { step: &step, scan: &scan, first: particles.start, slices });
    });
    *current = true;
    let (mut total, mut forces) = (MomentumBudget::default(), ExternalForces::default());
    budget.iter().for_each(|budget| total += *budget);
    *energies = (time.at.stage == Stage::Corrector).then_some(total.energies);
    let interface = interface.as_ref().map(|interface| interface.sums()).unwrap_or_default();
    if *part == StagePart::Density {
        // The velocity of this stage is an extrapolation: no force has acted.
        return StageBooks { interface, ..StageBooks::default() };
    }
    external.iter().for_each(|external| forces += *external);
    state.largest_acceleration = total.largest_acceleration;
    if *part == StagePart::Momentum {
        state.density_age = step.half;
    }
    let duration = step.duration;
    StageBooks {
        interface,
        accounts: accounts(&total, &forces, state.removed_momentum, duration),
        angular: step
            .origin
            .map(|_| angular_budget(&total.angular, &forces, state.removed_angular_momentum, duration)),
        duration,
        momentum_change: total.momentum - state.removed_momentum,
        gross_momentum: total.gross_momentum + duration * total.gross + state.removed_momentum.norm(),
    }
}

/// Where particle `i` was at the start of the step whose corrector produced `state` \[m\].
///
/// With leapfrog it is found from the step itself, to round-off.
pub fn start_of_step(state: &FluidState, workspace: &Workspace, time_step: f64, i: usize) -> Vector {
    if workspace.part == StagePart::Whole {
        return workspace.base.position[i];
    }
    let (x, v, rates) = (&state.position[i], &state.velocity[i], &workspace.rates[i]);
    let mean_velocity = v - rates.acceleration * (0.5 * time_step);
    x - (mean_velocity + rates.shift) * time_step
}

fn accounts(budget: &MomentumBudget, forces: &ExternalForces, removed: Vector, duration: f64) -> Accounts {
    let mut accounts = Accounts::default();
    accounts.add(Account::BodyForce, forces.body.force);
    accounts.add(Account::Walls, forces.walls.force);
    accounts.add(Account::Damping, budget.damping);
    accounts.add(Account::Stabilisers, forces.stabilisers.force);
    // Particles leave at step boundaries: the next step accounts for their momentum in both of its stages.
    accounts.add(Account::Removed, -removed / duration);
    accounts
}

/// As [`accounts`], for angular momentum, of which `removed` \[kg m/s\] was removed.
fn angular_budget(
    budget: &AngularBudgetSums,
    forces: &ExternalForces,
    removed: f64,
    duration: f64,
) -> AngularBudget {
    let mut torques = Torques::default();
    torques.add(TorqueAccount::BodyForce, forces.body.torque);
    torques.add(TorqueAccount::Walls, forces.walls.torque);
    torques.add(TorqueAccount::Damping, budget.damping);
    torques.add(TorqueAccount::Stabilisers, forces.stabilisers.torque);
    torques.add(TorqueAccount::OwnForces, forces.own_torque);
    torques.add(TorqueAccount::Removed, -removed / duration);
    torques.add(TorqueAccount::Shifting, budget.shifting / duration);
    torques.add(TorqueAccount::TimeScheme, budget.scheme / duration);
    AngularBudget {
        torques,
        change: budget.change - removed,
        gross: budget.gross_change + duration * budget.gross_torque + removed.abs(),
    }
}
