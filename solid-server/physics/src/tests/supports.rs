//! Supports: what is held, what it costs, and how it ends.

use sph::coupling::ledger::Account;
use sph::setup::{Formulation, Motion, SolidProbeKind, SolidStepping, SubstepCount, Support};
use sph::space::Vector;

use super::scenes::{Run, add_body, add_elastic, add_probe, add_support, block, clamp, scene};

const SPACING: f64 = 2e-3;

fn motion(x: &str, y: &str, angle: &str) -> Motion {
    Motion {
        displacement: [x.into(), y.into()],
        angle: angle.into(),
        axis: 1.0,
        pivot: Vector::new(0.01, 0.0),
    }
}

/// A bar of 12 x 4 whose first three columns are held by `support`.
fn held_bar(support: Support, gravity: f64) -> Run {
    let mut setup = scene(SPACING);
    add_elastic(&mut setup, &block(Vector::zeros(), 12, 4, SPACING));
    add_support(&mut setup, 0, support, |x| x.x < 3.0 * SPACING);
    setup.run.body_force.gravity = Vector::new(0.0, gravity);
    add_probe(&mut setup, SolidProbeKind::Reaction(0, 0));
    Run::new(setup, 1e-5)
}

#[test]
fn a_clamp_holds_its_particles_bit_for_bit_while_their_stress_evolves() {
    let mut run = held_bar(clamp(), -50.0);
    let start = run.vectors("position");
    run.until(2e-3);
    let (support, now) = (run.values("support"), run.vectors("position"));
    let stress = run.values("stress");
    for i in 0..now.len() {
        assert_eq!(support[i] > 0.0, now[i] == start[i], "particle {i}");
    }
    let held_stress =
        (0..now.len()).filter(|i| support[*i] > 0.0).map(|i| stress[3 * i].abs()).fold(0.0, f64::max);
    assert!(held_stress > 100.0, "{held_stress}");
    assert!(run.largest_residual < 1e-12, "{}", run.largest_residual);
}

#[test]
fn the_reaction_is_what_keeps_the_momentum_of_the_bar_from_falling() {
    let mut run = held_bar(clamp(), -50.0);
    let mass: f64 = run.values("mass").iter().sum();
    let mut impulse = Vector::zeros();
    while run.step < 200 {
        let budget = run.step().unwrap();
        let reaction = budget[1].accounts.get(Account::Supports).force.xy();
        assert_eq!(run.probes(), [reaction.x, reaction.y]);
        impulse += reaction * run.time_step;
    }
    let cell = run.values("mass")[0];
    let momentum: Vector = run.vectors("velocity").iter().map(|v| v * cell).sum();
    let weight = Vector::new(0.0, -50.0 * mass);
    assert!((momentum - impulse - weight * run.time()).norm() < 1e-12 * (weight * run.time()).norm());
    // The bar is short and stiff: over 2 ms the mean reaction carries most of the weight.
    assert!((0.3..1.7).contains(&(impulse.y / (-weight.y * run.time()))));
}

#[test]
fn a_moving_support_is_followed_exactly() {
    let support = Support { motion: Some(motion("2e-3*sin(300*t)", "0", "")), ..clamp() };
    let mut run = held_bar(support, 0.0);
    let first = run.vectors("velocity")[0];
    assert!((first - Vector::new(0.6, 0.0)).norm() < 1e-15);
    run.until(3e-3);
    let (sine, cosine) = (300.0f64 * 3e-3).sin_cos();
    let (x, v) = (run.vectors("displacement")[0], run.vectors("velocity")[0]);
    assert!((x - Vector::new(2e-3 * sine, 0.0)).norm() < 1e-16);
    assert!((v - Vector::new(0.6 * cosine, 0.0)).norm() < 1e-14);
    // The free end is dragged along.
    let tip = run.vectors("displacement")[11];
    assert!((tip.x / (2e-3 * sine) - 1.0).abs() < 0.2, "{tip}");
    assert!(run.largest_residual < 1e-12);
}

#[test]
fn a_run_that_starts_within_a_motion_does_not_jump() {
    let support = Support { motion: Some(motion("2e-3*sin(300*t)", "0", "20*t")), ..clamp() };
    let mut setup = scene(SPACING);
    add_elastic(&mut setup, &block(Vector::zeros(), 12, 4, SPACING));
    add_support(&mut setup, 0, support, |x| x.x < 3.0 * SPACING);
    setup.run.time.start_time = 0.4;
    let mut run = Run::new(setup, 1e-6);
    let start = run.vectors("position");
    run.step().unwrap();
    let largest = run.vectors("position").iter().zip(&start).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    // 0.6 m/s and 20 rad/s over 10 mm, for 1 µs.
    assert!(largest < 1e-6, "{largest}");
}

