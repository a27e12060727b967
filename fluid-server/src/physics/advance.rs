//! Advancing the state by the rates and the books of a stage.

use std::ops::AddAssign;

use sph::ledger::{Account, Accounts, StageBooks};
use sph::stage::{Stage, StageTime};
use sph::vector::Vector;

use super::checks::{Findings, Limits};
use super::model::FluidModel;
use super::rates::{OuterForces, Part, Rates};
use super::record::Record;
use super::state::{Base, FluidState};
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

/// Moves the state by the rates in `workspace`.
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
    let Workspace { base, fluid, rates, cross, outer, books, findings, part, .. } = workspace;
    let n = state.len();
    if *part == Part::Whole && time.at.stage == Stage::Predictor {
        base.position.clone_from(&state.position);
        base.velocity.clone_from(&state.velocity);
        base.density.clone_from(&state.density);
    }
    let step = Step {
        part: *part,
        duration: time.duration(),
        half: 0.5 * time.time_step,
        density_age: state.density_age,
        damping: model.damping_rate(time.state_time()),
        inverse_h: 1.0 / model.constants.smoothing_length,
        fluid,
        rates,
        mass: &state.mass,
        base,
    };
    let moving = (&mut state.position[..], (&mut state.velocity[..], &mut state.density[..]));
    let kept = (&mut state.density_rate[..], &mut state.acceleration[..]);
    // The next stage looks at what the predictor has made.
    let ends_step = time.at.stage == Stage::Corrector;
    let sums = (per_task(books, n), per_task(findings, n));
    let limits = Limits::of(model);
    for_each_task(n, ((moving, kept), sums), &|particles, ((moving, kept), sums)| {
        let (PerTask(books), PerTask(findings)) = sums;
        let (x, (v, rho)) = moving;
        let (density_rate, acceleration) = kept;
        let mut found = Findings::default();
        for (k, i) in particles.enumerate() {
            let before = x[k];
            let moving = (&mut x[k], &mut v[k], &mut rho[k]);
            match step.part {
                Part::Whole => step.whole(i, moving, &mut books[0]),
                Part::Density => step.density(i, moving, &mut density_rate[k]),
                Part::Momentum => {
                    step.momentum(i, moving, (density_rate[k], &mut acceleration[k]), &mut books[0])
                }
            }
            if step.part != Part::Density {
                found.add_move(&(x[k] - before));
            }
            if ends_step {
                found.add(&limits, i, (&x[k], &v[k], rho[k]), None);
            }
        }
        findings[0] = found;
    });
    let (mut total, mut forces) = (Books::default(), OuterForces::default());
    books.iter().for_each(|books| total += *books);
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
    accounts.add(Account::BodyForce, forces.body);
    accounts.add(Account::Walls, forces.walls);
    accounts.add(Account::Damping, books.damping);
    accounts.add(Account::Stabilisers, forces.stabilisers);
    // Particles leave at step boundaries: the next step carries their momentum off in both of its stages.
    accounts.add(Account::Removed, -removed / duration);
    accounts
}

/// Position, velocity and density of a particle.
type Moving<'a> = (&'a mut Vector, &'a mut Vector, &'a mut f64);

/// One stage's view on a particle.
struct Step<'a> {
    part: Part,
    duration: f64,
    half: f64,
    density_age: f64,
    damping: f64,
    inverse_h: f64,
    fluid: &'a [Record],
    rates: &'a [Rates],
    mass: &'a [f64],
    base: &'a Base,
}

impl Step<'_> {
    /// Either stage of Eq. (30)-(31). The position moves with the velocity of the stage state, and with the shift.
    #[inline]
    fn whole(&self, i: usize, (x, v, rho): Moving<'_>, books: &mut Books) {
        let Self { rates, base, duration, .. } = self;
        let rates = &rates[i];
        *x = base.position[i] + (*v + rates.shift) * *duration;
        *v = base.velocity[i] + rates.acceleration * *duration;
        *rho = base.density[i] + rates.density * *duration;
        self.book(i, &base.velocity[i], v, books);
    }

    /// The predictor of leapfrog.
    #[inline]
    fn density(&self, i: usize, (x, v, rho): Moving<'_>, density_rate: &mut f64) {
        let rate = self.rates[i].density;
        *x += *v * self.half;
        *rho += self.density_age * (rate - *density_rate) + self.half * rate;
        *density_rate = rate;
    }

    /// The corrector of leapfrog.
    #[inline]
    fn momentum(
        &self,
        i: usize,
        (x, v, rho): Moving<'_>,
        (density_rate, before): (f64, &mut Vector),
        books: &mut Books,
    ) {
        let Self { rates, half, duration, .. } = self;
        let (rates, start) = (&rates[i], *v);
        *v += rates.acceleration * *duration;
        *x += *v * *half + rates.shift * *duration;
        *rho += rates.density * *duration + density_rate * *half;
        *before = rates.acceleration;
        self.book(i, &start, v, books);
    }

    /// Books what happened to particle `i`, which came from velocity `v_0` to `v`.
    ///
    /// The scale of round-off in the momentum check counts for each particle, besides m|v| and m|a|, the size |p|V/h of
    /// the pair forces that cancel in its acceleration. The momentum is taken from the moved state, not from the
    /// forces: the books are checked against it.
    #[inline(always)]
    fn book(&self, i: usize, v_0: &Vector, v: &Vector, books: &mut Books) {
        let (m, fluid) = (self.mass[i], &self.fluid[i]);
        let acceleration = self.rates[i].acceleration.norm();
        books.damping += fluid.velocity() * (-self.damping * m);
        books.gross += m * acceleration + fluid.pressure().abs() * fluid.volume() * self.inverse_h;
        books.largest_acceleration = books.largest_acceleration.max(acceleration);
        books.momentum += (*v - *v_0) * m;
        books.gross_momentum += m * (v.norm() + v_0.norm());
    }
}
