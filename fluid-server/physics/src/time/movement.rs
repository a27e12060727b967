//! The pass that moves all particles by their rates, four at a time.

use sph::coupling::stage::Stage;
use sph::lanes::{LanePass, Lanes, WIDTH};
use sph::laws::equation_of_state::Tait;
use sph::space::Space;
use sph::tasks::PerTask;

use super::checks::{LaneScanFindings, Motion, ScanFindings};
use super::compression_budget::{DensityChange, LaneCompressionBudget};
use super::lane_rates::LaneRates;
use super::momentum_budget::{LaneAngularBudget, LaneMomentumBudget, MomentumBudget};
use super::stage_relaxation::StageRelaxation;
use super::state_scan::StateScan;
use crate::rates::particle_rates::{Rates, StagePart};
use crate::system::lane_arrays::{abs, get, numbers, put, vectors, weight};
use crate::system::packed_particle::{FluidSpace, LaneMotion, LaneParticles, Packed};
use crate::system::tasks::split_by_field;

/// Position, velocity, density and pressure of the acoustic relaxation of particles.
pub struct MotionSlices<'a, S: FluidSpace> {
    /// Position \[m\].
    pub position: &'a mut [S::Vector],
    /// Velocity \[m/s\].
    pub velocity: &'a mut [S::Vector],
    /// Density \[kg/m³\].
    pub density: &'a mut [f64],
    /// q \[Pa\]; empty without acoustic relaxation.
    pub relaxation: &'a mut [f64],
}

split_by_field!(MotionSlices<S> { position, velocity, density, relaxation });

/// Arrays that a stage changes.
pub struct StageSlices<'a, S: FluidSpace> {
    /// The state.
    pub motion: MotionSlices<'a, S>,
    /// Density rate that the state keeps, with leapfrog \[kg/(m³ s)\].
    pub density_rate: &'a mut [f64],
    /// Density rate by diffusion and volume correction that the state keeps, with leapfrog \[kg/(m³ s)\].
    pub density_correction: &'a mut [f64],
    /// Acceleration that the state keeps, with leapfrog \[m/s²\].
    pub acceleration: &'a mut [S::Vector],
    /// The state at the start of the step, without leapfrog.
    pub base: MotionSlices<'a, S>,
    /// The particles as pair sums read them: of the stage state before, of the new state after.
    pub fluid: &'a mut [S::Particle],
    /// Momentum budget.
    pub budget: PerTask<'a, MomentumBudget<S>>,
    /// Findings in the new state.
    pub findings: PerTask<'a, ScanFindings>,
}

split_by_field!(StageSlices<S> {
    motion,
    density_rate,
    density_correction,
    acceleration,
    base,
    fluid,
    budget,
    findings
});

/// The particles of one group.
///
/// Compiled with acoustic relaxation and without it. No product is fused with a sum: all paths give the same bits.
pub struct Movement<'a, S: FluidSpace, const RELAXES: bool> {
    /// Constants of the stage.
    pub step: &'a Step<'a, S>,
    /// The scan of the new state.
    pub scan: &'a StateScan<'a, S>,
    /// The first particle.
    pub first: usize,
    /// Their arrays.
    pub slices: StageSlices<'a, S>,
}

