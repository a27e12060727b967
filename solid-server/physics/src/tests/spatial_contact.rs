//! Contact and friction in space.

use nalgebra::Vector3;
use sph::coupling::ledger::EnergyAccount;
use sph::coupling::saved::SavedState;
use sph::coupling::solver::Solver;
use sph::setup::{
    Damping, ElasticParameters, Formulation, PlaneState, SolidProbeKind, SolidSetup, SolidStepping,
    SubstepCount,
};
use sph::space::Spatial;

use super::scenes::{
    Run, add_body, add_elastic, add_probe, add_total, add_wall, brick, rough, scene_in, set_material,
    set_velocity,
};

const SPACING: f64 = 2e-3;

/// Soft, for long steps.
const SOFT: ElasticParameters =
    ElasticParameters { density: 1100.0, bulk_modulus: 1e5, shear_modulus: 5e4, plane: PlaneState::Strain };

/// A block of 6 x 3 x 6 on the floor, in gravity turned by an incline of tangent `slope` that falls along `downhill`.
fn incline(friction: f64, slope: f64, downhill: Vector3<f64>) -> SolidSetup<Spatial> {
    let mut setup = scene_in::<Spatial>(SPACING);
    setup.contact = rough(friction);
    add_wall(&mut setup, &brick(Vector3::new(-7.0, -3.0, -7.0) * SPACING, [16, 3, 15], SPACING));
    add_total(&mut setup, 2, &brick(Vector3::new(-3.0, 0.0, -3.0) * SPACING, [6, 3, 6], SPACING));
    set_material(&mut setup, SOFT);
    let length = (1.0 + slope * slope).sqrt();
    setup.run.body_force.gravity = (downhill * slope - Vector3::y()) * (9.81 / length);
    // Without it the block rings and hops by micrometres when gravity sets in.
    setup.damping = Some(Damping { rate: 2000.0, until: 0.02 });
    add_probe(&mut setup, SolidProbeKind::Motion(0));
    add_probe(&mut setup, SolidProbeKind::Contact(None));
    setup
}

/// A direction along no axis of the lattice.
fn oblique() -> Vector3<f64> {
    Vector3::new(3f64.sqrt(), 0.0, 1.0) / 2.0
}

fn velocity(run: &Run<Spatial>) -> Vector3<f64> {
    let probes = run.probes();
    Vector3::new(probes[3], probes[4], probes[5])
}

#[test]
fn a_block_slides_down_an_oblique_incline_by_coulomb_s_law() {
    for friction in [0.0, 0.3] {
        let mut run = Run::new(incline(friction, 0.5, oblique()), 2e-4);
        run.until(0.03);
        let (start, from) = (velocity(&run), run.time());
        run.until(0.08);
        let acceleration = (velocity(&run) - start) / (run.time() - from);
        let expected = oblique() * (9.81 * (0.5 - friction) / 1.25f64.sqrt());
        let along = Vector3::new(acceleration.x, 0.0, acceleration.z);
        // 2 %: the block rocks a little.
        assert!((along - expected).norm() < 0.02 * expected.norm(), "{friction}: {acceleration} {expected}");
        assert!(run.largest_residual < 1e-12, "{}", run.largest_residual);
    }
}

#[test]
fn a_block_that_sticks_does_not_creep_and_its_state_can_be_saved() {
    let mut run = Run::new(incline(0.6, 0.5, oblique()), 2e-4);
    run.until(0.05);
    let start = run.probes();
    let mut saved = SavedState::default();
    run.solver.save(&mut saved);
    let mut restored = Run::new(incline(0.6, 0.5, oblique()), 2e-4);
    restored.solver.restore(&saved).unwrap();
    restored.step = run.step;
    run.until(0.08);
    restored.until(0.08);
    assert_eq!(run.bits(), restored.bits());
    let end = run.probes();
    for axis in [0, 2] {
        // Held by springs, where sliding freely would take it 4 mm far.
        assert!((end[axis] - start[axis]).abs() < 1e-6 * SPACING, "{}", end[axis] - start[axis]);
    }
    // Forces of the floor: those that carry it on the incline.
    let weight = 108.0 * SOFT.density * SPACING.powi(3) * 9.81;
    let carried = Vector3::new(end[16], end[17], end[18]);
    let gravity = (oblique() * 0.5 - Vector3::y()) * (weight / 1.25f64.sqrt());
    assert!((carried + gravity).norm() < 1e-3 * weight, "{carried} {gravity}");
}

