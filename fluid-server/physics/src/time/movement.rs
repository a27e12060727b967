//! The pass that moves all particles by their rates, four at a time.

use sph::coupling::stage::Stage;
use sph::lanes::{LanePass, Lanes, WIDTH};
use sph::laws::equation_of_state::Tait;
use sph::space::{Plane, Space, Vector};

use super::checks::{LaneScanFindings, Motion, ScanFindings};
use super::momentum_budget::{LaneAngularBudget, LaneMomentumBudget, MomentumBudget};
use super::state_scan::StateScan;
use crate::rates::particle_rates::{Rates, StagePart};
use crate::system::lane_arrays::{abs, get, numbers, put, rows, vectors, weight};
use crate::system::packed_particle::{LaneMotion, LaneParticles, Packed, PackedParticle};
use crate::system::tasks::{PerTask, split_by_field};

/// Position, velocity and density of particles.
pub struct MotionSlices<'a> {
    /// Position \[m\].
    pub position: &'a mut [Vector],
    /// Velocity \[m/s\].
    pub velocity: &'a mut [Vector],
    /// Density \[kg/m³\].
    pub density: &'a mut [f64],
}

split_by_field!(MotionSlices { position, velocity, density });

/// Arrays that a stage changes.
pub struct StageSlices<'a> {
    /// The state.
    pub motion: MotionSlices<'a>,
    /// Density rate that the state keeps, with leapfrog \[kg/(m³ s)\].
    pub density_rate: &'a mut [f64],
    /// Acceleration that the state keeps, with leapfrog \[m/s²\].
    pub acceleration: &'a mut [Vector],
    /// The state at the start of the step, without leapfrog.
    pub base: MotionSlices<'a>,
    /// The particles as pair sums read them: of the stage state before, of the new state after.
    pub fluid: &'a mut [PackedParticle],
    /// Momentum budget.
    pub budget: PerTask<'a, MomentumBudget>,
    /// Findings in the new state.
    pub findings: PerTask<'a, ScanFindings>,
}

split_by_field!(StageSlices { motion, density_rate, acceleration, base, fluid, budget, findings });

/// The particles of one task.
///
/// No product is fused with a sum: all paths give the same bits.
pub struct Movement<'a> {
    /// Constants of the stage.
    pub step: &'a Step<'a>,
    /// The scan of the new state.
    pub scan: &'a StateScan<'a>,
    /// The first particle.
    pub first: usize,
    /// Their arrays.
    pub slices: StageSlices<'a>,
}

impl LanePass for Movement<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { step, scan, first, slices } = self;
        let StageSlices { mut motion, density_rate, acceleration, base: mut start_of_step, fluid, .. } =
            slices;
        let count = fluid.len();
        let (mut budget, mut findings) = (LaneMomentumBudget::<L>::none(), LaneScanFindings::<L>::none());
        for k in (0..count).step_by(WIDTH) {
            let i = first + k;
            let (rates, mass) = (LaneRates::<L>::of(get(step.rates, i)), numbers::<L>(step.mass, i));
            let start = Motion::get(&motion, k);
            let mut extrapolated = None;
            let end = match step.part {
                StagePart::Whole => {
                    if step.stage == Stage::Predictor {
                        start.put(&mut start_of_step, k);
                    }
                    let base = Motion::get(&start_of_step, k);
                    let end = step.whole(&rates, &base, start.v);
                    let particles = StageParticles::of(get(fluid, k), mass, weight(k, count));
                    let path = Path { base: &base, stage: start.x, end: &end };
                    step.account_for(&particles, &rates, &path, &mut budget);
                    end
                }
                StagePart::Density => {
                    let (end, kept) = (step.density(&rates, &start, numbers(density_rate, k)), rates.density);
                    put(density_rate, k, kept.to_array());
                    extrapolated =
                        Some(add(end.v, vectors::<Plane, L>(acceleration, k), L::splat(step.half)));
                    end
                }
                StagePart::Momentum => {
                    let end = step.momentum(&rates, &start, numbers(density_rate, k));
                    let particles = StageParticles::of(get(fluid, k), mass, weight(k, count));
                    // (xⁿ + Δt/2 vⁿ) × vⁿ = xⁿ × vⁿ: the position of the stage stands for that at the start.
                    let path = Path { base: &start, stage: start.x, end: &end };
                    step.account_for(&particles, &rates, &path, &mut budget);
                    put(acceleration, k, rates.own_acceleration);
                    end
                }
            };
            // Moves at known velocities are known beforehand.
            if step.part != StagePart::Density {
                findings.add_move([end.x[0] - start.x[0], end.x[1] - start.x[1]]);
            }
            end.put(&mut motion, k);
            put(fluid, k, scan.pack(i, &end, mass, extrapolated, &mut findings));
        }
        (slices.budget.0[0], slices.findings.0[0]) = (budget.total(), findings.total());
    }
}

