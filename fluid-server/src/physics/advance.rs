//! Advancing the state by the rates and the books of a stage.

use std::ops::AddAssign;

use sph::ledger::{Account, Accounts, Energies, StageBooks};
use sph::stage::{Stage, StageTime};
use sph::vector::Vector;

use super::checks::{Findings, Values};
use super::look::Look;
use super::model::FluidModel;
use super::probes::energies_of;
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
        model,
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
        // One length for all, so that no index is checked.
        let n = particles.len();
        let (x, (v, rho)) = moving;
        let (x, v, rho, fluid) = (&mut x[..n], &mut v[..n], &mut rho[..n], &mut fluid[..n]);
        let (rates, mass) = (&step.rates[particles.clone()][..n], &step.mass[particles.clone()][..n]);
        let (x_0, (v_0, rho_0)) = base;
        let (density_rate, acceleration) = kept;
        let (mut books, mut found) = (Books::default(), Findings::default());
        for k in 0..n {
            let before = x[k];
            let particle = Particle { mass: mass[k], rates: &rates[k], shown: &fluid[k] };
            let moving = (&mut x[k], &mut v[k], &mut rho[k]);
            let mut shown_velocity = None;
            match step.part {
                Part::Whole => {
                    step.whole(&particle, moving, (&mut x_0[k], &mut v_0[k], &mut rho_0[k]), &mut books);
                }
                Part::Density => {
                    step.density(&particle, moving, &mut density_rate[k]);
                    shown_velocity = Some(v[k] + acceleration[k] * step.half);
                }
                Part::Momentum => {
                    let kept = (density_rate[k], &mut acceleration[k]);
                    step.momentum(&particle, moving, kept, &mut books);
                }
            }
            // Where particles go at known velocities it is known beforehand.
            if step.part != Part::Density {
                found.add_move(&(x[k] - before));
            }
            let i = particles.start + k;
            fluid[k] = look.at(i, (&x[k], &v[k], rho[k]), mass[k], shown_velocity, &mut found);
        }
        (of_task[0], findings[0]) = (books, found);
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

/// What is known of a particle before it is moved.
struct Particle<'a> {
    /// Mass per depth \[kg/m\].
    mass: f64,
    rates: &'a Rates,
    /// What neighbours have read.
    shown: &'a Record,
}

/// One stage's view on a particle.
struct Step<'a> {
    part: Part,
    stage: Stage,
    duration: f64,
    half: f64,
    density_age: f64,
    damping: f64,
    inverse_h: f64,
    gravity: Vector,
    model: &'a FluidModel,
    rates: &'a [Rates],
    mass: &'a [f64],
}

impl Step<'_> {
    /// Either stage of Eq. (30)-(31) from x_0, v_0 and ρ_0 at the start of the step, which the first one keeps. The
    /// position moves with the velocity of the stage state, and with the shift.
    #[inline(always)]
    fn whole(
        &self,
        particle: &Particle<'_>,
        (x, v, rho): Moving<'_>,
        (x_0, v_0, rho_0): Moving<'_>,
        books: &mut Books,
    ) {
        let (rates, duration) = (particle.rates, self.duration);
        if self.stage == Stage::Predictor {
            (*x_0, *v_0, *rho_0) = (*x, *v, *rho);
        }
        *x = *x_0 + (*v + rates.shift) * duration;
        *v = *v_0 + rates.acceleration * duration;
        *rho = *rho_0 + rates.density * duration;
        self.book(particle, v_0, (x, v, *rho), books);
    }

    /// The predictor of leapfrog.
    #[inline(always)]
    fn density(&self, particle: &Particle<'_>, (x, v, rho): Moving<'_>, density_rate: &mut f64) {
        let rate = particle.rates.density;
        *x += *v * self.half;
        *rho += self.density_age * (rate - *density_rate) + self.half * rate;
        *density_rate = rate;
    }

    /// The corrector of leapfrog.
    #[inline(always)]
    fn momentum(
        &self,
        particle: &Particle<'_>,
        (x, v, rho): Moving<'_>,
        (density_rate, before): (f64, &mut Vector),
        books: &mut Books,
    ) {
        let Self { half, duration, .. } = self;
        let (rates, start) = (particle.rates, *v);
        *v += rates.acceleration * *duration;
        *x += *v * *half + rates.shift * *duration;
        *rho += rates.density * *duration + density_rate * *half;
        *before = rates.acceleration;
        self.book(particle, &start, (x, v, *rho), books);
    }

    /// Books what happened to a particle that came from velocity `v_0` to where it is now.
    ///
    /// The scale of round-off in the momentum check counts for each particle, besides m|v| and m|a|, the size |p|V/h of
    /// the pair forces that cancel in its acceleration. The momentum is taken from the moved state, not from the
    /// forces: the books are checked against it.
    #[inline(always)]
    fn book(&self, particle: &Particle<'_>, v_0: &Vector, now: Values<'_>, books: &mut Books) {
        let Particle { mass: m, rates, shown } = *particle;
        let (_, v, _) = now;
        let acceleration = rates.acceleration.norm();
        books.damping += shown.velocity() * (-self.damping * m);
        books.gross += m * acceleration + shown.pressure().abs() * shown.volume() * self.inverse_h;
        books.largest_acceleration = books.largest_acceleration.max(acceleration);
        books.momentum += (*v - *v_0) * m;
        books.gross_momentum += m * (v.norm() + v_0.norm());
        if self.stage == Stage::Corrector {
            books.energies += energies_of(self.model, &self.gravity, m, now);
        }
    }
}
