//! Rigid bodies, periodic directions, damping, and what is refused.

use sph::coupling::ledger::Account;
use sph::coupling::ledger::EnergyAccount;
use sph::coupling::solver::Solver;
use sph::setup::{ContactLaw, Damping, Formulation, SolidProbeKind, SolidStepping, SubstepCount};
use sph::space::{Vector, cross};

use super::scenes::{RUBBER, Run, add_body, add_elastic, add_probe, block, scene, set_velocity};
use crate::SolidSolver;

const SPACING: f64 = 2e-3;

#[test]
fn a_rigid_body_spins_and_falls_exactly_and_keeps_its_shape() {
    let mut setup = scene(SPACING);
    let start = block(Vector::new(-0.008, -0.006), 8, 6, SPACING);
    add_body(&mut setup, Formulation::Rigid, &start);
    set_velocity(&mut setup, |x| Vector::new(0.2, 0.0) + Vector::new(-x.y, x.x) * 40.0);
    setup.run.body_force.gravity = Vector::new(0.0, -9.81);
    add_probe(&mut setup, SolidProbeKind::Motion(0));
    let mut run = Run::new(setup, 1e-4);
    let momentum = |run: &Run| -> f64 {
        let (x, v) = (run.vectors("position"), run.vectors("velocity"));
        let n = x.len() as f64;
        let (xc, vc) = (x.iter().sum::<Vector>() / n, v.iter().sum::<Vector>() / n);
        x.iter().zip(&v).map(|(x, v)| cross(&(x - xc), &(v - vc))).sum()
    };
    let before = momentum(&run);
    run.until(0.2);
    let t = run.time();
    assert!((momentum(&run) / before - 1.0).abs() < 1e-12);
    let probes = run.probes();
    let expected = [0.2 * t, -0.5 * 9.81 * t * t, 0.2, -9.81 * t, 40.0 * t, 40.0];
    for (value, expected) in probes.iter().zip(expected) {
        // 2000 steps of round-off.
        assert!((value - expected).abs() < 1e-11 * expected.abs().max(1.0), "{value} {expected}");
    }
    let now = run.vectors("position");
    for i in 0..now.len() {
        for j in 0..i {
            let (then, distance) = ((start[i] - start[j]).norm(), (now[i] - now[j]).norm());
            assert!((distance - then).abs() < 1e-15);
        }
    }
    assert!(run.largest_residual < 1e-12, "{}", run.largest_residual);
}

#[test]
fn a_rigid_body_turns_under_an_eccentric_push() {
    for stepping in [SolidStepping::StageRule, SolidStepping::Substeps(SubstepCount::Fixed(2))] {
        // A bullet hits the lower edge of a rigid bar: linear and angular momentum of the pair are kept.
        let mut setup = scene(SPACING);
        setup.stepping = stepping;
        add_body(&mut setup, Formulation::Rigid, &block(Vector::new(0.0, -0.01), 3, 20, SPACING));
        add_body(&mut setup, Formulation::Rigid, &block(Vector::new(-0.0045, -0.008), 2, 2, SPACING));
        set_velocity(&mut setup, |x| if x.x < 0.0 { Vector::new(3.0, 0.0) } else { Vector::zeros() });
        add_probe(&mut setup, SolidProbeKind::Motion(0));
        add_probe(&mut setup, SolidProbeKind::Sums(None));
        let mut run = Run::new(setup, 2e-6);
        let before = run.probes();
        run.until(1.5e-3);
        let after = run.probes();
        assert!(after[2] > 0.1 && after[5].abs() > 10.0, "{stepping:?}: {after:?}");
        let (momentum, angular) = (before[7], before[9]);
        assert!((after[7] / momentum - 1.0).abs() < 1e-12, "{stepping:?}");
        // The rules keep angular momentum to second order in the motion per step, not to round-off.
        assert!((after[9] - angular).abs() < 1e-6 * momentum * 0.02, "{stepping:?}: {} {angular}", after[9]);
    }
}

