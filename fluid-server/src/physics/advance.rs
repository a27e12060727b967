//! Advancing the state by the rates and the books of a stage.

use std::ops::AddAssign;

use sph::equation_of_state::Tait;
use sph::lanes::{Kernel, Lanes, WIDTH};
use sph::ledger::{Account, Accounts, Energies, StageBooks};
use sph::stage::{Stage, StageTime};
use sph::vector::Vector;

use super::checks::{Findings, LaneFindings};
use super::four::{abs, components, get, largest, numbers, put, rows, vectors, weight};
use super::look::Look;
use super::model::FluidModel;
use super::rates::{OuterForces, Part, Rates};
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
    /// Of the state that ends a step \[J/m\].
    energies: Energies,
}

impl AddAssign for Books {
    fn add_assign(&mut self, other: Self) {
        self.damping += other.damping;
        self.gross += other.gross;
        self.largest_acceleration = self.largest_acceleration.max(other.largest_acceleration);
        self.momentum += other.momentum;
        self.gross_momentum += other.gross_momentum;
        self.energies += other.energies;
    }
}

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
        let moves = Moves { step: &step, look: &look, first: particles.start, moving, kept, base, fluid };
        (of_task[0], findings[0]) = model.arithmetic.run(moves);
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
        duration,
        momentum_change: total.momentum - state.removed_momentum,
        gross_momentum: total.gross_momentum + duration * total.gross + state.removed_momentum.norm(),
    }
}

/// Position, velocity and density of the particles of a task.
type MovingOfTask<'a> = (&'a mut [Vector], (&'a mut [Vector], &'a mut [f64]));

/// The particles of one task and what is made of them.
///
/// No product is fused with a sum: all paths give the same bits.
struct Moves<'a> {
    step: &'a Step<'a>,
    look: &'a Look<'a>,
    /// The first particle.
    first: usize,
    moving: MovingOfTask<'a>,
    /// Density rate and acceleration that stay, with leapfrog.
    kept: (&'a mut [f64], &'a mut [Vector]),
    /// The start of the step, without.
    base: MovingOfTask<'a>,
    fluid: &'a mut [Record],
}

