//! Rigid bodies in space.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use sph::coupling::solver::Solver;
use sph::setup::{Formulation, Motion, SolidProbeKind, SolidSetup, SolidStepping, SubstepCount, Support};
use sph::space::Spatial;

use super::scenes::{
    RUBBER, Run, add_body, add_probe, add_support, add_total, brick, scene_in, set_velocity, spatial_clamp,
};

const SPACING: f64 = 0.01;

/// A free rigid brick of 6 x 4 x 2 cells that spins about the middle one of its principal axes, but for a hundredth.
fn tumbling(stepping: SolidStepping) -> SolidSetup<Spatial> {
    let mut setup = scene_in::<Spatial>(SPACING);
    setup.stepping = stepping;
    add_body(&mut setup, Formulation::Rigid, &brick(Vector3::new(-0.03, -0.02, -0.01), [6, 4, 2], SPACING));
    set_velocity(&mut setup, |x| SPIN.cross(x));
    add_probe(&mut setup, SolidProbeKind::Sums(Some(0)));
    setup
}

const SPIN: Vector3<f64> = Vector3::new(0.1, 10.0, 0.05);

/// Rotation and angular velocity after `time` of a body of `inertia` that starts with [`SPIN`], by Runge and Kutta's rule for
/// Euler's equations.
fn euler(inertia: &Matrix3<f64>, time: f64) -> (Matrix3<f64>, Vector3<f64>) {
    let inverse = inertia.try_inverse().unwrap();
    let rates = |r: &Matrix3<f64>, w: &Vector3<f64>| (r * w.cross_matrix(), inverse * (inertia * w).cross(w));
    let (mut r, mut w) = (Matrix3::identity(), SPIN);
    let steps = (time * 1e4).round();
    let dt = time / steps;
    for _ in 0..steps as usize {
        let (a, d) = rates(&r, &w);
        let (b, e) = rates(&(r + a * (0.5 * dt)), &(w + d * (0.5 * dt)));
        let (c, f) = rates(&(r + b * (0.5 * dt)), &(w + e * (0.5 * dt)));
        let (g, h) = rates(&(r + c * dt), &(w + f * dt));
        r += (a + b * 2.0 + c * 2.0 + g) * (dt / 6.0);
        w += (d + e * 2.0 + f * 2.0 + h) * (dt / 6.0);
    }
    (r, r * w)
}

fn angular_momentum(run: &Run<Spatial>) -> Vector3<f64> {
    let probes = run.probes();
    Vector3::new(probes[4], probes[5], probes[6])
}

#[test]
fn a_brick_tumbles_by_euler_s_equations_and_keeps_its_angular_momentum() {
    let rules = [SolidStepping::Substeps(SubstepCount::Fixed(2)), SolidStepping::StageRule];
    for stepping in rules {
        let time = 2.4;
        let errors = [4e-3, 2e-3].map(|time_step| {
            let mut run = Run::new(tumbling(stepping), time_step);
            let inertia = run.solver.masses().next().unwrap().1.unwrap();
            let (start, energy) = (angular_momentum(&run), run.probes()[7]);
            run.until(time);
            let (rotation, spin) = euler(&inertia, time);
            // It has turned over: the axis of the spin points the other way in the body.
            assert!((rotation.transpose() * spin).y < -9.0);
            // Round-off of 1,200 steps.
            assert!((angular_momentum(&run) - start).norm() < 1e-12 * start.norm());
            // Sub-steps are the same back in time, so that energy comes back; the stage rule drifts by 1e-4.
            let bound = if stepping == SolidStepping::StageRule { 1e-3 } else { 1e-6 };
            let kept = run.probes()[7] / energy - 1.0;
            assert!(kept.abs() < bound, "{stepping:?} {kept}");
            assert!(run.largest_residual < 1e-12, "{}", run.largest_residual);
            let found = run.solver.state.rigid[0].rotation.to_rotation_matrix().into_inner();
            (found - rotation).norm()
        });
        // Second order, in a motion that is unstable where it turns over.
        assert!(errors[0] / errors[1] > 3.5, "{stepping:?} {errors:?}");
        assert!(errors[1] < 0.05, "{stepping:?} {errors:?}");
    }
}

