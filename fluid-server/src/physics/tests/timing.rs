//! Gradients made once a step.

use sph::setup::{FluidSetup, GradientCorrection, GradientTiming};
use sph::vector::Vector;

use super::support::{ORDERED, random_patch, run, solver};

/// A stirred patch with all that the gradient pass makes, drifting at `drift` \[m/s\].
fn patch(gradient_timing: GradientTiming, drift: f64) -> FluidSetup {
    let mut setup = random_patch(9);
    setup.constants.correction = GradientCorrection::Renormalised;
    setup.acoustic_damping = 0.4;
    setup.order = ORDERED;
    setup.gradient_timing = gradient_timing;
    setup.particles.velocity.iter_mut().for_each(|v| v.x += drift);
    setup
}

/// Velocities after one step, in the order of the particles.
fn velocities(timing: GradientTiming, drift: f64, time_step: f64) -> Vec<Vector> {
    let mut solver = solver(patch(timing, drift));
    run(&mut solver, 1, time_step);
    solver.state.velocity
}

/// Largest difference between both timings after one step \[m/s\].
fn difference(drift: f64, time_step: f64) -> f64 {
    let [stage, step] =
        [GradientTiming::EachStage, GradientTiming::EachStep].map(|t| velocities(t, drift, time_step));
    stage.iter().zip(&step).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

#[test]
fn one_step_differs_by_the_square_of_its_size() {
    // The gradients change by O(Δt) in half a step and act for a step.
    let (whole, half) = (difference(0.0, 1e-5), difference(0.0, 5e-6));
    assert!(whole > 0.0);
    // The next order is Δt times the rates of the patch, below 1 %.
    assert!((whole / half - 4.0).abs() < 0.1, "{}", whole / half);
}

#[test]
fn a_corrector_that_builds_lists_makes_gradients_of_its_own() {
    // A tenth of a spacing outdates the lists; 3 m/s take half a step of 2e-3 s for it.
    assert_eq!(difference(3.0, 2e-3), 0.0);
}
