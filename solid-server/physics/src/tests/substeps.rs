//! Sub-steps of all kinds of bodies.

use sph::coupling::ledger::EnergyAccount;
use sph::coupling::ledger::{Account, LedgerVector};
use sph::coupling::solver::Solver;
use sph::setup::{
    Formulation, HyperelasticLaw, InterfaceLaw, Motion, SolidProbeKind, SolidSetup, SolidStepping,
    SubstepCount, Support,
};
use sph::space::Vector;

use super::scenes::{
    Run, add_body, add_elastic, add_probe, add_support, add_total, add_wall, block, clamp, scene,
    set_velocity, total_lagrangian,
};
use crate::SolidSolver;

const SPACING: f64 = 2e-3;

/// A moving clamp, a contact, a floor, gravity and damping, with bodies of all kinds.
fn everything(substeps: u32) -> SolidSetup {
    let mut setup = scene(SPACING);
    add_wall(&mut setup, &block(Vector::new(-0.03, -3.0 * SPACING), 40, 3, SPACING));
    let swung = add_total(&mut setup, substeps, &block(Vector::zeros(), 12, 4, SPACING));
    let motion = Motion {
        displacement: ["2e-3*sin(300*t)".into(), "0".into()],
        angle: "5*t".into(),
        axis: 1.0,
        pivot: Vector::zeros(),
    };
    let support = Support { motion: Some(motion), ..clamp() };
    add_support(&mut setup, swung, support, |x| x.x < 2.0 * SPACING);
    add_elastic(&mut setup, &block(Vector::new(0.0, 5.0 * SPACING), 5, 5, SPACING));
    add_body(&mut setup, Formulation::Rigid, &block(Vector::new(0.012, 5.0 * SPACING), 4, 4, SPACING));
    set_velocity(&mut setup, |x| {
        if x.y > 4.0 * SPACING { Vector::new(0.5, -3.0) } else { Vector::new(0.0, -1.0) }
    });
    setup.run.body_force.gravity = Vector::new(0.0, -9.81);
    setup.damping = Some(sph::setup::Damping { rate: 20.0, until: 2e-3 });
    add_probe(&mut setup, SolidProbeKind::Motion(1));
    add_probe(&mut setup, SolidProbeKind::Motion(2));
    add_probe(&mut setup, SolidProbeKind::Reaction(0, 0));
    setup
}

#[test]
fn books_close_at_round_off_with_bodies_of_all_kinds() {
    for substeps in [2, 6] {
        let mut run = Run::new(everything(substeps), 5e-6 * f64::from(substeps));
        let mut used = [false; 4];
        while run.time() < 4e-3 {
            for budget in run.step().unwrap() {
                for (used, account) in used.iter_mut().zip([
                    Account::BodyForce,
                    Account::Damping,
                    Account::Supports,
                    Account::WallContact,
                ]) {
                    *used |= budget.accounts.get(account).force != LedgerVector::zeros();
                }
            }
        }
        assert_eq!(used, [true; 4]);
        // 1e-16 per addition, several hundred additions per particle.
        assert!(run.largest_residual < 1e-13, "{substeps}: {}", run.largest_residual);
    }
}

#[test]
fn the_number_of_sub_steps_is_a_matter_of_accuracy_alone() {
    let end = |substeps: u32| {
        let mut run = Run::new(everything(substeps), 1e-5);
        run.until(3e-3);
        run.probes()
    };
    let (coarse, fine) = (end(2), end(8));
    for (k, (a, b)) in coarse.iter().zip(&fine).enumerate().take(4) {
        // Centre and velocity of the block that bounces on the swung one.
        assert!((a - b).abs() < 0.02 * b.abs().max(0.02), "column {k}: {a} {b}");
    }
}

#[test]
fn a_moving_support_is_followed_exactly() {
    let mut run = Run::new(everything(4), 1e-5);
    let start = run.vectors("position");
    run.until(3e-3);
    let (sine, cosine) = (5.0f64 * 3e-3).sin_cos();
    let shift = Vector::new(2e-3 * (0.9f64).sin(), 0.0);
    for i in (0..48).filter(|i| i % 12 < 2) {
        let x = start[i];
        let expected = Vector::new(cosine * x.x - sine * x.y, sine * x.x + cosine * x.y) + shift;
        assert!((run.vectors("position")[i] - expected).norm() < 1e-16);
    }
}

/// Displacement of an undamped oscillator: a bar of two masses, by one step of the given size, against a fine run.
fn error_after(time_step: f64, formulation: &dyn Fn() -> Formulation) -> f64 {
    let run = |time_step: f64| {
        let mut setup = scene(SPACING);
        add_body(&mut setup, formulation(), &block(Vector::zeros(), 12, 4, SPACING));
        setup.stepping = SolidStepping::Substeps(SubstepCount::Fixed(2));
        add_support(&mut setup, 0, clamp(), |x| x.x < 2.0 * SPACING);
        set_velocity(&mut setup, |x| Vector::new(0.0, 40.0 * (x.x - 2.0 * SPACING).max(0.0)));
        setup.damping = Some(sph::setup::Damping { rate: 200.0, until: 1.0 });
        let mut run = Run::new(setup, time_step);
        run.until(8e-4);
        run.vectors("position")
    };
    let (coarse, fine) = (run(time_step), run(2.5e-7));
    coarse.iter().zip(&fine).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

#[test]
fn sub_steps_are_of_second_order_for_both_elastic_formulations() {
    let total = || total_lagrangian(HyperelasticLaw::NeoHookean);
    let updated = || {
        let law = sph::setup::UpdatedLagrangian::default();
        // Without viscosity, whose onset on approach is not smooth.
        Formulation::UpdatedLagrangian(sph::setup::UpdatedLagrangian {
            viscosity_a: 0.0,
            viscosity_b: 0.0,
            ..law
        })
    };
    for formulation in [&total as &dyn Fn() -> Formulation, &updated] {
        let (coarse, fine) = (error_after(8e-6, formulation), error_after(4e-6, formulation));
        let order = (coarse / fine).log2();
        assert!((1.8..2.3).contains(&order), "{order}: {coarse} {fine}");
    }
}

#[test]
fn an_automatic_number_keeps_a_long_step_stable() {
    let mut setup = scene(SPACING);
    add_total(&mut setup, 2, &block(Vector::zeros(), 12, 4, SPACING));
    setup.stepping = SolidStepping::Substeps(SubstepCount::Automatic);
    set_velocity(&mut setup, |x| Vector::new(0.0, 50.0 * x.x));
    let mut run = Run::new(setup, 3e-4);
    let energy = |run: &Run| {
        run.solver.energies().value(EnergyAccount::Kinetic)
            + run.solver.energies().value(EnergyAccount::Strain)
    };
    let start = energy(&run);
    for _ in 0..40 {
        run.step().unwrap();
    }
    assert!((energy(&run) / start - 1.0).abs() < 0.02, "{}", energy(&run) / start);
}

#[test]
fn the_plain_sum_and_odd_counts_are_refused() {
    let mut setup = scene(SPACING);
    add_elastic(&mut setup, &block(Vector::zeros(), 4, 4, SPACING));
    setup.stepping = SolidStepping::Substeps(SubstepCount::Fixed(3));
    setup.run.coupling = Some(super::coupling::coupling(InterfaceLaw::PlainSum));
    let Err(errors) = SolidSolver::new(setup) else { panic!("accepted") };
    assert_eq!(errors.len(), 2, "{errors:?}");
    assert!(errors.iter().any(|e| e.contains("even")) && errors.iter().any(|e| e.contains("plain-sum")));
}
