//! Total-Lagrangian bodies in space: the ladder of tests of the plane.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use sph::coupling::ledger::EnergyAccount;
use sph::coupling::solver::Solver;
use sph::coupling::stage::Stage;
use sph::setup::{
    ElasticParameters, HyperelasticLaw, LoadLaw, PlaneState, SolidProbeKind, SolidSetup, SolidStepping,
    SubstepCount, SurfaceLoad,
};
use sph::space::{Plane, Spatial, Tensor, Vector};

use super::scenes::{
    RUBBER, Run, add_body, add_probe, add_support, add_total, block, brick, scene, scene_in, set_material,
    set_velocity, spatial_clamp, total_lagrangian,
};
use crate::SolidSolver;

const SPACING: f64 = 2e-3;

const LAWS: [HyperelasticLaw; 2] = [HyperelasticLaw::StVenantKirchhoff, HyperelasticLaw::NeoHookean];

/// Rotations about axes that are none of the lattice's.
fn rotations() -> [Matrix3<f64>; 3] {
    [Vector3::new(0.1, -0.2, 0.3), Vector3::new(1.1, 0.9, -1.3), Vector3::new(-2.0, 1.5, 1.7)]
        .map(|turn| UnitQuaternion::from_scaled_axis(turn).to_rotation_matrix().into_inner())
}

/// A brick of the given counts mapped by `map` about its centre, at rest.
fn mapped(law: HyperelasticLaw, counts: [u32; 3], map: Matrix3<f64>) -> Run<Spatial> {
    let mut setup = scene_in(SPACING);
    let corner = Vector3::from(counts.map(f64::from)) * (-0.5 * SPACING);
    let x = brick(corner, counts, SPACING);
    add_body(&mut setup, total_lagrangian(law), &x);
    setup.stepping = SolidStepping::Substeps(SubstepCount::Fixed(2));
    setup.particles.position = x.iter().map(|x| map * x).collect();
    Run::new(setup, 1e-6)
}

/// Forces on the particles of `run` in its first stage \[N\].
fn first_forces(run: &mut Run<Spatial>) -> Vec<Vector3<f64>> {
    let time = run.stage_time(Stage::Predictor);
    run.solver.begin_stage(&time).unwrap();
    run.solver.evaluate_own(&time);
    run.solver.workspace.forces.iter().map(|forces| forces.total).collect()
}

fn strain_energy(run: &Run<Spatial>) -> f64 {
    run.solver.energies().value(EnergyAccount::Strain)
}

fn total_energy(run: &Run<Spatial>) -> f64 {
    run.solver.energies().value(EnergyAccount::Kinetic) + strain_energy(run)
}

#[test]
fn a_rigid_rotation_makes_neither_stress_nor_force() {
    // A cube, and a sheet and a row of single particles, along which alone they are strained.
    for counts in [[6, 5, 4], [6, 5, 1], [1, 1, 9]] {
        for law in LAWS {
            for rotation in rotations() {
                let mut run = mapped(law, counts, rotation);
                let modulus = RUBBER.bulk_modulus;
                // Round-off of F, some 1e-15 by the inverse of the moment and the cofactor, times the moduli.
                assert!(run.values("stress").iter().all(|s| s.abs() < 2e-14 * modulus), "{counts:?}");
                let scale = modulus * SPACING * SPACING;
                assert!(first_forces(&mut run).iter().all(|f| f.norm() < 1e-13 * scale), "{counts:?}");
                assert!(strain_energy(&run) < 1e-25 * modulus * SPACING.powi(3) * 120.0);
            }
        }
    }
}