impl<L: Lanes> Motion<L> {
    /// Those of the particles from `k` on.
    #[inline(always)]
    fn get(from: &MotionSlices, k: usize) -> Self {
        Self {
            x: vectors::<Plane, L>(from.position, k),
            v: vectors::<Plane, L>(from.velocity, k),
            rho: numbers(from.density, k),
        }
    }

    /// Replaces those of the particles from `k` on.
    #[inline(always)]
    fn put(&self, to: &mut MotionSlices, k: usize) {
        let [a, b, c, d] = rows([self.x[0], self.x[1], self.v[0], self.v[1]]);
        put(to.position, k, [a, b, c, d].map(|[x, y, ..]| Vector::new(x, y)));
        put(to.velocity, k, [a, b, c, d].map(|[.., x, y]| Vector::new(x, y)));
        put(to.density, k, self.rho.to_array());
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
            acceleration: Plane::lanes(own_acceleration.each_ref()),
            shift: Plane::lanes([&a.shift, &b.shift, &c.shift, &d.shift]),
            density: L::from_array([a.density, b.density, c.density, d.density]),
            own_acceleration,
        }
    }
}

/// Four particles as pair sums have read them in the stage; those beyond the last have no mass and no volume.
struct StageParticles<L> {
    velocity: [L; 2],
    pressure: L,
    volume: L,
    /// Mass per depth \[kg/m\].
    mass: L,
}

impl<L: Lanes> StageParticles<L> {
    #[inline(always)]
    fn of(particles: [PackedParticle; WIDTH], mass: L, weight: L) -> Self {
        let LaneParticles { motion: LaneMotion { v: velocity, .. }, pressure, volume, .. } =
            PackedParticle::lanes(particles.each_ref());
        Self { velocity, pressure, volume: volume * weight, mass: mass * weight }
    }
}

/// The path of four particles in a stage.
struct Path<'a, L> {
    /// The start of the step.
    base: &'a Motion<L>,
    /// Where the forces were evaluated \[m\].
    stage: [L; 2],
    /// The new state.
    end: &'a Motion<L>,
}

