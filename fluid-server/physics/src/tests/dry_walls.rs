//! Walls above the surface of the water.

use sph::setup::{FluidParameters, FluidScheme, FluidSetup};
use sph::space::tensors::SpaceVector;
use sph::space::{Plane, Spatial};

use super::spatial::add_container;
use super::support::{add_lattice, empty_scene_in, evaluate, solver};
use crate::FluidSolver;
use crate::system::packed_particle::{FluidSpace, Packed};

const SPACING: f64 = 0.02;
const GRAVITY: f64 = 9.81;

/// Water of `counts` cells in a tank of `tank`, gravity along −y, at the pressure of rest plus `pressure` \[Pa\].
fn water<S: FluidSpace>(
    counts: S::Of<usize>,
    tank: S::Of<usize>,
    closed: S::Of<[bool; 2]>,
    pressure: f64,
) -> FluidSolver<S> {
    let mut setup: FluidSetup<S> = empty_scene_in::<S>(SPACING);
    setup.parameters = FluidParameters {
        particle_spacing: SPACING,
        sound_speed: 20.0,
        scheme: FluidScheme::PredictorCorrector,
        acoustic_relaxation: 0.0,
        ..FluidParameters::DEFAULT
    };
    setup.run.body_force.gravity[1] = -GRAVITY;
    let lower = S::Vector::repeat(0.2);
    add_lattice(&mut setup, lower, counts);
    add_container(&mut setup, lower, tank, closed);
    let surface = lower[1] + counts[1] as f64 * SPACING;
    let mut solver = solver(setup);
    for i in 0..solver.state.len() {
        let at_rest = 1000.0 * GRAVITY * (surface - solver.state.position[i][1]);
        solver.state.density[i] = solver.model.equation_of_state.density(at_rest + pressure);
    }
    evaluate(&mut solver);
    solver
}

/// Share with which each wall particle acts that has water within its support, with its height over the floor in spacings.
fn shares<S: FluidSpace>(solver: &FluidSolver<S>) -> Vec<(f64, f64)> {
    let walls = &solver.workspace.walls;
    let support = solver.model.kernel.support_radius();
    let near = |w: &usize| {
        let x = &walls.field.position[*w];
        solver.state.position.iter().any(|y| (*y - *x).norm() < 0.999 * support)
    };
    (0..solver.model.walls.len())
        .filter(near)
        .map(|w| {
            let particle = &walls.particles[w];
            let height = (walls.field.position[w][1] - 0.2) / SPACING;
            (height, particle.volume() * particle.density() / solver.model.walls.mass)
        })
        .collect()
}

fn walls_end_with_the_water<S: FluidSpace>(
    counts: S::Of<usize>,
    tank: S::Of<usize>,
    closed: S::Of<[bool; 2]>,
) {
    let solver = water::<S>(counts, tank, closed, 0.0);
    let (mut above, mut below) = (0, 0);
    for (height, share) in shares(&solver) {
        let expected = if height < counts[1] as f64 { 1.0 } else { 0.0 };
        // The share is a quotient.
        assert!((share - expected).abs() < 1e-12, "{share} at {height}");
        if expected > 0.0 { below += 1 } else { above += 1 }
    }
    assert!(above > 5 && below > 10, "{above} {below}");
}

#[test]
fn beside_still_water_walls_end_with_the_water_in_corners_too() {
    walls_end_with_the_water::<Plane>([8, 6], [8, 12], [[true, true], [true, false]]);
    walls_end_with_the_water::<Spatial>([8, 6, 9], [8, 12, 9], [[true, true], [true, false], [true, true]]);
}

#[test]
fn in_a_full_vessel_all_walls_act_under_pressure_and_suction() {
    for pressure in [500.0, -1000.0] {
        let closed = [[true, true]; 3];
        let space = shares(&water::<Spatial>([8, 6, 7], [8, 6, 7], closed, pressure));
        let plane = shares(&water::<Plane>([8, 6], [8, 6], [[true, true]; 2], pressure));
        assert!(space.iter().chain(&plane).all(|(_, share)| (share - 1.0).abs() < 1e-12), "{pressure}");
    }
}

#[test]
fn walls_above_water_that_strikes_them_act() {
    let solver = water::<Plane>([8, 6], [8, 12], [[true, true], [true, false]], 2000.0);
    let highest = shares(&solver).into_iter().filter(|(_, share)| *share > 0.999);
    assert!(highest.map(|row| row.0).fold(0.0, f64::max) > 7.0);
}

/// Largest difference between the accelerations of the water at a wall and of that in the middle, over gravity.
fn unevenness<S: FluidSpace>(solver: &FluidSolver<S>) -> f64 {
    let at = |x: f64, y: f64| {
        let mut place = S::Vector::repeat(0.2 + 4.5 * SPACING);
        (place[0], place[1]) = (x, y);
        let found = (0..solver.state.len()).find(|i| (solver.state.position[*i] - place).norm() < 1e-9);
        solver.workspace.rates[found.unwrap()].acceleration
    };
    let rows = (0..6).map(|row| 0.2 + (f64::from(row) + 0.5) * SPACING);
    let difference = |y: f64| (at(0.2 + 0.5 * SPACING, y) - at(0.2 + 4.5 * SPACING, y)).norm() / GRAVITY;
    rows.map(difference).fold(0.0, f64::max)
}

#[test]
fn still_water_at_a_wall_is_as_near_rest_as_in_the_middle() {
    let plane = unevenness(&water::<Plane>([9, 6], [9, 12], [[true, true], [true, false]], 0.0));
    let space = water::<Spatial>([9, 6, 9], [9, 12, 9], [[true, true], [true, false], [true, true]], 0.0);
    let space = unevenness(&space);
    // With walls that act above the surface it is 0.15 and 0.12.
    assert!(plane < 0.03 && space < 0.03, "{plane} {space}");
}
