use nalgebra::Rotation3;

use super::*;
use crate::coupling::ledger::{AngularBudget, axial};
use crate::coupling::stage::StepStage;
use crate::space::{Plane, Space, Vector};

const SPACING: f64 = 0.01;
const STEP: f64 = 1e-3;

/// A rigid block of 3 × 2 particles.
fn particles() -> PartnerParticles {
    let place = |k: u32| Vector::new(0.4 + SPACING * f64::from(k % 3), 0.5 + SPACING * f64::from(k / 3));
    PartnerParticles {
        id: (0..6).collect(),
        body: vec![0; 6],
        mass: vec![2.0; 6],
        position: (0..6).map(place).collect::<Column>(),
        bodies: vec![PartnerBody { name: "block".into(), cell_inertia: Some(1e-4), driven: false }],
    }
}

fn domain() -> DomainPlan {
    DomainPlan { lower: vec![0.0; 2], upper: vec![1.0; 2], periodic: vec![false; 2] }
}

fn audit() -> Audit {
    Audit::new(particles(), &domain(), CouplingKind::Loads, [SPACING, 1e-12], true)
}

/// The block after `time` \[s\] of an even fall, turning at `spin` \[rad/s\].
fn shown(time: f64, spin: f64) -> InterfaceStates<Plane> {
    let all = particles();
    let places: Vec<Vector> = all.position.quantities().collect();
    let centre = places.iter().sum::<Vector>() / 6.0;
    let velocity = Vector::new(0.3, -1.0);
    let turned = |arm: Vector, a: f64| {
        Vector::new(a.cos() * arm.x - a.sin() * arm.y, a.sin() * arm.x + a.cos() * arm.y)
    };
    let arms: Vec<Vector> = places.iter().map(|x| turned(x - centre, spin * time)).collect();
    InterfaceStates {
        id: all.id.clone(),
        group: all.body.clone(),
        mass: vec![1.0; 6],
        position: arms.iter().map(|arm| centre + velocity * time + arm).collect(),
        velocity: arms.iter().map(|arm| velocity + Vector::new(-arm.y, arm.x) * spin).collect(),
        ..InterfaceStates::default()
    }
}

fn at(step: u64, stage: Stage) -> StageTime {
    StageTime { at: StepStage { step, stage }, step_start: STEP * step as f64, time_step: STEP }
}

/// Shows `steps` steps of even motion, each frame altered by `alter`; `report` is that of every half-step.
fn observe(
    audit: &mut Audit,
    steps: u64,
    report: &MomentumReport,
    alter: impl Fn(u64, &mut InterfaceStates<Plane>),
) -> Result<(), String> {
    watch(audit, steps, report, |step, time| {
        let mut states = shown(time, 3.0);
        alter(step, &mut states);
        states
    })
}

/// Shows `steps` steps of the motion whose states at a step and a time \[s\] are `shown`.
fn watch<S: Space>(
    audit: &mut Audit,
    steps: u64,
    report: &MomentumReport,
    shown: impl Fn(u64, f64) -> InterfaceStates<S>,
) -> Result<(), String> {
    for step in 0..steps {
        for (stage, part) in [(Stage::Predictor, 0.0), (Stage::Corrector, 0.5)] {
            let states = shown(step, STEP * (step as f64 + part));
            let report = (step > 0 || stage == Stage::Corrector).then_some(report);
            let mut columns = StateColumns::default();
            states.write(&mut columns);
            audit.observe(&at(step, stage), &columns, report)?;
        }
    }
    Ok(())
}

/// What an even motion reports: nothing changes.
fn even() -> MomentumReport {
    MomentumReport {
        change: LedgerVector::zeros(),
        gross: 12.0,
        angular: Some(AngularBudget { change: axial(0.0), gross: 12.0 }),
    }
}

#[test]
fn an_even_motion_agrees_with_itself() {
    assert_eq!(observe(&mut audit(), 100, &even(), |_, _| {}), Ok(()));
}

#[test]
fn places_and_order_are_those_of_the_set_up() {
    let beside = observe(&mut audit(), 1, &even(), |_, states| {
        states.position.iter_mut().for_each(|x| x.x += 0.2 * SPACING);
    });
    assert!(beside.clone().unwrap_err().contains("2.000e-3 m beside its place"), "{beside:?}");
    let reversed = observe(&mut audit(), 1, &even(), |_, states| states.position.reverse());
    assert!(reversed.clone().unwrap_err().contains("place of particle 5"), "{reversed:?}");
    let foreign = observe(&mut audit(), 1, &even(), |_, states| states.id[5] = 9);
    assert!(foreign.clone().unwrap_err().contains("particle 9"), "{foreign:?}");
}

#[test]
fn masses_are_those_of_the_set_up_where_they_are_shown() {
    let mut states = Audit::new(particles(), &domain(), CouplingKind::States, [SPACING, 1e-12], true);
    let error = observe(&mut states, 1, &even(), |_, states| states.mass[2] *= 1.01).unwrap_err();
    assert!(error.contains("particle 0") && error.contains("mass"), "{error}");
}