#[test]
fn a_uniform_stretch_has_the_stress_of_the_formula_everywhere() {
    let (lambda, g) = (RUBBER.first_lame_constant(), RUBBER.shear_modulus);
    let stretches = [1.2, 0.9, 1.05];
    let jacobian: f64 = stretches.iter().product();
    // Second Piola-Kirchhoff S_a = λ tr E + 2G E_a, σ_a = Λ_a² S_a/J; neo-Hookean σ_a = (G(Λ_a² − 1) + λ ln J)/J.
    let trace: f64 = stretches.iter().map(|l| 0.5 * (l * l - 1.0)).sum();
    let venant = |l: f64| l * l * (lambda * trace + g * (l * l - 1.0)) / jacobian;
    let hooke = |l: f64| (g * (l * l - 1.0) + lambda * jacobian.ln()) / jacobian;
    for (law, expected) in LAWS.into_iter().zip([stretches.map(venant), stretches.map(hooke)]) {
        for rotation in rotations() {
            let map = rotation * Matrix3::from_diagonal(&stretches.into());
            let run = mapped(law, [6, 5, 4], map);
            let turned = rotation * Matrix3::from_diagonal(&expected.into()) * rotation.transpose();
            for s in run.values("stress").chunks(6) {
                let found = Matrix3::new(s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2]);
                // Round-off, as in the plane.
                assert!((found - turned).norm() < 1e-12 * turned.norm(), "{law:?} {found} {turned}");
            }
        }
    }
}

#[test]
fn a_sheet_in_its_plane_has_the_stress_of_plane_strain() {
    let map = Matrix3::new(1.1, 0.2, 0.0, -0.1, 0.95, 0.0, 0.0, 0.0, 1.0);
    for law in LAWS {
        let (sheet, whole) = (mapped(law, [6, 5, 1], map), mapped(law, [6, 5, 4], map));
        let (of_sheet, of_whole) = (sheet.values("stress"), whole.values("stress"));
        for (a, b) in of_sheet.chunks(6).flatten().zip(of_whole.chunks(6).flatten()) {
            // Round-off of the moduli.
            assert!((a - b).abs() < 1e-13 * RUBBER.bulk_modulus, "{law:?}: {a} {b}");
        }
    }
}

fn random(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
}

fn random_vector(seed: &mut u64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| random(seed))
}

/// A brick of these counts with random displacements and velocities.
fn disordered(counts: [u32; 3]) -> SolidSetup<Spatial> {
    let mut setup = scene_in(SPACING);
    add_total(&mut setup, 2, &brick(Vector3::zeros(), counts, SPACING));
    let mut seed = 7;
    let p = &mut setup.particles;
    for i in 0..p.id.len() {
        p.position[i] += random_vector(&mut seed) * 0.2 * SPACING;
        p.velocity[i] = random_vector(&mut seed) * 2.0;
    }
    setup
}

#[test]
fn internal_forces_have_neither_resultant_nor_torque() {
    for counts in [[6, 5, 4], [8, 8, 1], [20, 1, 1]] {
        let mut run = Run::new(disordered(counts), 2e-6);
        let forces = first_forces(&mut run);
        let gross: f64 = forces.iter().map(|f| f.norm()).sum();
        assert!(gross > 1.0);
        // Round-off of some thousand pairs.
        assert!(forces.iter().sum::<Vector3<f64>>().norm() < 1e-13 * gross);
        let positions = run.vectors("position");
        let torque: Vector3<f64> = positions.iter().zip(&forces).map(|(x, f)| x.cross(f)).sum();
        // Arms are at most 40 mm.
        assert!(torque.norm() < 1e-13 * gross * 0.04, "{counts:?}: {torque}");
    }
}

#[test]
fn forces_are_the_slope_of_the_energy() {
    for counts in [[4, 4, 3], [5, 5, 1], [9, 1, 1]] {
        let mut run = Run::new(disordered(counts), 2e-6);
        let forces = first_forces(&mut run);
        let scale = forces.iter().map(|f| f.norm()).fold(0.0, f64::max);
        let step = 1e-5 * SPACING;
        for (i, axis) in [(0, 0), (7, 1), (5, 2)] {
            let energy = |change: f64| {
                let mut setup = disordered(counts);
                setup.particles.position[i][axis] += change;
                strain_energy(&Run::new(setup, 2e-6))
            };
            let slope = (energy(step) - energy(-step)) / (2.0 * step);
            // Truncation of the third derivative, (1e-5)² of the scale; round-off 1e-16 of the energy over 1e-5.
            assert!(
                (forces[i][axis] + slope).abs() < 1e-7 * scale,
                "{counts:?}: {} {slope}",
                forces[i][axis]
            );
        }
    }
}

