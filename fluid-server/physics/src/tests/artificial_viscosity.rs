//! Artificial viscosity of all of an approach, and of what a smooth field of velocity does not explain.

use sph::setup::{FluidParameters, FluidSetup, ViscosityForm};
use sph::space::tensors::SpaceVector;
use sph::space::{Plane, Spatial};

use super::support::{Noise, add_lattice, disturb, empty_scene_in, evaluate, solver};
use crate::FluidSolver;
use crate::system::packed_particle::FluidSpace;

const SPACING: f64 = 0.02;

/// Accelerations that the artificial viscosity of `form` causes, with A = 0.5, and the solver.
fn artificial<S: FluidSpace>(setup: &FluidSetup<S>, form: ViscosityForm) -> (FluidSolver<S>, Vec<S::Vector>) {
    let evaluated = |viscosity_a: f64| {
        let mut setup = setup.clone();
        setup.parameters =
            FluidParameters { viscosity_a, viscosity_form: form, viscosity_b: 0.0, ..setup.parameters };
        let mut solver = solver(setup);
        evaluate(&mut solver);
        solver
    };
    let (with, without) = (evaluated(0.5), evaluated(0.0));
    let rates = with.workspace.rates.iter().zip(&without.workspace.rates);
    let difference = rates.map(|(with, without)| with.acceleration - without.acceleration).collect();
    (with, difference)
}

/// A disturbed lattice of 11 particles along each axis with a velocity of each position.
fn lattice<S: FluidSpace>(seed: u64, velocity: impl Fn(&S::Vector) -> S::Vector) -> FluidSetup<S> {
    let mut setup = empty_scene_in::<S>(SPACING);
    add_lattice(&mut setup, S::Vector::repeat(0.4), S::splat(11));
    let p = &mut setup.particles;
    let mut noise = Noise(seed);
    // At half a spacing from each other the form would be plain.
    p.position.iter_mut().for_each(|x| *x += noise.vector_in::<S>() * (0.08 * SPACING));
    p.velocity = p.position.iter().map(velocity).collect();
    setup
}

/// Largest acceleration of particles more than two supports from the edges of the lattice.
fn largest_inside<S: FluidSpace>(solver: &FluidSolver<S>, accelerations: &[S::Vector]) -> f64 {
    let middle = S::Vector::repeat(0.4 + 5.5 * SPACING);
    let inside =
        |x: &S::Vector| (0..S::DIMENSIONS).all(|axis| (x[axis] - middle[axis]).abs() < 0.6 * SPACING);
    let accelerations = solver.state.position.iter().zip(accelerations);
    accelerations.filter(|(x, _)| inside(x)).map(|(_, a)| a.norm()).fold(0.0, f64::max)
}

fn smooth_flow_is_left_alone<S: FluidSpace>() {
    for seed in 0..4 {
        let mut noise = Noise(seed);
        let columns: Vec<S::Vector> = (0..S::DIMENSIONS).map(|_| noise.vector_in::<S>()).collect();
        // Any rates of strain and rotation of up to 1/s, and a contraction of 3/s.
        let setup = lattice::<S>(seed, |x| {
            let from = *x - S::Vector::repeat(0.5);
            (0..S::DIMENSIONS).fold(from * -3.0, |v, axis| v + columns[axis] * from[axis])
        });
        let (solver, residual) = artificial(&setup, ViscosityForm::Residual);
        let (_, plain) = artificial(&setup, ViscosityForm::Plain);
        let (residual, plain) = (largest_inside(&solver, &residual), largest_inside(&solver, &plain));
        // Round-off of accelerations of up to 1e4 m/s² at the edges of the lattice.
        assert!(residual < 1e-9 && plain > 0.1, "{seed}: {residual} {plain}");
    }
}

#[test]
fn a_linear_field_of_velocity_is_not_resisted() {
    smooth_flow_is_left_alone::<Plane>();
    smooth_flow_is_left_alone::<Spatial>();
}

/// Power of forces that give such accelerations \[W\], per metre of width in the plane.
fn power<S: FluidSpace>(solver: &FluidSolver<S>, accelerations: &[S::Vector]) -> f64 {
    let state = &solver.state;
    (0..state.len()).map(|i| state.mass[i] * accelerations[i].dot(&state.velocity[i])).sum()
}

#[test]
fn velocities_that_alternate_are_resisted_in_full() {
    let setup = lattice::<Plane>(1, |x| {
        let cell = |axis: usize| ((x[axis] - 0.4) / SPACING).floor();
        sph::space::Vector::new(if (cell(0) + cell(1)) % 2.0 == 0.0 { 0.1 } else { -0.1 }, 0.0)
    });
    let (solver, residual) = artificial(&setup, ViscosityForm::Residual);
    let (_, plain) = artificial(&setup, ViscosityForm::Plain);
    // Such a field has no gradient inside the lattice, and half of one at its edges.
    let share = power(&solver, &residual) / power(&solver, &plain);
    assert!(share > 0.9 && share <= 1.0, "{share}");
}

#[test]
fn the_residual_form_takes_energy_and_no_more_than_the_plain_one() {
    fn check<S: FluidSpace>(counts: S::Of<usize>) {
        for seed in 0..6 {
            let mut setup = empty_scene_in::<S>(SPACING);
            add_lattice(&mut setup, S::Vector::repeat(0.4), counts);
            disturb(&mut setup, seed);
            let (solver, residual) = artificial(&setup, ViscosityForm::Residual);
            let (_, plain) = artificial(&setup, ViscosityForm::Plain);
            let (residual, plain) = (power(&solver, &residual), power(&solver, &plain));
            assert!(plain < residual && residual < 0.0, "{seed}: {residual} {plain}");
        }
    }
    check::<Plane>([9, 9]);
    check::<Spatial>([6, 6, 6]);
}

#[test]
fn particles_that_come_too_near_are_resisted_in_full() {
    // Columns half a spacing apart, in a uniform contraction along x.
    let mut setup = empty_scene_in::<Plane>(SPACING);
    add_lattice(&mut setup, sph::space::Vector::new(0.4, 0.4), [11, 11]);
    for (x, v) in setup.particles.position.iter_mut().zip(&mut setup.particles.velocity) {
        x[0] = 0.4 + 0.5 * (x[0] - 0.4);
        v[0] = -(x[0] - 0.4);
    }
    let (solver, residual) = artificial(&setup, ViscosityForm::Residual);
    let (_, plain) = artificial(&setup, ViscosityForm::Plain);
    let (residual, plain) = (power(&solver, &residual), power(&solver, &plain));
    // Of the pairs in a row only the nearest are nearer than 0.6 spacings.
    assert!(residual < 0.1 * plain && residual > plain, "{residual} {plain}");
}
