//! The energy budget: every account by itself, and the balance of all.

use sph::coupling::ledger::{EnergyAccount as A, EnergyReport, SignRule};
use sph::coupling::saved::SavedState;
use sph::coupling::solver::Solver;
use sph::setup::{
    Damping, DensityDiffusion, FluidScheme, FluidSetup, GradientCorrection, Motion, WallCondition,
};
use sph::space::Vector;

use super::support::{Noise, add_block, add_floor, dam_break, empty_scene, random_patch, run, solver};
use crate::FluidSolver;

const SCHEMES: [FluidScheme; 2] = [FluidScheme::Leapfrog, FluidScheme::PredictorCorrector];

/// The residual over the potential energy that was given, or over `scale` \[J/m\].
fn share(report: &EnergyReport, scale: f64) -> f64 {
    report.residual().unwrap().abs() / scale
}

/// A falling column in which everything acts that can.
fn everything(scheme: FluidScheme) -> FluidSetup {
    let mut setup = dam_break();
    let p = &mut setup.parameters;
    p.scheme = scheme;
    p.viscosity_b = 0.5;
    p.correction = GradientCorrection::Renormalised;
    p.density_diffusion = DensityDiffusion::Renormalised;
    (p.shifting, p.tensile_control, p.volume_correction) = (2.0, true, 2.0);
    (p.acoustic_damping, p.artificial_pressure, p.dynamic_viscosity) = (0.1, 0.2, 0.5);
    (p.acoustic_relaxation, p.acoustic_relaxation_time) = (1.0, Some(2e-3));
    setup.run.body_force.expressions = Some(["3*sin(40*t)".into(), "x".into()]);
    setup.damping = Some(Damping { rate: 2.0, until: 1.0 });
    let mut noise = Noise(11);
    setup.particles.velocity.iter_mut().for_each(|v| *v = noise.vector() * 0.3);
    setup
}

#[test]
fn the_budget_closes_with_everything_that_acts() {
    for scheme in SCHEMES {
        let mut solver = solver(everything(scheme));
        run(&mut solver, 400, 1e-4);
        let report = solver.energies();
        let fallen = report.value(A::Potential) - report.get(A::Potential).unwrap().start;
        // Cubes of the change of density in a half-step, 1e-3: see `LaneCompressionBudget::compresses`.
        let scale = fallen.abs().max(report.value(A::Kinetic));
        assert!(share(&report, scale) < 1e-5, "{scheme:?}: {} of {scale}", report.residual().unwrap());
        for account in [A::BodyForce, A::ArtificialViscosity, A::Viscosity, A::Damping, A::AcousticDamper]
            .into_iter()
            .chain([A::AcousticRelaxation, A::DensityDiffusion, A::VolumeCorrection, A::Shifting])
        {
            let value = report.value(account);
            assert!(value != 0.0, "{}", account.name());
            // Nothing that may only lose has gained.
            assert!(account.sign_rule() == SignRule::Either || value > 0.0, "{} {value}", account.name());
        }
        assert!(report.get(A::Walls).is_none() && report.get(A::Strain).is_none());
    }
}

#[test]
fn free_fall_turns_potential_into_kinetic_energy_alone() {
    for scheme in SCHEMES {
        let mut setup = empty_scene(0.02);
        setup.run.body_force.gravity = Vector::new(0.0, -9.81);
        setup.parameters.scheme = scheme;
        add_block(&mut setup, Vector::new(0.4, 0.4), 6, 6);
        let mut solver = solver(setup);
        run(&mut solver, 100, 1e-4);
        let report = solver.energies();
        let mass = 36.0 * 1000.0 * 0.02 * 0.02;
        let speed: f64 = 9.81 * 0.01;
        // Round-off of positions of 0.5 m, whose potential energy is 70 J/m.
        assert!((report.value(A::Kinetic) - 0.5 * mass * speed * speed).abs() < 1e-10, "{scheme:?}");
        for (account, entry) in report.entries() {
            let allowed = if matches!(account, A::Kinetic | A::Potential) { f64::INFINITY } else { 1e-10 };
            assert!((entry.value - entry.start).abs() < allowed, "{scheme:?} {}: {entry:?}", account.name());
        }
    }
}

