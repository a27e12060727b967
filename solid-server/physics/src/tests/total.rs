//! The total-Lagrangian body on its own.

use sph::coupling::ledger::EnergyAccount;
use sph::coupling::solver::Solver;
use sph::setup::{
    ElasticParameters, HyperelasticLaw, LoadLaw, SolidProbeKind, SolidSetup, SolidStepping, SubstepCount,
    SurfaceLoad,
};
use sph::space::{Tensor, Vector, cross};

use super::scenes::{
    RUBBER, Run, add_body, add_probe, add_support, add_total, block, clamp, scene, set_material,
    set_velocity, total_lagrangian,
};

const SPACING: f64 = 2e-3;

const LAWS: [HyperelasticLaw; 2] = [HyperelasticLaw::StVenantKirchhoff, HyperelasticLaw::NeoHookean];

/// A block mapped by `map` about its centre, at rest.
fn mapped(law: HyperelasticLaw, map: Tensor) -> Run {
    let mut setup = scene(SPACING);
    let x = block(Vector::new(-0.009, -0.007), 9, 7, SPACING);
    add_body(&mut setup, total_lagrangian(law), &x);
    setup.stepping = SolidStepping::Substeps(SubstepCount::Fixed(2));
    setup.particles.position = x.iter().map(|x| map * x).collect();
    Run::new(setup, 1e-6)
}

/// Forces on the particles of `run` in its first stage \[N/m\].
fn first_forces(run: &mut Run) -> Vec<Vector> {
    let time = run.stage_time(sph::coupling::stage::Stage::Predictor);
    run.solver.begin_stage(&time).unwrap();
    run.solver.evaluate_own(&time);
    run.solver.workspace.forces.iter().map(|forces| forces.total).collect()
}

#[test]
fn a_rigid_rotation_makes_neither_stress_nor_force() {
    for law in LAWS {
        for angle in [0.3, 1.7, 3.1, -2.0f64] {
            let (sine, cosine) = angle.sin_cos();
            let mut run = mapped(law, Tensor::new(cosine, -sine, sine, cosine));
            let modulus = RUBBER.bulk_modulus;
            // Round-off of F (1e-16 times a few operations and the inverse of the moment) times the moduli.
            assert!(run.values("stress").iter().all(|s| s.abs() < 1e-13 * modulus));
            let scale = modulus * SPACING;
            assert!(first_forces(&mut run).iter().all(|f| f.norm() < 1e-13 * scale));
            assert!(
                run.solver.energies().value(EnergyAccount::Strain)
                    < 1e-24 * modulus * SPACING * SPACING * 63.0
            );
        }
    }
}

#[test]
fn a_uniform_stretch_has_the_stress_of_the_formula_everywhere() {
    let (lambda, g) = (RUBBER.first_lame_constant(), RUBBER.shear_modulus);
    let (stretch, squeeze) = (1.2f64, 0.9f64);
    let jacobian = stretch * squeeze;
    // Second Piola-Kirchhoff S_a = λ tr E + 2G E_a, σ_a = Λ_a² S_a/J; neo-Hookean σ_a = (G(Λ_a² − 1) + λ ln J)/J.
    let trace = 0.5 * (stretch * stretch + squeeze * squeeze - 2.0);
    let venant = |l: f64| l * l * (lambda * trace + g * (l * l - 1.0)) / jacobian;
    let hooke = |l: f64| (g * (l * l - 1.0) + lambda * jacobian.ln()) / jacobian;
    let expected = [[venant(stretch), venant(squeeze)], [hooke(stretch), hooke(squeeze)]];
    for (law, expected) in LAWS.into_iter().zip(expected) {
        let mut run = mapped(law, Tensor::new(stretch, 0.0, 0.0, squeeze));
        for stress in run.values("stress").chunks(3) {
            for axis in 0..2 {
                assert!((stress[axis] / expected[axis] - 1.0).abs() < 1e-11, "{law:?} {stress:?}");
            }
            assert!(stress[2].abs() < 1e-11 * expected[0].abs());
        }
        run.step().unwrap();
        let time = run.stage_time(sph::coupling::stage::Stage::Predictor);
        run.solver.begin_stage(&time).unwrap();
        // One step of 1 µs later the density of the middle is that of the stretch but for what crosses the stencil.
        let density = run.values("density")[31];
        assert!((density * jacobian / RUBBER.density - 1.0).abs() < 1e-7, "{density}");
    }
}

