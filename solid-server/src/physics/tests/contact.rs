//! Contact between bodies and with walls, by repulsion and by the document's sums.

use sph::ledger::Account;
use sph::setup::{ContactLaw, Motion, SolidProbeKind, SolidSetup};
use sph::solver::Solver;
use sph::stage::Stage;
use sph::vector::Vector;

use super::scenes::{Run, add_elastic, add_probe, add_support, add_wall, block, clamp, scene, set_velocity};

const SPACING: f64 = 2e-3;

/// Two blocks of 6 x 6, a spacing apart, the left one moving at 2 m/s and shifted up by a third of a spacing.
fn collision(contact: ContactLaw) -> Run {
    let mut setup = scene(SPACING);
    setup.contact = contact;
    add_elastic(&mut setup, &block(Vector::new(-7.0 * SPACING, SPACING / 3.0), 6, 6, SPACING));
    add_elastic(&mut setup, &block(Vector::zeros(), 6, 6, SPACING));
    set_velocity(&mut setup, |x| if x.x < 0.0 { Vector::new(2.0, 0.0) } else { Vector::zeros() });
    add_probe(&mut setup, SolidProbeKind::Motion(0));
    add_probe(&mut setup, SolidProbeKind::Motion(1));
    add_probe(&mut setup, SolidProbeKind::Gap(None));
    Run::new(setup, 5e-6)
}

fn closest_pair(run: &Run) -> f64 {
    let x = run.vectors("position");
    let (a, b) = x.split_at(36);
    a.iter().flat_map(|a| b.iter().map(move |b| (a - b).norm())).fold(f64::INFINITY, f64::min)
}

#[test]
fn blocks_bounce_apart_and_keep_their_momentum() {
    let mut run = collision(super::scenes::REPULSION);
    let mut closest = f64::INFINITY;
    while run.time() < 4e-3 {
        run.step().unwrap();
        closest = closest.min(closest_pair(&run));
    }
    let probes = run.probes();
    let (left, right) = (probes[2], probes[8]);
    let gap = probes[12];
    assert!((gap - closest_pair(&run)).abs() < 1e-15 || gap.is_nan() && closest_pair(&run) > 3.0 * SPACING);
    assert!(probes[13].is_nan(), "there is no wall");
    assert!((left + right - 2.0).abs() < 1e-12, "{left} {right}");
    // They part, slower than they met.
    assert!(right - left > 0.5 && right - left < 2.0, "{left} {right}");
    assert!(closest > 0.5 * SPACING && closest < SPACING, "{closest}");
    assert!(run.largest_residual < 1e-12, "{}", run.largest_residual);
}

#[test]
fn contact_forces_of_a_pair_are_opposite_bit_for_bit_and_gone_after_parting() {
    let mut run = collision(super::scenes::REPULSION);
    let mut met = false;
    for _ in 0..800 {
        run.step().unwrap();
        let contact = &run.solver.workspace.contact;
        let touching: Vec<_> = contact.iter().filter(|sums| sums.stiffness > 0.0).collect();
        // With one pair in touch there are two forces.
        if touching.len() == 2 {
            assert_eq!(touching[0].bodies, -touching[1].bodies);
            met = true;
        }
        assert!(contact[..36].iter().all(|sums| sums.bodies.x <= 0.0), "pulls");
    }
    assert!(met);
    assert!(run.solver.workspace.contact.iter().all(|sums| sums.bodies == Vector::zeros()));
}

#[test]
fn blocks_also_meet_in_the_document_s_sums() {
    let mut run = collision(ContactLaw::Sums);
    let mut closest = f64::INFINITY;
    while run.time() < 4e-3 {
        run.step().unwrap();
        closest = closest.min(closest_pair(&run));
    }
    let probes = run.probes();
    assert!((probes[2] + probes[8] - 2.0).abs() < 1e-12);
    assert!(probes[8] > 0.5, "{}", probes[8]);
    assert!(closest > 0.5 * SPACING, "{closest}");
    assert!(run.largest_residual < 1e-12, "{}", run.largest_residual);
}

