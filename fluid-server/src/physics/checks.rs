//! What a healthy state looks like; a run that leaves it stops and says where.

use rayon::prelude::*;
use sph::domain::Domain;
use sph::equation_of_state::LARGEST_COMPRESSION;
use sph::solver::Divergence;
use sph::stage::StepStage;
use sph::vector::Vector;

use super::model::FluidModel;
use super::state::FluidState;

/// Particles per task.
const TASK: usize = 2048;

/// Position \[m\], velocity \[m/s\] and density \[kg/m³\] of a particle.
pub type Values<'a> = (&'a Vector, &'a Vector, f64);

/// What the check compares with.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    domain: Domain,
    square_speed: f64,
    densities: [f64; 2],
}

impl Limits {
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

/// What the check gathers over the particles.
#[derive(Clone, Copy, Debug)]
pub struct Findings {
    /// First particle that breaks a limit.
    first_bad: usize,
    largest_square_speed: f64,
    /// Square of the largest displacement since the lists were built \[m²\]; infinite where there are none.
    pub largest_square_displacement: f64,
    /// Square of the largest move in the stage that made the state \[m²\]; the predictor of leapfrog, which goes on at known
    /// velocities, tells none.
    pub largest_square_move: f64,
    /// Whether a particle is outside the domain.
    pub outside: bool,
}

impl Default for Findings {
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

impl Findings {
    /// Adds particle `i` at `x`, which was at `origin` when the lists were built \[m\].
    #[inline(always)]
    pub fn add(&mut self, limits: &Limits, i: usize, (x, v, density): Values<'_>, origin: Option<&Vector>) {
        let Limits { domain, square_speed: limit, densities: [lowest, highest] } = limits;
        let square_speed = v.norm_squared();
        // Written so that NaN fails.
        let healthy = (square_speed < *limit)
            & (density > *lowest)
            & (density < *highest)
            & x.x.is_finite()
            & x.y.is_finite();
        if !healthy {
            self.first_bad = self.first_bad.min(i);
        }
        raise(&mut self.largest_square_speed, square_speed);
        let square = origin.map_or(f64::INFINITY, |origin| domain.separation(x, origin).norm_squared());
        raise(&mut self.largest_square_displacement, square);
        self.outside |= !domain.contains(x);
    }

    /// Adds a particle that has moved by `d` \[m\].
    #[inline(always)]
    pub fn add_move(&mut self, d: &Vector) {
        raise(&mut self.largest_square_move, d.norm_squared());
    }

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

    /// Largest speed \[m/s\].
    ///
    /// # Errors
    /// The first particle that is not healthy.
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

/// Makes `largest` at least `value`; NaN is told otherwise.
#[inline(always)]
fn raise(largest: &mut f64, value: f64) {
    if value > *largest {
        *largest = value;
    }
}

/// Largest speed \[m/s\] of a state that is finite and within the limits of weak compressibility.
///
/// # Errors
/// The first particle that is not.
pub fn check_state(model: &FluidModel, state: &FluidState, at: StepStage) -> Result<f64, Box<Divergence>> {
    let limits = Limits::of(model);
    let with = |mut findings: Findings, i: usize| {
        findings.add(&limits, i, (&state.position[i], &state.velocity[i], state.density[i]), None);
        findings
    };
    let particles = (0..state.len()).into_par_iter().with_min_len(TASK);
    let findings = particles.fold(Findings::default, with).reduce(Findings::default, Findings::with);
    findings.verdict(model, state, at)
}

/// What is wrong with particle `i`.
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
                 water is torn"
            ),
        )
    };
    Divergence {
        at,
        particle: Some(state.id[i]),
        position: Some([x.x, x.y]),
        quantity: quantity.into(),
        value,
        allowed,
        hint,
    }
}
