//! How long neighbour lists last.

use sph::coupling::saved::SavedState;
use sph::coupling::solver::Solver;
use sph::coupling::stage::Stage;
use sph::setup::{FluidParticles, FluidScheme};

use super::support::*;
use crate::FluidSolver;
use crate::system::list_limits::{Skins, skins};

/// Pairs of fluid particles, and of fluid and wall, that are within support and missing in the lists.
fn missing(solver: &FluidSolver) -> usize {
    let (state, lists) = (&solver.state, &solver.workspace.lists);
    let (support, walls) = (solver.model.kernel.support_radius(), &solver.workspace.walls.field.position);
    let near = |i: usize, x: &sph::space::Vector| (state.position[i] - x).norm() < support;
    let mut missing = 0;
    for i in 0..state.len() {
        let fluid: Vec<usize> = lists.fluid.neighbours(i).collect();
        let of_walls: Vec<usize> = lists.walls.neighbours(i).collect();
        missing += (0..state.len())
            .filter(|j| *j != i && near(i, &state.position[*j]) && !fluid.contains(j))
            .count();
        missing += (0..walls.len()).filter(|w| near(i, &walls[*w]) && !of_walls.contains(w)).count();
    }
    missing
}

/// Largest displacement since the lists were built \[m\].
fn displacement(solver: &FluidSolver) -> f64 {
    let origin = &solver.state.list_origin.as_ref().unwrap().position;
    let moved = solver.state.position.iter().zip(origin).map(|(x, origin)| (x - origin).norm());
    moved.fold(0.0, f64::max)
}

#[test]
fn lists_outlast_half_the_skin_where_neighbours_move_alike_and_miss_no_pair() {
    for scheme in [FluidScheme::PredictorCorrector, FluidScheme::Leapfrog] {
        let mut setup = dam_break();
        setup.parameters.scheme = scheme;
        let mut noise = Noise(5);
        // The column falls over and some of it flies: all velocities differ, those of neighbours by little.
        let spray = setup.particles.position.len();
        add_block(&mut setup, sph::space::Vector::new(0.5, 0.5), 6, 6);
        for (i, v) in setup.particles.velocity.iter_mut().enumerate() {
            *v = noise.vector() * 0.1;
            v.x += if i < spray { 1.0 } else { -4.0 };
        }
        let mut solver = FluidSolver::new(setup).unwrap();
        let (mut stages, mut beyond) = (0, 0);
        for step in 0..150 {
            for stage in Stage::BOTH {
                let time = stage_time(step, stage, 2e-4);
                solver.begin_stage(&time).unwrap();
                assert_eq!(missing(&solver), 0, "step {step}");
                stages += 1;
                beyond += usize::from(displacement(&solver) > 0.5 * solver.state.list_skin);
                solver.evaluate_own(&time);
                solver.evaluate_cross(&time, &Default::default(), &Default::default());
                solver.advance(&time).unwrap();
            }
            solver.end_step(&stage_time(step, Stage::Corrector, 2e-4)).unwrap();
        }
        assert!(5 * beyond > stages, "{beyond} of {stages} stages with lists older than half the skin");
        assert!(solver.state.list_builds > 5);
    }
}

#[test]
fn the_skin_follows_how_long_lists_last() {
    // The same shear, in steps that use up an eighth of the skin and twice of it.
    let Skins { thinnest, first, thickest } = skins::<sph::space::Plane>(0.02);
    let skin_after = |time_step: f64| {
        let mut setup = dam_break();
        for (x, v) in setup.particles.position.iter().zip(&mut setup.particles.velocity) {
            *v = sph::space::Vector::new(10.0 * x.y, 0.0);
        }
        let mut solver = FluidSolver::new(setup).unwrap();
        assert_eq!(solver.state.list_skin, first);
        for step in 0..60 {
            for stage in Stage::BOTH {
                let time = stage_time(step, stage, time_step);
                solver.begin_stage(&time).unwrap();
                assert_eq!(missing(&solver), 0, "step {step}");
                solver.evaluate_own(&time);
                solver.evaluate_cross(&time, &Default::default(), &Default::default());
                solver.advance(&time).unwrap();
            }
            solver.end_step(&stage_time(step, Stage::Corrector, time_step)).unwrap();
        }
        assert!(solver.state.list_builds > 3, "{}", solver.state.list_builds);
        solver.state.list_skin
    };
    let (slow, fast) = (skin_after(2e-5), skin_after(4e-4));
    assert!(thinnest <= slow && slow < 0.7 * fast && fast <= thickest, "{slow} {fast}");
}

#[test]
fn a_saved_skin_that_lists_never_have_is_refused() {
    let mut solver = FluidSolver::new(dam_break()).unwrap();
    let mut saved = SavedState::default();
    solver.save(&mut saved);
    solver.restore(&saved).unwrap();
    for skin in [0.0, -1e-3, 0.02, f64::INFINITY] {
        let mut other = saved.clone();
        other.arrays.retain(|(name, _)| name != "fluid.list_skin");
        other.put_f64("fluid.list_skin", [skin]);
        let error = solver.restore(&other).unwrap_err();
        assert!(error.to_string().contains("fluid.list_skin"), "{error}");
    }
}

#[test]
fn water_that_flies_as_one_finds_the_wall_before_it() {
    // The width decides how far the last cell reaches beyond whole cells, the gap when lists are built.
    for (columns, gap) in
        (6..26).flat_map(|columns| (0..24).map(move |k| (columns, 0.03 + 5e-4 * f64::from(k))))
    {
        let mut setup = dam_break();
        setup.particles = FluidParticles::default();
        let lower = sph::space::Vector::new(0.9 - gap - 0.02 * f64::from(columns), 0.5);
        add_block(&mut setup, lower, columns as usize, 2);
        setup.particles.velocity.iter_mut().for_each(|v| v.x = 4.0);
        let mut solver = FluidSolver::new(setup).unwrap();
        for step in 0..60 {
            for stage in Stage::BOTH {
                let time = stage_time(step, stage, 1e-4);
                solver.begin_stage(&time).unwrap();
                assert_eq!(missing(&solver), 0, "{columns} columns, gap {gap}, step {step}");
                solver.evaluate_own(&time);
                solver.evaluate_cross(&time, &Default::default(), &Default::default());
                solver.advance(&time).unwrap();
            }
            solver.end_step(&stage_time(step, Stage::Corrector, 1e-4)).unwrap();
        }
    }
}
