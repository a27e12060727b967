//! Flow along the face of a solid.

use sph::coupling::exchange::{Column, Extent, StateColumns};
use sph::coupling::solver::Solver;
use sph::coupling::stage::Stage;
use sph::interface::states::InterfaceStates;
use sph::setup::{
    Coupling, CouplingKind, FluidSetup, GradientCorrection, InterfaceLaw, ViscosityForm, WallCondition,
    WallSetup,
};
use sph::space::Vector;

use super::support::{add_block, empty_scene, run, solver, stage_time};
use crate::FluidSolver;

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
    add_wall(&mut setup, WallCondition::NoSlip, FACE + height, 1.0);
    couple(&mut setup, InterfaceLaw::WallNoSlip);
    setup
}

/// Adds a wall behind a face at height `face` \[m\], upward or downward.
fn add_wall(setup: &mut FluidSetup, condition: WallCondition, face: f64, direction: f64) {
    setup.walls.push(WallSetup { name: "wall".into(), condition, motion: None, release_time: None });
    for x in rows(face, direction) {
        setup.wall_particles.wall.push(0);
        setup.wall_particles.position.push(x);
        setup.wall_particles.normal.push(Vector::new(0.0, -direction));
    }
}

fn couple(setup: &mut FluidSetup, law: InterfaceLaw) {
    setup.run.coupling = Some(Coupling {
        kind: CouplingKind::States,
        law,
        fluid: setup.parameters,
        solid_spacing: SPACING,
        repulsion: 1.0,
        margin: SPACING,
        implicit: None,
    });
}

/// Four rows behind a face at height `face` \[m\], upward or downward.
fn rows(face: f64, direction: f64) -> impl Iterator<Item = Vector> {
    let place = move |k: usize| {
        let (column, row) = ((k % COLUMNS) as f64 + 0.5, (k / COLUMNS) as f64 + 0.5);
        Vector::new(column * SPACING, face + direction * row * SPACING)
    };
    (0..4 * COLUMNS).map(place)
}

/// The solid as a belt of `speed` \[m/s\]: it stays in place.
fn belt(speed: f64) -> InterfaceStates {
    let position: Vec<Vector> = rows(FACE, -1.0).collect();
    let n = position.len();
    InterfaceStates {
        id: (0..n as u32).collect(),
        group: vec![0; n],
        mass: vec![1100.0 * SPACING * SPACING; n],
        velocity: vec![Vector::new(speed, 0.0); n],
        density: vec![1100.0; n],
        pressure: vec![0.0; n],
        stress: Vec::new(),
        position,
    }
}

/// Takes `steps` of `length` \[s\] above `partner`.
fn run_above(solver: &mut FluidSolver, partner: &InterfaceStates, steps: u64, length: f64) {
    let partner = StateColumns::from(partner);
    let boxes = Column::from_iter([[0.0, FACE - 4.0 * SPACING, COLUMNS as f64 * SPACING, FACE]]);
    let extent = Extent { version: 1, boxes };
    let mut own = StateColumns::default();
    for step in 0..steps {
        for stage in Stage::BOTH {
            let time = stage_time(step, stage, length);
            solver.begin_stage(&time).unwrap();
            solver.interface(&extent, 0.1, &mut own);
            solver.evaluate_own(&time);
            solver.evaluate_cross(&time, &own, &partner);
            solver.advance(&time).unwrap();
        }
        solver.end_step(&stage_time(step, Stage::Corrector, length)).unwrap();
    }
}

#[test]
fn couette_flow_has_the_speed_of_the_solid_at_its_face() {
    let mut solver = solver(gap());
    // Five times as long as the slowest departure from the steady profile lives, H²/(π² ν).
    run_above(&mut solver, &belt(SPEED), 400, 5e-5);
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

#[test]
fn a_solid_at_rest_is_a_wall() {
    // Flow toward the face and along it, unlike from place to place, that repeats along it.
    let field = |x: &Vector| {
        let phase = std::f64::consts::TAU * x.x / (COLUMNS as f64 * SPACING);
        Vector::new(0.3 + 0.2 * phase.sin(), -(x.y - FACE) * (1.0 + 0.5 * phase.cos()) - 0.05)
    };
    for (law, condition) in
        [(InterfaceLaw::Wall, WallCondition::Slip), (InterfaceLaw::WallNoSlip, WallCondition::NoSlip)]
    {
        let mut setup = empty_scene(SPACING);
        setup.run.domain.upper.x = COLUMNS as f64 * SPACING;
        setup.run.domain.periodic = [true, false];
        // All walls and solids know of the water is in pair sums then, which are alike for both.
        setup.parameters.correction = GradientCorrection::LatticeMoment;
        setup.parameters.viscosity_form = ViscosityForm::Plain;
        setup.parameters.viscosity_solid_share = 1.0;
        add_block(&mut setup, Vector::new(0.0, FACE), COLUMNS, ROWS);
        for i in 0..setup.particles.id.len() {
            setup.particles.velocity[i] = field(&setup.particles.position[i]);
        }
        let mut above_wall = setup.clone();
        add_wall(&mut above_wall, condition, FACE, -1.0);
        couple(&mut setup, law);
        let [mut above_wall, mut above_solid] = [above_wall, setup].map(solver);
        run(&mut above_wall, 1, 1e-4);
        run_above(&mut above_solid, &belt(0.0), 1, 1e-4);
        let (wall, solid) = (&above_wall.state, &above_solid.state);
        let (mut turned, mut compressed) = (0.0f64, 0.0f64);
        let (mut other_velocity, mut other_density) = (0.0f64, 0.0f64);
        for i in 0..wall.len() {
            turned = turned.max((wall.velocity[i] - field(&wall.position[i])).norm());
            compressed = compressed.max((wall.density[i] - 1000.0).abs());
            other_velocity = other_velocity.max((wall.velocity[i] - solid.velocity[i]).norm());
            other_density = other_density.max((wall.density[i] - solid.density[i]).abs());
        }
        assert!(turned > 1e-4 && compressed > 0.01, "the face does nothing");
        // A wall knows its normal, that of the solid follows from where the water lies.
        assert!(other_velocity < 0.01 * turned, "{law:?}: {other_velocity} of {turned} m/s");
        assert!(other_density < 0.01 * compressed, "{law:?}: {other_density} of {compressed} kg/m³");
    }
}
