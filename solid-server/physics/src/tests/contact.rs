//! Contact between bodies and with walls, by repulsion and by the sums of the source paper.

use nalgebra::Vector3;
use sph::coupling::ledger::{Account, LedgerVector};
use sph::coupling::saved::SavedState;
use sph::coupling::solver::Solver;
use sph::coupling::stage::Stage;
use sph::setup::{
    ContactLaw, ElasticParameters, Formulation, Motion, RepulsionParameters, SolidProbeKind, SolidSetup,
    SolidStepping, SubstepCount,
};
use sph::space::{Plane, Spatial, Vector, cross};

use crate::SolidSolver;
use crate::space::SolidSpace;
use crate::system::state::BodyContact;
use crate::system::workspace::Workspace;
use crate::time::limits::step_limit;

use super::scenes::{
    RUBBER, Run, add_body, add_elastic, add_probe, add_support, add_total, add_wall, block, brick, clamp,
    scene, scene_in, set_material, set_velocity,
};

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

/// A restored run builds its lists later than one that went through, so that other particles come first in them.
#[test]
fn a_collision_of_uneven_particles_does_not_depend_on_when_lists_were_built() {
    let uneven = || {
        let mut setup = scene(SPACING);
        setup.contact = super::scenes::REPULSION;
        add_total(&mut setup, 2, &block(Vector::new(-8.0 * SPACING, SPACING / 3.0), 6, 6, SPACING));
        add_total(&mut setup, 2, &block(Vector::zeros(), 6, 6, SPACING));
        add_wall(&mut setup, &block(Vector::new(0.2 * SPACING, -3.5 * SPACING), 24, 3, SPACING));
        for (k, mass) in setup.particles.mass.iter_mut().enumerate() {
            *mass *= 1.0 + 0.1 * (k as f64).sin();
        }
        set_velocity(&mut setup, |x| if x.x < 0.0 { Vector::new(6.0, 0.0) } else { Vector::new(0.0, -6.0) });
        setup
    };
    let mut whole = Run::new(uneven(), 5e-6);
    let mut touched = [false; 2];
    for moment in [1e-4, 2e-4, 3e-4, 4e-4, 5e-4, 6e-4] {
        whole.until(moment);
        let mut saved = SavedState::default();
        whole.solver.save(&mut saved);
        let mut restored = SolidSolver::new(uneven()).unwrap();
        restored.restore(&saved).unwrap();
        let mut continued = Run::new(uneven(), 5e-6);
        (continued.solver, continued.step) = (restored, whole.step);
        whole.until(moment + 1e-4);
        continued.until(moment + 1e-4);
        assert_eq!(whole.bits(), continued.bits(), "from {moment} s on");
        for forces in &whole.solver.workspace.contact_forces {
            touched[0] |= forces.bodies != Vector::zeros();
            touched[1] |= forces.walls != Vector::zeros();
        }
    }
    assert_eq!(touched, [true; 2]);
}

#[test]
fn bodies_that_are_drawn_too_near_start_without_a_kick_and_still_repel() {
    // A block 0.8 spacings over a wall and 0.8 from another block, staggered.
    let mut setup = scene(SPACING);
    add_total(&mut setup, 2, &block(Vector::new(0.0, -0.2 * SPACING), 6, 6, SPACING));
    add_total(&mut setup, 2, &block(Vector::new(5.8 * SPACING, 0.3 * SPACING), 6, 6, SPACING));
    add_wall(&mut setup, &block(Vector::new(-4.0 * SPACING, -3.0 * SPACING), 24, 3, SPACING));
    add_probe(&mut setup, SolidProbeKind::Motion(0));
    let mut run = Run::new(setup.clone(), 5e-6);
    let remarks = run.solver.remarks();
    assert_eq!(remarks.len(), 2, "{remarks:?}");
    assert!(
        remarks.iter().any(|remark| remark.contains("`body0`") && remark.contains("a wall")),
        "{remarks:?}"
    );
    assert!(remarks.iter().any(|remark| remark.contains("`body1`")), "{remarks:?}");
    run.until(2e-4);
    // Without the start depths: 4 m/s after a tenth of that.
    assert!(run.vectors("velocity").iter().all(|v| v.norm() < 1e-9), "{:?}", run.probes());
    // Pressed onto the wall it still rebounds, before it has gone through the remaining distance.
    set_velocity(&mut setup, |x| if x.x < 5.8 * SPACING { Vector::new(0.0, -2.0) } else { Vector::zeros() });
    let mut run = Run::new(setup, 5e-6);
    let mut lowest = f64::INFINITY;
    while run.time() < 4e-3 {
        run.step().unwrap();
        lowest = run.vectors("position").iter().map(|x| x.y).fold(lowest, f64::min);
    }
    assert!(run.probes()[3] > 0.5, "{:?}", run.probes());
    assert!(lowest > -0.5 * SPACING, "{lowest}");
}