fn random(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
}

/// A block with random displacements and velocities.
fn disordered() -> SolidSetup {
    let mut setup = scene(SPACING);
    add_total(&mut setup, 2, &block(Vector::zeros(), 9, 7, SPACING));
    let mut seed = 7;
    let p = &mut setup.particles;
    for i in 0..p.id.len() {
        p.position[i] += Vector::new(random(&mut seed), random(&mut seed)) * 0.2 * SPACING;
        p.velocity[i] = Vector::new(random(&mut seed), random(&mut seed)) * 2.0;
    }
    setup
}

#[test]
fn internal_forces_have_neither_resultant_nor_torque() {
    let mut run = Run::new(disordered(), 2e-6);
    let forces = first_forces(&mut run);
    let gross: f64 = forces.iter().map(|f| f.norm()).sum();
    assert!(gross > 1e3);
    assert!(forces.iter().sum::<Vector>().norm() < 1e-13 * gross);
    let torque: f64 = run.vectors("position").iter().zip(&forces).map(|(x, f)| cross(x, f)).sum();
    // Arms are at most 20 mm.
    assert!(torque.abs() < 1e-13 * gross * 0.02, "{torque}");
}

#[test]
fn a_disordered_block_keeps_momentum_angular_momentum_and_energy() {
    let mut run = Run::new(disordered(), 5e-6);
    let mass = run.values("mass")[0];
    let momentum = |run: &Run| run.vectors("velocity").iter().map(|v| v * mass).sum::<Vector>();
    let angular = |run: &Run| -> f64 {
        run.vectors("position").iter().zip(run.vectors("velocity")).map(|(x, v)| mass * cross(x, &v)).sum()
    };
    let energy = |run: &Run| {
        run.solver.energies().value(EnergyAccount::Kinetic)
            + run.solver.energies().value(EnergyAccount::Strain)
    };
    let start = (momentum(&run), angular(&run), energy(&run));
    let gross: f64 = run.vectors("velocity").iter().map(|v| v.norm() * mass).sum();
    for _ in 0..200 {
        run.step().unwrap();
    }
    assert!((momentum(&run) - start.0).norm() < 1e-12 * gross);
    // Velocity Verlet keeps angular momentum exactly where forces have no torque.
    assert!((angular(&run) - start.1).abs() < 1e-12 * gross * 0.02);
    // Its energy error is bounded: (ω τ)²/8 or so of the stiffest modes, ω τ = 0.4 here.
    assert!((energy(&run) / start.2 - 1.0).abs() < 0.02, "{}", energy(&run) / start.2);
    assert!(run.largest_residual < 1e-12, "{}", run.largest_residual);
}

#[test]
fn a_spinning_square_keeps_its_angular_momentum_to_round_off() {
    let mut setup = scene(SPACING);
    add_total(&mut setup, 2, &block(Vector::new(-0.018, -0.018), 18, 18, SPACING));
    set_velocity(&mut setup, |x| Vector::new(-x.y, x.x) * 50.0);
    add_probe(&mut setup, SolidProbeKind::Motion(0));
    let mut run = Run::new(setup, 1e-5);
    let angular = |run: &Run| -> f64 {
        run.vectors("position").iter().zip(&run.vectors("velocity")).map(|(x, v)| cross(x, v)).sum()
    };
    let energy = |run: &Run| {
        run.solver.energies().value(EnergyAccount::Kinetic)
            + run.solver.energies().value(EnergyAccount::Strain)
    };
    let start = (angular(&run), energy(&run));
    run.until(std::f64::consts::TAU / 50.0 / 4.0);
    assert!((angular(&run) / start.0 - 1.0).abs() < 1e-11);
    assert!((energy(&run) / start.1 - 1.0).abs() < 1e-4, "{}", energy(&run) / start.1);
    // The square grows a little under the centrifugal force, so it lags.
    assert!((run.probes()[4] / (50.0 * run.time()) - 1.0).abs() < 0.01);
}