/// A floor of three layers whose surface is y = 0.
fn add_floor(setup: &mut SolidSetup) {
    add_wall(setup, &block(Vector::new(-15.0 * SPACING, -3.0 * SPACING), 30, 3, SPACING));
}

fn falling_block(contact: ContactLaw, height: f64) -> SolidSetup {
    let mut setup = scene(SPACING);
    setup.contact = contact;
    add_floor(&mut setup);
    add_elastic(&mut setup, &block(Vector::new(-6.0 * SPACING, height), 12, 6, SPACING));
    setup.run.body_force.gravity = Vector::new(0.0, -9.81);
    add_probe(&mut setup, SolidProbeKind::Motion(0));
    setup
}

#[test]
fn a_block_laid_on_the_floor_stays_there_and_the_floor_carries_its_weight() {
    for (contact, gap) in [(super::scenes::REPULSION, 0.0), (ContactLaw::Sums, 0.9 * SPACING)] {
        let mut run = Run::new(falling_block(contact, gap), 1e-5);
        let start = run.probes()[1];
        let mass: f64 = run.values("mass").iter().sum();
        let mut impulse = 0.0;
        while run.time() < 20e-3 {
            let books = run.step().unwrap();
            impulse += books[1].accounts.get(Account::WallContact).y * run.time_step;
        }
        let probes = run.probes();
        let carried = impulse / (mass * 9.81 * run.time());
        assert!((carried - 1.0).abs() < 0.25, "{contact:?}: {carried}");
        assert!((probes[1] - start).abs() < 0.5 * SPACING, "{contact:?}: {}", probes[1] - start);
        assert!(run.largest_residual < 1e-12, "{contact:?}: {}", run.largest_residual);
    }
}

#[test]
fn in_the_document_s_sums_walls_take_the_pressure_of_the_solid() {
    let first_pressures = |gravity: f64, wall_motion: &str| {
        let mut setup = falling_block(ContactLaw::Sums, 0.0);
        setup.run.body_force.gravity = Vector::new(0.0, gravity);
        setup.particles.density.iter_mut().for_each(|rho| *rho *= 1.001);
        let displacement = [String::new(), wall_motion.into()];
        setup.walls[0].motion = Some(Motion { displacement, angle: String::new(), pivot: Vector::zeros() });
        let mut run = Run::new(setup, 1e-6);
        let time = run.stage_time(Stage::Predictor);
        run.solver.begin_stage(&time).unwrap();
        run.solver.evaluate_own(&time);
        // The three layers below the middle of the block, from the top.
        [75, 45, 15].map(|w| run.solver.workspace.wall_pressure[w])
    };
    // 0.001 of 20 MPa; the third layer lies 3 spacings from the block, beyond the support of 2.6.
    let [top, middle, bottom] = first_pressures(0.0, "");
    assert!((top - 2e4).abs() < 1e-6 && (middle - 2e4).abs() < 1e-6, "{top} {middle}");
    assert_eq!(bottom, 0.0);
    let [top, middle, _] = first_pressures(-1e3, "");
    // ρ g times the kernel-weighted depth below the block's rows: only the lowest, 2 spacings up, reaches the second.
    let step = 1101.1 * 1e3 * SPACING;
    assert!(top > 2e4 + step && top < 2e4 + 1.5 * step, "{top}");
    assert!((middle - 2e4 - 2.0 * step).abs() < 1e-6, "{middle}");
    // A floor that falls as fast as gravity pulls adds nothing.
    let [top, middle, _] = first_pressures(-1e3, "-500*t^2");
    assert!((top - 2e4).abs() < 1e-6 && (middle - 2e4).abs() < 1e-6, "{top} {middle}");
}