#[test]
fn a_torque_spins_up_about_its_axis() {
    // A force k x along z on each unit of mass has the torque −k Σ m x² about y.
    let mut setup = tumbling(SolidStepping::Substeps(SubstepCount::Fixed(2)));
    set_velocity(&mut setup, |_| Vector3::zeros());
    setup.bodies[0].acceleration = Some(["0".into(), "0".into(), "30*x".into()]);
    let second: f64 =
        setup.particles.position.iter().zip(&setup.particles.mass).map(|(x, m)| m * x.x * x.x).sum();
    let mut run = Run::new(setup, 1e-3);
    let inertia = run.solver.masses().next().unwrap().1.unwrap();
    run.until(0.01);
    let spin = run.solver.state.rigid[0].angular_velocity;
    let expected = Vector3::new(0.0, -30.0 * second * 0.01 / inertia[(1, 1)], 0.0);
    // It has turned by 1e-3: cosines of that.
    assert!((spin - expected).norm() < 1e-5 * expected.norm(), "{spin} {expected}");
    assert!(run.largest_residual < 1e-12, "{}", run.largest_residual);
}

#[test]
fn a_row_of_particles_keeps_the_spin_that_its_velocities_describe() {
    let mut setup = scene_in::<Spatial>(SPACING);
    setup.stepping = SolidStepping::Substeps(SubstepCount::Fixed(2));
    add_body(
        &mut setup,
        Formulation::Rigid,
        &brick(Vector3::new(-0.05, -0.005, -0.005), [10, 1, 1], SPACING),
    );
    set_velocity(&mut setup, |x| Vector3::new(3.0, 2.0, -1.0).cross(x) + Vector3::new(0.5, 0.0, 0.0));
    let mut run = Run::new(setup, 1e-3);
    let rigid = &run.solver.state.rigid[0];
    assert!((rigid.angular_velocity - Vector3::new(0.0, 2.0, -1.0)).norm() < 1e-12);
    run.until(0.1);
    let rigid = &run.solver.state.rigid[0];
    // Across its axis a row turns as a body of revolution: steadily.
    assert!((rigid.angular_velocity - Vector3::new(0.0, 2.0, -1.0)).norm() < 1e-10);
    assert!((rigid.centre - Vector3::new(0.05, 0.0, 0.0)).norm() < 1e-12);
}

/// A turn about an axis that is none of the lattice's, with a displacement.
fn turning() -> Support<Spatial> {
    let motion = Motion::<Spatial> {
        displacement: ["0.1*t".into(), String::new(), "t^2".into()],
        angle: "2*t".into(),
        axis: Vector3::new(1.0, 2.0, 2.0) / 3.0,
        pivot: Vector3::new(0.02, 0.01, 0.0),
    };
    Support { motion: Some(motion), ..spatial_clamp() }
}

/// Where [`turning`] takes `x` by `time`.
fn turned(x: &Vector3<f64>, time: f64) -> Vector3<f64> {
    let rotation = UnitQuaternion::from_scaled_axis(Vector3::new(1.0, 2.0, 2.0) / 3.0 * (2.0 * time));
    let pivot = Vector3::new(0.02, 0.01, 0.0);
    pivot + rotation * (x - pivot) + Vector3::new(0.1 * time, 0.0, time * time)
}

#[test]
fn a_prescribed_rotation_about_an_axis_is_followed_exactly() {
    for rigid in [true, false] {
        for stepping in [SolidStepping::Substeps(SubstepCount::Fixed(20)), SolidStepping::StageRule] {
            let mut setup = scene_in::<Spatial>(SPACING);
            let x = brick(Vector3::zeros(), [4, 3, 3], SPACING);
            if rigid {
                add_body(&mut setup, Formulation::Rigid, &x);
            } else {
                add_total(&mut setup, 2, &x);
            }
            setup.stepping = stepping;
            add_support(&mut setup, 0, turning(), |_| true);
            add_probe(&mut setup, SolidProbeKind::Motion(0));
            let mut run = Run::new(setup, 1e-3);
            run.until(0.5);
            for (x, now) in x.iter().zip(run.vectors("position")) {
                // Round-off.
                assert!((turned(x, 0.5) - now).norm() < 1e-14, "{rigid} {stepping:?}");
            }
            let probes = run.probes();
            // Quaternion and angular velocity of an angle of 1 rad at 2 rad/s.
            let expected = [
                0.5f64.cos(),
                0.5f64.sin() / 3.0,
                0.5f64.sin() / 1.5,
                0.5f64.sin() / 1.5,
                2.0 / 3.0,
                4.0 / 3.0,
            ];
            for (found, expected) in probes[6..12].iter().zip(expected) {
                assert!((found - expected).abs() < 1e-10, "{probes:?}");
            }
            assert!(run.largest_residual < 1e-12, "{}", run.largest_residual);
        }
    }
}

