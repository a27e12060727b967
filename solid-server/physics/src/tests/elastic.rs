//! The updated-Lagrangian body on its own.

use sph::coupling::ledger::EnergyAccount;
use sph::coupling::solver::Solver;
use sph::setup::{Formulation, SolidProbeKind};
use sph::space::{Vector, cross};

use super::scenes::{
    RUBBER, Run, add_body, add_elastic, add_probe, add_support, block, clamp, scene, set_velocity,
};

/// Mass-weighted angular momentum about the centre of a body whose centre is at the origin.
fn angular_momentum(run: &Run) -> f64 {
    let (x, v) = (run.vectors("position"), run.vectors("velocity"));
    x.iter().zip(&v).map(|(x, v)| cross(x, v)).sum()
}

/// A free square of 36 mm, 18 particles across, spinning at 50 rad/s.
fn spinning_square(gradient_correction: bool) -> Run {
    let spacing = 2e-3;
    let mut setup = scene(spacing);
    let law = sph::setup::UpdatedLagrangian { gradient_correction, ..Default::default() };
    add_body(
        &mut setup,
        Formulation::UpdatedLagrangian(law),
        &block(Vector::new(-0.018, -0.018), 18, 18, spacing),
    );
    set_velocity(&mut setup, |x| Vector::new(-x.y, x.x) * 50.0);
    add_probe(&mut setup, SolidProbeKind::Motion(0));
    Run::new(setup, 1e-5)
}

#[test]
fn a_spinning_square_keeps_its_angular_momentum_with_correction() {
    let mut run = spinning_square(true);
    let start = angular_momentum(&run);
    // An eighth of a revolution; measured elsewhere as 1.002 after a full one.
    run.until(std::f64::consts::TAU / 50.0 / 8.0);
    let ratio = angular_momentum(&run) / start;
    assert!((ratio - 1.0).abs() < 5e-3, "{ratio}");
    let probes = run.probes();
    let (angle, omega) = (probes[4], probes[5]);
    assert!((angle - 50.0 * run.time()).abs() < 0.02, "{angle}");
    assert!((omega - 50.0).abs() < 0.5, "{omega}");
    assert!(run.largest_residual < 1e-12, "{}", run.largest_residual);
}

#[test]
fn without_correction_the_same_square_cannot_rotate() {
    let mut run = spinning_square(false);
    let start = angular_momentum(&run);
    run.until(std::f64::consts::TAU / 50.0 / 8.0);
    let ratio = angular_momentum(&run) / start;
    // Measured elsewhere: 0.30 at 0.12 revolutions. This documents the source paper as it stands.
    assert!(ratio < 0.5, "{ratio}");
}

#[test]
fn free_fall_is_g_t_without_stress() {
    let mut setup = scene(2e-3);
    add_elastic(&mut setup, &block(Vector::zeros(), 6, 4, 2e-3));
    setup.run.body_force.gravity = Vector::new(0.3, -9.81);
    let mut run = Run::new(setup, 1e-5);
    run.until(1e-3);
    for v in run.vectors("velocity") {
        // 100 additions of g·Δt round at 1e-16 each.
        assert!((v - Vector::new(0.3, -9.81) * 1e-3).norm() < 1e-15);
    }
    for x in run.vectors("displacement") {
        assert!((x - Vector::new(0.3, -9.81) * 0.5e-6).norm() < 1e-15);
    }
    assert!(run.values("stress").iter().all(|s| s.abs() < 1e-4));
    assert!(run.largest_residual < 1e-12);
}

#[test]
fn a_disordered_stressed_patch_conserves_momentum() {
    let spacing = 2e-3;
    let mut setup = scene(spacing);
    add_elastic(&mut setup, &block(Vector::zeros(), 9, 7, spacing));
    let mut seed = 7u64;
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    let p = &mut setup.particles;
    for i in 0..p.id.len() {
        p.position[i] += Vector::new(random(), random()) * 0.2 * spacing;
        p.velocity[i] = Vector::new(random(), random()) * 2.0;
        p.density[i] *= 1.0 + 0.02 * random();
        p.deviatoric_stress[i].xx = 1e5 * random();
        p.deviatoric_stress[i].xy = 1e5 * random();
    }
    let mass = p.mass[0];
    let mut run = Run::new(setup, 2e-6);
    let momentum = |run: &Run| run.vectors("velocity").iter().map(|v| v * mass).sum::<Vector>();
    let start = momentum(&run);
    for _ in 0..50 {
        run.step().unwrap();
    }
    let gross: f64 = run.vectors("velocity").iter().map(|v| v.norm() * mass).sum();
    assert!((momentum(&run) - start).norm() < 1e-12 * gross);
    assert!(run.largest_residual < 1e-12, "{}", run.largest_residual);
}