impl<S: FluidSpace, const RELAXES: bool> LanePass for Movement<'_, S, RELAXES> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { step, scan, first, slices } = self;
        let StageSlices {
            mut motion,
            density_rate,
            density_correction,
            acceleration,
            base: mut start_of_step,
            fluid,
            ..
        } = slices;
        let count = fluid.len();
        // Lanes beyond the last particle repeat it.
        let all = first..first + count;
        let (scan, step_rates, step_mass) =
            (scan.within(all.clone()), &step.rates[all.clone()], &step.mass[all.clone()]);
        let continuity = if step.continuity.is_empty() { &[] } else { &step.continuity[all] };
        let relaxation = if RELAXES { step.relaxation } else { None };
        let mut compression = LaneCompressionBudget::<L>::none();
        let (mut budget, mut findings) = (LaneMomentumBudget::<S, L>::none(), LaneScanFindings::<L>::none());
        for k in (0..count).step_by(WIDTH) {
            let (rates, mass) = (LaneRates::<S, L>::of(get(step_rates, k)), numbers::<L>(step_mass, k));
            let start = Motion::<S, L>::get(&motion, k);
            let (mut extrapolated, mut q) = (None, None);
            let weighted = mass * weight(k, count);
            // The density and the pressure by Eq. (3) where this stage starts, and how it changes the density.
            let (end, from, change) = match step.part {
                StagePart::Whole => {
                    if step.stage == Stage::Predictor {
                        start.put(&mut start_of_step, k);
                    }
                    let rate = numbers(continuity, k);
                    if let Some(law) = &relaxation {
                        if step.stage == Stage::Predictor {
                            put(start_of_step.relaxation, k, get(motion.relaxation, k));
                        }
                        let q_0 = numbers(start_of_step.relaxation, k);
                        compression.relaxes(law.lost(q_0, rate, weighted, start.rho));
                        q = Some(law.advanced(q_0, rate));
                    }
                    let base = Motion::get(&start_of_step, k);
                    let end = step.whole(&rates, &base, start.v);
                    let particles = StageParticles::of(get(fluid, k), mass, weight(k, count));
                    let path = Path { base: &base, stage: start.x, end: &end };
                    step.account_for(&particles, &rates, &path, &mut budget);
                    let (from, duration) = ((base.rho, scan.pressures(base.rho)), step.duration);
                    (end, from, rates.change(rate * L::splat(duration), rates.density - rate, duration))
                }
                StagePart::Density => {
                    let (before, kept) = (numbers(density_rate, k), rates.density);
                    let correction = numbers::<L>(density_correction, k) * L::splat(step.density_age);
                    let by_continuity = step.predicted_change(kept, before);
                    let end = step.density(&start, by_continuity + correction);
                    if let Some(law) = &relaxation {
                        let q_0 = numbers(motion.relaxation, k);
                        compression.relaxes(law.lost(
                            law.corrected(q_0, kept, before),
                            kept,
                            weighted,
                            start.rho,
                        ));
                        q = Some(law.predicted(q_0, kept, before));
                    }
                    put(density_rate, k, kept.to_array());
                    if step.extrapolates {
                        let acceleration = vectors::<S, L>(acceleration, k);
                        extrapolated = Some(add::<S, L>(end.v, acceleration, L::splat(step.half)));
                    }
                    let change = DensityChange::after_boundary(by_continuity, correction);
                    (end, (start.rho, scan.pressures(start.rho)), change)
                }
                StagePart::Momentum => {
                    let end = step.momentum(&rates, &start, numbers(density_rate, k));
                    let particles = StageParticles::of(get(fluid, k), mass, weight(k, count));
                    // (xⁿ + Δt/2 vⁿ) × vⁿ = xⁿ × vⁿ: the position of the stage stands for that at the start.
                    let path = Path { base: &start, stage: start.x, end: &end };
                    step.account_for(&particles, &rates, &path, &mut budget);
                    put(acceleration, k, rates.own_acceleration);
                    put(density_correction, k, rates.density.to_array());
                    let (rate, mut pressure) = (numbers(density_rate, k), particles.pressure);
                    if let Some(law) = &relaxation {
                        let q_0 = numbers(motion.relaxation, k);
                        compression.relaxes(law.lost(q_0, rate, weighted, start.rho));
                        q = Some(law.advanced(q_0, rate));
                        // Pair sums have read the pressure with it.
                        pressure = pressure - q_0;
                    }
                    (end, (start.rho, pressure), rates.change_to_boundary(rate, step.half))
                }
            };
            // Moves at known velocities are known beforehand.
            if step.part != StagePart::Density {
                findings.add_move::<S>(S::minus(end.x, start.x));
            }
            end.put(&mut motion, k);
            let mut pressure = scan.pressures(end.rho);
            compression.compresses(weighted, [from, (end.rho, pressure)], &change);
            if let (Some(law), Some(free)) = (&relaxation, q) {
                let new = law.limited(free, pressure);
                put(motion.relaxation, k, new.to_array());
                let stored = law.law.stored_energy(new, weighted, end.rho);
                compression.relaxes(law.law.stored_energy(free, weighted, end.rho) - stored);
                budget.relaxation = budget.relaxation + stored;
                pressure = pressure + new;
            }
            put(fluid, k, scan.pack(k, &end, mass, extrapolated, pressure, &mut findings));
        }
        (slices.budget.0[0], slices.findings.0[0]) = (budget.total(compression.total()), findings.total());
    }
}

impl<S: FluidSpace, L: Lanes> Motion<S, L> {
    /// Those of the particles from `k` on.
    #[inline(always)]
    fn get(from: &MotionSlices<S>, k: usize) -> Self {
        Self {
            x: vectors::<S, L>(from.position, k),
            v: vectors::<S, L>(from.velocity, k),
            rho: numbers(from.density, k),
        }
    }

