//! Advancing the state by the rates, Eq. (30)-(31), and the books of a stage.

use std::ops::AddAssign;

use rayon::prelude::*;
use sph::ledger::{Account, Accounts, StageBooks};
use sph::stage::{Stage, StageTime};
use sph::sums::ordered_sum;
use sph::vector::Vector;

use super::model::FluidModel;
use super::pair::Record;
use super::rates::Rates;
use super::state::{Base, FluidState};
use super::workspace::Workspace;

/// Particles per task.
const TASK: usize = 1024;

/// Sums over all particles of the forces of a stage.
#[derive(Clone, Copy, Debug, Default)]
struct Forces {
    body: Vector,
    walls: Vector,
    damping: Vector,
    stabilisers: Vector,
    gross: f64,
    largest_acceleration: f64,
}

impl AddAssign for Forces {
    fn add_assign(&mut self, other: Self) {
        self.body += other.body;
        self.walls += other.walls;
        self.damping += other.damping;
        self.stabilisers += other.stabilisers;
        self.gross += other.gross;
        self.largest_acceleration = self.largest_acceleration.max(other.largest_acceleration);
    }
}

/// Sums over all particles of m (v − vⁿ) and of m |v| + m |vⁿ| \[kg/s\].
#[derive(Clone, Copy, Debug, Default)]
struct MomentumChange {
    net: Vector,
    gross: f64,
}

impl AddAssign for MomentumChange {
    fn add_assign(&mut self, other: Self) {
        self.net += other.net;
        self.gross += other.gross;
    }
}

/// Moves the state from the start of the step by the stage's duration and the rates in `workspace`.
///
/// ```text
/// φⁿ⁺¹ᐟ² = φⁿ + Δt/2 F(φⁿ)                                        Eq. (30)
/// φⁿ⁺¹   = φⁿ + Δt F(φⁿ⁺¹ᐟ²)                                      Eq. (31)
/// ```
pub fn advance(
    model: &FluidModel,
    state: &mut FluidState,
    workspace: &mut Workspace,
    time: &StageTime,
) -> StageBooks {
    let Workspace { base, fluid, rates, cross, .. } = workspace;
    if time.at.stage == Stage::Predictor {
        base.position.clone_from(&state.position);
        base.velocity.clone_from(&state.velocity);
        base.density.clone_from(&state.density);
    }
    let duration = time.duration();
    let forces = forces(model, state, fluid, rates, time);
    move_from_base(state, base, rates, duration);
    // Summed from the moved state, not from the forces: the books are checked against it.
    let momentum = ordered_sum(state.len(), |i| {
        let (m, v, v_base) = (state.mass[i], state.velocity[i], base.velocity[i]);
        MomentumChange { net: (v - v_base) * m, gross: m * (v.norm() + v_base.norm()) }
    });
    state.largest_acceleration = forces.largest_acceleration;
    StageBooks {
        interface: cross.as_ref().map(|cross| cross.sums()).unwrap_or_default(),
        accounts: accounts(&forces, state.removed_momentum, duration),
        duration,
        momentum_change: momentum.net - state.removed_momentum,
        gross_momentum: momentum.gross + duration * forces.gross + state.removed_momentum.norm(),
    }
}

fn accounts(forces: &Forces, removed: Vector, duration: f64) -> Accounts {
    let mut accounts = Accounts::default();
    accounts.add(Account::BodyForce, forces.body);
    accounts.add(Account::Walls, forces.walls);
    accounts.add(Account::Damping, forces.damping);
    accounts.add(Account::Stabilisers, forces.stabilisers);
    // Particles leave at step boundaries: the next step carries their momentum off in both of its stages.
    accounts.add(Account::Removed, -removed / duration);
    accounts
}

/// Sums of the stage's forces, taken before anything moves.
///
/// The scale of round-off in the momentum check counts for each particle, besides m|v| and m|a|, the size |p|V/h of
/// the pair forces that cancel in its acceleration.
fn forces(
    model: &FluidModel,
    state: &FluidState,
    fluid: &[Record],
    rates: &[Rates],
    time: &StageTime,
) -> Forces {
    let damping = model.damping_rate(time.state_time());
    let inverse_h = 1.0 / model.constants.smoothing_length;
    ordered_sum(state.len(), |i| {
        let (m, rates) = (state.mass[i], &rates[i]);
        let acceleration = rates.acceleration.norm();
        Forces {
            body: rates.body * m,
            walls: rates.walls * m,
            damping: state.velocity[i] * (-damping * m),
            stabilisers: rates.stabilisers * m,
            gross: m * acceleration + fluid[i].pressure.abs() * fluid[i].volume * inverse_h,
            largest_acceleration: acceleration,
        }
    })
}

fn move_from_base(state: &mut FluidState, base: &Base, rates: &[Rates], duration: f64) {
    let FluidState { position, velocity, density, .. } = state;
    (position, velocity, density).into_par_iter().with_min_len(TASK).enumerate().for_each(
        |(i, (x, v, rho))| {
            // The position moves with the velocity of the stage state, and with the shift.
            *x = base.position[i] + (*v + rates[i].shift) * duration;
            *v = base.velocity[i] + rates[i].acceleration * duration;
            *rho = base.density[i] + rates[i].density * duration;
        },
    );
}
