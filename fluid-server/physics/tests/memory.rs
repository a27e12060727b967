//! Memory: none is asked for in a steady step, and not much for a particle.

#[path = "../benches/stage/scene.rs"]
#[allow(dead_code, reason = "the benchmark takes more of it")]
mod scene;

use fluid::FluidSolver;
use sph::coupling::exchange::StateColumns;
use sph::coupling::saved::SavedState;
use sph::coupling::solver::Solver;
use sph::coupling::stage::{Stage, StageTime, StepStage};
use sph::setup::{FluidProbe, FluidProbeKind};

/// One step without a partner.
fn step(solver: &mut FluidSolver, step: u64, time_step: f64) {
    let none = StateColumns::default();
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
        // Long enough for lists to be rebuilt, in memory that is there by then.
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
fn outputs_of_one_boundary_share_one_evaluation() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let mut setup = scene::block(scene::RECOMMENDED, 4000);
    setup.probes = vec![FluidProbe { name: "load".into(), kind: FluidProbeKind::WallForce(0) }];
    let mut solver = FluidSolver::new(setup).unwrap();
    pool.install(|| {
        step(&mut solver, 0, 2e-5);
        let asked = |solver: &FluidSolver, time: f64| {
            let mut values = Vec::new();
            let used = allocation_counter::measure(|| solver.probes(time, &mut values)).bytes_total;
            assert!(values[1] < 0.0, "{values:?}");
            used
        };
        let (first, second) = (asked(&solver, 2e-5), asked(&solver, 2e-5));
        // What is left are the forces of some hundred particles near the wall.
        assert!(second < first / 10, "{second} bytes after {first}");
        let shared = allocation_counter::measure(|| drop(solver.snapshot(1, 2e-5))).bytes_total;
        assert!(shared < first, "the snapshot takes its fields only: {shared} bytes after {first}");
        // Another time or another state is evaluated for itself.
        assert!(asked(&solver, 3e-5) > first / 2);
        step(&mut solver, 1, 2e-5);
        assert!(asked(&solver, 3e-5) > first / 2);
    });
}

#[test]
fn a_particle_takes_little_memory() {
    let particles = 90_000;
    // Half of it would mean that something is not counted.
    let most = 550.0;
    for settings in [scene::LEAN, scene::RECOMMENDED] {
        let setup = scene::block(settings, particles);
        let thickest = 0.3 * setup.parameters.particle_spacing;
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
