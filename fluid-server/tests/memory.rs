//! Memory: none is asked for in a steady step, and not much for a particle.

#[path = "../benches/stage/scene.rs"]
#[allow(dead_code, reason = "the benchmark takes more of it")]
mod scene;

use fluid_server::physics::FluidSolver;
use sph::exchange::InterfaceStates;
use sph::saved::SavedState;
use sph::solver::Solver;
use sph::stage::{Stage, StageTime, StepStage};

/// One step without a partner.
fn step(solver: &mut FluidSolver, step: u64, time_step: f64) {
    let none = InterfaceStates::default();
    let mut time = StageTime { at: StepStage::FIRST, step_start: step as f64 * time_step, time_step };
    for stage in Stage::BOTH {
        time.at = StepStage { step, stage };
        solver.begin_stage(&time).unwrap();
        solver.evaluate_own(&time);
        solver.evaluate_cross(&time, &none, &none);
        solver.advance(&time).unwrap();
    }
    solver.end_step(&time).unwrap();
}

#[test]
fn a_steady_step_allocates_nothing() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    for settings in [scene::RECOMMENDED, scene::LEAN] {
        let mut solver = FluidSolver::new(scene::block(settings, 4000)).unwrap();
        // Long enough for lists to be built anew, in memory that is there by then.
        pool.install(|| {
            for k in 0..40 {
                step(&mut solver, k, 2e-5);
            }
            let builds = solver.counts().list_builds;
            let used = allocation_counter::measure(|| {
                for k in 40..60 {
                    step(&mut solver, k, 2e-5);
                }
            });
            assert_eq!(solver.counts().list_builds, builds, "the steps must be steady");
            assert_eq!(used.count_total, 0, "{} bytes", used.bytes_total);
        });
    }
}

#[test]
fn a_particle_takes_little_memory() {
    let particles = 90_000;
    // Half of the goal would mean that something is not counted.
    let most = 500.0;
    for settings in [scene::LEAN, scene::RECOMMENDED] {
        let setup = scene::block(settings, particles);
        let thickest = 0.3 * setup.constants.particle_spacing;
        let mut solver = FluidSolver::new(setup).unwrap();
        let mut saved = SavedState::default();
        solver.save(&mut saved);
        // Lists of fast water, the longest that there are.
        saved.arrays.retain(|(name, _)| name != "fluid.list_skin");
        saved.put_f64("fluid.list_skin", [thickest]);
        solver.restore(&saved).unwrap();
        step(&mut solver, 0, 1e-6);
        let each = solver.memory() as f64 / particles as f64;
        assert!((0.5 * most..=most).contains(&each), "{each:.0} bytes");
    }
}
