//! The pass over all particles that moves them by their rates, four at a time.

use sph::equation_of_state::Tait;
use sph::lanes::{Kernel, Lanes, WIDTH};
use sph::stage::Stage;
use sph::vector::Vector;

use super::checks::{Findings, LaneFindings};
use super::momentum_budget::{Books, LaneAngularBooks, LaneBooks};
use super::state_scan::Look;
use crate::rates::particle_rates::{Part, Rates};
use crate::system::lane_arrays::{abs, components, get, numbers, put, rows, vectors, weight};
use crate::system::packed_particle::Record;

/// Position, velocity and density of the particles of a task.
pub type MovingOfTask<'a> = (&'a mut [Vector], (&'a mut [Vector], &'a mut [f64]));

/// The particles of one task and what is made of them.
///
/// No product is fused with a sum: all paths give the same bits.
pub struct Movement<'a> {
    /// What the stage does.
    pub step: &'a Step<'a>,
    /// What is made of the new state.
    pub look: &'a Look<'a>,
    /// The first particle.
    pub first: usize,
    /// What moves.
    pub moving: MovingOfTask<'a>,
    /// Density rate and acceleration that stay, with leapfrog.
    pub kept: (&'a mut [f64], &'a mut [Vector]),
    /// The start of the step, without.
    pub base: MovingOfTask<'a>,
    /// What neighbours have read, and what they will read.
    pub fluid: &'a mut [Record],
}

impl Kernel for Movement<'_> {
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
                    step.book(&shown, &rates, &Path { base: &base, stage: start.x, end: &end }, &mut books);
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
                    // (xⁿ + Δt/2 vⁿ) × vⁿ = xⁿ × vⁿ: the half-way place serves as that at the start.
                    step.book(&shown, &rates, &Path { base: &start, stage: start.x, end: &end }, &mut books);
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

/// From where to where a stage has moved four particles.
struct Path<'a, L> {
    /// The start of the step.
    base: &'a Moving<L>,
    /// Where the forces were evaluated \[m\].
    stage: [L; 2],
    /// The new state.
    end: &'a Moving<L>,
}

/// What a stage does to the particles.
pub struct Step<'a> {
    /// Which rates there are.
    pub part: Part,
    /// Predictor or corrector.
    pub stage: Stage,
    /// From the start of the step to the new state \[s\].
    pub duration: f64,
    /// Half the step \[s\].
    pub half: f64,
    /// See [`crate::system::state::FluidState::density_age`] \[s\].
    pub density_age: f64,
    /// Rate by which velocities are damped \[1/s\].
    pub damping: f64,
    /// 1/h \[1/m\].
    pub inverse_h: f64,
    /// Constant part of the body force \[m/s²\].
    pub gravity: Vector,
    /// Point about which torques are taken; without one angular momentum is left out \[m\].
    pub origin: Option<Vector>,
    /// Of the energies.
    pub equation_of_state: Tait,
    /// Rates of all particles.
    pub rates: &'a [Rates],
    /// Mass per depth of all particles \[kg/m\].
    pub mass: &'a [f64],
}

/// `a + b t`, each product rounded.
#[inline(always)]
fn add<L: Lanes>([a_x, a_y]: [L; 2], [b_x, b_y]: [L; 2], t: L) -> [L; 2] {
    [a_x + b_x * t, a_y + b_y * t]
}

/// `a − b`.
#[inline(always)]
fn minus<L: Lanes>([a_x, a_y]: [L; 2], [b_x, b_y]: [L; 2]) -> [L; 2] {
    [a_x - b_x, a_y - b_y]
}

/// z component of `a × b`.
#[inline(always)]
fn cross<L: Lanes>([a_x, a_y]: [L; 2], [b_x, b_y]: [L; 2]) -> L {
    a_x * b_y - a_y * b_x
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

    /// Books what happened to particles on their `path`.
    ///
    /// The scale of round-off in the momentum check counts for each particle, besides m|v| and m|a|, the size |p|V/h of
    /// the pair forces that cancel in its acceleration. The momentum is taken from the moved state, not from the
    /// forces: the books are checked against it.
    #[inline(always)]
    fn book<L: Lanes>(
        &self,
        shown: &Shown<L>,
        rates: &LaneRates<L>,
        path: &Path<'_, L>,
        books: &mut LaneBooks<L>,
    ) {
        let (now, v_0) = (path.end, path.base.v);
        let (m, v, acceleration) = (shown.mass, now.v, norm(rates.acceleration));
        let gross_force = m * acceleration + abs(shown.pressure) * shown.volume * L::splat(self.inverse_h);
        let gross_momentum = m * (norm(v) + norm(v_0));
        books.damping = add(books.damping, shown.velocity, L::splat(-self.damping) * m);
        books.gross = books.gross + gross_force;
        books.largest_acceleration = acceleration.max(books.largest_acceleration);
        books.momentum = add(books.momentum, [v[0] - v_0[0], v[1] - v_0[1]], m);
        books.gross_momentum = books.gross_momentum + gross_momentum;
        if let Some(origin) = self.origin {
            let origin = [L::splat(origin.x), L::splat(origin.y)];
            let gross = (gross_force, gross_momentum);
            self.book_angular(shown, rates.shift, path, origin, gross, &mut books.angular);
        }
        if self.stage == Stage::Corrector {
            // As `energies_of`.
            let ([x, y], [g_x, g_y]) = (now.x, self.gravity.data.0[0]);
            let fall = L::splat(g_x) * x + L::splat(g_y) * y;
            books.kinetic = books.kinetic + L::splat(0.5) * m * (v[0] * v[0] + v[1] * v[1]);
            books.potential = books.potential - m * fall;
            books.internal = books.internal + m * self.equation_of_state.compression_energies(now.rho);
        }
    }

    /// The part of [`Self::book`] for angular momentum about `origin` \[m\]; `gross` are the particles' scales of force
    /// \[N/m\] and momentum \[kg/s\].
    #[inline(always)]
    fn book_angular<L: Lanes>(
        &self,
        shown: &Shown<L>,
        shift: [L; 2],
        path: &Path<'_, L>,
        origin: [L; 2],
        gross: (L, L),
        books: &mut LaneAngularBooks<L>,
    ) {
        let (m, arm, start, end) = (shown.mass, minus(path.stage, origin), path.base, path.end);
        let (distance, duration) = (norm(arm), L::splat(self.duration));
        let shifted = [shift[0] * duration, shift[1] * duration];
        let after_stage = minus(minus(end.x, path.stage), shifted);
        let before_stage = minus(path.stage, start.x);
        let change = cross(minus(end.x, origin), end.v) - cross(minus(start.x, origin), start.v);
        books.change = books.change + m * change;
        books.gross_change = books.gross_change + distance * gross.1;
        books.gross_torque = books.gross_torque + distance * gross.0;
        books.damping = books.damping - L::splat(self.damping) * m * cross(arm, shown.velocity);
        books.shifting = books.shifting + m * cross(shifted, end.v);
        books.scheme = books.scheme + m * (cross(after_stage, end.v) + cross(before_stage, start.v));
    }
}
