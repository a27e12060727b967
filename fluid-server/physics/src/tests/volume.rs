//! The volume correction.

use sph::setup::{FluidParameters, FluidSetup, WallCondition};
use sph::space::Vector;

use super::support::{add_block, add_floor, empty_scene, evaluate, solver};

const SPACING: f64 = 0.02;

/// A lattice over the whole length of a periodic channel, in which rows slide past each other at 2 `speed` \[m/s\].
fn sliding_rows(speed: f64, rows: usize) -> FluidSetup {
    let mut setup = empty_scene(SPACING);
    setup.run.domain.periodic = [true, false];
    add_block(&mut setup, Vector::new(0.0, 0.2), 50, rows);
    for i in 0..setup.particles.id.len() {
        setup.particles.velocity[i].x = if i / 50 % 2 == 0 { speed } else { -speed };
    }
    setup
}

/// Height \[m\] and density rate \[kg/(m³ s)\] of each particle by a coefficient of 2.
fn rates(setup: &FluidSetup) -> Vec<(f64, f64)> {
    let rates = |volume_correction| {
        let parameters = FluidParameters { volume_correction, ..setup.parameters };
        let mut solver = solver(FluidSetup { parameters, ..setup.clone() });
        evaluate(&mut solver);
        let density = solver.workspace.rates.iter().map(|rates| rates.density);
        solver.state.position.iter().map(|x| x.y).zip(density).collect::<Vec<_>>()
    };
    rates(2.0).into_iter().zip(rates(0.0)).map(|((y, with), (_, without))| (y, with - without)).collect()
}

#[test]
fn fluid_that_claims_too_much_volume_gains_density_as_fast_as_it_slides() {
    let mut setup = sliding_rows(0.05, 20);
    setup.particles.density.iter_mut().for_each(|rho| *rho = 990.0);
    // ρ (σ − 1) 2U/h, with σ = 1/0.99 and U = 0.1 m/s.
    let expected = 990.0 * (1.0 / 0.99 - 1.0) * 0.2 / setup.parameters.smoothing_length();
    for (y, rate) in rates(&setup) {
        // Nothing within 2h of the particles at the surfaces.
        let inside = (0.26..0.54).contains(&y);
        let error = if inside { rate / expected - 1.0 } else { rate };
        assert!(error.abs() < 1e-9 || (0.25..0.55).contains(&y) && !inside, "{y}: {rate} {expected}");
    }
}

#[test]
fn rates_are_bounded_and_rigid_motion_has_none() {
    // 3 % too much volume count as 2 %, and a speed of 2 U as 0.02 c₀.
    let mut setup = sliding_rows(5.0, 20);
    setup.particles.density.iter_mut().for_each(|rho| *rho = 970.0);
    let expected = 970.0 * 0.02 * 0.02 * setup.parameters.sound_speed / setup.parameters.smoothing_length();
    let largest = |setup: &FluidSetup| rates(setup).iter().map(|(_, rate)| rate.abs()).fold(0.0, f64::max);
    assert!((largest(&setup) / expected - 1.0).abs() < 1e-9);
    setup.particles.velocity.iter_mut().for_each(|v| *v = Vector::new(3.0, 0.0));
    assert_eq!(largest(&setup), 0.0);
}

#[test]
fn a_wall_stands_for_its_cells_under_any_pressure() {
    // The wall is denser than the fluid by Eq. (28), and still no volume is missing or in excess.
    let mut setup = sliding_rows(0.05, 20);
    setup.run.body_force.gravity = Vector::new(0.0, -100.0);
    add_floor(&mut setup, 0.0, 0.2, 50, WallCondition::Slip);
    let (mut near_wall, scale) = (0, 1000.0 * 0.2 / setup.parameters.smoothing_length());
    for (y, rate) in rates(&setup) {
        if y < 0.5 {
            // Round-off of σ.
            assert!(rate.abs() < 1e-12 * scale, "{y}: {rate}");
            near_wall += 1;
        }
    }
    assert_eq!(near_wall, 15 * 50);
    // With more volume in the fluid, the row at the wall sees only its part of it.
    setup.particles.density.iter_mut().for_each(|rho| *rho = 990.0);
    let [mut lowest, mut above] = [0.0; 2];
    for (y, rate) in rates(&setup) {
        if y < 0.22 {
            lowest = rate;
        } else if (0.28..0.3).contains(&y) {
            above = rate;
        }
    }
    assert!((0.5 * above..0.9 * above).contains(&lowest), "{lowest} {above}");
}