#[test]
fn a_body_drifting_across_a_periodic_side_does_not_notice() {
    let build = |periodic: bool| {
        let mut setup = scene(SPACING);
        setup.run.domain.periodic = [periodic, false];
        add_elastic(&mut setup, &block(Vector::new(0.98, 0.0), 8, 6, SPACING));
        set_velocity(&mut setup, |x| Vector::new(20.0 + 100.0 * (x.x - 0.99), 30.0 * (x.x - 0.99)));
        setup.run.domain.upper.x = if periodic { 1.0 } else { 3.0 };
        add_probe(&mut setup, SolidProbeKind::Motion(0));
        Run::new(setup, 1e-5)
    };
    let (mut periodic, mut open) = (build(true), build(false));
    periodic.until(3e-3);
    open.until(3e-3);
    let stray = periodic.vectors("position").iter().filter(|x| x.x > 0.0).count();
    assert_eq!(stray, 0);
    for name in ["displacement", "velocity"] {
        for (a, b) in periodic.vectors(name).iter().zip(&open.vectors(name)) {
            // Positions near 1 m round at 1e-16, amplified by stiffness over 300 steps.
            assert!((a - b).norm() < 1e-9, "{name}: {a} {b}");
        }
    }
    for (a, b) in periodic.probes().iter().zip(&open.probes()) {
        assert!((a - b).abs() < 1e-9, "{a} {b}");
    }
}

#[test]
fn damping_is_accounted_for_and_ends() {
    let mut setup = scene(SPACING);
    add_elastic(&mut setup, &block(Vector::zeros(), 6, 4, SPACING));
    set_velocity(&mut setup, |_| Vector::new(1.0, 0.0));
    setup.damping = Some(Damping { rate: 100.0, until: 1e-3 });
    let mut run = Run::new(setup, 1e-5);
    let budget = run.step().unwrap();
    let mass: f64 = run.values("mass").iter().sum();
    let damping = budget[0].accounts.get(Account::Damping).force;
    assert!((damping.x + 100.0 * mass).abs() < 1e-12 * 100.0 * mass);
    run.until(1e-3);
    let v = run.vectors("velocity")[0].x;
    // e^(−0.1) up to the midpoint rule's third-order error per step.
    assert!((v - (-0.1f64).exp()).abs() < 1e-7);
    run.until(2e-3);
    assert!((run.vectors("velocity")[0].x - v).abs() < 1e-12);
    assert!(run.largest_residual < 1e-12);
}

#[test]
fn sums_and_energies_of_a_body_are_those_of_its_particles() {
    let mut setup = scene(SPACING);
    setup.run.body_force.gravity = Vector::new(0.0, -10.0);
    add_elastic(&mut setup, &block(Vector::new(0.1, 0.2), 4, 2, SPACING));
    let strain = 1e-3;
    let s = &mut setup.particles;
    s.density.fill(RUBBER.density * (1.0 + strain));
    s.deviatoric_stress.iter_mut().for_each(|s| s.xy = 3e3);
    set_velocity(&mut setup, |_| Vector::new(2.0, 1.0));
    add_probe(&mut setup, SolidProbeKind::Sums(Some(0)));
    let run = Run::new(setup, 1e-6);
    let values = run.probes();
    let mass = 8.0 * RUBBER.density * SPACING * SPACING;
    let (cx, cy) = (0.1 + 2.0 * SPACING, 0.2 + SPACING);
    let volume = mass / (RUBBER.density * (1.0 + strain));
    let pressure = RUBBER.bulk_modulus * strain;
    let energy =
        volume * (pressure * pressure / (2.0 * RUBBER.bulk_modulus) + 9e6 / (2.0 * RUBBER.shear_modulus));
    let expected = [
        mass,
        2.0 * mass,
        mass,
        mass * (cx - 2.0 * cy),
        2.5 * mass,
        10.0 * mass * cy,
        energy,
        cx,
        cy,
        // Columns at ±1/2, ±3/2 spacings; rows at ±1/2.
        1.25 * SPACING * SPACING,
        0.25 * SPACING * SPACING,
        0.0,
    ];
    assert_eq!(values.len(), expected.len());
    for (k, (value, expected)) in values.iter().zip(expected).enumerate() {
        assert!(
            (value - expected).abs() < 1e-11 * expected.abs().max(1e-6),
            "column {k}: {value} {expected}"
        );
    }
    let energies = run.solver.energies();
    assert_eq!(
        [
            energies.value(EnergyAccount::Kinetic),
            energies.value(EnergyAccount::Potential),
            energies.value(EnergyAccount::Strain)
        ],
        [values[4], values[5], values[6]]
    );
}

