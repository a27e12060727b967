//! The energy budget of bodies: every account by itself, and the balance of all.

use sph::coupling::ledger::{EnergyAccount as A, EnergyReport};
use sph::coupling::saved::SavedState;
use sph::coupling::solver::Solver;
use sph::setup::{
    Damping, Formulation, Motion, SolidSetup, SolidStepping, SubstepCount, Support, UpdatedLagrangian,
};
use sph::space::Vector;

use super::scenes::{
    Run, add_body, add_elastic, add_support, add_total, add_wall, block, clamp, rough, scene, set_velocity,
};
use crate::SolidSolver;

const SPACING: f64 = 2e-3;

fn share(report: &EnergyReport, scale: f64) -> f64 {
    report.residual().unwrap().abs() / scale
}

#[test]
fn a_ringing_bar_keeps_strain_and_kinetic_energy() {
    let mut setup = scene(SPACING);
    add_total(&mut setup, 4, &block(Vector::new(0.0, 0.0), 20, 5, SPACING));
    set_velocity(&mut setup, |x| Vector::new(2.0 * (x.x - 0.02), 0.0) * 10.0);
    let mut run = Run::new(setup, 2e-6);
    let start = run.solver.energies().value(A::Kinetic);
    run.until(4e-4);
    let report = run.solver.energies();
    assert!(report.value(A::Strain) > 1e-3 * start, "{report:?}");
    // Velocity Verlet keeps a nearby energy: what differs is bounded, (ω τ)²/8 of the fastest motion.
    assert!(report.value(A::TimeScheme).abs() < 2e-3 * start, "{report:?}");
    // Round-off.
    assert!(share(&report, start) < 1e-12, "{:?}", report.residual());
}

/// Bodies of all formulations, pushed about in gravity.
fn everything(stepping: SolidStepping) -> SolidSetup {
    let mut setup = scene(SPACING);
    setup.stepping = stepping;
    setup.contact = rough(0.3);
    setup.run.body_force.gravity = Vector::new(1.0, -9.81);
    setup.run.body_force.expressions = Some(["sin(500*t)".into(), "0".into()]);
    setup.damping = Some(Damping { rate: 3.0, until: 1.0 });
    add_wall(&mut setup, &block(Vector::new(-0.02, -3.0 * SPACING), 80, 3, SPACING));
    let held = add_elastic(&mut setup, &block(Vector::new(0.0, 0.0), 10, 4, SPACING));
    let at_left = |x: &Vector| x.x < 2.0 * SPACING;
    add_support(&mut setup, held, clamp(), at_left);
    add_body(&mut setup, Formulation::Rigid, &block(Vector::new(0.03, 0.0), 6, 6, SPACING));
    let updated = UpdatedLagrangian { viscosity_a: 1.0, ..UpdatedLagrangian::default() };
    add_body(
        &mut setup,
        Formulation::UpdatedLagrangian(updated),
        &block(Vector::new(0.06, 4.0 * SPACING), 8, 5, SPACING),
    );
    let driven = add_body(&mut setup, Formulation::Rigid, &block(Vector::new(0.09, 0.02), 4, 4, SPACING));
    let motion = Motion {
        displacement: ["0.01*t".into(), String::new()],
        angle: "30*t".into(),
        axis: 1.0,
        pivot: Vector::new(0.09, 0.02),
    };
    add_support(&mut setup, driven, Support { motion: Some(motion), ..clamp() }, |_| true);
    set_velocity(&mut setup, |x| Vector::new(0.3 * (100.0 * x.y).sin(), -0.4));
    setup
}

#[test]
fn the_budget_closes_for_all_formulations_and_both_ways_to_step() {
    for stepping in [SolidStepping::StageRule, SolidStepping::Substeps(SubstepCount::Fixed(4))] {
        let mut run = Run::new(everything(stepping), 1e-6);
        let start = run.solver.energies().value(A::Kinetic);
        run.until(4e-4);
        let report = run.solver.energies();
        // The change of kinetic energy is the work of all forces by round-off.
        assert!(share(&report, start) < 1e-11, "{stepping:?}: {:?}", report.residual());
        for account in
            [A::BodyForce, A::Supports, A::ArtificialViscosity, A::Damping, A::Contact, A::Friction]
        {
            assert!(report.value(account) != 0.0, "{stepping:?} {}", account.name());
        }
        assert!(report.value(A::ArtificialViscosity) > 0.0 && report.value(A::Damping) > 0.0);
        assert!(report.get(A::Walls).is_none() && report.get(A::Compression).is_none());
    }
}

#[test]
fn friction_takes_what_a_sliding_block_loses() {
    let mut setup = scene(SPACING);
    setup.contact = rough(0.3);
    add_wall(&mut setup, &block(Vector::new(-15.0 * SPACING, -3.0 * SPACING), 60, 3, SPACING));
    add_body(&mut setup, Formulation::Rigid, &block(Vector::new(-6.0 * SPACING, 0.0), 12, 6, SPACING));
    setup.stepping = SolidStepping::Substeps(SubstepCount::Fixed(4));
    setup.run.body_force.gravity = Vector::new(0.0, -9.81);
    set_velocity(&mut setup, |_| Vector::new(0.2, 0.0));
    let mut run = Run::new(setup, 2e-5);
    let start = run.solver.energies().value(A::Kinetic);
    run.until(0.04);
    let report = run.solver.energies();
    let lost = start - report.value(A::Kinetic);
    // It slows down by μg over 40 ms: 5 % allow for its rocking on the face.
    let mass = 72.0 * 1100.0 * SPACING * SPACING;
    let speed: f64 = 0.2 - 0.3 * 9.81 * 0.04;
    let expected = start - 0.5 * mass * speed * speed;
    assert!((report.value(A::Friction) / expected - 1.0).abs() < 0.05, "{report:?} {expected}");
    assert!((lost / expected - 1.0).abs() < 0.05, "{lost} {expected}");
    assert!(share(&report, start) < 1e-11, "{:?}", report.residual());
}

#[test]
fn a_restored_run_continues_its_accounts_to_the_bit() {
    let stepping = SolidStepping::Substeps(SubstepCount::Fixed(4));
    let mut whole = Run::new(everything(stepping), 1e-6);
    whole.until(5e-5);
    let mut saved = SavedState::default();
    whole.solver.save(&mut saved);
    let mut restored = SolidSolver::new(everything(stepping)).unwrap();
    restored.restore(&saved).unwrap();
    assert_eq!(whole.solver.energies(), restored.energies());
    let mut continued = Run::new(everything(stepping), 1e-6);
    (continued.solver, continued.step) = (restored, whole.step);
    whole.until(8e-5);
    continued.until(8e-5);
    assert_eq!(whole.solver.energies(), continued.solver.energies());
}
