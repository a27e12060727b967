//! Acoustic relaxation: its effect on sound, its limit, its state.

use sph::coupling::ledger::EnergyAccount;
use std::f64::consts::PI;

use sph::coupling::saved::SavedState;
use sph::coupling::solver::Solver;
use sph::laws::acoustic_relaxation::LARGEST_TENSION;
use sph::setup::{DensityDiffusion, FluidScheme, FluidSetup, GradientCorrection, WallCondition};
use sph::space::Vector;

use super::support::{Noise, add_block, add_floor, dam_break, empty_scene, largest_residual, run, solver};
use crate::FluidSolver;

const SCHEMES: [FluidScheme; 2] = [FluidScheme::PredictorCorrector, FluidScheme::Leapfrog];

fn relaxing(setup: &mut FluidSetup, strength: f64, time: f64) {
    (setup.parameters.acoustic_relaxation, setup.parameters.acoustic_relaxation_time) =
        (strength, Some(time));
}

/// A standing sound wave of 1 m in a periodic box; its angular frequency \[1/s\].
fn sound_wave(scheme: FluidScheme) -> (FluidSetup, f64) {
    let (spacing, columns, rows) = (0.02, 50, 8);
    let mut setup = empty_scene(spacing);
    setup.run.domain.upper = Vector::new(columns as f64, rows as f64) * spacing;
    setup.run.domain.periodic = [true, true];
    (setup.parameters.viscosity_a, setup.parameters.viscosity_b) = (0.0, 0.0);
    setup.parameters.correction = GradientCorrection::Renormalised;
    setup.parameters.density_diffusion = DensityDiffusion::None;
    setup.parameters.scheme = scheme;
    // Far from tension.
    setup.parameters.background_pressure = 1e3;
    add_block(&mut setup, Vector::zeros(), columns, rows);
    let k = 2.0 * PI / setup.run.domain.upper.x;
    for (v, x) in setup.particles.velocity.iter_mut().zip(&setup.particles.position) {
        *v = Vector::new(1e-3 * (k * x.x).sin(), 0.0);
    }
    let omega = k * setup.parameters.sound_speed;
    (setup, omega)
}

#[test]
fn sound_decays_at_the_rate_of_the_maxwell_element() {
    for scheme in SCHEMES {
        let (mut setup, omega) = sound_wave(scheme);
        let (strength, time_step, steps) = (0.05, 2e-4, 500);
        relaxing(&mut setup, strength, 1.0 / omega);
        let mut solver = solver(setup);
        let energy = |solver: &FluidSolver| {
            let energies = solver.energies();
            energies.value(EnergyAccount::Kinetic)
                + energies.value(EnergyAccount::Compression)
                + energies.value(EnergyAccount::Relaxation)
        };
        // In a period q has forgotten that it was zero.
        run(&mut solver, steps / 2, time_step);
        let start = energy(&solver);
        run(&mut solver, steps, time_step);
        let rate = -(energy(&solver) / start).ln() / (steps as f64 * time_step);
        // Twice that of the amplitude, ½ r ω² τ/(1 + ω²τ²) at ωτ = 1; off by a share of order r, and by (kh)²/4.
        let expected = 0.5 * strength * omega;
        assert!((rate / expected - 1.0).abs() < 0.05, "{scheme:?}: {rate} {expected}");
    }
}

#[test]
fn both_schemes_follow_the_same_pressure() {
    let [whole, leapfrog] = SCHEMES.map(|scheme| {
        let (mut setup, omega) = sound_wave(scheme);
        relaxing(&mut setup, 1.0, 1.0 / omega);
        let mut solver = solver(setup);
        run(&mut solver, 200, 5e-5);
        let mut by_id: Vec<(u32, f64)> =
            solver.state.id.iter().copied().zip(solver.state.relaxation.iter().copied()).collect();
        by_id.sort_unstable_by_key(|(id, _)| *id);
        by_id
    });
    let largest = whole.iter().map(|(_, q)| q.abs()).fold(0.0, f64::max);
    // A velocity of 1 mm/s makes sound of up to 20 Pa √2.
    assert!(largest > 2.0, "{largest}");
    for ((i, a), (j, b)) in whole.iter().zip(&leapfrog) {
        // Both are of second order: (ω Δt)² = 4e-5 of 1.
        assert!(i == j && (a - b).abs() < 1e-3 * largest, "{a} {b}");
    }
}

#[test]
fn it_bears_little_tension_and_the_budgets_close() {
    for scheme in SCHEMES {
        let mut setup = empty_scene(0.02);
        relaxing(&mut setup, 1.0, 5e-3);
        setup.parameters.scheme = scheme;
        add_floor(&mut setup, 0.3, 0.5, 24, WallCondition::Slip);
        add_block(&mut setup, Vector::new(0.36, 0.5), 18, 8);
        let mut noise = Noise(3);
        let falling = Vector::new(0.0, -0.5);
        setup.particles.velocity.iter_mut().for_each(|v| *v = falling + noise.vector() * 0.2);
        let mut solver = solver(setup);
        assert!(largest_residual(&run(&mut solver, 20, 1e-4)) < 1e-12);
        let (state, law) = (&solver.state, &solver.model.equation_of_state);
        let tension = LARGEST_TENSION * solver.model.bulk_modulus();
        for i in 0..state.len() {
            assert!(state.pressure(law, i) >= law.pressure(state.density[i]).min(0.0) - tension);
        }
        assert!(state.relaxation.iter().any(|q| *q < -10.0) && state.relaxation.iter().any(|q| *q > 100.0));
    }
}

#[test]
fn a_saved_state_holds_it() {
    for scheme in SCHEMES {
        let make = || {
            let mut setup = dam_break();
            setup.parameters.scheme = scheme;
            relaxing(&mut setup, 1.0, 5e-3);
            solver(setup)
        };
        let (mut whole, mut restored, mut saved) = (make(), make(), SavedState::default());
        run(&mut whole, 30, 4e-4);
        whole.save(&mut saved);
        restored.restore(&saved).unwrap();
        for step in 30..60 {
            super::support::try_step(&mut whole, step, 4e-4).unwrap();
            super::support::try_step(&mut restored, step, 4e-4).unwrap();
        }
        assert!(whole.state == restored.state, "{scheme:?}");
    }
}

#[test]
fn the_step_is_that_of_the_faster_sound() {
    for scheme in SCHEMES {
        let (mut setup, _) = sound_wave(scheme);
        let limit = solver(setup.clone()).model.constants.acoustic_limit(0.0);
        relaxing(&mut setup, 3.0, 1.0);
        assert!((limit / setup.parameters.acoustic_limit(0.0) - 2.0).abs() < 1e-12);
    }
}