#[test]
fn a_wave_runs_along_a_bar_at_the_plane_strain_bar_speed() {
    // A bar of 80 x 6 that starts with a half sine of axial velocity: v ∝ cos(πx/L) has period 2L/c.
    let spacing = 2e-3;
    let (columns, rows) = (80, 6);
    let length = spacing * f64::from(columns);
    let mut setup = scene(spacing);
    add_elastic(&mut setup, &block(Vector::zeros(), columns, rows, spacing));
    let shape = move |x: &Vector| (std::f64::consts::PI * x.x / length).cos();
    set_velocity(&mut setup, |x| Vector::new(0.05 * shape(x), 0.0));
    let (k, g) = (RUBBER.bulk_modulus, RUBBER.shear_modulus);
    let modulus = 4.0 * g * (k + g / 3.0) / (k + 4.0 / 3.0 * g);
    let period = 2.0 * length / (modulus / RUBBER.density).sqrt();
    let mut run = Run::new(setup, 1e-5);
    let amplitude = |run: &Run| -> f64 {
        run.vectors("velocity")
            .iter()
            .zip(run.vectors("reference_position"))
            .map(|(v, x)| v.x * shape(&x))
            .sum()
    };
    // The amplitude passes zero after a quarter period.
    let (mut before, mut crossing) = (amplitude(&run), 0.0);
    while crossing == 0.0 && run.time() < period {
        run.step().unwrap();
        let now = amplitude(&run);
        if now <= 0.0 {
            crossing = run.time() - run.time_step * now / (now - before);
        }
        before = now;
    }
    let ratio = 4.0 * crossing / period;
    // The ends' free half cells and dispersion at 80 particles per half wave leave some per cent.
    assert!((ratio - 1.0).abs() < 0.04, "{ratio}");
}

/// The cantilever of Gray et al. 2001: 0.2 m x 0.02 m, clamp extended to the left, velocity of the first mode.
fn cantilever() -> Run {
    let across = 6;
    let (length, height) = (0.2, 0.02);
    let spacing = height / f64::from(across);
    let clamp_columns = 10;
    let columns = 60 + clamp_columns;
    let mut setup = scene(spacing);
    let corner = Vector::new(-f64::from(clamp_columns) * spacing, -0.5 * height);
    add_elastic(&mut setup, &block(corner, columns, across, spacing));
    setup.bodies[0].material = sph::setup::ElasticParameters {
        density: 1000.0,
        bulk_modulus: 3.25e6,
        shear_modulus: 7.15e5,
        plane: sph::setup::PlaneState::Strain,
    };
    let cell = spacing * spacing;
    setup.particles.mass.fill(1000.0 * cell);
    setup.particles.density.fill(1000.0);
    add_support(&mut setup, 0, clamp(), |x| x.x < 0.0);
    // First mode, k L = 1.875; tip speed 0.01 c0.
    let sound_speed = (3.25e6f64 / 1000.0).sqrt();
    let k: f64 = 1.875;
    let mode = |x: f64| {
        (k.cos() + k.cosh()) * ((k * x).cosh() - (k * x).cos())
            + (k.sin() - k.sinh()) * ((k * x).sinh() - (k * x).sin())
    };
    set_velocity(&mut setup, |x| {
        let along = (x.x / length).max(0.0);
        Vector::new(0.0, 0.01 * sound_speed * mode(along) / mode(1.0))
    });
    add_probe(&mut setup, SolidProbeKind::MaterialPoint(0, Vector::new(length, 0.0)));
    add_probe(&mut setup, SolidProbeKind::Reaction(0, 0));
    let mut run = Run::new(setup, 1.0);
    // 0.9 of the stated limit: the step that a careful user takes.
    run.time_step = 0.9 * run.solver.time_step_limit();
    run
}

#[test]
fn a_quarter_wave_of_the_cantilever_takes_the_measured_time() {
    let mut run = cantilever();
    let (mut before, mut quarter, mut largest) = (1.0, 0.0, 0.0f64);
    while quarter == 0.0 && run.time() < 0.12 {
        run.step().unwrap();
        let probes = run.probes();
        largest = largest.max(probes[1]);
        if probes[3] <= 0.0 {
            quarter = run.time() - run.time_step * probes[3] / (probes[3] - before);
        }
        before = probes[3];
    }
    // An exploratory program measured 2 x quarter-wave as half of 0.3204 s for this scheme at 6 across.
    assert!((4.0 * quarter / 0.3204 - 1.0).abs() < 0.04, "period {}", 4.0 * quarter);
    assert!((0.015..0.04).contains(&largest), "{largest}");
    assert!(run.largest_residual < 1e-12, "{}", run.largest_residual);
}

#[test]
fn bits_do_not_depend_on_the_number_of_threads() {
    let bits = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut run = spinning_square(true);
            for _ in 0..40 {
                run.step().unwrap();
            }
            run.bits()
        })
    };
    let one = bits(1);
    assert_eq!(one, bits(2));
    assert_eq!(one, bits(4));
}

#[test]
fn a_step_beyond_the_limit_diverges_with_a_named_particle() {
    let mut run = cantilever();
    run.time_step = 3.0 * run.solver.time_step_limit();
    let failure = (0..2000).find_map(|_| run.step().err()).unwrap();
    assert!(failure.particle.is_some() && failure.position.is_some());
    assert!(failure.quantity.contains("body `body0`"), "{failure}");
    assert!(failure.hint.contains("time step"), "{failure}");
}

#[test]
fn the_stated_limit_is_stable() {
    let mut run = cantilever();
    run.time_step = run.solver.time_step_limit();
    let start = run.solver.energies().value(EnergyAccount::Kinetic);
    for _ in 0..300 {
        run.step().unwrap();
    }
    let energies = run.solver.energies();
    assert!(energies.value(EnergyAccount::Kinetic) + energies.value(EnergyAccount::Strain) < 1.05 * start);
}