/// Constants of a stage.
pub struct Step<'a> {
    /// Part of the rates that the stage has computed.
    pub part: StagePart,
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
    /// Point about which torques are taken; `None` leaves angular momentum out \[m\].
    pub origin: Option<Vector>,
    /// For the energies.
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
    fn whole<L: Lanes>(&self, rates: &LaneRates<L>, base: &Motion<L>, v: [L; 2]) -> Motion<L> {
        let duration = L::splat(self.duration);
        let moves = [v[0] + rates.shift[0], v[1] + rates.shift[1]];
        Motion {
            x: add(base.x, moves, duration),
            v: add(base.v, rates.acceleration, duration),
            rho: base.rho + rates.density * duration,
        }
    }

    /// The predictor of leapfrog; `before` is the density rate at the start of the step before.
    #[inline(always)]
    fn density<L: Lanes>(&self, rates: &LaneRates<L>, start: &Motion<L>, before: L) -> Motion<L> {
        let (half, rate) = (L::splat(self.half), rates.density);
        let since = L::splat(self.density_age) * (rate - before) + half * rate;
        Motion { x: add(start.x, start.v, half), v: start.v, rho: start.rho + since }
    }

    /// The corrector of leapfrog, from the density rate of the predictor.
    #[inline(always)]
    fn momentum<L: Lanes>(&self, rates: &LaneRates<L>, start: &Motion<L>, density_rate: L) -> Motion<L> {
        let (half, duration) = (L::splat(self.half), L::splat(self.duration));
        let v = add(start.v, rates.acceleration, duration);
        let by = add([v[0] * half, v[1] * half], rates.shift, duration);
        Motion {
            x: [start.x[0] + by[0], start.x[1] + by[1]],
            v,
            rho: start.rho + (rates.density * duration + density_rate * half),
        }
    }

    /// Accounts for what happened to particles on their `path`.
    ///
    /// The scale of round-off in the momentum check adds for each particle to m|v| and m|a| the size |p|V/h of
    /// the pair forces that cancel in its acceleration. The momentum is taken from the moved state, not from the
    /// forces: the budget is checked against it.
    #[inline(always)]
    fn account_for<L: Lanes>(
        &self,
        particles: &StageParticles<L>,
        rates: &LaneRates<L>,
        path: &Path<'_, L>,
        budget: &mut LaneMomentumBudget<L>,
    ) {
        let (now, v_0) = (path.end, path.base.v);
        let (m, v, acceleration) = (particles.mass, now.v, norm(rates.acceleration));
        let gross_force =
            m * acceleration + abs(particles.pressure) * particles.volume * L::splat(self.inverse_h);
        let gross_momentum = m * (norm(v) + norm(v_0));
        budget.damping = add(budget.damping, particles.velocity, L::splat(-self.damping) * m);
        budget.gross = budget.gross + gross_force;
        budget.largest_acceleration = acceleration.max(budget.largest_acceleration);
        budget.momentum = add(budget.momentum, [v[0] - v_0[0], v[1] - v_0[1]], m);
        budget.gross_momentum = budget.gross_momentum + gross_momentum;
        if let Some(origin) = self.origin {
            let origin = [L::splat(origin.x), L::splat(origin.y)];
            let gross = (gross_force, gross_momentum);
            self.account_for_angular(particles, rates.shift, path, origin, gross, &mut budget.angular);
        }
        if self.stage == Stage::Corrector {
            // As `energies_of`.
            let ([x, y], [g_x, g_y]) = (now.x, self.gravity.data.0[0]);
            let fall = L::splat(g_x) * x + L::splat(g_y) * y;
            budget.kinetic = budget.kinetic + L::splat(0.5) * m * (v[0] * v[0] + v[1] * v[1]);
            budget.potential = budget.potential - m * fall;
            budget.internal = budget.internal + m * self.equation_of_state.compression_energies(now.rho);
        }
    }

    /// As [`Self::account_for`], for angular momentum about `origin` \[m\]; `gross` are the particles' scales of force
    /// \[N/m\] and momentum \[kg/s\].
    #[inline(always)]
    fn account_for_angular<L: Lanes>(
        &self,
        particles: &StageParticles<L>,
        shift: [L; 2],
        path: &Path<'_, L>,
        origin: [L; 2],
        gross: (L, L),
        budget: &mut LaneAngularBudget<L>,
    ) {
        let (m, arm, start, end) = (particles.mass, minus(path.stage, origin), path.base, path.end);
        let (distance, duration) = (norm(arm), L::splat(self.duration));
        let shifted = [shift[0] * duration, shift[1] * duration];
        let after_stage = minus(minus(end.x, path.stage), shifted);
        let before_stage = minus(path.stage, start.x);
        let change = cross(minus(end.x, origin), end.v) - cross(minus(start.x, origin), start.v);
        budget.change = budget.change + m * change;
        budget.gross_change = budget.gross_change + distance * gross.1;
        budget.gross_torque = budget.gross_torque + distance * gross.0;
        budget.damping = budget.damping - L::splat(self.damping) * m * cross(arm, particles.velocity);
        budget.shifting = budget.shifting + m * cross(shifted, end.v);
        budget.scheme = budget.scheme + m * (cross(after_stage, end.v) + cross(before_stage, start.v));
    }
}
