//! What a healthy state looks like; a run that leaves it stops and says where.

use rayon::prelude::*;
use sph::equation_of_state::LARGEST_COMPRESSION;
use sph::solver::Divergence;
use sph::stage::StepStage;

use super::model::FluidModel;
use super::state::FluidState;

/// Particles per task.
const TASK: usize = 2048;

/// What the check gathers over the particles.
#[derive(Clone, Copy)]
struct Findings {
    /// First particle that breaks a limit.
    first_bad: usize,
    largest_square_speed: f64,
}

/// Largest speed \[m/s\] of a state that is finite and within the limits of weak compressibility.
///
/// # Errors
/// The first particle that is not.
pub fn check_state(model: &FluidModel, state: &FluidState, at: StepStage) -> Result<f64, Box<Divergence>> {
    let square_limit = model.constants.sound_speed.powi(2);
    let rest_density = model.constants.rest_density;
    let healthy = |i: usize, square_speed: f64| {
        let x = &state.position[i];
        // Written so that NaN fails.
        square_speed < square_limit
            && (state.density[i] - rest_density).abs() < LARGEST_COMPRESSION * rest_density
            && x.x.is_finite()
            && x.y.is_finite()
    };
    let none = || Findings { first_bad: usize::MAX, largest_square_speed: 0.0 };
    let findings = (0..state.len())
        .into_par_iter()
        .with_min_len(TASK)
        .map(|i| {
            let square_speed = state.velocity[i].norm_squared();
            let first_bad = if healthy(i, square_speed) { usize::MAX } else { i };
            Findings { first_bad, largest_square_speed: square_speed }
        })
        .reduce(none, |a, b| Findings {
            first_bad: a.first_bad.min(b.first_bad),
            largest_square_speed: a.largest_square_speed.max(b.largest_square_speed),
        });
    if findings.first_bad == usize::MAX {
        Ok(findings.largest_square_speed.sqrt())
    } else {
        Err(Box::new(diagnosis(model, state, at, findings.first_bad)))
    }
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
        let (low, high) = ((1.0 - LARGEST_COMPRESSION) * rest, (1.0 + LARGEST_COMPRESSION) * rest);
        let allowed = format!("{low} to {high} kg/m³");
        (
            "density [kg/m³]",
            density,
            allowed,
            format!("{step}; else raise the sound speed or the artificial viscosity"),
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
