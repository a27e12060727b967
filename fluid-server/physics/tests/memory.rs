//! Memory: none is asked for in a steady step, and not much for a particle.

#[path = "../benches/stage/scene.rs"]
#[allow(dead_code, reason = "the benchmark takes more of it")]
mod scene;

use fluid::{FluidSolver, FluidSpace};
use sph::coupling::exchange::StateColumns;
use sph::coupling::saved::SavedState;
use sph::coupling::solver::{ParticleFields, Solver};
use sph::coupling::stage::{Stage, StageTime, StepStage};
use sph::setup::{FluidProbe, FluidProbeKind};
use sph::space::{Plane, Spatial};

/// One step without a partner.
fn step<S: FluidSpace>(solver: &mut FluidSolver<S>, step: u64, time_step: f64) {
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
        let mut solver = FluidSolver::new(scene::block::<Plane>(settings, 4000)).unwrap();
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
fn outputs_take_no_second_workspace() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let mut setup = scene::block::<Plane>(scene::RECOMMENDED, 4000);
    setup.probes = vec![FluidProbe { name: "load".into(), kind: FluidProbeKind::WallForce(0) }];
    let mut solver = FluidSolver::new(setup).unwrap();
    pool.install(|| {
        step(&mut solver, 0, 2e-5);
        let mut values = Vec::new();
        let used = allocation_counter::measure(|| solver.probes(2e-5, &mut values)).bytes_max;
        assert!(values[1] < 0.0, "{values:?}");
        // Forces of some hundred particles near the wall.
        assert!(used < solver.memory() as u64 / 20, "{used} bytes beside {}", solver.memory());
        let mut snapshot = ParticleFields::default();
        let used = allocation_counter::measure(|| snapshot = solver.snapshot(1, 2e-5)).bytes_max;
        let numbers: usize = snapshot.fields.iter().map(|field| field.values.len()).sum();
        // Lists of ids, their order, and vectors that grow.
        assert!(used < 24 * numbers as u64, "{used} bytes for {numbers} numbers");
    });
}

#[test]
fn a_particle_takes_little_memory() {
    for settings in [scene::LEAN, scene::RECOMMENDED] {
        check_memory::<Plane>(settings, 90_000, 555.0);
    }
    check_memory::<Spatial>(scene::LEAN, 64_000, 740.0);
    check_memory::<Spatial>(scene::DEFAULT, 64_000, 1030.0);
}

#[test]
#[ignore = "takes half a minute and more than a gigabyte; walls count less than around few particles"]
fn a_particle_of_a_million_takes_little_memory() {
    check_memory::<Spatial>(scene::DEFAULT, 1_000_000, 950.0);
}

/// That state and workspace take at most `most` bytes per particle, walls included; half of it would mean that something
/// is not counted.
fn check_memory<S: FluidSpace>(settings: scene::Settings, particles: usize, most: f64) {
    let setup = scene::block::<S>(settings, particles);
    let thickest = if S::DIMENSIONS == 3 { 0.15 } else { 0.3 } * setup.parameters.particle_spacing;
    let mut solver = FluidSolver::new(setup).unwrap();
    let mut saved = SavedState::default();
    solver.save(&mut saved);
    // Lists of fast water, the longest that there are.
    saved.arrays.retain(|(name, _)| name != "fluid.list_skin");
    saved.put_f64("fluid.list_skin", [thickest]);
    solver.restore(&saved).unwrap();
    step(&mut solver, 0, 1e-6);
    let each = solver.memory() as f64 / particles as f64;
    assert!((0.5 * most..=most).contains(&each), "{each:.0} bytes in {} dimensions", S::DIMENSIONS);
}