#[test]
fn a_body_that_leaves_the_scene_stops_the_run_and_is_named() {
    let mut setup = scene(SPACING);
    add_elastic(&mut setup, &block(Vector::new(0.98, 0.0), 4, 4, SPACING));
    set_velocity(&mut setup, |_| Vector::new(10.0, 0.0));
    setup.lost_particle_limit = 3;
    let mut run = Run::new(setup, 1e-5);
    let failure = (0..1000).find_map(|_| run.step().err()).unwrap();
    // The first column of four is out once its right particle passes x = 1 m: 13 mm at 10 m/s.
    assert_eq!(failure.value, 4.0);
    assert!(failure.quantity.contains("`body0`") && failure.hint.contains("domain"), "{failure}");
    assert!((run.time() - 1.3e-3).abs() < 3e-5, "{}", run.time());
}

#[test]
fn all_mistakes_of_a_set_up_are_reported_at_once() {
    let mut setup = scene(SPACING);
    add_body(&mut setup, Formulation::Rigid, &block(Vector::zeros(), 4, 4, SPACING));
    setup.contact = ContactLaw::Sums;
    setup.run.body_force.expressions = Some(["sin(".into(), "0".into()]);
    add_probe(&mut setup, SolidProbeKind::MaterialPoint(0, Vector::new(0.5, 0.0)));
    add_probe(&mut setup, SolidProbeKind::Motion(7));
    let Err(errors) = SolidSolver::new(setup) else { panic!("accepted") };
    for part in ["contact through the sums", "body force x", "`probe0`", "`probe1`"] {
        assert_eq!(errors.iter().filter(|e| e.contains(part)).count(), 1, "{part}: {errors:?}");
    }
    let mut setup = scene(SPACING);
    add_elastic(&mut setup, &block(Vector::zeros(), 4, 4, SPACING));
    setup.particles.velocity.pop();
    assert!(SolidSolver::new(setup).is_err());
}

#[test]
fn a_material_point_reads_the_invariants_of_its_stress() {
    let mut setup = scene(SPACING);
    add_elastic(&mut setup, &block(Vector::zeros(), 6, 6, SPACING));
    let strain = 1e-3;
    setup.particles.density.fill(RUBBER.density * (1.0 + strain));
    setup.particles.deviatoric_stress.iter_mut().for_each(|s| s.xy = 3e3);
    let at = Vector::new(3.0 * SPACING, 3.0 * SPACING);
    add_probe(&mut setup, SolidProbeKind::MaterialPoint(0, at));
    let run = Run::new(setup, 1e-6);
    let values = run.probes();
    let pressure = RUBBER.bulk_modulus * strain;
    let energy = pressure * pressure / (2.0 * RUBBER.bulk_modulus) + 9e6 / (2.0 * RUBBER.shear_modulus);
    // Pure shear of 3 kPa under pressure: von Mises √3 τ, principal stresses −p ± τ; energy per undeformed volume.
    let expected = [
        -pressure,
        -pressure,
        3e3,
        3f64.sqrt() * 3e3,
        3e3 - pressure,
        -3e3 - pressure,
        energy / (1.0 + strain),
    ];
    for (value, expected) in values[4..].iter().zip(expected) {
        assert!((value / expected - 1.0).abs() < 1e-11, "{value} {expected}");
    }
    assert_eq!(values.len(), 11);
    for (name, expected) in
        [("von_mises", expected[3]), ("principal_largest", expected[4]), ("principal_smallest", expected[5])]
    {
        assert!((run.values(name)[7] / expected - 1.0).abs() < 1e-11, "{name}");
    }
    assert!((run.values("strain_energy_density")[7] * (1.0 + strain) / energy - 1.0).abs() < 1e-11);
}

#[test]
fn a_rigid_block_turns_with_the_inertia_of_its_cells() {
    // A block of n × n cells of edge d and mass m has M (n d)²/6; points of mass alone would have M ((n d)² − d²)/6.
    for n in [1_u32, 4, 10] {
        let mut setup = scene(SPACING);
        add_body(&mut setup, Formulation::Rigid, &block(Vector::zeros(), n, n, SPACING));
        let solver = SolidSolver::new(setup).unwrap();
        let (mass, inertia) = solver.masses().next().unwrap();
        let expected = mass * (f64::from(n) * SPACING).powi(2) / 6.0;
        // Round-off of a sum over 100 cells.
        assert!((inertia.unwrap() / expected - 1.0).abs() < 1e-12, "{n}");
    }
}