#[test]
fn a_disordered_brick_keeps_momentum_angular_momentum_and_energy() {
    let mut run = Run::new(disordered([6, 5, 4]), 4e-6);
    let mass = run.values("mass")[0];
    let momentum = |run: &Run<Spatial>| run.vectors("velocity").iter().sum::<Vector3<f64>>() * mass;
    let angular = |run: &Run<Spatial>| {
        let (x, v) = (run.vectors("position"), run.vectors("velocity"));
        x.iter().zip(&v).map(|(x, v)| x.cross(v)).sum::<Vector3<f64>>() * mass
    };
    let start = (momentum(&run), angular(&run), total_energy(&run));
    let gross: f64 = run.vectors("velocity").iter().map(|v| v.norm() * mass).sum();
    for _ in 0..300 {
        run.step().unwrap();
    }
    // Round-off of 1,200 evaluations.
    assert!((momentum(&run) - start.0).norm() < 1e-12 * gross);
    assert!((angular(&run) - start.1).norm() < 1e-12 * gross * 0.012);
    // Velocity Verlet near its limit.
    assert!((total_energy(&run) / start.2 - 1.0).abs() < 0.02, "{}", total_energy(&run) / start.2);
    assert!(run.largest_residual < 1e-12, "{}", run.largest_residual);
}

#[test]
fn a_spinning_cube_keeps_its_angular_momentum_and_energy_over_a_turn() {
    let spacing = 0.1 / 6.0;
    let mut setup = scene_in::<Spatial>(spacing);
    add_total(&mut setup, 2, &brick(Vector3::repeat(-0.05), [6; 3], spacing));
    let (young, nu) = (1.7e7, 0.45);
    let material = ElasticParameters {
        density: 1100.0,
        bulk_modulus: young / (3.0 * (1.0 - 2.0 * nu)),
        shear_modulus: young / (2.0 * (1.0 + nu)),
        plane: PlaneState::Strain,
    };
    set_material(&mut setup, material);
    let spin = Vector3::new(1.0, 2.0, 3.0) * (50.0 / 14f64.sqrt());
    set_velocity(&mut setup, |x| spin.cross(x));
    add_probe(&mut setup, SolidProbeKind::Sums(Some(0)));
    add_probe(&mut setup, SolidProbeKind::Motion(0));
    let mut run = Run::new(setup, 5e-5);
    let start = run.probes();
    let energy = total_energy(&run);
    let turn = std::f64::consts::TAU / 50.0;
    run.until(0.5 * turn);
    // Half a turn about (1, 2, 3), which lags a little as the cube grows under the centrifugal force.
    let half = run.probes();
    let axis = Vector3::new(half[26], half[27], half[28]);
    assert!(half[25].abs() < 0.03 && (axis.normalize() - spin.normalize()).norm() < 0.01, "{axis}");
    run.until(turn);
    let end = run.probes();
    let scale = Vector3::new(start[4], start[5], start[6]).norm();
    for k in 4..7 {
        assert!((end[k] - start[k]).abs() < 1e-6 * scale, "{}", (end[k] - start[k]) / scale);
    }
    // Round-off against the momenta of the particles.
    assert!(end[1..4].iter().all(|momentum| momentum.abs() < 1e-12), "{:?}", &end[1..4]);
    assert!((total_energy(&run) / energy - 1.0).abs() < 5e-3, "{}", total_energy(&run) / energy);
}