#[test]
fn a_falling_block_does_not_pass_the_floor() {
    let mut setup = falling_block(super::scenes::REPULSION, 0.5 * SPACING);
    set_velocity(&mut setup, |_| Vector::new(0.0, -5.0));
    let mut run = Run::new(setup, 5e-6);
    let mut lowest = f64::INFINITY;
    while run.time() < 2e-3 {
        run.step().unwrap();
        lowest = run.vectors("position").iter().map(|x| x.y).fold(lowest, f64::min);
    }
    assert!(lowest > -0.2 * SPACING, "{lowest}");
    assert!(run.probes()[3] > 0.5, "bounces: {}", run.probes()[3]);
}

#[test]
fn a_clamp_does_not_feel_the_wall_it_enters_but_the_rest_of_the_wall_holds() {
    // At a distance of 1.5 spacings the first free row would feel the edge of the slot.
    let repulsion = ContactLaw::Repulsion { stiffness: 0.5, distance: 1.5, damping: 0.2 };
    for contact in [repulsion, ContactLaw::Sums] {
        let mut setup = scene(SPACING);
        setup.contact = contact;
        // A floor with a slot of four columns that three clamp rows fill.
        let floor: Vec<Vector> = block(Vector::new(-15.0 * SPACING, -3.0 * SPACING), 30, 3, SPACING)
            .into_iter()
            .filter(|x| x.x.abs() > 2.0 * SPACING)
            .collect();
        add_wall(&mut setup, &floor);
        add_elastic(&mut setup, &block(Vector::new(-2.0 * SPACING, -3.0 * SPACING), 4, 13, SPACING));
        add_support(&mut setup, 0, clamp(), |x| x.y < 0.0);
        set_velocity(&mut setup, |x| Vector::new(20.0 * x.y.max(0.0), 0.0));
        let mut run = Run::new(setup, 1e-5);
        for _ in 0..50 {
            let books = run.step().unwrap();
            assert_eq!(books[1].accounts.get(Account::WallContact), Vector::zeros());
        }
        let exempt =
            run.solver.model.bodies[0].wall_exemption.iter().filter(|until| **until == f64::INFINITY).count();
        assert!(exempt >= 12 && exempt < floor.len() / 2, "{exempt}");
    }
}

#[test]
fn a_moving_wall_pushes_until_it_is_released() {
    let mut setup = scene(SPACING);
    add_wall(&mut setup, &block(Vector::new(-3.0 * SPACING, -2.0 * SPACING), 3, 10, SPACING));
    let motion = Motion {
        displacement: ["0.5*t".into(), String::new()],
        angle: String::new(),
        pivot: Vector::zeros(),
    };
    setup.walls[0].motion = Some(motion);
    setup.walls[0].release_time = Some(5e-3);
    add_elastic(&mut setup, &block(Vector::zeros(), 6, 6, SPACING));
    add_probe(&mut setup, SolidProbeKind::Motion(0));
    let mut run = Run::new(setup, 1e-5);
    run.until(5e-3);
    let probes = run.probes();
    // The block rides ahead of the wall.
    assert!(probes[2] > 0.3, "{}", probes[2]);
    assert!(probes[0] - 6.0 * SPACING / 2.0 > 0.5 * 5e-3 - 0.2 * SPACING);
    let books = run.step().unwrap();
    assert_eq!(books[0].accounts.get(Account::WallContact), Vector::zeros());
    assert!(run.largest_residual < 1e-12, "{}", run.largest_residual);
}

#[test]
fn contact_tightens_the_time_step() {
    let mut setup = falling_block(super::scenes::REPULSION, -0.3 * SPACING);
    setup.contact = ContactLaw::Repulsion { stiffness: 5.0, distance: 1.0, damping: 0.2 };
    let mut run = Run::new(setup, 1e-6);
    let free = run.solver.time_step_limit();
    run.step().unwrap();
    assert!(run.solver.time_step_limit() < 0.5 * free);
}