#[test]
fn a_roller_leaves_a_body_free_to_turn() {
    let mut setup = tumbling(SolidStepping::Substeps(SubstepCount::Fixed(2)));
    setup.run.body_force.gravity = Vector3::new(0.0, -9.81, 0.0);
    add_support(&mut setup, 0, Support { held: [false, true, false], ..spatial_clamp() }, |_| true);
    let mut run = Run::new(setup, 2e-3);
    let start = angular_momentum(&run);
    run.until(1.0);
    assert!(run.solver.state.rigid[0].centre.y.abs() < 1e-14);
    assert!((angular_momentum(&run) - start).norm() < 1e-12 * start.norm());
    let reaction = run.solver.state.last.reactions[0][0];
    let weight = 48.0 * RUBBER.density * SPACING.powi(3) * 9.81;
    assert!((reaction - Vector3::new(0.0, weight, 0.0)).norm() < 1e-10 * weight, "{reaction}");
    assert!(run.largest_residual < 1e-12, "{}", run.largest_residual);
}

#[test]
fn a_setup_has_the_mass_and_the_inertia_that_the_solver_computes_with() {
    let setup = tumbling(SolidStepping::StageRule);
    let of_setup = setup.particles.of_body(0);
    let (mass, inertia) = (of_setup.mass(), sph::space::tensors::SpaceSymmetric::full(&of_setup.inertia()));
    let run = Run::new(setup, 1e-3);
    let (of_solver, tensor) = run.solver.masses().next().unwrap();
    assert!((of_solver / mass - 1.0).abs() < 1e-14);
    assert!((tensor.unwrap() - inertia).norm() < 1e-14 * inertia.norm());
    // A box of a x b x c has M (b² + c²)/12.
    let exact = |b: f64, c: f64| mass * (b * b + c * c) / 12.0;
    for (k, exact) in [exact(0.04, 0.02), exact(0.06, 0.02), exact(0.06, 0.04)].into_iter().enumerate() {
        assert!((inertia[(k, k)] / exact - 1.0).abs() < 1e-13);
    }
    assert!(run.solver.remarks().is_empty());
}

/// A support at `pivot`.
fn hinge(pivot: Vector3<f64>) -> Support<Spatial> {
    Support { name: "hinge".into(), held: [false; 3], pivot: Some(pivot), ..spatial_clamp() }
}

