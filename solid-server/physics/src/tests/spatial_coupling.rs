//! The solids' end of the interface in space, and the water in gaps, against water that is played by hand.

use nalgebra::Vector3;
use sph::coupling::exchange::{Column, Extent, StateColumns};
use sph::coupling::ledger::{StageBudget, TorqueCheck, imbalance};
use sph::coupling::solver::Solver;
use sph::coupling::stage::Stage;
use sph::interface::Interface;
use sph::interface::states::InterfaceStates;
use sph::prescribed::body_force::BodyForceField;
use sph::setup::{Formulation, InterfaceLaw, SolidProbeKind};
use sph::space::Spatial;

use super::coupling::coupling;
use super::scenes::{Run, add_body, add_elastic, add_probe, add_wall, brick, scene_in};

const SPACING: f64 = 2e-3;

/// Water of `pressure` \[Pa\] and `velocity` \[m/s\] at `position` \[m\].
fn water(position: Vec<Vector3<f64>>, pressure: f64, velocity: Vector3<f64>) -> InterfaceStates<Spatial> {
    let n = position.len();
    InterfaceStates {
        id: (0..n as u32).collect(),
        group: vec![0; n],
        mass: vec![1000.0 * SPACING.powi(3); n],
        velocity: vec![velocity; n],
        density: vec![1000.0; n],
        pressure: vec![pressure; n],
        stress: Vec::new(),
        position,
    }
}

/// The first predictor of `run` in `water`: own states and budget.
fn evaluated(
    run: &mut Run<Spatial>,
    water: &InterfaceStates<Spatial>,
) -> (InterfaceStates<Spatial>, StageBudget) {
    let time = run.stage_time(Stage::Predictor);
    let extent = Extent { version: 1, boxes: Column::from_iter([[-1.0, -1.0, -1.0, 1.0, 1.0, 1.0]]) };
    let mut own = StateColumns::default();
    run.solver.begin_stage(&time).unwrap();
    run.solver.interface(&extent, 1.0, &mut own);
    run.solver.evaluate_own(&time);
    run.solver.evaluate_cross(&time, &own, &water.into());
    ((&own).into(), run.solver.advance(&time).unwrap())
}

#[test]
fn the_fluid_s_sums_are_the_opposite_of_the_solid_s() {
    for (law, check) in [
        (InterfaceLaw::Wall, TorqueCheck::Central),
        (InterfaceLaw::WallNoSlip, TorqueCheck::WithCouple),
        (InterfaceLaw::PlainSum, TorqueCheck::WithCouple),
    ] {
        let mut setup = scene_in::<Spatial>(SPACING);
        setup.run.coupling = Some(coupling(law));
        add_elastic(&mut setup, &brick(Vector3::zeros(), [5, 5, 5], SPACING));
        add_probe(&mut setup, SolidProbeKind::BodyForce(0));
        let beside = brick(Vector3::new(-4.0, -1.0, -1.2) * SPACING, [4, 7, 7], SPACING);
        let water = water(beside, 2e3, Vector3::new(1.0, 0.2, -0.1));
        let mut run = Run::new(setup, 1e-5);
        let time = run.stage_time(Stage::Predictor);
        let (own, budget) = evaluated(&mut run, &water);
        let field = BodyForceField::uniform(Vector3::zeros());
        let mut interface = Interface::new(&coupling(law), &run.solver.model.domain, field);
        interface.update(time.state_time(), &water, &own);
        let theirs = interface.fluid_forces(&water, &own);
        // A face of 10 x 10 mm under 2 kPa.
        assert!(budget.interface.force.x > 0.1, "{law:?}: {}", budget.interface.force);
        let imbalance = imbalance(&budget.interface, &theirs, check);
        assert!(imbalance.force < 1e-13 && imbalance.torque < 1e-13, "{law:?}: {imbalance:?}");
        assert!(budget.momentum_residual().max(budget.angular_residual()) < 1e-12);
    }
}

#[test]
fn water_around_a_body_on_the_floor_presses_from_below_as_if_it_were_there() {
    let (pressure, width) = (2e3, 8);
    for gap in [0.0, 0.4] {
        let mut setup = scene_in::<Spatial>(SPACING);
        setup.run.coupling = Some(coupling(InterfaceLaw::Wall));
        add_wall(&mut setup, &brick(Vector3::new(-8.0, -4.0, -8.0) * SPACING, [24, 4, 24], SPACING));
        let body = brick(Vector3::new(0.0, gap, 0.0) * SPACING, [width, 4, width], SPACING);
        add_body(&mut setup, Formulation::Rigid, &body);
        let side = f64::from(width) * SPACING;
        let outside = |x: &Vector3<f64>| x.x.min(x.z) < 0.0 || x.x.max(x.z) > side;
        let around = brick(Vector3::new(-4.0, 0.0, -4.0) * SPACING, [width + 8, 4, width + 8], SPACING);
        let water = water(around.into_iter().filter(outside).collect(), pressure, Vector3::zeros());
        let mut run = Run::new(setup, 1e-5);
        let (_, budget) = evaluated(&mut run, &water);
        let forces = &run.solver.workspace.film.as_ref().unwrap().forces;
        let of_walls: Vector3<f64> = forces.iter().map(|force| force.walls).sum();
        // The water beside presses on the edges too.
        let share = (of_walls.y + budget.interface.force.y) / (pressure * side * side);
        assert!((share - 1.0).abs() < 0.05, "{gap}: {share}");
        assert!(of_walls.x.hypot(of_walls.z) < 1e-9 * of_walls.y);
        assert!(forces.iter().all(|force| force.bodies == Vector3::zeros()));
        assert!(budget.momentum_residual().max(budget.angular_residual()) < 1e-12);
    }
}