impl Kernel for Moves<'_> {
    type Output = (Books, Findings);

    #[inline(always)]
    fn run<L: Lanes>(self) -> (Books, Findings) {
        let Self { step, look, moving: (x, (v, rho)), fluid, .. } = self;
        let (x_0, (v_0, rho_0)) = self.base;
        let (density_rate, acceleration) = self.kept;
        let count = fluid.len();
        let (mut books, mut found) = (LaneBooks::<L>::none(), LaneFindings::<L>::none());
        for k in (0..count).step_by(WIDTH) {
            let i = self.first + k;
            let (rates, mass) = (LaneRates::<L>::of(get(step.rates, i)), numbers::<L>(step.mass, i));
            let start = Moving { x: vectors(x, k), v: vectors(v, k), rho: numbers(rho, k) };
            let mut shown_velocity = None;
            let end = match step.part {
                Part::Whole => {
                    if step.stage == Stage::Predictor {
                        start.put((x_0, v_0, rho_0), k);
                    }
                    let base = Moving { x: vectors(x_0, k), v: vectors(v_0, k), rho: numbers(rho_0, k) };
                    let end = step.whole(&rates, &base, start.v);
                    let shown = Shown::of(get(fluid, k), mass, weight(k, count));
                    step.book(&shown, &rates, base.v, &end, &mut books);
                    end
                }
                Part::Density => {
                    let (end, kept) = (step.density(&rates, &start, numbers(density_rate, k)), rates.density);
                    put(density_rate, k, kept.to_array());
                    shown_velocity = Some(add(end.v, vectors(acceleration, k), L::splat(step.half)));
                    end
                }
                Part::Momentum => {
                    let end = step.momentum(&rates, &start, numbers(density_rate, k));
                    let shown = Shown::of(get(fluid, k), mass, weight(k, count));
                    step.book(&shown, &rates, start.v, &end, &mut books);
                    put(acceleration, k, rates.own_acceleration);
                    end
                }
            };
            // Where particles go at known velocities it is known beforehand.
            if step.part != Part::Density {
                found.add_move([end.x[0] - start.x[0], end.x[1] - start.x[1]]);
            }
            end.put((x, v, rho), k);
            put(fluid, k, look.at(i, (end.x, end.v, end.rho), mass, shown_velocity, &mut found));
        }
        (books.total(), found.total())
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

/// Position, velocity and density of four particles.
struct Moving<L> {
    x: [L; 2],
    v: [L; 2],
    rho: L,
}

impl<L: Lanes> Moving<L> {
    /// Replaces those of the particles from `k` on.
    #[inline(always)]
    fn put(&self, (x, v, rho): (&mut [Vector], &mut [Vector], &mut [f64]), k: usize) {
        let [a, b, c, d] = rows([self.x[0], self.x[1], self.v[0], self.v[1]]);
        put(x, k, [a, b, c, d].map(|[x, y, ..]| Vector::new(x, y)));
        put(v, k, [a, b, c, d].map(|[.., x, y]| Vector::new(x, y)));
        put(rho, k, self.rho.to_array());
    }
}

/// [`Rates`] of four particles.
struct LaneRates<L> {
    acceleration: [L; 2],
    shift: [L; 2],
    density: L,
    own_acceleration: [Vector; WIDTH],
}

impl<L: Lanes> LaneRates<L> {
    #[inline(always)]
    fn of([a, b, c, d]: [Rates; WIDTH]) -> Self {
        let own_acceleration = [a.acceleration, b.acceleration, c.acceleration, d.acceleration];
        Self {
            acceleration: components(own_acceleration),
            shift: components([a.shift, b.shift, c.shift, d.shift]),
            density: L::from_array([a.density, b.density, c.density, d.density]),
            own_acceleration,
        }
    }
}

/// What neighbours have read of four particles; those beyond the last have no mass and no volume.
struct Shown<L> {
    velocity: [L; 2],
    pressure: L,
    volume: L,
    /// Mass per depth \[kg/m\].
    mass: L,
}

impl<L: Lanes> Shown<L> {
    #[inline(always)]
    fn of([a, b, c, d]: [Record; WIDTH], mass: L, weight: L) -> Self {
        let [_, _, v_x, v_y] = L::columns([&a.motion, &b.motion, &c.motion, &d.motion]);
        let [_, pressure, volume, _] = L::columns([&a.matter, &b.matter, &c.matter, &d.matter]);
        Self { velocity: [v_x, v_y], pressure, volume: volume * weight, mass: mass * weight }
    }
}

/// One stage's view on the particles.
struct Step<'a> {
    part: Part,
    stage: Stage,
    duration: f64,
    half: f64,
    density_age: f64,
    damping: f64,
    inverse_h: f64,
    gravity: Vector,
    equation_of_state: Tait,
    rates: &'a [Rates],
    mass: &'a [f64],
}

/// `a + b t`, each product rounded.
#[inline(always)]
fn add<L: Lanes>([a_x, a_y]: [L; 2], [b_x, b_y]: [L; 2], t: L) -> [L; 2] {
    [a_x + b_x * t, a_y + b_y * t]
}

/// Length of each vector.
#[inline(always)]
fn norm<L: Lanes>([x, y]: [L; 2]) -> L {
    (x * x + y * y).sqrt()
}