#[test]
fn the_momentum_reported_is_that_of_the_motion_shown() {
    // The block reports a push that its velocities do not show.
    let push = MomentumReport { change: LedgerVector::new(1e-9, 0.0, 0.0), ..even() };
    let error = observe(&mut audit(), 1, &push, |_, _| {}).unwrap_err();
    assert!(error.contains("momentum changed by (1.0"), "{error}");
    let turn = MomentumReport { angular: Some(AngularBudget { change: axial(1e-9), gross: 12.0 }), ..even() };
    let error = observe(&mut audit(), 1, &turn, |_, _| {}).unwrap_err();
    assert!(error.contains("moment of inertia"), "{error}");
    // A deformable body that couples by loads may carry its mass elsewhere than its samples.
    let mut soft = particles();
    soft.bodies[0].cell_inertia = None;
    let mut soft = Audit::new(soft, &domain(), CouplingKind::Loads, [SPACING, 1e-12], true);
    assert_eq!(observe(&mut soft, 3, &push, |_, _| {}), Ok(()));
}

#[test]
fn velocities_at_rest_are_named_before_the_body_has_moved_far() {
    let mut soft = particles();
    soft.bodies[0].cell_inertia = None;
    let mut soft = Audit::new(soft, &domain(), CouplingKind::Loads, [SPACING, 1e-12], true);
    // At 1.04 m/s a tenth of a spacing is passed within the first step.
    let still = |_: u64, states: &mut InterfaceStates<Plane>| states.velocity.fill(Vector::zeros());
    let error = observe(&mut soft, 3, &even(), still).unwrap_err();
    assert!(error.contains("velocities shown lead"), "{error}");
}

#[test]
fn a_run_that_continues_is_not_held_against_the_start() {
    let mut later = Audit::new(particles(), &domain(), CouplingKind::Loads, [SPACING, 1e-12], false);
    let moved =
        |_: u64, states: &mut InterfaceStates<Plane>| states.position.iter_mut().for_each(|x| x.x += 0.1);
    assert_eq!(observe(&mut later, 3, &MomentumReport { angular: None, ..even() }, moved), Ok(()));
}

/// A rigid block of 2 × 2 × 2 particles in space after `time` \[s\] of turning about an oblique axis at `speed` \[rad/s\].
fn turning_in_space(time: f64, speed: f64) -> InterfaceStates<Spatial> {
    let axis = LedgerVector::new(1.0, 2.0, 2.0) / 3.0;
    let spin = axis * speed;
    let centre = LedgerVector::repeat(0.5);
    let arm =
        |k: u32| LedgerVector::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2)) * SPACING;
    let middle = LedgerVector::repeat(0.5 * SPACING);
    let turn = Rotation3::new(spin * time);
    let arms: Vec<LedgerVector> = (0..8).map(|k| turn * (arm(k) - middle)).collect();
    InterfaceStates {
        id: (0..8).collect(),
        group: vec![0; 8],
        mass: vec![2.0; 8],
        position: arms.iter().map(|arm| centre + arm).collect(),
        velocity: arms.iter().map(|arm| spin.cross(arm)).collect(),
        ..InterfaceStates::default()
    }
}

#[test]
fn a_spin_in_space_agrees_with_itself_and_a_torque_that_is_not_shown_is_named() {
    let start = turning_in_space(0.0, 3.0);
    let particles = PartnerParticles {
        id: start.id.clone(),
        body: start.group.clone(),
        mass: start.mass.clone(),
        position: start.position.iter().copied().collect(),
        bodies: vec![PartnerBody { name: "block".into(), cell_inertia: Some(1e-4), driven: false }],
    };
    let domain = DomainPlan { lower: vec![0.0; 3], upper: vec![1.0; 3], periodic: vec![false; 3] };
    let audit = || Audit::new(particles.clone(), &domain, CouplingKind::States, [SPACING, 1e-12], true);
    assert_eq!(watch(&mut audit(), 20, &even(), |_, time| turning_in_space(time, 3.0)), Ok(()));
    // Faster by a part in 1e6: the angular momentum of the particles and of their cells grows, about all axes.
    let faster = |step: u64, time| turning_in_space(time, if step < 1 { 3.0 } else { 3.0 + 3e-6 });
    let error = watch(&mut audit(), 2, &even(), faster).unwrap_err();
    assert!(error.contains("moment of inertia"), "{error}");
    // A cube turns about any axis with I ω: (2 · 8 · Δx²/2 + cells) · 3e-6 rad/s, of which the axis has a third along x.
    let change = (16.0 * 0.5 * SPACING * SPACING + 1e-4) * 3e-6;
    assert!(error.contains(&format!("{:.3e}", change / 3.0)[..4]), "{error} has not {change:e}");
}
