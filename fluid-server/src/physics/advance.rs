//! Advancing the state by the rates, Eq. (30)-(31), and the books of a stage.

use std::ops::AddAssign;

use sph::ledger::{Account, Accounts, StageBooks};
use sph::stage::{Stage, StageTime};
use sph::vector::Vector;

use super::model::FluidModel;
use super::rates::{OuterForces, Rates};
use super::record::Record;
use super::state::FluidState;
use super::tasks::{PerTask, for_each_task, per_task};
use super::workspace::Workspace;

/// Sums over particles of the forces of a stage and of what they did to the momentum.
#[derive(Clone, Copy, Debug, Default)]
pub struct Books {
    damping: Vector,
    gross: f64,
    largest_acceleration: f64,
    /// Σ m (v − vⁿ) \[kg/s\].
    momentum: Vector,
    /// Σ m |v| + m |vⁿ| \[kg/s\].
    gross_momentum: f64,
}

impl AddAssign for Books {
    fn add_assign(&mut self, other: Self) {
        self.damping += other.damping;
        self.gross += other.gross;
        self.largest_acceleration = self.largest_acceleration.max(other.largest_acceleration);
        self.momentum += other.momentum;
        self.gross_momentum += other.gross_momentum;
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
    let Workspace { base, fluid, rates, cross, outer, books, .. } = workspace;
    let n = state.len();
    if time.at.stage == Stage::Predictor {
        base.position.resize(n, Vector::zeros());
        base.velocity.resize(n, Vector::zeros());
        base.density.resize(n, 0.0);
    }
    let step = Step {
        duration: time.duration(),
        predictor: time.at.stage == Stage::Predictor,
        damping: model.damping_rate(time.state_time()),
        inverse_h: 1.0 / model.constants.smoothing_length,
        fluid,
        rates,
        mass: &state.mass,
    };
    let moving = (&mut state.position[..], (&mut state.velocity[..], &mut state.density[..]));
    let from = (&mut base.position[..], (&mut base.velocity[..], &mut base.density[..]));
    let results = ((moving, from), per_task(books, n));
    for_each_task(n, results, &|particles, (((x, (v, rho)), (x_0, (v_0, rho_0))), PerTask(books))| {
        for (k, i) in particles.enumerate() {
            let moved = [&mut x[k], &mut x_0[k]];
            step.particle(i, moved, [&mut v[k], &mut v_0[k]], [&mut rho[k], &mut rho_0[k]], &mut books[0]);
        }
    });
    let (mut total, mut forces) = (Books::default(), OuterForces::default());
    books.iter().for_each(|books| total += *books);
    outer.iter().for_each(|outer| forces += *outer);
    state.largest_acceleration = total.largest_acceleration;
    let duration = step.duration;
    StageBooks {
        interface: cross.as_ref().map(|cross| cross.sums()).unwrap_or_default(),
        accounts: accounts(&total, &forces, state.removed_momentum, duration),
        duration,
        momentum_change: total.momentum - state.removed_momentum,
        gross_momentum: total.gross_momentum + duration * total.gross + state.removed_momentum.norm(),
    }
}

fn accounts(books: &Books, forces: &OuterForces, removed: Vector, duration: f64) -> Accounts {
    let mut accounts = Accounts::default();
    accounts.add(Account::BodyForce, forces.body);
    accounts.add(Account::Walls, forces.walls);
    accounts.add(Account::Damping, books.damping);
    accounts.add(Account::Stabilisers, forces.stabilisers);
    // Particles leave at step boundaries: the next step carries their momentum off in both of its stages.
    accounts.add(Account::Removed, -removed / duration);
    accounts
}

/// One stage's view on a particle.
struct Step<'a> {
    duration: f64,
    predictor: bool,
    damping: f64,
    inverse_h: f64,
    fluid: &'a [Record],
    rates: &'a [Rates],
    mass: &'a [f64],
}

impl Step<'_> {
    /// Moves particle `i`, whose values now and at the start of the step are given, and books what happens.
    ///
    /// The scale of round-off in the momentum check counts for each particle, besides m|v| and m|a|, the size |p|V/h of
    /// the pair forces that cancel in its acceleration. The momentum is taken from the moved state, not from the
    /// forces: the books are checked against it.
    #[inline]
    fn particle(
        &self,
        i: usize,
        [x, x_0]: [&mut Vector; 2],
        [v, v_0]: [&mut Vector; 2],
        [rho, rho_0]: [&mut f64; 2],
        books: &mut Books,
    ) {
        let (m, rates, fluid) = (self.mass[i], &self.rates[i], &self.fluid[i]);
        if self.predictor {
            (*x_0, *v_0, *rho_0) = (*x, *v, *rho);
        }
        let acceleration = rates.acceleration.norm();
        books.damping += *v * (-self.damping * m);
        books.gross += m * acceleration + fluid.pressure().abs() * fluid.volume() * self.inverse_h;
        books.largest_acceleration = books.largest_acceleration.max(acceleration);
        // The position moves with the velocity of the stage state, and with the shift.
        *x = *x_0 + (*v + rates.shift) * self.duration;
        *v = *v_0 + rates.acceleration * self.duration;
        *rho = *rho_0 + rates.density * self.duration;
        books.momentum += (*v - *v_0) * m;
        books.gross_momentum += m * (v.norm() + v_0.norm());
    }
}
