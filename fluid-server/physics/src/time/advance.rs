//! Advancing the state by the rates and the books of a stage.

use sph::ledger::{Account, Accounts, AngularBudget, StageBooks, TorqueAccount, Torques};
use sph::stage::{Stage, StageTime};
use sph::vector::Vector;

use super::momentum_budget::{AngularBooks, Books};
use super::movement::{Movement, Step};
use super::stage::Workspace;
use super::state_scan::Look;
use crate::rates::particle_rates::{OuterForces, Part};
use crate::system::model::FluidModel;
use crate::system::state::FluidState;
use crate::system::tasks::{PerTask, for_each_task, per_task};

/// Moves the state by the rates in `workspace`, and makes the records of the new one.
///
/// The letter of the source:
/// ```text
/// φⁿ⁺¹ᐟ² = φⁿ + Δt/2 F(φⁿ)                                        Eq. (30)
/// φⁿ⁺¹   = φⁿ + Δt F(φⁿ⁺¹ᐟ²)                                      Eq. (31)
/// ```
/// Leapfrog, with R of Eq. (17) and D of Eq. (18), of second order too, and without gain or loss of energy up to its
/// limit of stability:
/// ```text
/// xⁿ⁺¹ᐟ² = xⁿ + Δt/2 vⁿ
/// ρⁿ⁺¹ᐟ² = ρⁿ⁻¹ᐟ² + Δt̄ R(xⁿ, vⁿ),  Δt̄ between the middles of the steps
/// vⁿ⁺¹   = vⁿ + Δt a(xⁿ⁺¹ᐟ², ρⁿ⁺¹ᐟ², vⁿ + Δt/2 aⁿ⁻¹ᐟ²)
/// xⁿ⁺¹   = xⁿ + Δt/2 (vⁿ + vⁿ⁺¹) + Δt δu
/// ρⁿ⁺¹   = ρⁿ⁺¹ᐟ² + Δt D + Δt/2 R(xⁿ, vⁿ)
/// ```
/// The last is for outputs and for the other sums at the boundary: the next step takes its part of R back.
pub fn advance(
    model: &FluidModel,
    state: &mut FluidState,
    workspace: &mut Workspace,
    time: &StageTime,
) -> StageBooks {
    let Workspace { base, fluid, rates, cross, outer, books, findings, part, current, energies, .. } =
        workspace;
    let n = state.len();
    if *part == Part::Whole {
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
        inverse_h: 1.0 / model.constants.smoothing_length,
        gravity: model.body_force.gravity(),
        origin: (!model.domain.is_periodic()).then(|| model.domain.torque_origin()),
        equation_of_state: model.equation_of_state,
        rates,
        mass,
    };
    let moving = (&mut position[..], (&mut velocity[..], &mut density[..]));
    let kept = (&mut density_rate[..], &mut acceleration[..]);
    let base = (&mut base.position[..], (&mut base.velocity[..], &mut base.density[..]));
    let sums = (per_task(books, n), per_task(findings, n));
    let look = Look::new(model, list_origin.as_ref());
    let results = (((moving, kept), (base, &mut fluid[..])), sums);
    for_each_task(n, results, &|particles, (((moving, kept), (base, fluid)), sums)| {
        let (PerTask(of_task), PerTask(findings)) = sums;
        let task = Movement { step: &step, look: &look, first: particles.start, moving, kept, base, fluid };
        (of_task[0], findings[0]) = model.arithmetic.run(task);
    });
    *current = true;
    let (mut total, mut forces) = (Books::default(), OuterForces::default());
    books.iter().for_each(|books| total += *books);
    *energies = (time.at.stage == Stage::Corrector).then_some(total.energies);
    let interface = cross.as_ref().map(|cross| cross.sums()).unwrap_or_default();
    if *part == Part::Density {
        // The velocity of this stage is an extrapolation: no force has acted.
        return StageBooks { interface, ..StageBooks::default() };
    }
    outer.iter().for_each(|outer| forces += *outer);
    state.largest_acceleration = total.largest_acceleration;
    if *part == Part::Momentum {
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

/// Where particle `i` was at the start of the step whose corrector made `state` \[m\].
///
/// With leapfrog it is found from the step itself, to round-off.
pub fn start_of_step(state: &FluidState, workspace: &Workspace, time_step: f64, i: usize) -> Vector {
    if workspace.part == Part::Whole {
        return workspace.base.position[i];
    }
    let (x, v, rates) = (&state.position[i], &state.velocity[i], &workspace.rates[i]);
    let mean_velocity = v - rates.acceleration * (0.5 * time_step);
    x - (mean_velocity + rates.shift) * time_step
}

fn accounts(books: &Books, forces: &OuterForces, removed: Vector, duration: f64) -> Accounts {
    let mut accounts = Accounts::default();
    accounts.add(Account::BodyForce, forces.body.force);
    accounts.add(Account::Walls, forces.walls.force);
    accounts.add(Account::Damping, books.damping);
    accounts.add(Account::Stabilisers, forces.stabilisers.force);
    // Particles leave at step boundaries: the next step carries their momentum off in both of its stages.
    accounts.add(Account::Removed, -removed / duration);
    accounts
}

/// As [`accounts`], for angular momentum, of which `removed` \[kg m/s\] has left.
fn angular_budget(books: &AngularBooks, forces: &OuterForces, removed: f64, duration: f64) -> AngularBudget {
    let mut torques = Torques::default();
    torques.add(TorqueAccount::BodyForce, forces.body.torque);
    torques.add(TorqueAccount::Walls, forces.walls.torque);
    torques.add(TorqueAccount::Damping, books.damping);
    torques.add(TorqueAccount::Stabilisers, forces.stabilisers.torque);
    torques.add(TorqueAccount::OwnForces, forces.own_torque);
    torques.add(TorqueAccount::Removed, -removed / duration);
    torques.add(TorqueAccount::Shifting, books.shifting / duration);
    torques.add(TorqueAccount::TimeScheme, books.scheme / duration);
    AngularBudget {
        torques,
        change: books.change - removed,
        gross: books.gross_change + duration * books.gross_torque + removed.abs(),
    }
}
