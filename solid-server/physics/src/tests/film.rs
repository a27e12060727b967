//! Water in gaps that are too thin for its particles, against water that is played by hand.

use sph::coupling::exchange::{Column, Extent, StateColumns};
use sph::coupling::ledger::{EnergyAccount as A, StageBudget};
use sph::coupling::solver::Solver;
use sph::coupling::stage::Stage;
use sph::interface::states::InterfaceStates;
use sph::setup::{ContactLaw, Formulation, InterfaceLaw, SolidProbeKind, SolidSetup};
use sph::space::Vector;

use super::coupling::coupling;
use super::scenes::{Run, add_body, add_probe, add_total, add_wall, block, scene};

const SPACING: f64 = 2e-3;

/// Width of the body in particles.
const WIDTH: u32 = 12;

/// Water at rest of `pressure` \[Pa\] at height zero under gravity `g` \[m/s²\] in the columns whose left sides are `lefts`, 4
/// columns wide and 5 rows high.
fn water(lefts: &[f64], pressure: f64, g: f64) -> InterfaceStates {
    let position: Vec<Vector> =
        lefts.iter().flat_map(|left| block(Vector::new(*left, 0.0), 4, 5, SPACING)).collect();
    let n = position.len();
    InterfaceStates {
        id: (0..n as u32).collect(),
        group: vec![0; n],
        mass: vec![1000.0 * SPACING * SPACING; n],
        velocity: vec![Vector::zeros(); n],
        density: vec![1000.0; n],
        pressure: position.iter().map(|x| pressure - 1000.0 * g * x.y).collect(),
        stress: Vec::new(),
        position,
    }
}

/// Left sides of the water to both sides of a body whose left side is at zero.
const LEFT: f64 = -4.0 * SPACING;
const RIGHT: f64 = WIDTH as f64 * SPACING;

/// A body of `WIDTH` x 6 particles whose lower face is `gap` \[m\] over a floor.
fn on_floor(gap: f64) -> SolidSetup {
    let mut setup = scene(SPACING);
    setup.run.coupling = Some(coupling(InterfaceLaw::Wall));
    add_wall(&mut setup, &block(Vector::new(-10.0 * SPACING, -4.0 * SPACING), WIDTH + 20, 4, SPACING));
    let body = block(Vector::new(0.0, gap), WIDTH, 6, SPACING);
    let body = add_body(&mut setup, Formulation::Rigid, &body);
    add_probe(&mut setup, SolidProbeKind::BodyForce(body));
    setup
}

/// The first predictor of `setup` in `water`.
fn evaluated(setup: SolidSetup, water: &InterfaceStates) -> (Run, StageBudget) {
    let mut run = Run::new(setup, 1e-5);
    let budget = stage(&mut run, Stage::Predictor, water);
    (run, budget)
}

fn stage(run: &mut Run, stage: Stage, water: &InterfaceStates) -> StageBudget {
    let time = run.stage_time(stage);
    let extent = Extent { version: 1, boxes: Column::from_iter([[-1.0, -1.0, 1.0, 1.0]]) };
    let mut own = StateColumns::default();
    run.solver.begin_stage(&time).unwrap();
    run.solver.interface(&extent, 1.0, &mut own);
    run.solver.evaluate_own(&time);
    run.solver.evaluate_cross(&time, &own, &water.into());
    run.solver.advance(&time).unwrap()
}

/// Force of the film on all particles toward bodies and toward walls \[N/m\].
fn film(run: &Run) -> [Vector; 2] {
    let forces = &run.solver.workspace.film.as_ref().unwrap().forces;
    [forces.iter().map(|force| force.bodies).sum(), forces.iter().map(|force| force.walls).sum()]
}

