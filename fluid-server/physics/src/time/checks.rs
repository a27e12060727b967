//! Limits that a valid state keeps; a run that breaks one stops and reports where.

use serde::{Deserialize, Serialize};
use sph::coupling::solver::Divergence;
use sph::coupling::stage::StepStage;
use sph::lanes::{LanePass, Lanes, WIDTH};
use sph::laws::equation_of_state::LARGEST_COMPRESSION;
use sph::space::Space;
use sph::space::components::Components;
use sph::space::domain::Domain;
use sph::space::tensors::SpaceVector;

use crate::system::lane_arrays::{abs, largest, numbers, vectors};
use crate::system::model::FluidModel;
use crate::system::state::FluidState;

/// All bits of [`Lanes::below`].
const ALL_LANES: u8 = (1 << WIDTH) - 1;

/// Position \[m\], velocity \[m/s\] and density \[kg/m³\] of four particles.
#[derive(Clone, Copy, Debug)]
pub struct Motion<S: Space, L: Lanes> {
    /// Position x \[m\].
    pub x: S::Of<L>,
    /// Velocity v \[m/s\].
    pub v: S::Of<L>,
    /// Density ρ \[kg/m³\].
    pub rho: L,
}

/// Limits of a valid state.
#[derive(Clone, Copy, Debug)]
pub struct StateLimits<S: Space> {
    domain: Domain<S>,
    square_speed: f64,
    densities: [f64; 2],
}

impl<S: Space> StateLimits<S> {
    /// The limits of `model`.
    pub fn of(model: &FluidModel<S>) -> Self {
        let c = &model.constants;
        let highest = (1.0 + LARGEST_COMPRESSION) * c.rest_density;
        Self {
            domain: model.domain,
            square_speed: c.sound_speed.powi(2),
            densities: [model.equation_of_state.lowest_density(), highest],
        }
    }
}

/// Findings of a scan over particles.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct ScanFindings {
    /// First particle that breaks a limit, by its index in the scan or its [`FluidState::place`].
    first_bad: u64,
    largest_square_speed: f64,
    /// Square of the largest displacement since the lists were built \[m²\]; infinite where there are none.
    largest_square_displacement: f64,
    /// Square of the largest move in the stage that produced the state \[m²\]; zero from the
    /// predictor of leapfrog, whose velocities are known beforehand.
    pub largest_square_move: f64,
    /// Whether a particle is outside the domain.
    pub outside: bool,
}

impl Default for ScanFindings {
    fn default() -> Self {
        Self {
            first_bad: u64::MAX,
            largest_square_speed: 0.0,
            largest_square_displacement: 0.0,
            largest_square_move: 0.0,
            outside: false,
        }
    }
}

/// [`ScanFindings`] in lanes.
#[derive(Clone, Copy, Debug)]
pub struct LaneScanFindings<L> {
    first_bad: usize,
    square_speed: L,
    square_displacement: L,
    square_move: L,
    outside: bool,
}

impl<L: Lanes> LaneScanFindings<L> {
    /// Of no particle.
    #[inline(always)]
    pub fn none() -> Self {
        let zero = L::zero();
        Self {
            first_bad: usize::MAX,
            square_speed: zero,
            square_displacement: zero,
            square_move: zero,
            outside: false,
        }
    }

    /// Adds the particles from `first` on, displaced by `displacement` since the lists were built \[m\].
    #[inline(always)]
    pub fn add<S: Space>(
        &mut self,
        limits: &StateLimits<S>,
        first: usize,
        motion: &Motion<S, L>,
        displacement: Option<S::Of<L>>,
    ) {
        let StateLimits { domain, square_speed: limit, densities: [lowest, highest] } = limits;
        let Motion { x, v, rho: density } = *motion;
        let (square_speed, infinite) = (S::rounded_dot(v, v), L::splat(f64::INFINITY));
        // Comparisons with NaN are false.
        let mut valid = square_speed.below(L::splat(*limit))
            & L::splat(*lowest).below(density)
            & density.below(L::splat(*highest));
        for axis in 0..S::DIMENSIONS {
            valid &= abs(x[axis]).below(infinite);
            self.outside |= beyond(domain, axis, x[axis]);
        }
        let bad = valid ^ ALL_LANES;
        if bad != 0 {
            self.first_bad = self.first_bad.min(first + bad.trailing_zeros() as usize);
        }
        self.square_speed = square_speed.max(self.square_speed);
        let square = match displacement {
            Some(u) => S::rounded_dot(u, u),
            None => L::splat(f64::INFINITY),
        };
        self.square_displacement = square.max(self.square_displacement);
    }

    /// Adds particles that have moved by `u` \[m\].
    #[inline(always)]
    pub fn add_move<S: Space>(&mut self, u: S::Of<L>) {
        self.square_move = S::rounded_dot(u, u).max(self.square_move);
    }

    /// The findings of all lanes.
    #[inline(always)]
    pub fn total(&self) -> ScanFindings {
        ScanFindings {
            first_bad: if self.first_bad == usize::MAX { u64::MAX } else { self.first_bad as u64 },
            largest_square_speed: largest(self.square_speed),
            largest_square_displacement: largest(self.square_displacement),
            largest_square_move: largest(self.square_move),
            outside: self.outside,
        }
    }
}