/// Mean rate of precession of a top of a square cross-section whose tip is at the origin, with its axis at `tilt` to the
/// vertical and `spin` about it, over that of a steady one by Euler's equations about the tip; and its largest nutation.
fn precession(stepping: SolidStepping, time_step: f64) -> (f64, f64) {
    let (spin, gravity, tilt): (f64, f64, f64) = (200.0, 9.81, 1.0);
    let mut setup = scene_in::<Spatial>(SPACING);
    setup.stepping = stepping;
    setup.run.body_force.gravity = Vector3::new(0.0, 0.0, -gravity);
    add_body(&mut setup, Formulation::Rigid, &brick(Vector3::new(-0.03, -0.03, 0.03), [6, 6, 4], SPACING));
    // Upright at first, so that moments are principal ones, then leant over by a rotation about y.
    let particles = &mut setup.particles;
    let mass: f64 = particles.mass.iter().sum();
    let height = 0.05;
    let of = |axis: usize| -> f64 {
        let square = |x: &Vector3<f64>| x.norm_squared() - x[axis] * x[axis];
        let cell = SPACING * SPACING / 6.0;
        particles.position.iter().zip(&particles.mass).map(|(x, m)| m * (square(x) + cell)).sum()
    };
    let (across, along) = (of(0), of(2));
    // A top precesses steadily at Ω where (I₃ ω₃ − I₁ Ω cos θ) Ω = m g l.
    let (a, b, c) = (across * tilt.cos(), -along * spin, mass * gravity * height);
    let steady = (-b - (b * b - 4.0 * a * c).sqrt()) / (2.0 * a);
    let lean = UnitQuaternion::from_scaled_axis(Vector3::y() * tilt);
    let axis = lean * Vector3::z();
    // ω₃ is the whole component along the axis.
    let omega = axis * (spin - steady * tilt.cos()) + Vector3::z() * steady;
    for i in 0..particles.position.len() {
        particles.position[i] = lean * particles.position[i];
        particles.reference_position[i] = particles.position[i];
        particles.velocity[i] = omega.cross(&particles.position[i]);
    }
    add_support(&mut setup, 0, hinge(Vector3::zeros()), |_| false);
    let mut run = Run::new(setup, time_step);
    let energy = |run: &Run<Spatial>| run.solver.state.rigid[0].centre.z * mass * gravity;
    let (start, duration) = (energy(&run), 1.0);
    run.until(duration);
    let centre = run.solver.state.rigid[0].centre;
    // The tip stays, and the budget of momentum closes.
    assert!((centre.norm() - height).abs() < 1e-12, "{centre}");
    assert!(run.largest_residual < 1e-12, "{}", run.largest_residual);
    let turned = (centre.y.atan2(centre.x)).rem_euclid(std::f64::consts::TAU);
    let whole = ((steady * duration - turned) / std::f64::consts::TAU).round() * std::f64::consts::TAU;
    let rate = (turned + whole) / duration;
    (rate / steady - 1.0, (energy(&run) - start).abs() / (mass * gravity * height))
}

#[test]
fn a_heavy_top_precesses_as_the_text_books_say() {
    for stepping in [SolidStepping::Substeps(SubstepCount::Fixed(2)), SolidStepping::StageRule] {
        // Steps of a twentieth and of a fortieth of a radian of spin.
        let [coarse, fine] = [2.5e-4, 1.25e-4].map(|step| precession(stepping, step));
        assert!(fine.0.abs() < 1e-3 && fine.1 < 1e-3, "{stepping:?} {fine:?}");
        // Second order, unless it is round-off already.
        assert!(coarse.0.abs() < 1e-8 || (coarse.0 / fine.0).abs() > 3.0, "{stepping:?} {coarse:?} {fine:?}");
    }
}

#[test]
fn a_pivot_that_is_moved_carries_its_body_along() {
    // A pendulum of which the pivot is accelerated steadily hangs still, at the angle of the apparent gravity.
    let mut setup = scene_in::<Spatial>(SPACING);
    setup.stepping = SolidStepping::Substeps(SubstepCount::Fixed(2));
    setup.run.body_force.gravity = Vector3::new(0.0, 0.0, -9.81);
    let lean = UnitQuaternion::from_scaled_axis(Vector3::y() * (4.0f64 / 9.81).atan());
    let cells = brick(Vector3::new(-0.01, -0.01, -0.2), [2, 2, 10], SPACING);
    let cells: Vec<Vector3<f64>> = cells.iter().map(|x| lean * x).collect();
    add_body(&mut setup, Formulation::Rigid, &cells);
    let motion = Motion::<Spatial> {
        displacement: ["2*t^2".into(), String::new(), String::new()],
        angle: String::new(),
        axis: Vector3::z(),
        pivot: Vector3::zeros(),
    };
    add_support(&mut setup, 0, Support { motion: Some(motion), ..hinge(Vector3::zeros()) }, |_| false);
    let mut run = Run::new(setup, 1e-3);
    let start = run.solver.state.rigid[0].centre;
    run.until(0.5);
    let way = run.solver.state.rigid[0].centre - start;
    // The way of the pivot, with what second-order steps of 1 ms miss of it.
    assert!((way - Vector3::new(0.5, 0.0, 0.0)).norm() < 1e-5, "{way}");
    let weight = run.solver.masses().next().unwrap().0 * 9.81;
    let reaction = run.solver.state.last.reactions[0][0];
    assert!((reaction - Vector3::new(weight * 4.0 / 9.81, 0.0, weight)).norm() < 1e-3 * weight, "{reaction}");
    assert!(run.largest_residual < 1e-12, "{}", run.largest_residual);
}
