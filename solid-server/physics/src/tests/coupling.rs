//! The solids' end of the interface, against a partner that is played by hand.

use sph::coupling::exchange::{Column, Extent, StateColumns};
use sph::coupling::ledger::{StageBudget, TorqueCheck, imbalance};
use sph::coupling::solver::Solver;
use sph::coupling::stage::Stage;
use sph::interface::Interface;
use sph::interface::states::InterfaceStates;
use sph::prescribed::body_force::BodyForceField;
use sph::setup::{Coupling, CouplingKind, FluidParameters, InterfaceLaw, SolidProbeKind};
use sph::space::Vector;

use super::scenes::{Run, add_elastic, add_probe, block, scene};

const SPACING: f64 = 2e-3;

pub fn coupling(law: InterfaceLaw) -> Coupling {
    Coupling {
        kind: CouplingKind::States,
        law,
        fluid: FluidParameters {
            sound_speed: 25.0,
            dynamic_viscosity: 1e-3,
            particle_spacing: SPACING,
            ..FluidParameters::PLAIN
        },
        solid_spacing: SPACING,
        repulsion: 0.5,
        margin: SPACING,
        implicit: None,
    }
}

/// A block of 6 x 6 with water of 2 kPa to its left that approaches at 1 m/s.
fn wetted_block(law: InterfaceLaw) -> (Run, InterfaceStates, Extent) {
    let mut setup = scene(SPACING);
    setup.run.coupling = Some(coupling(law));
    add_elastic(&mut setup, &block(Vector::zeros(), 6, 6, SPACING));
    add_probe(&mut setup, SolidProbeKind::BodyForce(0));
    let corner = Vector::new(-4.0 * SPACING, -SPACING);
    let position = block(corner, 4, 8, SPACING);
    let n = position.len();
    let water = InterfaceStates {
        id: (0..n as u32).collect(),
        group: vec![0; n],
        mass: vec![1000.0 * SPACING * SPACING; n],
        velocity: vec![Vector::new(1.0, 0.0); n],
        density: vec![1002.0; n],
        pressure: vec![2e3; n],
        stress: Vec::new(),
        position,
    };
    let extent = Extent { version: 1, boxes: Column::from_iter([[corner.x, corner.y, 0.0, 7.0 * SPACING]]) };
    (Run::new(setup, 1e-5), water, extent)
}

/// One stage against fixed water; returns own states and budget.
fn stage(
    run: &mut Run,
    stage: Stage,
    water: &InterfaceStates,
    extent: &Extent,
    reach: f64,
) -> (InterfaceStates, StageBudget, u64) {
    let time = run.stage_time(stage);
    let mut own = StateColumns::default();
    run.solver.begin_stage(&time).unwrap();
    let version = run.solver.interface(extent, reach, &mut own);
    run.solver.evaluate_own(&time);
    run.solver.evaluate_cross(&time, &own, &water.into());
    ((&own).into(), run.solver.advance(&time).unwrap(), version)
}

const REACH: f64 = 2.0 * 1.2 * SPACING + SPACING;

#[test]
fn the_fluid_s_sums_are_the_opposite_of_the_solid_s() {
    for (law, check) in [
        (InterfaceLaw::Wall, TorqueCheck::Central),
        (InterfaceLaw::WallNoSlip, TorqueCheck::WithCouple),
        (InterfaceLaw::PlainSum, TorqueCheck::WithCouple),
    ] {
        let (mut run, water, extent) = wetted_block(law);
        let time = run.stage_time(Stage::Predictor);
        let (own, budget, _) = stage(&mut run, Stage::Predictor, &water, &extent, REACH);
        let field = BodyForceField::uniform(Vector::zeros());
        let mut interface = Interface::new(&coupling(law), &run.solver.model.domain, field);
        interface.update(time.state_time(), &water, &own);
        let theirs = interface.fluid_forces(&water, &own);
        assert!(budget.interface.force.x > 10.0, "{law:?}: {}", budget.interface.force);
        let imbalance = imbalance(&budget.interface, &theirs, check);
        assert!(imbalance.force < 1e-13 && imbalance.torque < 1e-13, "{law:?}: {imbalance:?}");
        assert!(budget.momentum_residual().max(budget.angular_residual()) < 1e-12);
    }
}

#[test]
fn own_states_lie_within_reach_and_their_version_counts_changes() {
    let (mut run, water, extent) = wetted_block(InterfaceLaw::Wall);
    let (own, _, version) = stage(&mut run, Stage::Predictor, &water, &extent, REACH);
    // Centres at 0.5, 1.5, 2.5 spacings from the water's box lie within 3.4 spacings; 3.5 does not.
    assert_eq!(own.len(), 18);
    assert!(own.id.is_sorted() && own.stress.is_empty());
    assert!(own.position.iter().all(|x| x.x <= REACH));
    let (again, _, same) = stage(&mut run, Stage::Corrector, &water, &extent, REACH);
    assert_eq!((again.id, same), (own.id, version));
    run.step += 1;
    let far = Extent { version: 2, boxes: Column::from_iter([[-1.0, -1.0, -0.9, 1.0]]) };
    let (filler, _, changed) = stage(&mut run, Stage::Predictor, &water, &far, REACH);
    assert!(filler.is_empty());
    assert_eq!(changed, version + 1);
    assert_eq!(run.solver.counts().largest_interface, 18);
    assert!(run.solver.covered_by(run.solver.extent(), REACH).is_ok());
    assert!(run.solver.covered_by(run.solver.extent(), SPACING).is_err());
}

#[test]
fn spare_particles_change_no_bit() {
    let bits = |reach: f64| {
        let (mut run, water, extent) = wetted_block(InterfaceLaw::Wall);
        for _ in 0..5 {
            for which in Stage::BOTH {
                stage(&mut run, which, &water, &extent, reach);
            }
            run.step += 1;
        }
        run.bits()
    };
    assert_eq!(bits(REACH), bits(10.0 * REACH));
}

#[test]
fn the_body_force_probe_reports_the_fluid_s_force() {
    let (mut run, water, extent) = wetted_block(InterfaceLaw::Wall);
    stage(&mut run, Stage::Predictor, &water, &extent, REACH);
    assert_eq!(run.probes(), [0.0, 0.0]);
    let (_, budget, _) = stage(&mut run, Stage::Corrector, &water, &extent, REACH);
    let probes = run.probes();
    let force = budget.interface.force;
    assert!((probes[0] - force.x).abs() < 1e-12 * force.x && probes[0] > 10.0);
}

#[test]
fn under_the_plain_sum_the_fluid_enters_the_solid_s_continuity() {
    let first_density_rate = |law| {
        let (mut run, water, extent) = wetted_block(law);
        let (own, _, _) = stage(&mut run, Stage::Predictor, &water, &extent, REACH);
        assert_eq!(own.stress.is_empty(), law == InterfaceLaw::Wall);
        run.solver.workspace.rates.density[0]
    };
    assert_eq!(first_density_rate(InterfaceLaw::Wall), 0.0);
    // Water that approaches compresses.
    assert!(first_density_rate(InterfaceLaw::PlainSum) > 0.0);
}