/// A rectangle in the plane and the same as a slab, periodic along z, both displaced in the plane by `displace`.
fn slab(layers: u32, displace: impl Fn(usize, Vector) -> Vector) -> (Run<Plane>, Run<Spatial>) {
    let rectangle = block(Vector::new(-0.008, -0.006), 8, 6, SPACING);
    let mut plane = scene(SPACING);
    add_total(&mut plane, 2, &rectangle);
    let mut space = scene_in::<Spatial>(SPACING);
    space.run.domain.lower.z = 0.0;
    space.run.domain.upper.z = f64::from(layers) * SPACING;
    space.run.domain.periodic[2] = true;
    add_total(&mut space, 2, &brick(Vector3::new(-0.008, -0.006, 0.0), [8, 6, layers], SPACING));
    let moved: Vec<Vector> = rectangle.iter().enumerate().map(|(i, x)| displace(i, *x)).collect();
    for (i, x) in space.particles.position.iter_mut().enumerate() {
        (x.x, x.y) = (moved[i % 48].x, moved[i % 48].y);
    }
    plane.particles.position = moved;
    (Run::new(plane, 4e-6), Run::new(space, 4e-6))
}

#[test]
fn a_slab_has_the_stress_of_plane_strain_and_no_motion_across() {
    let map = Tensor::new(1.1, 0.3, -0.2, 0.8);
    let (plane, space) = slab(8, |_, x| map * x);
    let (flat, pressure) = (plane.values("stress"), plane.values("pressure"));
    for (i, stress) in space.values("stress").chunks(6).enumerate() {
        let expected = &flat[i % 48 * 3..][..3];
        // xx, yy and xy are columns 0, 1 and 3 in space; σ_zz is that of the pressure −tr σ/3.
        let across = -3.0 * pressure[i % 48] - expected[0] - expected[1];
        for (found, expected) in [
            (stress[0], expected[0]),
            (stress[1], expected[1]),
            (stress[3], expected[2]),
            (stress[2], across),
        ] {
            // Round-off of the moduli.
            assert!((found - expected).abs() < 1e-13 * RUBBER.bulk_modulus, "{i}: {found} {expected}");
        }
        assert!(stress[4].abs().max(stress[5].abs()) < 1e-13 * RUBBER.bulk_modulus);
    }
    // In disorder all layers move alike.
    let mut seed = 5;
    let shifts: Vec<Vector> =
        (0..48).map(|_| Vector::new(random(&mut seed), random(&mut seed)) * 0.1 * SPACING).collect();
    let (_, mut space) = slab(8, |i, x| x + shifts[i]);
    for _ in 0..100 {
        space.step().unwrap();
    }
    let velocity = space.vectors("velocity");
    let largest = velocity.iter().map(|v| v.norm()).fold(0.0, f64::max);
    for (i, v) in velocity.iter().enumerate() {
        // Round-off, which grows a little in 100 steps.
        assert!(v.z.abs() < 1e-11 * largest, "{} of {largest}", v.z);
        assert!((v - velocity[i % 48]).norm() < 1e-11 * largest);
    }
}

/// A short cantilever along x.
fn cantilever() -> SolidSetup<Spatial> {
    let mut setup = scene_in(SPACING);
    add_total(&mut setup, 4, &brick(Vector3::new(-2.0, -2.0, -2.0) * SPACING, [14, 4, 4], SPACING));
    add_support(&mut setup, 0, spatial_clamp(), |x| x.x < 0.0);
    setup
}