impl Step<'_> {
    /// Either stage of Eq. (30)-(31) from the start of the step. The position moves with the velocity `v` of the stage
    /// state, and with the shift.
    #[inline(always)]
    fn whole<L: Lanes>(&self, rates: &LaneRates<L>, base: &Moving<L>, v: [L; 2]) -> Moving<L> {
        let duration = L::splat(self.duration);
        let moves = [v[0] + rates.shift[0], v[1] + rates.shift[1]];
        Moving {
            x: add(base.x, moves, duration),
            v: add(base.v, rates.acceleration, duration),
            rho: base.rho + rates.density * duration,
        }
    }

    /// The predictor of leapfrog; `before` is the density rate at the start of the step before.
    #[inline(always)]
    fn density<L: Lanes>(&self, rates: &LaneRates<L>, start: &Moving<L>, before: L) -> Moving<L> {
        let (half, rate) = (L::splat(self.half), rates.density);
        let since = L::splat(self.density_age) * (rate - before) + half * rate;
        Moving { x: add(start.x, start.v, half), v: start.v, rho: start.rho + since }
    }

    /// The corrector of leapfrog, from the density rate of the predictor.
    #[inline(always)]
    fn momentum<L: Lanes>(&self, rates: &LaneRates<L>, start: &Moving<L>, density_rate: L) -> Moving<L> {
        let (half, duration) = (L::splat(self.half), L::splat(self.duration));
        let v = add(start.v, rates.acceleration, duration);
        let by = add([v[0] * half, v[1] * half], rates.shift, duration);
        Moving {
            x: [start.x[0] + by[0], start.x[1] + by[1]],
            v,
            rho: start.rho + (rates.density * duration + density_rate * half),
        }
    }

    /// Books what happened to particles that came from velocity `v_0` to where they are now.
    ///
    /// The scale of round-off in the momentum check counts for each particle, besides m|v| and m|a|, the size |p|V/h of
    /// the pair forces that cancel in its acceleration. The momentum is taken from the moved state, not from the
    /// forces: the books are checked against it.
    #[inline(always)]
    fn book<L: Lanes>(
        &self,
        shown: &Shown<L>,
        rates: &LaneRates<L>,
        v_0: [L; 2],
        now: &Moving<L>,
        books: &mut LaneBooks<L>,
    ) {
        let (m, v, acceleration) = (shown.mass, now.v, norm(rates.acceleration));
        books.damping = add(books.damping, shown.velocity, L::splat(-self.damping) * m);
        books.gross =
            books.gross + (m * acceleration + abs(shown.pressure) * shown.volume * L::splat(self.inverse_h));
        books.largest_acceleration = acceleration.max(books.largest_acceleration);
        books.momentum = add(books.momentum, [v[0] - v_0[0], v[1] - v_0[1]], m);
        books.gross_momentum = books.gross_momentum + m * (norm(v) + norm(v_0));
        if self.stage == Stage::Corrector {
            // As `energies_of`.
            let ([x, y], [g_x, g_y]) = (now.x, self.gravity.data.0[0]);
            let fall = L::splat(g_x) * x + L::splat(g_y) * y;
            books.kinetic = books.kinetic + L::splat(0.5) * m * (v[0] * v[0] + v[1] * v[1]);
            books.potential = books.potential - m * fall;
            books.internal = books.internal + m * self.equation_of_state.compression_energies(now.rho);
        }
    }
}

/// [`Books`] in lanes.
struct LaneBooks<L> {
    damping: [L; 2],
    gross: L,
    largest_acceleration: L,
    momentum: [L; 2],
    gross_momentum: L,
    kinetic: L,
    potential: L,
    internal: L,
}

impl<L: Lanes> LaneBooks<L> {
    #[inline(always)]
    fn none() -> Self {
        let zero = L::zero();
        Self {
            damping: [zero; 2],
            gross: zero,
            largest_acceleration: zero,
            momentum: [zero; 2],
            gross_momentum: zero,
            kinetic: zero,
            potential: zero,
            internal: zero,
        }
    }

    #[inline(always)]
    fn total(&self) -> Books {
        let ([damped_x, damped_y], [x, y]) = (self.damping, self.momentum);
        let [damped_x, damped_y, x, y] = L::sums([damped_x, damped_y, x, y]);
        let [gross, gross_momentum, kinetic, potential] =
            L::sums([self.gross, self.gross_momentum, self.kinetic, self.potential]);
        let [internal, ..] = L::sums([self.internal, L::zero(), L::zero(), L::zero()]);
        Books {
            damping: Vector::new(damped_x, damped_y),
            gross,
            largest_acceleration: largest(self.largest_acceleration),
            momentum: Vector::new(x, y),
            gross_momentum,
            energies: Energies { kinetic, potential, internal },
        }
    }
}
