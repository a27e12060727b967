//! Friction of bodies on walls and on each other.

use sph::setup::{SolidProbeKind, SolidSetup};
use sph::space::Vector;

use super::scenes::{Run, add_probe, add_total, add_wall, block, rough, scene, set_velocity};

const SPACING: f64 = 2e-3;

/// A block of 12 x 6 on the floor in gravity turned by an incline of tangent `slope`, at `speed` along it.
fn incline(friction: f64, slope: f64, speed: f64) -> SolidSetup {
    let mut setup = scene(SPACING);
    setup.contact = rough(friction);
    add_wall(&mut setup, &block(Vector::new(-15.0 * SPACING, -3.0 * SPACING), 60, 3, SPACING));
    add_total(&mut setup, 4, &block(Vector::new(-6.0 * SPACING, 0.0), 12, 6, SPACING));
    let length = (1.0 + slope * slope).sqrt();
    setup.run.body_force.gravity = Vector::new(slope, -1.0) * (9.81 / length);
    set_velocity(&mut setup, |_| Vector::new(speed, 0.0));
    add_probe(&mut setup, SolidProbeKind::Motion(0));
    add_probe(&mut setup, SolidProbeKind::Contact(None));
    setup
}

#[test]
fn a_block_slides_down_an_incline_by_coulomb_s_law_and_does_not_lock_into_the_lattice() {
    for friction in [0.0, 0.3] {
        let mut run = Run::new(incline(friction, 0.5, 0.05), 2e-5);
        run.until(0.02);
        let (start, from) = (run.probes()[2], run.time());
        run.until(0.12);
        let acceleration = (run.probes()[2] - start) / (run.time() - from);
        let expected = 9.81 * (0.5 - friction) / 1.25f64.sqrt();
        // 2 %: the block settles on the face during the first 20 ms and rocks a little afterwards.
        assert!((acceleration / expected - 1.0).abs() < 0.02, "{friction}: {acceleration} {expected}");
        let (impulse, mass) = (run.probes()[11], 72.0 * 1100.0 * SPACING * SPACING);
        let load = mass * 9.81 / 1.25f64.sqrt() * (1.0 + friction * friction).sqrt();
        // Forces on the particles of the face splay a little toward its ends.
        assert!((impulse / (load * run.time()) - 1.0).abs() < 0.1, "{friction}: {impulse}");
        assert!(run.largest_residual < 1e-12, "{}", run.largest_residual);
    }
}

#[test]
fn a_block_that_sticks_does_not_creep() {
    let mut setup = incline(0.6, 0.5, 0.0);
    // The undamped block rings and hops by micrometres when gravity sets in; a start without that.
    setup.damping = Some(sph::setup::Damping { rate: 2000.0, until: 0.02 });
    let mut run = Run::new(setup, 2e-5);
    run.until(0.03);
    let start = run.probes()[0];
    run.until(0.08);
    let probes = run.probes();
    // Held by springs: 1e-14 m by round-off, where sliding freely would take it 5 mm far.
    assert!((probes[0] - start).abs() < 1e-9 * SPACING, "{}", probes[0] - start);
}

#[test]
fn friction_turns_a_block_that_lands_at_an_angle_and_keeps_the_momentum_budget() {
    // Two bodies in free space, one sliding along the other: what one loses the other gains, spin included.
    let mut setup = scene(SPACING);
    setup.contact = rough(0.5);
    add_total(&mut setup, 4, &block(Vector::new(-15.0 * SPACING, -6.0 * SPACING), 30, 6, SPACING));
    add_total(&mut setup, 4, &block(Vector::new(-4.0 * SPACING, 0.3 * SPACING), 8, 8, SPACING));
    set_velocity(&mut setup, |x| if x.y > 0.0 { Vector::new(2.0, -1.0) } else { Vector::zeros() });
    add_probe(&mut setup, SolidProbeKind::Sums(None));
    add_probe(&mut setup, SolidProbeKind::Motion(0));
    let mut run = Run::new(setup, 1e-5);
    let before = run.probes();
    run.until(4e-3);
    let after = run.probes();
    let scale = before[1].hypot(before[2]);
    for k in [1, 2] {
        assert!((after[k] - before[k]).abs() < 1e-12 * scale, "momentum {k}");
    }
    // Scale: momentum times the half length of the lower body.
    assert!((after[3] - before[3]).abs() < 1e-11 * scale * 0.03, "{} {}", after[3], before[3]);
    let dragged = after[14];
    assert!(dragged > 0.05, "the lower body is dragged along: {dragged}");
    assert!(after[4] + after[6] < before[4], "contact takes energy out");
}
