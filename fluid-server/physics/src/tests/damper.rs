//! The acoustic damper: its effect, its limits and its momentum budget.

use sph::coupling::ledger::EnergyAccount;
use std::f64::consts::PI;

use sph::coupling::solver::Solver;
use sph::setup::{DensityDiffusion, FluidScheme, GradientCorrection, WallCondition};
use sph::space::Vector;

use super::support::{
    Noise, add_block, add_floor, empty_scene, evaluate, largest_residual, random_patch, run, solver,
};

const SPACING: f64 = 0.02;

/// Accelerations of `setup`'s particles.
fn accelerations(setup: sph::setup::FluidSetup) -> Vec<Vector> {
    let mut solver = solver(setup);
    evaluate(&mut solver);
    solver.workspace.rates.iter().map(|rates| rates.acceleration).collect()
}

#[test]
fn rotation_feels_nothing_on_any_arrangement_of_particles() {
    // ∇·v is Ω times the trace of an antisymmetric matrix times the symmetric moment matrix: zero on any patch.
    for seed in 1..4 {
        let rotating = |alpha: f64| {
            let mut setup = random_patch(seed);
            setup.parameters.acoustic_damping = alpha;
            let p = &mut setup.particles;
            for (v, x) in p.velocity.iter_mut().zip(&p.position) {
                *v = Vector::new(-(x.y - 0.5), x.x - 0.5) * 7.0;
            }
            accelerations(setup)
        };
        for (with, without) in rotating(1.0).iter().zip(&rotating(0.0)) {
            // Round-off of sums of some twenty terms.
            assert!((with - without).norm() < 1e-11 * without.norm().max(1.0));
        }
    }
}

#[test]
fn a_standing_sound_wave_decays_at_the_rate_of_the_bulk_viscosity() {
    // u = u₀ sin kx in a periodic box decays as exp(−k² ν t/2), ν = α c₀ h.
    for timing in [FluidScheme::PredictorCorrector, FluidScheme::Leapfrog] {
        for correction in [GradientCorrection::LatticeMoment, GradientCorrection::Renormalised] {
            sound_wave_decays(timing, correction);
        }
    }
}

fn sound_wave_decays(timing: FluidScheme, correction: GradientCorrection) {
    let (columns, rows, alpha, time_step, steps) = (50, 8, 0.5, 2e-4, 500);
    let mut setup = empty_scene(SPACING);
    setup.run.domain.upper = Vector::new(columns as f64 * SPACING, rows as f64 * SPACING);
    setup.run.domain.periodic = [true, true];
    (setup.parameters.viscosity_a, setup.parameters.viscosity_b) = (0.0, 0.0);
    setup.parameters.correction = correction;
    setup.parameters.density_diffusion = DensityDiffusion::None;
    setup.parameters.acoustic_damping = alpha;
    setup.parameters.scheme = timing;
    add_block(&mut setup, Vector::zeros(), columns, rows);
    let k = 2.0 * PI / setup.run.domain.upper.x;
    for (v, x) in setup.particles.velocity.iter_mut().zip(&setup.particles.position) {
        *v = Vector::new(1e-3 * (k * x.x).sin(), 0.0);
    }
    let nu = alpha * setup.parameters.sound_speed * setup.parameters.smoothing_length();
    let mut solver = solver(setup);
    let energy = |solver: &crate::FluidSolver| {
        let energies = solver.energies();
        energies.value(EnergyAccount::Kinetic) + energies.value(EnergyAccount::Compression)
    };
    let start = energy(&solver);
    run(&mut solver, steps, time_step);
    let rate = -(energy(&solver) / start).ln() / (steps as f64 * time_step);
    let exact = k * k * nu;
    // The SPH operator at 50 spacings per wavelength is off by (kh)²/4 at most; a period fits 2 times into the run.
    assert!((rate / exact - 1.0).abs() < 0.02, "{timing:?}, {correction:?}: {rate} {exact}");
}

#[test]
fn the_budgets_close_and_a_wall_mirrors_it() {
    let mut setup = empty_scene(SPACING);
    setup.parameters.acoustic_damping = 1.0;
    add_floor(&mut setup, 0.3, 0.5, 24, WallCondition::Slip);
    add_block(&mut setup, Vector::new(0.36, 0.5), 18, 8);
    let mut noise = Noise(3);
    setup.particles.velocity.iter_mut().for_each(|v| *v = noise.vector() * 0.2);
    let falling = Vector::new(0.0, -0.5);
    setup.particles.velocity.iter_mut().for_each(|v| *v += falling);
    let mut solver = solver(setup);
    assert!(largest_residual(&run(&mut solver, 20, 1e-4)) < 1e-12);
}