#[test]
fn water_on_both_sides_presses_from_below_as_if_it_were_there() {
    let pressure = 2e3;
    let area = f64::from(WIDTH) * SPACING;
    for gap in [0.0, 0.2, 0.4] {
        let (run, budget) = evaluated(on_floor(gap * SPACING), &water(&[LEFT, RIGHT], pressure, 0.0));
        let [of_bodies, of_walls] = film(&run);
        assert_eq!(of_bodies, Vector::zeros());
        // The water beside presses on the corners too.
        let share = (of_walls.y + budget.interface.force.y) / (pressure * area);
        assert!((share - 1.0).abs() < 0.04, "{gap}: {share}");
        assert!(of_walls.x.abs() < 1e-9 * of_walls.y);
        assert!(budget.momentum_residual().max(budget.angular_residual()) < 1e-12);
    }
}

#[test]
fn the_force_on_the_body_includes_the_water_below_it() {
    let still = water(&[LEFT, RIGHT], 2e3, 0.0);
    let (mut run, _) = evaluated(on_floor(0.0), &still);
    let budget = stage(&mut run, Stage::Corrector, &still);
    let expected = budget.interface.force.y + film(&run)[1].y;
    assert!((run.probes()[1] - expected).abs() < 1e-12 * expected.abs() && expected > 40.0);
}

#[test]
fn pressure_falls_linearly_to_the_side_of_the_air() {
    let pressure = 2e3;
    let (run, _) = evaluated(on_floor(0.0), &water(&[LEFT], pressure, 0.0));
    let forces = &run.solver.workspace.film.as_ref().unwrap().forces;
    let column = |k: usize| -> f64 { (0..6).map(|row| forces[row * WIDTH as usize + k].walls.y).sum() };
    let full = pressure * SPACING;
    // Columns 3 to 8 of 12, between ends that reach into the gap by a spacing or two.
    let (left, right) = (column(3) / full, column(8) / full);
    assert!((left + right - 1.0).abs() < 0.1, "{left} {right}");
    assert!((left - right - 5.0 / 12.0).abs() < 0.06, "{left} {right}");
    let middle = 0.5 * (column(5) + column(6)) / full;
    assert!((middle - 0.5 * (left + right)).abs() < 0.01, "{middle}");
}

#[test]
fn dry_gaps_and_dry_contact_have_no_film() {
    let nothing = water(&[], 0.0, 0.0);
    let (run, _) = evaluated(on_floor(0.0), &nothing);
    assert_eq!(film(&run), [Vector::zeros(); 2]);
    let mut setup = on_floor(0.0);
    let ContactLaw::Repulsion(law) = &mut setup.contact else { panic!() };
    law.wet = false;
    let (run, _) = evaluated(setup, &water(&[LEFT, RIGHT], 2e3, 0.0));
    assert!(run.solver.workspace.film.is_none());
}

#[test]
fn a_wide_gap_without_water_is_a_void() {
    let thin = evaluated(on_floor(0.5 * SPACING), &water(&[LEFT, RIGHT], 2e3, 0.0));
    let wide = evaluated(on_floor(1.5 * SPACING), &water(&[LEFT, RIGHT], 2e3, 0.0));
    let middle = |run: &Run| run.solver.workspace.film.as_ref().unwrap().forces[WIDTH as usize / 2].walls.y;
    assert!(middle(&wide.0) < 0.1 * middle(&thin.0));
}