#[test]
fn a_cantilever_bends_alike_in_both_directions() {
    let tip = |push: Vector3<f64>| {
        let mut setup = cantilever();
        set_velocity(&mut setup, |x| push * (x.x.max(0.0) / 0.024).powi(2));
        add_probe(&mut setup, SolidProbeKind::MaterialPoint(0, Vector3::new(0.024, 0.0, 0.0)));
        add_probe(&mut setup, SolidProbeKind::Reaction(0, 0));
        let mut run = Run::new(setup, 1e-5);
        run.until(1e-3);
        assert!(run.largest_residual < 1e-12, "{}", run.largest_residual);
        run.probes()
    };
    let (y, z) = (tip(Vector3::new(0.0, 5.0, 0.0)), tip(Vector3::new(0.0, 0.0, 5.0)));
    assert!(y[1].abs() > 1e-3, "{}", y[1]);
    for (a, b) in [(y[0], z[0]), (y[1], z[2]), (y[2], z[1])] {
        // Round-off in 200 sub-steps.
        assert!((a - b).abs() < 1e-9 * y[1].abs(), "{y:?} {z:?}");
    }
    for (a, b) in [(y[16], z[16]), (y[17], z[18]), (y[18], z[17])] {
        assert!((a - b).abs() < 1e-9 * y[17].abs(), "{y:?} {z:?}");
    }
}

#[test]
fn bits_do_not_depend_on_the_number_of_threads() {
    let bits = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut setup = cantilever();
            let mut seed = 2;
            setup.particles.velocity.iter_mut().for_each(|v| *v = random_vector(&mut seed));
            let mut run = Run::new(setup, 1e-5);
            for _ in 0..20 {
                run.step().unwrap();
            }
            run.bits()
        })
    };
    assert_eq!(bits(1), bits(2));
}

#[test]
fn the_stated_limit_is_stable_and_a_fifth_more_is_not() {
    let growth = |factor: f64| {
        let mut setup = cantilever();
        setup.stepping = SolidStepping::Substeps(SubstepCount::Fixed(2));
        let mut seed = 3;
        setup.particles.velocity.iter_mut().for_each(|v| *v = random_vector(&mut seed) * 0.1);
        let mut run = Run::new(setup, 1.0);
        run.time_step = factor * run.solver.time_step_limit();
        let start = run.solver.energies().value(EnergyAccount::Kinetic);
        for _ in 0..300 {
            if run.step().is_err() {
                return f64::INFINITY;
            }
        }
        total_energy(&run) / start
    };
    assert!(growth(1.0) < 1.5, "{}", growth(1.0));
    assert!(growth(1.2) > 1e3, "{}", growth(1.2));
}

#[test]
fn a_body_under_pressure_shrinks_to_that_pressure() {
    let counts = [5, 4, 4];
    let mut setup = scene_in::<Spatial>(SPACING);
    add_total(&mut setup, 2, &brick(Vector3::repeat(-0.004), counts, SPACING));
    let (mut particles, mut areas) = (Vec::new(), Vec::new());
    for i in 0..80 {
        let cell = [i % 5, i / 5 % 4, i / 20];
        for axis in 0..3 {
            for (place, sign) in [(0, -1.0), (counts[axis] - 1, 1.0)] {
                if cell[axis] == place {
                    particles.push(i);
                    areas.push(Vector3::ith(axis, sign * SPACING * SPACING));
                }
            }
        }
    }
    setup.bodies[0].loads.push(SurfaceLoad {
        name: "sea".into(),
        law: LoadLaw::Pressure("2e5".into()),
        particles,
        areas,
    });
    setup.damping = Some(sph::setup::Damping { rate: 2e4, until: 1.0 });
    let mut run = Run::new(setup, 1e-5);
    run.until(5e-3);
    for stress in run.values("stress").chunks(6) {
        // Forces of a uniform stress balance those on the faces in the mean; at edges and corners 1 % is left.
        assert!(stress[..3].iter().all(|s| (s + 2e5).abs() < 2e3), "{stress:?}");
        assert!(stress[3..].iter().all(|s| s.abs() < 2e3), "{stress:?}");
    }
    assert!(run.largest_residual < 1e-12, "{}", run.largest_residual);
}

#[test]
fn plane_stress_is_refused() {
    let mut setup = cantilever();
    setup.bodies[0].material.plane = PlaneState::Stress;
    let errors = SolidSolver::new(setup).err().unwrap();
    assert!(errors.iter().any(|error| error.contains("plane stress belongs to the plane")), "{errors:?}");
}
