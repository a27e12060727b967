//! Shifting and tensile control.

use sph::ledger::Account;
use sph::setup::{FluidSetup, OrderControl, ViscousForm};
use sph::vector::Vector;

use crate::physics::rates::Rates;

use super::support::{
    Noise, ORDERED, add_block, add_particle, empty_scene, evaluate, random_patch, run, solver,
};

/// A periodic box of 12 × 12 particles, displaced by up to a quarter spacing, with a Taylor-Green flow.
fn stirred() -> FluidSetup {
    let mut setup = empty_scene(1.0 / 12.0);
    setup.run.domain.periodic = [true, true];
    add_block(&mut setup, Vector::zeros(), 12, 12);
    let mut noise = Noise(3);
    let wave = 2.0 * std::f64::consts::PI;
    for i in 0..setup.particles.id.len() {
        setup.particles.position[i] += noise.vector() / 48.0;
        let x = setup.particles.position[i] * wave;
        setup.particles.velocity[i] = Vector::new(-x.x.cos() * x.y.sin(), x.x.sin() * x.y.cos());
    }
    setup
}

/// Root mean square of Σ V_j ∇W \[1/m\].
fn crowding(setup: &FluidSetup) -> f64 {
    let mut solver = solver(FluidSetup { order: ORDERED, ..setup.clone() });
    evaluate(&mut solver);
    let local = &solver.workspace.gradients.order;
    (local.iter().map(|local| local.concentration.norm_squared()).sum::<f64>() / local.len() as f64).sqrt()
}

#[test]
fn shifting_spreads_particles() {
    let after = |shifting: f64| {
        let setup = FluidSetup {
            order: Some(OrderControl { shifting, tensile_control: false }),
            viscous_form: ViscousForm::Pairwise,
            ..stirred()
        };
        let mut moved = solver(setup.clone());
        run(&mut moved, 300, 1e-3);
        let mut setup = setup;
        for i in 0..moved.state.len() {
            let id = moved.state.id[i] as usize;
            setup.particles.position[id] = setup.run.domain.wrapped(&moved.state.position[i]);
        }
        crowding(&setup)
    };
    let (without, with) = (after(0.0), after(1.0));
    assert!(with < 0.7 * without, "{with} against {without}");
}

#[test]
fn a_fluid_that_moves_as_one_is_left_alone() {
    let mut setup = random_patch(8);
    setup.particles.velocity.fill(Vector::new(3.0, -2.0));
    setup.order = Some(OrderControl { shifting: 5.0, tensile_control: false });
    let mut solver = solver(setup);
    evaluate(&mut solver);
    // Nothing but the difference of equal numbers.
    assert!(solver.workspace.rates.iter().all(|rates| rates.shift == Vector::zeros()));
}

#[test]
fn no_shift_along_the_normal_of_a_flat_surface() {
    // A block of shearing fluid, disturbed by noise; above it nothing.
    let mut setup = empty_scene(0.02);
    add_block(&mut setup, Vector::new(0.2, 0.2), 24, 16);
    let mut noise = Noise(5);
    for i in 0..setup.particles.id.len() {
        setup.particles.position[i] += noise.vector() * 0.001;
        let y = setup.particles.position[i].y;
        setup.particles.velocity[i] = Vector::new(5.0 * y, 0.0);
    }
    setup.order = Some(OrderControl { shifting: 1.0, tensile_control: false });
    let mut solver = solver(setup);
    evaluate(&mut solver);
    let (mut inside, mut top) = (0.0_f64, 0.0_f64);
    for i in 0..solver.state.len() {
        let (x, shift) = (solver.state.position[i], solver.workspace.rates[i].shift);
        if !(0.3..0.58).contains(&x.x) {
            continue;
        }
        if (0.3..0.42).contains(&x.y) {
            inside = inside.max(shift.y.abs());
        } else if x.y > 0.5 {
            top = top.max(shift.y.abs());
        }
    }
    // The noise of 5 % of a spacing turns the normal by some degrees.
    assert!(inside > 1e-4 && top < 0.5 * inside, "{top} at the surface, {inside} inside");
}

#[test]
fn spray_is_not_shifted() {
    let mut setup = empty_scene(0.02);
    add_particle(&mut setup, Vector::new(0.5, 0.5), Vector::new(1.0, 0.0));
    add_particle(&mut setup, Vector::new(0.51, 0.5), Vector::new(-1.0, 0.0));
    setup.order = ORDERED;
    let mut solver = solver(setup);
    evaluate(&mut solver);
    assert!(solver.workspace.rates.iter().all(|rates| rates.shift == Vector::zeros()));
}

#[test]
fn tensile_control_acts_on_negative_pressure_only_and_is_booked() {
    let booked = |density: f64| {
        let mut setup = stirred();
        setup.particles.density.fill(density);
        let [without, with] = [false, true].map(|tensile_control| {
            let order = Some(OrderControl { shifting: 0.0, tensile_control });
            let mut solver = solver(FluidSetup { order, ..setup.clone() });
            evaluate(&mut solver);
            solver.workspace.rates
        });
        let change = |(a, b): (&Rates, &Rates)| (a.acceleration - b.acceleration).norm();
        let gross: f64 = with.iter().zip(&without).map(change).sum();
        setup.order = Some(OrderControl { shifting: 0.0, tensile_control: true });
        let books = run(&mut solver(setup), 1, 1e-5);
        (gross, books[0].accounts.get(Account::Stabilisers).norm())
    };
    assert_eq!(booked(1001.0), (0.0, 0.0));
    let (gross, account) = booked(999.0);
    assert!(gross > 1.0 && account > 0.0, "{gross} {account}");
}