#[test]
fn pressure_grows_with_depth_along_an_upright_gap() {
    let mut setup = scene(SPACING);
    setup.run.coupling = Some(coupling(InterfaceLaw::Wall));
    setup.run.body_force.gravity = Vector::new(0.0, -9.81);
    // Two blocks side by side, 8 rows high, with water above and below.
    for left in [-6.0, 0.1] {
        add_body(&mut setup, Formulation::Rigid, &block(Vector::new(left * SPACING, 0.0), 6, 8, SPACING));
    }
    let mut still = water(&[], 0.0, 0.0);
    for level in [-4.0, 8.0] {
        still.position.extend(block(Vector::new(-8.0 * SPACING, level * SPACING), 16, 4, SPACING));
    }
    let n = still.position.len();
    still.id = (0..n as u32).collect();
    still.group = vec![0; n];
    still.mass = vec![1000.0 * SPACING * SPACING; n];
    still.velocity = vec![Vector::zeros(); n];
    still.density = vec![1000.0; n];
    still.pressure = still.position.iter().map(|x| 500.0 - 9810.0 * x.y).collect();
    let (run, budget) = evaluated(setup, &still);
    let [between, walls] = film(&run);
    let forces = &run.solver.workspace.film.as_ref().unwrap().forces;
    assert_eq!(walls, Vector::zeros());
    // Pairs are opposite bit for bit, sums to round-off.
    let gross: f64 = forces.iter().map(|force| force.bodies.norm()).sum();
    assert!(gross > 10.0 && between.norm() < 1e-13 * gross);
    assert!(budget.momentum_residual().max(budget.angular_residual()) < 1e-12);
    // Row by row on the left body, from its columns that face the gap.
    for row in 2..6 {
        let load: f64 = (3..6).map(|column| -forces[row * 6 + column].bodies.x).sum();
        let expected = (500.0 - 9810.0 * (row as f64 + 0.5) * SPACING) * SPACING;
        assert!((load / expected - 1.0).abs() < 0.02, "{row}: {load} {expected}");
    }
}

#[test]
fn water_behind_a_thin_plate_is_not_in_the_gap() {
    let load = |behind: f64| {
        let mut setup = scene(SPACING);
        setup.run.coupling = Some(coupling(InterfaceLaw::Wall));
        add_wall(&mut setup, &block(Vector::new(-10.0 * SPACING, -4.0 * SPACING), 44, 4, SPACING));
        add_body(&mut setup, Formulation::Rigid, &block(Vector::zeros(), 24, 2, SPACING));
        let mut all = water(&[LEFT, 24.0 * SPACING], 1e3, 0.0);
        let above = water(&[4.0 * SPACING, 8.0 * SPACING, 12.0 * SPACING, 16.0 * SPACING], behind, 0.0);
        all.id.extend((0..above.len() as u32).map(|k| 1000 + k));
        all.group.extend(above.group);
        all.mass.extend(above.mass);
        all.velocity.extend(above.velocity);
        all.density.extend(above.density);
        all.pressure.extend(above.pressure);
        all.position.extend(above.position.iter().map(|x| x + Vector::new(0.0, 2.0 * SPACING)));
        film(&evaluated(setup, &all).0)[1].y
    };
    let (shallow, deep) = (load(500.0), load(5e3));
    assert!((deep / shallow - 1.0).abs() < 0.01, "{shallow} {deep}");
}

#[test]
fn an_undeformed_body_does_not_face_itself_in_coarse_water() {
    // The fluid's kernel reaches over 10 of its particles.
    let fine = 0.25 * SPACING;
    let mut setup = scene(fine);
    let mut coupling = coupling(InterfaceLaw::Wall);
    coupling.solid_spacing = fine;
    setup.run.coupling = Some(coupling);
    add_total(&mut setup, 2, &block(Vector::zeros(), 3, 40, fine));
    let (run, _) = evaluated(setup, &water(&[LEFT, 3.0 * fine], 2e3, 0.0));
    assert_eq!(film(&run), [Vector::zeros(); 2]);
}

#[test]
fn work_of_the_film_is_accounted() {
    let mut setup = on_floor(0.0);
    setup.bodies.clear();
    setup.probes.clear();
    setup.particles = Default::default();
    add_total(&mut setup, 8, &block(Vector::zeros(), WIDTH, 6, SPACING));
    let still = water(&[LEFT, RIGHT], 2e3, 0.0);
    let mut run = Run::new(setup, 1e-5);
    for _ in 0..40 {
        for which in Stage::BOTH {
            let budget = stage(&mut run, which, &still);
            assert!(budget.momentum_residual().max(budget.angular_residual()) < 1e-12);
        }
        run.solver.end_step(&run.stage_time(Stage::Corrector)).unwrap();
        run.step += 1;
    }
    let report = run.solver.energies();
    let work = report.value(A::Film);
    assert!(work > 0.0 && report.residual().unwrap().abs() < 1e-12 * work, "{report:?}");
}