/// The cantilever of Gray et al. 2001 at 6 particles across, held rows continued into the wall.
fn cantilever(substeps: SubstepCount) -> SolidSetup {
    let spacing = 0.02 / 6.0;
    let mut setup = scene(spacing);
    add_total(&mut setup, 2, &block(Vector::new(-4.0 * spacing, -0.01), 64, 6, spacing));
    setup.stepping = SolidStepping::Substeps(substeps);
    set_material(
        &mut setup,
        ElasticParameters {
            density: 1000.0,
            bulk_modulus: 3.25e6,
            shear_modulus: 7.15e5,
            plane: sph::setup::PlaneState::Strain,
        },
    );
    add_support(&mut setup, 0, clamp(), |x| x.x < 0.0);
    add_probe(&mut setup, SolidProbeKind::MaterialPoint(0, Vector::new(0.2, 0.0)));
    add_probe(&mut setup, SolidProbeKind::Reaction(0, 0));
    setup
}

#[test]
fn the_static_deflection_of_a_cantilever_is_that_of_beam_theory() {
    let mut setup = cantilever(SubstepCount::Automatic);
    setup.run.body_force.gravity = Vector::new(0.0, -0.5);
    // Twice the first angular frequency of 24.6 1/s: critical.
    setup.damping = Some(sph::setup::Damping { rate: 49.0, until: 1.0 });
    let mut run = Run::new(setup, 2e-4);
    run.until(0.5);
    let probes = run.probes();
    // Thin plate with shear: 1.28e-3 m. A sparse linear solution of these very sums gives +0.46 %.
    let ratio = -probes[1] / 1.28e-3;
    assert!((ratio - 1.0046).abs() < 0.004, "{ratio}");
    let weight = 0.5 * 1000.0 * 0.2 * 0.02;
    let reaction = probes[12] - 0.5 * 1000.0 * 24.0 * (0.02f64 / 6.0).powi(2);
    // The support carries the free part and what it holds itself.
    assert!((reaction / weight - 1.0).abs() < 1e-3, "{reaction}");
    assert!(run.largest_residual < 1e-12, "{}", run.largest_residual);
}

#[test]
fn an_elastic_bar_swings_with_its_exact_period_and_keeps_its_energy() {
    // nu = 0, fixed-free, 40 along, 4 across: T = 4 L/c.
    let spacing = 0.2 / 40.0;
    let mut setup = scene(spacing);
    add_total(&mut setup, 2, &block(Vector::new(-4.0 * spacing, 0.0), 44, 4, spacing));
    set_material(
        &mut setup,
        ElasticParameters {
            density: 1000.0,
            bulk_modulus: 2e6 / 3.0,
            shear_modulus: 1e6,
            plane: sph::setup::PlaneState::Strain,
        },
    );
    add_support(&mut setup, 0, clamp(), |x| x.x < 0.0);
    let shape = |x: &Vector| (std::f64::consts::PI * x.x.max(0.0) / 0.4).sin();
    set_velocity(&mut setup, |x| Vector::new(0.05 * shape(x), 0.0));
    let mut run = Run::new(setup, 1e-4);
    let amplitude = |run: &Run| -> f64 {
        run.vectors("displacement")
            .iter()
            .zip(run.vectors("reference_position"))
            .map(|(u, x)| u.x * shape(&x))
            .sum()
    };
    let energy = |run: &Run| {
        run.solver.energies().value(EnergyAccount::Kinetic)
            + run.solver.energies().value(EnergyAccount::Strain)
    };
    let start = energy(&run);
    let (mut crossings, mut before) = (Vec::new(), 0.0);
    while crossings.len() < 4 {
        run.step().unwrap();
        let now = amplitude(&run);
        if before * now < 0.0 {
            crossings.push(run.time() - run.time_step * now / (now - before));
        }
        before = now;
    }
    let period = crossings[2] - crossings[0];
    // Exact 17.889 ms; a linear model of these sums gives 17.956 ms.
    assert!((period / 17.889e-3 - 1.0).abs() < 0.006, "{period}");
    assert!((energy(&run) / start - 1.0).abs() < 1e-3, "{}", energy(&run) / start);
}

