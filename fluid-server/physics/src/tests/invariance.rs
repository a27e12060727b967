//! Results do not depend on the frame, the box, or the number of threads.

use sph::lanes::Arithmetic;
use sph::setup::{FluidSetup, GradientCorrection};
use sph::space::Vector;
use sph::space::domain::Domain;

use super::support::{ORDERED, dam_break, random_patch, run, solver, variants};
use crate::FluidSolver;
use crate::system::packed_particle::FluidSpace;

/// (position, velocity, density) of each particle by id.
pub(super) fn by_id<S: FluidSpace>(solver: &FluidSolver<S>) -> Vec<(S::Vector, S::Vector, f64)> {
    let state = &solver.state;
    let mut order: Vec<usize> = (0..state.len()).collect();
    order.sort_by_key(|i| state.id[*i]);
    order.into_iter().map(|i| (state.position[i], state.velocity[i], state.density[i])).collect()
}

fn finished(setup: FluidSetup, steps: u64) -> FluidSolver {
    let mut solver = solver(setup);
    run(&mut solver, steps, 1e-4);
    solver
}

#[test]
fn a_moving_frame_changes_nothing() {
    let (steps, frame) = (50, Vector::new(0.7, -0.4));
    for (correction, diffusion) in variants() {
        let make = |velocity: Vector| {
            let mut setup = random_patch(5);
            setup.parameters.correction = correction;
            setup.parameters.density_diffusion = diffusion;
            (setup.parameters.shifting, setup.parameters.tensile_control) = ORDERED;
            setup.particles.velocity.iter_mut().for_each(|v| *v += velocity);
            by_id(&finished(setup, steps))
        };
        let (resting, moving) = (make(Vector::zeros()), make(frame));
        for (a, b) in resting.iter().zip(&moving) {
            // Round-off grown over 50 steps of a stirred patch, far below any physical difference.
            assert!((b.0 - a.0 - frame * (steps as f64 * 1e-4)).norm() < 1e-12);
            assert!((b.1 - a.1 - frame).norm() < 1e-9);
            assert!((b.2 - a.2).abs() < 1e-6);
        }
    }
}

#[test]
fn a_patch_across_a_periodic_border_moves_like_one_in_the_open() {
    let steps = 50;
    for correction in [GradientCorrection::LatticeMoment, GradientCorrection::Renormalised] {
        let mut setup = random_patch(6);
        setup.parameters.correction = correction;
        (setup.parameters.shifting, setup.parameters.tensile_control) = ORDERED;
        let open = by_id(&finished(setup.clone(), steps));
        let shift = Vector::new(0.51, 0.49);
        setup.run.domain =
            Domain { lower: Vector::zeros(), upper: Vector::new(1.0, 1.0), periodic: [true, true] };
        for x in &mut setup.particles.position {
            *x = setup.run.domain.wrapped(&(*x + shift));
        }
        let domain = setup.run.domain;
        let periodic = by_id(&finished(setup, steps));
        let crossed = periodic.iter().filter(|p| p.0.x < 0.3).count();
        assert!(crossed > 10 && crossed < 70, "the patch must lie across the border: {crossed}");
        for (a, b) in open.iter().zip(&periodic) {
            assert!(domain.separation(&b.0, &(a.0 + shift)).norm() < 1e-12);
            assert!((b.1 - a.1).norm() < 1e-9);
            assert!((b.2 - a.2).abs() < 1e-6);
        }
    }
}

#[test]
fn one_two_and_four_threads_give_the_same_bits_on_each_path() {
    let paths = || Arithmetic::all();
    for (arithmetic, (correction, diffusion)) in
        paths().flat_map(|path| variants().into_iter().map(move |variant| (path, variant)))
    {
        let runs: Vec<_> = [1, 2, 4]
            .into_iter()
            .map(|threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| {
                    let mut setup = dam_break();
                    setup.parameters.correction = correction;
                    setup.parameters.density_diffusion = diffusion;
                    (setup.parameters.shifting, setup.parameters.tensile_control) = ORDERED;
                    let mut solver = FluidSolver::with_arithmetic(setup, arithmetic).unwrap();
                    let budgets = run(&mut solver, 100, 4e-4);
                    (solver.state, budgets)
                })
            })
            .collect();
        assert!(runs[0].0.list_builds > 1, "the runs must rebuild their lists");
        assert!(runs.iter().all(|run| *run == runs[0]), "{correction:?} {diffusion:?}");
    }
}

#[test]
fn a_state_taken_at_a_step_boundary_goes_on_with_the_same_bits() {
    for arithmetic in Arithmetic::all() {
        let make = || {
            let mut setup = dam_break();
            (setup.parameters.shifting, setup.parameters.tensile_control) = ORDERED;
            FluidSolver::with_arithmetic(setup, arithmetic).unwrap()
        };
        let mut whole = make();
        run(&mut whole, 30, 4e-4);
        let mut restored = make();
        restored.state = whole.state.clone();
        for step in 30..60 {
            super::support::try_step(&mut whole, step, 4e-4).unwrap();
            super::support::try_step(&mut restored, step, 4e-4).unwrap();
        }
        assert!(whole.state == restored.state, "{}", arithmetic.name());
    }
}
