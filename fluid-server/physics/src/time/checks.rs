//! Limits that a valid state keeps; a run that breaks one stops and reports where.

use sph::coupling::solver::Divergence;
use sph::coupling::stage::StepStage;
use sph::lanes::{LanePass, Lanes, WIDTH};
use sph::laws::equation_of_state::LARGEST_COMPRESSION;
use sph::space::Plane;
use sph::space::domain::Domain;

use crate::system::lane_arrays::{abs, largest, numbers, vectors};
use crate::system::model::FluidModel;
use crate::system::state::FluidState;

/// All bits of [`Lanes::below`].
const ALL_LANES: u8 = (1 << WIDTH) - 1;

/// Position \[m\], velocity \[m/s\] and density \[kg/m³\] of four particles.
#[derive(Clone, Copy, Debug)]
pub struct Motion<L> {
    /// Position x \[m\].
    pub x: [L; 2],
    /// Velocity v \[m/s\].
    pub v: [L; 2],
    /// Density ρ \[kg/m³\].
    pub rho: L,
}

/// Limits of a valid state.
#[derive(Clone, Copy, Debug)]
pub struct StateLimits {
    domain: Domain,
    square_speed: f64,
    densities: [f64; 2],
}

impl StateLimits {
    /// The limits of `model`.
    pub fn of(model: &FluidModel) -> Self {
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
#[derive(Clone, Copy, Debug)]
pub struct ScanFindings {
    /// First particle that breaks a limit.
    first_bad: usize,
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
            first_bad: usize::MAX,
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
    pub fn add(
        &mut self,
        limits: &StateLimits,
        first: usize,
        motion: &Motion<L>,
        displacement: Option<[L; 2]>,
    ) {
        let StateLimits { domain, square_speed: limit, densities: [lowest, highest] } = limits;
        let Motion { x: [x, y], v: [v_x, v_y], rho: density } = *motion;
        let (square_speed, infinite) = (v_x * v_x + v_y * v_y, L::splat(f64::INFINITY));
        // Comparisons with NaN are false.
        let valid = square_speed.below(L::splat(*limit))
            & L::splat(*lowest).below(density)
            & density.below(L::splat(*highest))
            & abs(x).below(infinite)
            & abs(y).below(infinite);
        let bad = valid ^ ALL_LANES;
        if bad != 0 {
            self.first_bad = self.first_bad.min(first + bad.trailing_zeros() as usize);
        }
        self.square_speed = square_speed.max(self.square_speed);
        let square = match displacement {
            Some([x, y]) => x * x + y * y,
            None => L::splat(f64::INFINITY),
        };
        self.square_displacement = square.max(self.square_displacement);
        self.outside |= beyond(domain, 0, x) | beyond(domain, 1, y);
    }

    /// Adds particles that have moved by `x` and `y` \[m\].
    #[inline(always)]
    pub fn add_move(&mut self, [x, y]: [L; 2]) {
        self.square_move = (x * x + y * y).max(self.square_move);
    }

    /// The findings of all lanes.
    #[inline(always)]
    pub fn total(&self) -> ScanFindings {
        ScanFindings {
            first_bad: self.first_bad,
            largest_square_speed: largest(self.square_speed),
            largest_square_displacement: largest(self.square_displacement),
            largest_square_move: largest(self.square_move),
            outside: self.outside,
        }
    }
}

/// Whether a coordinate along `axis` is beyond the sides of `domain`.
#[inline(always)]
fn beyond<L: Lanes>(domain: &Domain, axis: usize, x: L) -> bool {
    let (lower, upper) = (L::splat(domain.lower[axis]), L::splat(domain.upper[axis]));
    !domain.periodic[axis] && (x.below(lower) | upper.below(x)) != 0
}

impl ScanFindings {
    /// The findings of both.
    pub fn with(self, other: Self) -> Self {
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
    pub fn verdict(
        &self,
        model: &FluidModel,
        state: &FluidState,
        at: StepStage,
    ) -> Result<f64, Box<Divergence>> {
        if self.first_bad == usize::MAX {
            Ok(self.largest_square_speed.sqrt())
        } else {
            Err(Box::new(diagnosis(model, state, at, self.first_bad)))
        }
    }
}

/// Largest speed \[m/s\] of a state that is finite and within the limits of weak compressibility.
///
/// # Errors
/// The first particle that is not.
pub fn check_state(model: &FluidModel, state: &FluidState, at: StepStage) -> Result<f64, Box<Divergence>> {
    model.arithmetic.run(CheckPass { limits: StateLimits::of(model), state }).verdict(model, state, at)
}

/// The scan of every particle, without displacements.
struct CheckPass<'a> {
    limits: StateLimits,
    state: &'a FluidState,
}

impl LanePass for CheckPass<'_> {
    type Output = ScanFindings;

    #[inline(always)]
    fn run<L: Lanes>(self) -> ScanFindings {
        let Self { limits, state: FluidState { position, velocity, density, .. } } = self;
        let mut findings = LaneScanFindings::<L>::none();
        for first in (0..density.len()).step_by(WIDTH) {
            let (x, v) = (vectors::<Plane, L>(position, first), vectors::<Plane, L>(velocity, first));
            findings.add(&limits, first, &Motion { x, v, rho: numbers(density, first) }, None);
        }
        findings.total()
    }
}

/// The limit that particle `i` breaks.
fn diagnosis(model: &FluidModel, state: &FluidState, at: StepStage, i: usize) -> Divergence {
    let (x, v, density) = (state.position[i], state.velocity[i], state.density[i]);
    let (rest, c0) = (model.constants.rest_density, model.constants.sound_speed);
    let step = "a smaller time step or a smaller step factor usually cures this";
    let (quantity, value, allowed, hint) = if !(x.x.is_finite() && x.y.is_finite()) {
        let value = if x.x.is_finite() { x.y } else { x.x };
        ("position [m]", value, "a finite number".to_string(), step.to_string())
    } else if !(v.x.is_finite() && v.y.is_finite()) {
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
        let allowed = format!("{low} to {high} kg/m³");
        (
            "density [kg/m³]",
            density,
            allowed,
            format!(
                "{step}; else raise the sound speed or the artificial viscosity, or set `tension_limit_pa` where \
                 the fluid is under tension"
            ),
        )
    };
    Divergence {
        at,
        particle: Some(state.id[i]),
        position: Some(x.as_slice().to_vec()),
        quantity: quantity.into(),
        value,
        allowed,
        hint,
    }
}
