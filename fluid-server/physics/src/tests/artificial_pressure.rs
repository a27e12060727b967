//! Artificial pressure (Monaghan 2000).

use sph::setup::{FluidParameters, FluidSetup};
use sph::space::Vector;

use super::support::{add_block, empty_scene, evaluate, solver};
use crate::equations::artificial_pressure::ArtificialPressure;

const SPACING: f64 = 1.0 / 12.0;

/// A periodic lattice at `density` over that at rest, with one particle moved by a tenth of a spacing to the right.
fn displaced(density: f64, artificial_pressure: f64) -> FluidSetup {
    let mut setup = empty_scene(SPACING);
    setup.run.domain.periodic = [true, true];
    add_block(&mut setup, Vector::zeros(), 12, 12);
    setup.particles.density.iter_mut().for_each(|rho| *rho *= density);
    setup.particles.position[MOVED].x += 0.1 * SPACING;
    let parameters = FluidParameters { artificial_pressure, ..setup.parameters };
    FluidSetup { parameters, ..setup }
}

/// A particle in the middle of the box.
const MOVED: usize = 78;

/// Acceleration of the moved particle to the right \[m/s²\].
fn acceleration(density: f64, artificial_pressure: f64) -> f64 {
    let mut solver = solver(displaced(density, artificial_pressure));
    evaluate(&mut solver);
    let row = solver.state.id.iter().position(|id| *id == MOVED as u32).unwrap();
    solver.workspace.rates[row].acceleration.x
}

#[test]
fn tension_adds_a_share_of_itself_at_a_spacing() {
    let model = solver(displaced(1.0, 0.2)).model;
    let law = ArtificialPressure::<f64>::new(&model);
    let at_spacing = model.constants.particle_spacing / model.constants.smoothing_length();
    // W/W(Δx) = 1 there, and pressure adds nothing.
    assert!((law.at(at_spacing, -300.0, 500.0) - 60.0).abs() < 1e-12);
    assert_eq!(law.at(at_spacing, 300.0, 500.0), 0.0);
    assert_eq!(law.at(2.0, -300.0, -300.0), 0.0);
}

#[test]
fn a_particle_in_a_lattice_under_tension_is_pushed_back_to_its_place() {
    // Tension pulls a displaced particle further away, which is the tensile instability; Monaghan's 0.2 reverses it.
    assert!(acceleration(0.99, 0.0) > 0.0);
    assert!(acceleration(0.99, 0.2) < 0.0);
    assert_eq!(acceleration(1.01, 0.0), acceleration(1.01, 0.2));
}