#[test]
fn bits_do_not_depend_on_the_number_of_threads() {
    let bits = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut run = Run::new(cantilever(SubstepCount::Fixed(4)), 2e-5);
            for _ in 0..20 {
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
fn the_stated_limit_is_stable_and_a_fifth_more_is_not() {
    let growth = |factor: f64| {
        let mut setup = cantilever(SubstepCount::Fixed(2));
        let mut seed = 3;
        for v in &mut setup.particles.velocity {
            *v = Vector::new(random(&mut seed), random(&mut seed)) * 0.1;
        }
        let mut run = Run::new(setup, 1.0);
        run.time_step = factor * run.solver.time_step_limit();
        let start = run.solver.energies().value(EnergyAccount::Kinetic);
        for _ in 0..400 {
            if run.step().is_err() {
                return f64::INFINITY;
            }
        }
        (run.solver.energies().value(EnergyAccount::Kinetic)
            + run.solver.energies().value(EnergyAccount::Strain))
            / start
    };
    assert!(growth(1.0) < 1.5, "{}", growth(1.0));
    assert!(growth(1.2) > 1e3, "{}", growth(1.2));
}

/// A block with a uniform pressure on its whole surface.
fn pressed(pressure: &str) -> SolidSetup {
    let mut setup = scene(SPACING);
    add_total(&mut setup, 2, &block(Vector::new(-0.008, -0.006), 8, 6, SPACING));
    let sides = |i: u32| {
        let (column, row) = (i % 8, i / 8);
        [
            (column == 0, (-1.0, 0.0)),
            (column == 7, (1.0, 0.0)),
            (row == 0, (0.0, -1.0)),
            (row == 5, (0.0, 1.0)),
        ]
    };
    let faces: Vec<(u32, Vector)> = (0..48)
        .flat_map(|i| sides(i).into_iter().filter(|side| side.0).map(move |side| (i, side.1)))
        .map(|(i, normal)| (i, Vector::new(normal.0, normal.1) * SPACING))
        .collect();
    setup.bodies[0].loads.push(SurfaceLoad {
        name: "sea".into(),
        law: LoadLaw::Pressure(pressure.into()),
        particles: faces.iter().map(|face| face.0).collect(),
        areas: faces.iter().map(|face| face.1).collect(),
    });
    setup
}

#[test]
fn a_body_under_pressure_shrinks_to_that_pressure_while_it_turns() {
    let mut setup = pressed("2e5");
    setup.damping = Some(sph::setup::Damping { rate: 2e4, until: 1.0 });
    let mut run = Run::new(setup, 1e-5);
    run.until(5e-3);
    for stress in run.values("stress").chunks(3) {
        // In-plane stresses are the load: uniform strain is met exactly, the rest is what still rings.
        assert!((stress[0] + 2e5).abs() < 1e3 && (stress[1] + 2e5).abs() < 1e3, "{stress:?}");
    }
    assert!(run.largest_residual < 1e-12, "{}", run.largest_residual);
    // A follower load on a closed surface neither pushes nor turns a spinning body.
    let mut setup = pressed("2e5");
    set_velocity(&mut setup, |x| Vector::new(-x.y, x.x) * 300.0);
    let mut run = Run::new(setup, 1e-5);
    let angular = |run: &Run| -> f64 {
        run.vectors("position").iter().zip(&run.vectors("velocity")).map(|(x, v)| cross(x, v)).sum()
    };
    let start = angular(&run);
    run.until(3e-3);
    assert!((angular(&run) / start - 1.0).abs() < 1e-3, "{}", angular(&run) / start);
}

#[test]
fn an_acceleration_of_one_body_moves_it_alone() {
    let mut setup = scene(SPACING);
    add_total(&mut setup, 2, &block(Vector::zeros(), 4, 4, SPACING));
    add_total(&mut setup, 2, &block(Vector::new(0.1, 0.0), 4, 4, SPACING));
    setup.bodies[1].acceleration = Some(["2*t".into(), "0".into()]);
    let mut run = Run::new(setup, 1e-5);
    run.until(1e-2);
    let v = run.vectors("velocity");
    // Round-off of F times the modulus leaves some 1e-9 m/s² for 10 ms.
    assert!(v[..16].iter().all(|v| v.norm() < 1e-9));
    // v = t², which the trapezoidal rule of the kicks meets exactly.
    assert!(v[16..].iter().all(|v| (v - Vector::new(1e-4, 0.0)).norm() < 1e-9));
}

#[test]
fn a_crushed_body_stops_the_run_with_a_diagnosis() {
    let mut setup = scene(SPACING);
    add_total(&mut setup, 2, &block(Vector::zeros(), 8, 4, SPACING));
    set_velocity(&mut setup, |x| Vector::new(if x.x < 8e-3 { 280.0 } else { -280.0 }, 0.0));
    let mut run = Run::new(setup, 2e-6);
    let failure = (0..500).find_map(|_| run.step().err()).unwrap();
    assert!(failure.quantity.contains("body `body0`"), "{failure}");
}