#[test]
fn a_block_that_spins_on_the_floor_slows_down_by_friction_and_stays_in_place() {
    let friction = 0.3;
    let mut setup = incline(friction, 0.0, oblique());
    set_velocity(&mut setup, |x| Vector3::new(0.0, 20.0, 0.0).cross(x));
    setup.damping = None;
    let lever: f64 =
        setup.particles.position[..108].iter().filter(|x| x.y < SPACING).map(|x| x.x.hypot(x.z) / 36.0).sum();
    let arm: f64 = setup.particles.position.iter().map(|x| (x.x * x.x + x.z * x.z) / 108.0).sum();
    let mut run = Run::new(setup, 2e-4);
    let spin = |run: &Run<Spatial>| run.probes()[11];
    let (start, x) = (spin(&run), run.probes()[0]);
    run.until(0.03);
    let rate = (spin(&run) - start) / run.time();
    // Torque μ W |r| over the inertia M r², under a pressure that is uniform but for hopping.
    let expected = -friction * 9.81 * lever / arm;
    assert!((rate / expected - 1.0).abs() < 0.1, "{rate} {expected}");
    assert!((run.probes()[0] - x).abs() < 1e-2 * SPACING, "{}", run.probes()[0] - x);
}

/// Bodies of all kinds that run into each other at odd angles, with friction.
fn collision(stepping: SolidStepping) -> SolidSetup<Spatial> {
    let mut setup = scene_in::<Spatial>(SPACING);
    setup.contact = rough(0.4);
    add_total(&mut setup, 4, &brick(Vector3::new(-4.0, -4.0, -4.0) * SPACING, [8, 4, 8], SPACING));
    add_body(
        &mut setup,
        Formulation::Rigid,
        &brick(Vector3::new(-3.2, 0.3, -2.3) * SPACING, [4, 4, 5], SPACING),
    );
    add_elastic(&mut setup, &brick(Vector3::new(1.4, 0.4, -1.7) * SPACING, [4, 5, 4], SPACING));
    setup.stepping = stepping;
    set_velocity(&mut setup, |x| {
        if x.y > 0.0 {
            Vector3::new(1.5, -2.0, 0.7) + Vector3::new(90.0, -50.0, 120.0).cross(x)
        } else {
            Vector3::zeros()
        }
    });
    add_probe(&mut setup, SolidProbeKind::Sums(None));
    add_probe(&mut setup, SolidProbeKind::Contact(None));
    setup
}

#[test]
fn bodies_that_collide_keep_momentum_and_angular_momentum_and_lose_energy() {
    for (stepping, time_step) in
        [(SolidStepping::Substeps(SubstepCount::Fixed(4)), 1e-5), (SolidStepping::StageRule, 2e-6)]
    {
        let mut run = Run::new(collision(stepping), time_step);
        let before = run.probes();
        run.until(7e-4);
        let after = run.probes();
        assert!(after[25] > 0.05 * SPACING, "they are in contact: {}", after[25]);
        let momentum = Vector3::new(before[1], before[2], before[3]).norm();
        for k in 1..4 {
            assert!(
                (after[k] - before[k]).abs() < 1e-11 * momentum,
                "momentum {k}: {}",
                after[k] - before[k]
            );
        }
        for k in 4..7 {
            // The sums of the updated-Lagrangian body are not central, so that torques are in the ledger's account.
            let gain = (after[k] - before[k]).abs();
            assert!(gain < 1e-3 * momentum * 0.01, "angular momentum {k}: {gain}");
        }
        assert!(run.largest_residual < 1e-12, "{}", run.largest_residual);
        let energies = run.solver.energies();
        let total = energies.value(EnergyAccount::Kinetic) + energies.value(EnergyAccount::Strain);
        assert!(total < before[7], "{total} {}", before[7]);
    }
}

#[test]
fn contact_and_friction_alone_keep_the_angular_momentum() {
    let mut setup = collision(SolidStepping::Substeps(SubstepCount::Fixed(4)));
    setup.bodies[2].formulation = setup.bodies[0].formulation;
    let mut run = Run::new(setup, 1e-5);
    let before = run.probes();
    run.until(7e-4);
    let after = run.probes();
    let momentum = Vector3::new(before[1], before[2], before[3]).norm();
    for k in 4..7 {
        // Round-off of forces on arms of 10 mm.
        let gain = (after[k] - before[k]).abs();
        assert!(gain < 1e-11 * momentum * 0.01, "angular momentum {k}: {gain}");
    }
}

#[test]
fn bits_of_a_contact_do_not_depend_on_the_number_of_threads() {
    let bits = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut run = Run::new(collision(SolidStepping::Substeps(SubstepCount::Fixed(4))), 1e-5);
            run.until(3e-4);
            run.bits()
        })
    };
    assert_eq!(bits(1), bits(2));
}
