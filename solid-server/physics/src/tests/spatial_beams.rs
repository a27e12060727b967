//! Beams in space against the references of three-dimensional elasticity.

use nalgebra::Vector3;
use sph::coupling::ledger::EnergyAccount;
use sph::coupling::solver::Solver;
use sph::setup::{
    Damping, ElasticParameters, PlaneState, SolidProbeKind, SolidSetup, SolidStepping, SubstepCount,
};
use sph::space::Spatial;

use super::scenes::{
    Run, add_probe, add_support, add_total, brick, scene_in, set_material, set_velocity, spatial_clamp,
};

fn material(young: f64, nu: f64) -> ElasticParameters {
    ElasticParameters {
        density: 1000.0,
        bulk_modulus: young / (3.0 * (1.0 - 2.0 * nu)),
        shear_modulus: young / (2.0 * (1.0 + nu)),
        plane: PlaneState::Strain,
    }
}

/// A bar of 0.2 x 0.02 x 0.02 m, `across` cells across, clamped at x = 0; E = 2 MPa, Poisson's ratio 0.3.
fn cantilever(across: u32) -> SolidSetup<Spatial> {
    let spacing = 0.02 / f64::from(across);
    let mut setup = scene_in(spacing);
    add_total(
        &mut setup,
        2,
        &brick(Vector3::new(-2.0 * spacing, -0.01, -0.01), [10 * across + 2, across, across], spacing),
    );
    setup.stepping = SolidStepping::Substeps(SubstepCount::Automatic);
    set_material(&mut setup, material(2e6, 0.3));
    add_support(&mut setup, 0, spatial_clamp(), |x| x.x < 0.0);
    add_probe(&mut setup, SolidProbeKind::MaterialPoint(0, Vector3::new(0.2, 0.0, 0.0)));
    add_probe(&mut setup, SolidProbeKind::Reaction(0, 0));
    setup
}

#[test]
fn a_cantilever_swings_with_its_frequency_on_a_straight_line() {
    let mut setup = cantilever(4);
    let (sine, cosine) = 30f64.to_radians().sin_cos();
    // First mode of a clamped-free beam, over its value at the tip.
    let beta = 1.875_104_068_7;
    let phi = |s: f64| {
        (beta * s).cosh() - (beta * s).cos() - 0.734_095_514 * ((beta * s).sinh() - (beta * s).sin())
    };
    set_velocity(&mut setup, |x| {
        Vector3::new(0.0, cosine, sine) * (0.01 * phi(x.x.max(0.0) / 0.2) / phi(1.0))
    });
    let mut run = Run::new(setup, 1e-3);
    let energy = |run: &Run<Spatial>| {
        let energies = run.solver.energies();
        energies.value(EnergyAccount::Kinetic) + energies.value(EnergyAccount::Strain)
    };
    let start = energy(&run);
    let (mut crossings, mut before, mut largest, mut widest) = (Vec::new(), 0.0, 0.0f64, 0.0f64);
    while crossings.len() < 2 {
        run.step().unwrap();
        let probes = run.probes();
        let along = cosine * probes[1] + sine * probes[2];
        (largest, widest) =
            (largest.max(along.abs()), widest.max((cosine * probes[2] - sine * probes[1]).abs()));
        if before * along < 0.0 {
            crossings.push(run.time() - run.time_step * along / (along - before));
        }
        before = along;
    }
    let frequency = 1.0 / crossings[1];
    // 3.600 Hz by finite elements; 4 % at 6 across, 5 % at 4.
    assert!((frequency / 3.600 - 1.0).abs() < 0.05, "{frequency}");
    // The lattice has the section's symmetry, so that both bending modes have one frequency; what is left is of the square
    // of the slope.
    assert!(widest < 1e-6 * largest, "{widest} {largest}");
    assert!((energy(&run) / start - 1.0).abs() < 0.01, "{}", energy(&run) / start);
    assert!(run.largest_residual < 1e-12, "{}", run.largest_residual);
}

#[test]
fn a_cantilever_sags_under_its_weight() {
    let mut setup = cantilever(3);
    setup.run.body_force.gravity = Vector3::new(0.0, 0.0, -0.1);
    // Twice the first angular frequency of 22.6 1/s: critical.
    setup.damping = Some(Damping { rate: 45.0, until: 10.0 });
    let mut run = Run::new(setup, 1e-3);
    run.until(0.3);
    let probes = run.probes();
    // 0.3005 mm by finite elements; 4 % at 6 across, 8 % at 3.
    assert!((-probes[2] / 0.3005e-3 - 1.0).abs() < 0.08, "{}", probes[2]);
    assert!(probes[1].abs() < 1e-12);
    let weight = 32.0 * 9.0 * 1000.0 * (0.02f64 / 3.0).powi(3) * 0.1;
    // It comes to rest with e^(−6.8) (1 + 6.8).
    assert!((probes[18] / weight - 1.0).abs() < 0.01, "{} {weight}", probes[18]);
}

#[test]
fn a_round_rod_twists_with_the_frequency_of_shear_waves() {
    // 8 particles across the diameter; the end at x = 0 clamped, the other free.
    let spacing = 0.0025;
    let mut setup = scene_in::<Spatial>(spacing);
    let all = brick(Vector3::new(-2.0 * spacing, -0.01, -0.01), [32, 8, 8], spacing);
    let rod: Vec<Vector3<f64>> = all.into_iter().filter(|x| x.y.hypot(x.z) < 0.01).collect();
    add_total(&mut setup, 2, &rod);
    setup.stepping = SolidStepping::Substeps(SubstepCount::Automatic);
    set_material(&mut setup, material(1e6, 0.3));
    add_support(&mut setup, 0, spatial_clamp(), |x| x.x < 0.0);
    // Of 0.075 m: c_s/4L = 65.372 Hz.
    let speed = std::f64::consts::TAU * 65.4 * 0.015;
    let shape = |x: f64| (std::f64::consts::PI * x.max(0.0) / 0.15).sin();
    set_velocity(&mut setup, |x| Vector3::new(0.0, -x.z, x.y) * (speed * shape(x.x)));
    let mut run = Run::new(setup, 1e-4);
    let twist = |run: &Run<Spatial>| -> f64 {
        let (x, u) = (run.vectors("reference_position"), run.vectors("displacement"));
        x.iter().zip(&u).map(|(x, u)| (x.y * u.z - x.z * u.y) * shape(x.x)).sum()
    };
    let (mut crossing, mut before) = (None, 0.0);
    while crossing.is_none() {
        run.step().unwrap();
        let now = twist(&run);
        if before * now < 0.0 {
            crossing = Some(run.time() - run.time_step * now / (now - before));
        }
        before = now;
    }
    let frequency = 0.5 / crossing.unwrap();
    // 2 % at 8 across, and a stepped outline twists more easily than a round one.
    assert!((frequency / 65.372 - 1.0).abs() < 0.04, "{frequency}");
    // It neither bends nor stretches: the lattice has the section's symmetry.
    let momentum: Vector3<f64> = run.vectors("velocity").iter().sum();
    assert!(momentum.y.hypot(momentum.z) < 1e-9, "{momentum}");
}