#[test]
fn contact_has_neither_resultant_nor_torque_and_is_gone_after_parting() {
    for law in [super::scenes::REPULSION, super::scenes::rough(0.4)] {
        let mut run = collision(law);
        let mut met = 0;
        for _ in 0..800 {
            run.step().unwrap();
            let Workspace { contact_forces: contact, stage, .. } = &run.solver.workspace;
            let gross: f64 = contact.iter().map(|sums| sums.bodies.norm()).sum();
            let force: Vector = contact.iter().map(|sums| sums.bodies).sum();
            let torque: f64 =
                contact.iter().zip(&stage.position).map(|(sums, x)| cross(x, &sums.bodies)).sum();
            assert!(force.norm() <= 1e-13 * gross, "{force} of {gross}");
            // Arms up to ten spacings.
            assert!(torque.abs() <= 1e-12 * gross * SPACING, "{torque} of {gross}");
            let push: Vector = contact[..36].iter().map(|sums| sums.bodies).sum();
            assert!(push.x <= 0.0, "pulls");
            met += usize::from(gross > 0.0);
        }
        assert!(met > 50, "{met}");
        assert!(run.solver.workspace.contact_forces.iter().all(|sums| sums.bodies == Vector::zeros()));
        let contact = BodyContact::all(&run.solver.state.last.contacts);
        // Two bodies of 0.158 kg/m that exchange more than half of 2 m/s: at least 0.4 N s/m on each.
        assert!(
            contact.impulse > 0.4 && contact.deepest > 0.0 && contact.deepest < 0.6 * SPACING,
            "{contact:?}"
        );
    }
}

#[test]
fn blocks_also_collide_in_the_sums_of_the_source_paper() {
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
            let budget = run.step().unwrap();
            impulse += budget[1].accounts.get(Account::WallContact).force.y * run.time_step;
        }
        let probes = run.probes();
        let carried = impulse / (mass * 9.81 * run.time());
        assert!((carried - 1.0).abs() < 0.25, "{contact:?}: {carried}");
        assert!((probes[1] - start).abs() < 0.5 * SPACING, "{contact:?}: {}", probes[1] - start);
        assert!(run.largest_residual < 1e-12, "{contact:?}: {}", run.largest_residual);
    }
}