#[test]
fn damping_takes_what_a_damped_drop_loses() {
    let mut setup = empty_scene(0.02);
    add_block(&mut setup, Vector::new(0.4, 0.4), 6, 6);
    setup.particles.velocity.iter_mut().for_each(|v| *v = Vector::new(0.5, 0.0));
    setup.damping = Some(Damping { rate: 20.0, until: 1.0 });
    let mut solver = solver(setup);
    let start = solver.energies().value(A::Kinetic);
    run(&mut solver, 500, 1e-4);
    let report = solver.energies();
    // e^(-2 k t) of it is left; the scheme is of second order in k Δt = 2e-3.
    assert!((report.value(A::Kinetic) / start - (-2.0f64).exp()).abs() < 1e-5);
    assert!((report.value(A::Damping) + report.value(A::Kinetic) - start).abs() < 1e-12 * start);
}

#[test]
fn a_moving_floor_does_the_work_that_lifts_the_fluid() {
    for scheme in SCHEMES {
        let mut setup = empty_scene(0.02);
        setup.parameters.scheme = scheme;
        setup.parameters.viscosity_a = 1.0;
        add_floor(&mut setup, 0.3, 0.4, 24, WallCondition::Slip);
        add_block(&mut setup, Vector::new(0.36, 0.4), 18, 8);
        setup.walls[0].motion = Some(Motion {
            displacement: [String::new(), "0.5*t".into()],
            angle: String::new(),
            axis: 1.0,
            pivot: Vector::zeros(),
        });
        let mut solver = solver(setup);
        run(&mut solver, 200, 1e-4);
        let report = solver.energies();
        let gained: f64 = report.entries().filter(|(a, _)| *a == A::Kinetic).map(|(_, e)| e.value).sum();
        assert!(report.value(A::Walls) > gained && gained > 0.1, "{report:?}");
        // As above.
        assert!(share(&report, report.value(A::Walls)) < 1e-5, "{scheme:?} {:?}", report.residual());
    }
}

#[test]
fn viscosities_and_damping_never_give_energy_on_random_patches() {
    for seed in 0..6 {
        for scheme in SCHEMES {
            let mut setup = random_patch(seed);
            let p = &mut setup.parameters;
            (p.scheme, p.viscosity_a, p.dynamic_viscosity) = (scheme, 0.5, 5.0);
            (p.acoustic_relaxation, p.acoustic_relaxation_time) = (1.0, Some(1e-3));
            setup.damping = Some(Damping { rate: 5.0, until: 1.0 });
            let mut solver = solver(setup);
            let mut before = solver.energies();
            for _ in 0..10 {
                run(&mut solver, 1, 2e-5);
                let now = solver.energies();
                for (account, entry) in now.entries() {
                    let is_loss = account != A::Kinetic && account.sign_rule() == SignRule::NeverNegative;
                    let lost = entry.value - before.value(account);
                    assert!(!is_loss || lost >= 0.0, "{seed} {scheme:?} {}: {lost}", account.name());
                }
                before = now;
            }
        }
    }
}

#[test]
fn a_restored_run_continues_its_accounts_to_the_bit() {
    let mut whole = solver(everything(FluidScheme::Leapfrog));
    run(&mut whole, 30, 1e-4);
    let mut saved = SavedState::default();
    whole.save(&mut saved);
    let mut restored: FluidSolver = solver(everything(FluidScheme::Leapfrog));
    restored.restore(&saved).unwrap();
    assert_eq!(whole.state.energy, restored.state.energy);
    // The steps count from zero in both: times of the body force differ from those before, not between the two.
    for solver in [&mut whole, &mut restored] {
        run(solver, 20, 1e-4);
    }
    assert_eq!(whole.energies(), restored.energies());
}

#[test]
fn particles_that_leave_take_their_energy_along() {
    let mut setup = empty_scene(0.02);
    setup.outflow.upper[0] = true;
    add_block(&mut setup, Vector::new(0.9, 0.4), 5, 5);
    setup.particles.velocity.iter_mut().for_each(|v| *v = Vector::new(5.0, 0.0));
    let right = setup.run.domain.upper[0];
    let mut solver = solver(setup);
    let start = solver.energies().value(A::Kinetic);
    let mut step = 0;
    while solver.counts().outflow < 10 {
        run(&mut solver, 1, 1e-4);
        step += 1;
        assert!(step < 10_000, "nothing left to the right of {right} m");
    }
    let report = solver.energies();
    assert!(report.value(A::Removed) > 0.3 * start, "{report:?}");
    // Round-off of the sums.
    assert!(share(&report, start) < 1e-12, "{:?}", report.residual());
}