    /// Replaces those of the particles from `k` on.
    #[inline(always)]
    fn put(&self, to: &mut MotionSlices<S>, k: usize) {
        let pairs = S::vector_pairs(self.x, self.v);
        put(to.position, k, pairs.map(|[x, _]| x));
        put(to.velocity, k, pairs.map(|[_, v]| v));
        put(to.density, k, self.rho.to_array());
    }
}

/// Four particles as pair sums have read them in the stage; those beyond the last have no mass and no volume.
struct StageParticles<S: Space, L: Lanes> {
    velocity: S::Of<L>,
    pressure: L,
    volume: L,
    /// Mass per depth \[kg/m\].
    mass: L,
}

impl<S: FluidSpace, L: Lanes> StageParticles<S, L> {
    #[inline(always)]
    fn of(particles: [S::Particle; WIDTH], mass: L, weight: L) -> Self {
        let LaneParticles { motion: LaneMotion { v: velocity, .. }, pressure, volume, .. } =
            S::Particle::lanes(particles.each_ref());
        Self { velocity, pressure, volume: volume * weight, mass: mass * weight }
    }
}

/// The path of four particles in a stage.
struct Path<'a, S: Space, L: Lanes> {
    /// The start of the step.
    base: &'a Motion<S, L>,
    /// Where the forces were evaluated \[m\].
    stage: S::Of<L>,
    /// The new state.
    end: &'a Motion<S, L>,
}

/// Constants of a stage.
pub struct Step<'a, S: Space> {
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
    /// Whether the corrector reads velocities that are extrapolated, with leapfrog.
    pub extrapolates: bool,
    /// Rate by which velocities are damped \[1/s\].
    pub damping: f64,
    /// 1/h \[1/m\].
    pub inverse_h: f64,
    /// The part of gravity that has a potential \[m/s²\].
    pub gravity: S::Vector,
    /// Point about which torques are taken; `None` leaves angular momentum out \[m\].
    pub origin: Option<S::Vector>,
    /// For the energies.
    pub equation_of_state: Tait,
    /// Acoustic relaxation, if there is any.
    pub relaxation: Option<StageRelaxation>,
    /// Rates of all particles.
    pub rates: &'a [Rates<S>],
    /// The part of their density rates by continuity, where the stage has computed all rates \[kg/(m³ s)\].
    pub continuity: &'a [f64],
    /// Mass per depth of all particles \[kg/m\].
    pub mass: &'a [f64],
}

/// `a + b t`, each product rounded.
#[inline(always)]
fn add<S: Space, L: Lanes>(a: S::Of<L>, b: S::Of<L>, t: L) -> S::Of<L> {
    S::plus(a, S::scaled(b, t))
}

/// Length of each vector.
#[inline(always)]
fn norm<S: Space, L: Lanes>(a: S::Of<L>) -> L {
    S::rounded_dot(a, a).sqrt()
}