/// Whether a coordinate along `axis` is beyond the sides of `domain`.
#[inline(always)]
fn beyond<S: Space, L: Lanes>(domain: &Domain<S>, axis: usize, x: L) -> bool {
    let (lower, upper) = (L::splat(domain.lower[axis]), L::splat(domain.upper[axis]));
    !domain.periodic[axis] && (x.below(lower) | upper.below(x)) != 0
}

impl ScanFindings {
    /// The findings of `tasks` in the scan of `state`.
    pub fn of_tasks<S: Space>(state: &FluidState<S>, tasks: &[Self]) -> Self {
        let mut own = tasks.iter().copied().fold(Self::default(), Self::with);
        if own.first_bad != u64::MAX {
            own.first_bad = state.place(own.first_bad as usize);
        }
        own
    }

    /// Adds the findings of other particles.
    pub fn add(&mut self, others: Self) {
        *self = self.with(others);
    }

    /// The findings of both.
    fn with(self, other: Self) -> Self {
        Self {
            first_bad: self.first_bad.min(other.first_bad),
            largest_square_speed: self.largest_square_speed.max(other.largest_square_speed),
            largest_square_displacement: self
                .largest_square_displacement
                .max(other.largest_square_displacement),
            largest_square_move: self.largest_square_move.max(other.largest_square_move),
            outside: self.outside || other.outside,
        }
    }

    /// Largest displacement since the lists were built \[m\].
    pub fn largest_displacement(&self) -> f64 {
        self.largest_square_displacement.sqrt()
    }

    /// Largest speed \[m/s\].
    ///
    /// # Errors
    /// The first particle that breaks a limit.
    pub fn verdict<S: Space>(
        &self,
        model: &FluidModel<S>,
        state: &FluidState<S>,
        at: StepStage,
    ) -> Result<f64, Box<Divergence>> {
        if self.first_bad == u64::MAX {
            Ok(self.largest_square_speed.sqrt())
        } else {
            let own = (0..state.len()).find(|i| state.place(*i) == self.first_bad);
            let found = own.map(|i| diagnosis(model, state, at, i));
            let found = model.team.join(found, |one, other| *one = one.take().or(other));
            Err(Box::new(found.unwrap_or_else(|| unreachable!("one part has the particle"))))
        }
    }
}

/// Largest speed \[m/s\] of a state that is finite and within the limits of weak compressibility.
///
/// # Errors
/// The first particle that is not.
pub fn check_state<S: Space>(
    model: &FluidModel<S>,
    state: &FluidState<S>,
    at: StepStage,
) -> Result<f64, Box<Divergence>> {
    let findings = model.arithmetic.run(CheckPass { limits: StateLimits::of(model), state });
    let own = ScanFindings::of_tasks(state, &[findings]);
    model.team.join(own, ScanFindings::add).verdict(model, state, at)
}

/// The scan of every particle, without displacements.
struct CheckPass<'a, S: Space> {
    limits: StateLimits<S>,
    state: &'a FluidState<S>,
}

impl<S: Space> LanePass for CheckPass<'_, S> {
    type Output = ScanFindings;

    #[inline(always)]
    fn run<L: Lanes>(self) -> ScanFindings {
        let Self { limits, state: FluidState { position, velocity, density, .. } } = self;
        let mut findings = LaneScanFindings::<L>::none();
        for first in (0..density.len()).step_by(WIDTH) {
            let (x, v) = (vectors::<S, L>(position, first), vectors::<S, L>(velocity, first));
            findings.add(&limits, first, &Motion::<S, L> { x, v, rho: numbers(density, first) }, None);
        }
        findings.total()
    }
}

/// The limit that particle `i` breaks.
fn diagnosis<S: Space>(model: &FluidModel<S>, state: &FluidState<S>, at: StepStage, i: usize) -> Divergence {
    let (x, v, density) = (state.position[i], state.velocity[i], state.density[i]);
    let (rest, c0) = (model.constants.rest_density, model.constants.sound_speed);
    let step = "a smaller time step or a smaller step factor usually cures this";
    let not_finite = |v: S::Vector| v.row().as_ref().iter().copied().find(|c| !c.is_finite());
    let (quantity, value, allowed, hint) = if let Some(value) = not_finite(x) {
        ("position [m]", value, "a finite number".to_string(), step.to_string())
    } else if not_finite(v).is_some() {
        ("speed [m/s]", v.norm(), "a finite number".to_string(), step.to_string())
    } else if !density.is_finite() {
        ("density [kg/m³]", density, "a finite number".to_string(), step.to_string())
    } else if v.norm() >= c0 {
        let allowed = format!("below the sound speed {c0} m/s");
        (
            "speed [m/s]",
            v.norm(),
            allowed,
            format!("{step}; else raise the sound speed, at least 10 times the largest speed"),
        )
    } else {
        let (low, high) = (model.equation_of_state.lowest_density(), (1.0 + LARGEST_COMPRESSION) * rest);
        let allowed = format!("{low:.3e} to {high:.3e} kg/m³");
        let cure = if density < low {
            "set `tension_limit_pa`, with which the fluid cavitates under tension"
        } else {
            "raise the sound speed or the artificial viscosity"
        };
        ("density [kg/m³]", density, allowed, format!("{step}; else {cure}"))
    };
    Divergence {
        at,
        particle: Some(state.id[i]),
        position: Some(x.row().as_ref().to_vec()),
        quantity: quantity.into(),
        value,
        allowed,
        hint,
    }
}