#[test]
fn a_roller_holds_one_component() {
    let roller = Support { held: [true, false], ..clamp() };
    let mut run = held_bar(roller, -50.0);
    let start = run.vectors("position");
    run.until(1e-3);
    let (support, now) = (run.values("support"), run.vectors("position"));
    for i in (0..now.len()).filter(|i| support[*i] > 0.0) {
        assert_eq!(now[i].x, start[i].x);
        assert!((now[i].y - start[i].y + 25e-6).abs() < 1e-9);
    }
    // Nothing is held along y.
    assert_eq!(run.probes()[1], 0.0);
}

#[test]
fn a_released_bar_falls_freely() {
    let mut run = held_bar(Support { release_time: Some(1e-3), ..clamp() }, -50.0);
    run.until(1e-3);
    assert!(run.probes()[1] > 0.0);
    let momentum = |run: &Run| run.vectors("velocity").iter().map(|v| v.y).sum::<f64>();
    let before = momentum(&run);
    run.until(2e-3);
    let fallen = (momentum(&run) - before) / 48.0;
    assert!((fallen + 50.0 * 1e-3).abs() < 1e-12, "{fallen}");
    assert_eq!(run.probes(), [0.0, 0.0]);
}

#[test]
fn a_support_moves_a_rigid_body_as_prescribed() {
    let mut setup = scene(SPACING);
    let x = block(Vector::zeros(), 6, 4, SPACING);
    add_body(&mut setup, Formulation::Rigid, &x);
    let support = Support { motion: Some(motion("0.1*t", "", "30*t")), ..clamp() };
    add_support(&mut setup, 0, support, |x| x.x < SPACING);
    add_probe(&mut setup, SolidProbeKind::Motion(0));
    add_probe(&mut setup, SolidProbeKind::Reaction(0, 0));
    let mut run = Run::new(setup, 1e-4);
    run.until(0.25);
    let (sine, cosine) = (30.0f64 * 0.25).sin_cos();
    let pivot = Vector::new(0.01, 0.0);
    for (now, start) in run.vectors("position").iter().zip(&x) {
        let arm = start - pivot;
        let turned = Vector::new(cosine * arm.x - sine * arm.y, sine * arm.x + cosine * arm.y);
        assert!((now - pivot - turned - Vector::new(0.025, 0.0)).norm() < 1e-14);
    }
    let probes = run.probes();
    // More than one turn: the angle continues.
    assert!((probes[4] - 7.5).abs() < 1e-12 && (probes[5] - 30.0).abs() < 1e-9, "{probes:?}");
    // Reaction = M a with a = −ω² r of the centre.
    let mass: f64 = run.values("mass").iter().sum();
    let arm = Vector::new(probes[0], probes[1]) - pivot - Vector::new(0.025, 0.0);
    let reaction = Vector::new(probes[6], probes[7]);
    // Difference quotient over Δt = 1e-4 s at ω = 30: centred half a step earlier, 1.5e-3 rad.
    assert!((reaction + arm * (mass * 900.0)).norm() < 3e-3 * reaction.norm());
    assert!(run.largest_residual < 1e-12);
}

#[test]
fn a_hinged_body_swings_as_a_physical_pendulum() {
    for stepping in [SolidStepping::Substeps(SubstepCount::Fixed(2)), SolidStepping::StageRule] {
        let mut setup = scene(0.01);
        setup.stepping = stepping;
        setup.run.body_force.gravity = Vector::new(0.0, -9.81);
        // 2 x 20 cells that hang from the origin, leant by a hundredth.
        let cells: Vec<Vector> = (0..40)
            .map(|k| Vector::new(0.01 * (k % 2) as f64 - 0.005, -0.01 * (k / 2) as f64 - 0.005))
            .map(|x| Vector::new(x.x - 0.01 * x.y, x.y + 0.01 * x.x))
            .collect();
        add_body(&mut setup, Formulation::Rigid, &cells);
        let pivot = Support { held: [false; 2], pivot: Some(Vector::zeros()), ..clamp() };
        add_support(&mut setup, 0, pivot, |_| false);
        let (mass, cell) = (setup.particles.mass[0], 1e-4 / 6.0);
        let inertia: f64 = cells.iter().map(|x| mass * (x.norm_squared() + cell)).sum();
        let period = std::f64::consts::TAU * (inertia / (40.0 * mass * 9.81 * 0.1)).sqrt();
        let mut run = Run::new(setup, period / 1000.0);
        let start = run.solver.state.rigid[0].centre;
        run.until(0.5 * period);
        let half = run.solver.state.rigid[0].centre;
        // The other side; an amplitude of a hundredth lengthens the period by 6e-6, steps by as little.
        assert!((half - Vector::new(-start.x, start.y)).norm() < 1e-3 * start.x.abs(), "{start} {half}");
        assert!(run.largest_residual < 1e-12, "{}", run.largest_residual);
        // The reaction turns the angular momentum, and does no work.
        run.until(period);
        let back = run.solver.state.rigid[0].centre;
        assert!((back - start).norm() < 1e-3 * start.x.abs(), "{start} {back}");
    }
}