impl<S: Space> Step<'_, S> {
    /// Either stage of Eq. (30)-(31) from the start of the step. The position moves with the velocity `v` of the stage
    /// state, and with the shift.
    #[inline(always)]
    fn whole<L: Lanes>(&self, rates: &LaneRates<S, L>, base: &Motion<S, L>, v: S::Of<L>) -> Motion<S, L> {
        let duration = L::splat(self.duration);
        let moves = S::plus(v, rates.shift);
        Motion {
            x: add::<S, L>(base.x, moves, duration),
            v: add::<S, L>(base.v, rates.acceleration, duration),
            rho: base.rho + rates.density * duration,
        }
    }

    /// The predictor of leapfrog, with its change of the density \[kg/m³\].
    #[inline(always)]
    fn density<L: Lanes>(&self, start: &Motion<S, L>, change: L) -> Motion<S, L> {
        Motion { x: add::<S, L>(start.x, start.v, L::splat(self.half)), v: start.v, rho: start.rho + change }
    }

    /// Change of the density by continuity in the predictor of leapfrog \[kg/m³\] at a density `rate`, that at the start
    /// of the step before having been `before`.
    #[inline(always)]
    fn predicted_change<L: Lanes>(&self, rate: L, before: L) -> L {
        L::splat(self.density_age) * (rate - before) + L::splat(self.half) * rate
    }

    /// The corrector of leapfrog, from the density rate of the predictor.
    #[inline(always)]
    fn momentum<L: Lanes>(
        &self,
        rates: &LaneRates<S, L>,
        start: &Motion<S, L>,
        density_rate: L,
    ) -> Motion<S, L> {
        let (half, duration) = (L::splat(self.half), L::splat(self.duration));
        let v = add::<S, L>(start.v, rates.acceleration, duration);
        let by = add::<S, L>(S::scaled(v, half), rates.shift, duration);
        Motion { x: S::plus(start.x, by), v, rho: start.rho + (rates.density + density_rate) * half }
    }

    /// Accounts for what happened to particles on their `path`.
    ///
    /// The scale of round-off in the momentum check adds for each particle to m|v| and m|a| the size |p|V/h of
    /// the pair forces that cancel in its acceleration. The momentum is taken from the moved state, not from the
    /// forces: the budget is checked against it.
    #[inline(always)]
    fn account_for<L: Lanes>(
        &self,
        particles: &StageParticles<S, L>,
        rates: &LaneRates<S, L>,
        path: &Path<'_, S, L>,
        budget: &mut LaneMomentumBudget<S, L>,
    ) {
        let (now, v_0) = (path.end, path.base.v);
        let (m, v, acceleration) = (particles.mass, now.v, norm::<S, L>(rates.acceleration));
        let gross_force =
            m * acceleration + abs(particles.pressure) * particles.volume * L::splat(self.inverse_h);
        let gross_momentum = m * (norm::<S, L>(v) + norm::<S, L>(v_0));
        budget.damping = add::<S, L>(budget.damping, particles.velocity, L::splat(-self.damping) * m);
        budget.gross = budget.gross + gross_force;
        budget.largest_acceleration = acceleration.max(budget.largest_acceleration);
        budget.momentum = add::<S, L>(budget.momentum, S::minus(v, v_0), m);
        budget.gross_momentum = budget.gross_momentum + gross_momentum;
        if let Some(origin) = self.origin {
            let origin = S::splat_vector(&origin);
            let gross = (gross_force, gross_momentum);
            self.account_for_angular(particles, rates.shift, path, origin, gross, &mut budget.angular);
        }
        if self.stage == Stage::Corrector {
            // As `energies_of`.
            let fall = S::rounded_dot(S::splat_vector(&self.gravity), now.x);
            budget.kinetic = budget.kinetic + L::splat(0.5) * m * S::rounded_dot(v, v);
            budget.potential = budget.potential - m * fall;
            budget.internal = budget.internal + m * self.equation_of_state.compression_energies(now.rho);
        }
    }

    /// As [`Self::account_for`], for angular momentum about `origin` \[m\]; `gross` are the particles' scales of force
    /// \[N/m\] and momentum \[kg/s\].
    #[inline(always)]
    fn account_for_angular<L: Lanes>(
        &self,
        particles: &StageParticles<S, L>,
        shift: S::Of<L>,
        path: &Path<'_, S, L>,
        origin: S::Of<L>,
        gross: (L, L),
        budget: &mut LaneAngularBudget<S, L>,
    ) {
        let (m, arm, start, end) = (particles.mass, S::minus(path.stage, origin), path.base, path.end);
        let (distance, duration) = (norm::<S, L>(arm), L::splat(self.duration));
        let shifted = S::scaled(shift, duration);
        let after_stage = S::minus(S::minus(end.x, path.stage), shifted);
        let before_stage = S::minus(path.stage, start.x);
        let moment = S::rounded_cross(S::minus(end.x, origin), end.v);
        let change = S::spin_minus(moment, S::rounded_cross(S::minus(start.x, origin), start.v));
        budget.change = S::spin_plus(budget.change, S::spin_scaled(change, m));
        budget.gross_change = budget.gross_change + distance * gross.1;
        budget.gross_torque = budget.gross_torque + distance * gross.0;
        let damped = S::spin_scaled(S::rounded_cross(arm, particles.velocity), L::splat(self.damping) * m);
        budget.damping = S::spin_minus(budget.damping, damped);
        let of_shift = S::spin_scaled(S::rounded_cross(shifted, end.v), m);
        budget.shifting = S::spin_plus(budget.shifting, of_shift);
        let of_scheme =
            S::spin_plus(S::rounded_cross(after_stage, end.v), S::rounded_cross(before_stage, start.v));
        budget.scheme = S::spin_plus(budget.scheme, S::spin_scaled(of_scheme, m));
    }
}