#[test]
fn in_the_sums_of_the_source_paper_walls_take_the_pressure_of_the_solid() {
    let first_pressures = |gravity: f64, wall_motion: &str| {
        let mut setup = falling_block(ContactLaw::Sums, 0.0);
        setup.run.body_force.gravity = Vector::new(0.0, gravity);
        setup.particles.density.iter_mut().for_each(|rho| *rho *= 1.001);
        let displacement = [String::new(), wall_motion.into()];
        setup.walls[0].motion =
            Some(Motion { displacement, angle: String::new(), axis: 1.0, pivot: Vector::zeros() });
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
fn a_clamp_is_not_in_contact_with_the_wall_it_enters_but_the_rest_of_the_wall_holds() {
    // At a distance of 1.5 spacings the first free row would feel the edge of the slot.
    let repulsion = ContactLaw::Repulsion(RepulsionParameters {
        stiffness: 0.5,
        distance: 1.5,
        self_contact: false,
        ..RepulsionParameters::default()
    });
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
            let budget = run.step().unwrap();
            assert_eq!(budget[1].accounts.get(Account::WallContact).force, LedgerVector::zeros());
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
        // Once released it dashes through where the block is.
        displacement: ["0.5*t + 20*ramp(t - 0.005)".into(), String::new()],
        angle: String::new(),
        axis: 1.0,
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
    for _ in 0..50 {
        let budget = run.step().unwrap();
        assert_eq!(budget[1].accounts.get(Account::WallContact).force, LedgerVector::zeros());
    }
    assert!(run.largest_residual < 1e-12, "{}", run.largest_residual);
}

#[test]
fn contact_tightens_the_time_step() {
    let mut setup = falling_block(super::scenes::REPULSION, 0.0);
    setup.particles.velocity.iter_mut().for_each(|v| *v = Vector::new(0.0, -1.0));
    setup.contact = ContactLaw::Repulsion(RepulsionParameters {
        stiffness: 5.0,
        distance: 1.0,
        self_contact: true,
        ..RepulsionParameters::default()
    });
    let mut run = Run::new(setup, 1e-6);
    // Not the solver's whole limit, which counts accelerations too.
    let limit = |run: &Run| step_limit(&run.solver.model, &run.solver.state);
    let free = limit(&run);
    // On its way half a spacing into the floor and back.
    let tightest = (0..1000).map(|_| {
        run.step().unwrap();
        limit(&run)
    });
    let tightest = tightest.fold(f64::INFINITY, f64::min);
    assert!(tightest < 0.5 * free, "{tightest} {free}");
}

#[test]
fn a_body_bent_into_a_horseshoe_does_not_pass_through_itself() {
    // The free ends of a ring with a gap run at each other.
    let horseshoe = |law: ContactLaw| {
        let mut setup = scene(SPACING);
        setup.contact = law;
        let particles: Vec<Vector> = block(Vector::new(-20.0 * SPACING, -20.0 * SPACING), 40, 40, SPACING)
            .into_iter()
            .filter(|x| x.norm() < 0.036 && x.norm() > 0.028 && (x.x < 0.0 || x.y.abs() > 1.6 * SPACING))
            .collect();
        add_total(&mut setup, 4, &particles);
        set_velocity(&mut setup, |x| Vector::new(0.0, -8.0 * x.y.signum() * (x.x / 0.036).max(0.0)));
        let count = particles.len();
        let mut run = Run::new(setup, 1e-5);
        let mut closest = f64::INFINITY;
        while run.time() < 8e-3 {
            run.step().unwrap();
            let x = run.vectors("position");
            for i in 0..count {
                for j in (0..i).filter(|j| (particles[i] - particles[*j]).norm() > 4.5 * SPACING) {
                    closest = closest.min((x[i] - x[j]).norm());
                }
            }
        }
        (closest / SPACING, run.largest_residual)
    };
    let (closest, residual) = horseshoe(super::scenes::REPULSION);
    assert!(closest > 0.5 && closest < 1.1, "{closest}");
    assert!(residual < 1e-12, "{residual}");
    let blind = ContactLaw::Repulsion(RepulsionParameters {
        stiffness: 0.5,
        distance: 1.0,
        self_contact: false,
        ..RepulsionParameters::default()
    });
    assert!(horseshoe(blind).0 < 0.4, "without self-contact the ends pass through each other");
}

#[test]
fn an_updated_lagrangian_block_bounces_off_a_total_lagrangian_plate() {
    let mut setup = scene(SPACING);
    add_total(&mut setup, 4, &block(Vector::new(-24.0 * SPACING, -6.0 * SPACING), 48, 6, SPACING));
    add_support(&mut setup, 0, clamp(), |x| x.x.abs() > 20.0 * SPACING);
    add_elastic(&mut setup, &block(Vector::new(-4.0 * SPACING, 0.5 * SPACING), 8, 8, SPACING));
    set_velocity(&mut setup, |x| if x.y > 0.0 { Vector::new(0.0, -4.0) } else { Vector::zeros() });
    add_probe(&mut setup, SolidProbeKind::Motion(1));
    add_probe(&mut setup, SolidProbeKind::Gap(None));
    add_probe(&mut setup, SolidProbeKind::Reaction(0, 0));
    let mut run = Run::new(setup, 1e-5);
    let (mut closest, mut reaction) = (f64::INFINITY, 0.0);
    while run.time() < 15e-3 {
        run.step().unwrap();
        let probes = run.probes();
        closest = closest.min(probes[6]);
        reaction += probes[9] * run.time_step;
    }
    let after = run.probes();
    assert!(after[3] > 1.0 && after[3] < 4.0, "bounces: {}", after[3]);
    // Mirror symmetry about x = 0 up to the order in which sums round.
    assert!(after[2].abs() < 1e-9 && after[5].abs() < 1e-6, "{} {}", after[2], after[5]);
    assert!(closest > 0.5 * SPACING, "{closest}");
    assert!(reaction > 0.0, "the clamps take up the block's momentum");
    assert!(run.largest_residual < 1e-12, "{}", run.largest_residual);
}

/// A rigid block that falls by six spacings onto a wall, without friction or damping, in steps of 0.8 of the stated limit.
///
/// Nothing but the contact limits its steps, and that only where it acts: the first step is that of free fall.
fn land<S: SolidSpace>(
    bulk_modulus: f64,
    stepping: SolidStepping,
    block: &[S::Vector],
    floor: &[S::Vector],
) -> (f64, f64) {
    let mut setup = scene_in::<S>(SPACING);
    if let ContactLaw::Repulsion(law) = &mut setup.contact {
        law.damping = 0.0;
    }
    setup.stepping = stepping;
    add_body(&mut setup, Formulation::Rigid, block);
    add_wall(&mut setup, floor);
    set_material(&mut setup, ElasticParameters { bulk_modulus, ..RUBBER });
    setup.run.body_force.gravity[1] = -9.81;
    add_probe(&mut setup, SolidProbeKind::Motion(0));
    add_probe(&mut setup, SolidProbeKind::Gap(None));
    let mut run = Run::new(setup, 1e-5);
    let energy = |probes: &[f64]| 9.81 * probes[1] + 0.5 * probes[S::DIMENSIONS + 1].powi(2);
    let (start, fall) = (energy(&run.probes()), 6.0 * SPACING);
    let (mut lowest, mut highest) = (f64::INFINITY, f64::NEG_INFINITY);
    let mut elapsed = 0.0;
    while elapsed < 0.06 {
        run.time_step = 0.8 * run.solver.time_step_limit();
        elapsed += run.time_step;
        run.step().unwrap();
        let probes = run.probes();
        let gap = probes[probes.len() - 1];
        lowest = if gap.is_nan() { lowest } else { lowest.min(gap) };
        // In contact a part of the energy is in its springs.
        if gap.is_nan() || gap > SPACING {
            highest = highest.max(energy(&probes));
        }
    }
    let last = energy(&run.probes());
    assert!(run.largest_residual < 1e-12, "{}", run.largest_residual);
    ((highest.max(last) - start) / (9.81 * fall), lowest / SPACING)
}

#[test]
fn rigid_blocks_of_any_modulus_land_and_rebound_in_steps_of_the_stated_limit() {
    let (side, depth) = (8, 3);
    let square = block(Vector::new(-4.0, 6.0) * SPACING, side, side, SPACING);
    let ground = block(Vector::new(-10.0, -3.0) * SPACING, 20, depth, SPACING);
    let cube = brick(Vector3::new(-4.0, 6.0, -4.0) * SPACING, [side; 3], SPACING);
    let plate = brick(Vector3::new(-10.0, -3.0, -10.0) * SPACING, [20, depth, 20], SPACING);
    for bulk_modulus in [1e6, 1e8, 1e10] {
        for stepping in [SolidStepping::Substeps(SubstepCount::Automatic), SolidStepping::StageRule] {
            // The midpoint rule takes steps as short as the sub-steps would be.
            if stepping == SolidStepping::StageRule && bulk_modulus > 1e9 {
                continue;
            }
            for (gain, lowest) in [
                land::<Plane>(bulk_modulus, stepping, &square, &ground),
                land::<Spatial>(bulk_modulus, stepping, &cube, &plate),
            ] {
                // 1 %: some 20 sub-steps for a rebound, whose contact sets in within one of them.
                assert!(gain.abs() < 0.01, "{bulk_modulus:e}, {stepping:?}: {gain}");
                assert!(lowest > 0.2, "{bulk_modulus:e}, {stepping:?}: {lowest}");
            }
        }
    }
}
