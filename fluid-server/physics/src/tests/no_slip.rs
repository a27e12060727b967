//! Flow along a solid without slip.

use sph::coupling::exchange::{Column, Extent, StateColumns};
use sph::coupling::solver::Solver;
use sph::coupling::stage::Stage;
use sph::interface::states::InterfaceStates;
use sph::setup::{Coupling, CouplingKind, FluidSetup, InterfaceLaw, WallCondition, WallSetup};
use sph::space::Vector;

use super::support::{add_block, empty_scene, solver, stage_time};

const SPACING: f64 = 0.02;
const COLUMNS: usize = 20;
const ROWS: usize = 10;
/// Height of the solid's face \[m\].
const FACE: f64 = 0.4;
/// Speed of the solid along its face \[m/s\].
const SPEED: f64 = 0.1;

/// Fluid between a solid below and a no-slip wall at rest above, periodic along both, with the linear profile.
fn gap() -> FluidSetup {
    let mut setup = empty_scene(SPACING);
    setup.run.domain.upper.x = COLUMNS as f64 * SPACING;
    setup.run.domain.periodic = [true, false];
    let parameters = &mut setup.parameters;
    (parameters.viscosity_a, parameters.viscosity_b) = (0.0, 0.0);
    parameters.dynamic_viscosity = 1000.0;
    parameters.kernel_ratio = 1.3;
    add_block(&mut setup, Vector::new(0.0, FACE), COLUMNS, ROWS);
    let height = ROWS as f64 * SPACING;
    for i in 0..setup.particles.id.len() {
        setup.particles.velocity[i].x = SPEED * (1.0 - (setup.particles.position[i].y - FACE) / height);
    }
    let (name, condition) = ("ceiling".into(), WallCondition::NoSlip);
    setup.walls.push(WallSetup { name, condition, motion: None, release_time: None });
    for x in rows(FACE + height, 1.0) {
        setup.wall_particles.wall.push(0);
        setup.wall_particles.position.push(x);
        setup.wall_particles.normal.push(Vector::new(0.0, -1.0));
    }
    setup.run.coupling = Some(Coupling {
        kind: CouplingKind::States,
        law: InterfaceLaw::WallNoSlip,
        fluid: setup.parameters,
        solid_spacing: SPACING,
        repulsion: 1.0,
        margin: SPACING,
        implicit: None,
    });
    setup
}

/// Four rows behind a face at height `face` \[m\], upward or downward.
fn rows(face: f64, direction: f64) -> impl Iterator<Item = Vector> {
    let place = move |k: usize| {
        let (column, row) = ((k % COLUMNS) as f64 + 0.5, (k / COLUMNS) as f64 + 0.5);
        Vector::new(column * SPACING, face + direction * row * SPACING)
    };
    (0..4 * COLUMNS).map(place)
}

/// The solid as a belt: it stays in place.
fn belt() -> InterfaceStates {
    let position: Vec<Vector> = rows(FACE, -1.0).collect();
    let n = position.len();
    InterfaceStates {
        id: (0..n as u32).collect(),
        group: vec![0; n],
        mass: vec![1100.0 * SPACING * SPACING; n],
        velocity: vec![Vector::new(SPEED, 0.0); n],
        density: vec![1100.0; n],
        pressure: vec![0.0; n],
        stress: Vec::new(),
        position,
    }
}

#[test]
fn couette_flow_has_the_speed_of_the_solid_at_its_face() {
    let mut solver = solver(gap());
    let partner = StateColumns::from(&belt());
    let boxes = Column::from_iter([[0.0, FACE - 4.0 * SPACING, COLUMNS as f64 * SPACING, FACE]]);
    let extent = Extent { version: 1, boxes };
    let mut own = StateColumns::default();
    // Five times as long as the slowest departure from the steady profile lives, H²/(π² ν).
    for step in 0..400 {
        for stage in Stage::BOTH {
            let time = stage_time(step, stage, 5e-5);
            solver.begin_stage(&time).unwrap();
            solver.interface(&extent, 0.1, &mut own);
            solver.evaluate_own(&time);
            solver.evaluate_cross(&time, &own, &partner);
            solver.advance(&time).unwrap();
        }
        solver.end_step(&stage_time(step, Stage::Corrector, 5e-5)).unwrap();
    }
    let mean = |row: usize| {
        let bottom = FACE + row as f64 * SPACING;
        let inside = |i: &usize| (bottom..bottom + SPACING).contains(&solver.state.position[*i].y);
        let speeds: Vec<f64> =
            (0..solver.state.len()).filter(inside).map(|i| solver.state.velocity[i].x).collect();
        assert_eq!(speeds.len(), COLUMNS);
        speeds.iter().sum::<f64>() / COLUMNS as f64
    };
    let speeds: Vec<f64> = (0..ROWS).map(mean).collect();
    let fall = (speeds[2] - speeds[7]) / 5.0;
    for (row, speed) in speeds.iter().enumerate() {
        let straight = speeds[2] - (row as f64 - 2.0) * fall;
        // The rows next to solid and wall see a mean of means in place of single rows: by the sums over a lattice, the line
        // is bent there by 0.004 of the change per row.
        assert!((speed - straight).abs() < 0.02 * fall, "row {row}: {speed}, {straight} by the others");
    }
    let at_face = speeds[2] + 2.5 * fall;
    // By the same sums 0.008 of the change per row; a solid that acts at its first row is off by 0.5.
    assert!((at_face - SPEED).abs() < 0.03 * fall, "{at_face} m/s at the face, {fall} m/s per row");
}
