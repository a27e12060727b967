//! What a participant computes, as far as it can be judged from outside.

use sph::coupling::driver::StepReport;
use sph::coupling::ledger::{LedgerVector, TorqueCheck, imbalance, lifted};
use sph::coupling::solver::Role;
use sph::in_space;
use sph::setup::{
    CouplingKind, FluidSetup, ParameterSet, ParameterSpec, ParticipantSetup, RunPlan, SolidSetup,
};
use sph::space::Space;

use super::bench::{Bench, Record};
use super::dummy::Quirk;
use super::scene::{KERNEL, Scene};
use super::{Finding, not_offered, passed};
use crate::description::{Constants, OpenReport};

/// Relative round-off of sums over some hundred particles and steps: 1e-14 times some hundred.
const ROUND_OFF: f64 = 1e-12;
/// The same for what depends on differences of positions, which are 100 times smaller than positions.
const ROUND_OFF_OF_PAIRS: f64 = 1e-9;

/// Changes a run's set-up in one place.
type Change = fn(&mut RunPlan);

fn changed(setup: &ParticipantSetup, change: Change) -> ParticipantSetup {
    let (mut setup, mut plan) = (setup.clone(), setup.plan());
    change(&mut plan);
    match &mut setup {
        ParticipantSetup::Fluid(fluid) => in_space!(fluid, fluid => change_fluid(fluid, &plan)),
        ParticipantSetup::Solid(solid) => in_space!(solid, solid => change_solid(solid, &plan)),
    }
    setup
}

fn change_fluid<S: Space>(fluid: &mut FluidSetup<S>, plan: &RunPlan) {
    // A change leaves the dimensions as they are.
    if let Some(run) = plan.to_setup() {
        fluid.run = run;
    }
    if let Some(coupling) = &plan.coupling {
        let stated = |spec: &ParameterSpec| coupling.fluid.get(spec.key).filter(|_| spec.is_of_pair_law);
        fluid.parameters = fluid.parameters.with(stated);
    }
}

fn change_solid<S: Space>(solid: &mut SolidSetup<S>, plan: &RunPlan) {
    if let Some(run) = plan.to_setup() {
        solid.run = run;
    }
    if let Some(coupling) = &plan.coupling {
        solid.particle_spacing = coupling.solid_spacing;
    }
}

fn set_gravity(run: &mut RunPlan) {
    for (component, value) in run.body_force.gravity.iter_mut().zip([1.25, -3.7, 0.4]) {
        *component = value;
    }
}

pub(super) async fn constants(bench: &Bench) -> Finding {
    let setup = bench.fit(bench.still()).setup(bench.role);
    let changes: [(&str, Change); 6] = [
        ("as they are", |_| {}),
        ("gravity", set_gravity),
        ("end time", |run| run.time.end_time *= 2.0),
        ("domain", |run| run.domain.upper[1] = 1.5),
        ("sound speed", |run| run.coupling.iter_mut().for_each(|c| c.fluid.sound_speed = 22.5)),
        ("solid spacing", |run| run.coupling.iter_mut().for_each(|c| c.solid_spacing *= 1.1)),
    ];
    let mut wrong = Vec::new();
    for (what, change) in changes {
        let asked = changed(&setup, change);
        let (mut client, report) = bench.open(&asked).await.map_err(|e| format!("{what}: {e}"))?;
        client.close().await.map_err(|e| e.to_string())?;
        let OpenReport { role, coupling_kind, constants, .. } = &report;
        if *role != bench.role || *coupling_kind != bench.kind {
            wrong.push(format!("{what}: opened as {role}, coupled by {}", coupling_kind.name()));
        }
        if format!("{constants:?}") != format!("{:?}", Constants::of(&asked.plan())) {
            wrong.push(format!("{what}: the reply has {constants:?}"));
        }
        if constants.kernel != KERNEL {
            wrong.push(format!("{what}: the kernel is {}", constants.kernel));
        }
        if report.time_step_limit.is_nan() || report.time_step_limit <= 0.0 {
            wrong.push(format!("{what}: the time-step limit is {} s", report.time_step_limit));
        }
        if report.extent.boxes.is_empty() {
            wrong.push(format!("{what}: the extent is empty"));
        }
    }
    if wrong.is_empty() { passed(format!("{} set-ups", changes.len())) } else { Err(wrong.join("; ")) }
}

pub(super) async fn gravity(bench: &Bench) -> Finding {
    if !bench.takes_free_bodies {
        return not_offered("it takes clamped bodies only, which do not fall");
    }
    for gravity in [[0.0, -9.81, 0.0], [3.0, 1.5, -2.0]].map(|gravity| bench.vector(gravity)) {
        let scene = Scene { gravity, ..bench.still() };
        let record = bench.run_alone(scene).await?;
        let expected = gravity * scene.duration();
        let velocities = record.field(bench.space, "velocity")?;
        let mean = velocities.iter().sum::<LedgerVector>() / velocities.len().max(1) as f64;
        let off = |velocity: &LedgerVector, allowed: f64| {
            let error = (velocity - expected).norm() / expected.norm();
            error.is_nan() || error > allowed
        };
        // Stiffness makes forces of the round-off of positions, which cancel over the body.
        let particle = velocities.iter().find(|velocity| off(velocity, ROUND_OFF_OF_PAIRS));
        if let Some(velocity) = Some(&mean).filter(|mean| off(mean, ROUND_OFF)).or(particle) {
            return Err(format!(
                "in {gravity:?} m/s2 the velocity is {velocity:?} m/s after {} s, expected {expected:?}",
                scene.duration()
            ));
        }
    }
    passed("two gravities, all particles")
}

/// Sum of the sizes of all interface forces that a record reports \[N\].
fn gross(reports: &[StepReport]) -> f64 {
    reports.iter().flat_map(|report| &report.budgets).map(|budget| budget.interface.gross_force).sum()
}

pub(super) async fn free_flight(bench: &Bench) -> Finding {
    let velocity =
        if bench.takes_free_bodies { bench.vector([0.7, -0.3, 0.2]) } else { LedgerVector::zeros() };
    let scene = bench.fit(Scene { velocity, ..bench.still() });
    let [own, _] = bench.completed(scene, Quirk::default()).await?;
    if gross(&own.reports) != 0.0 {
        return Err(format!("forces of {:e} N in sum, without any pair", gross(&own.reports)));
    }
    let still = Scene { steps: 0, ..scene };
    let start = positions(&still.setup(bench.role));
    for (i, (from, to)) in start.iter().zip(own.field(bench.space, "position")?).enumerate() {
        let error = (to - from - velocity * scene.duration()).norm();
        if error.is_nan() || error > ROUND_OFF {
            return Err(format!("particle {i} is {error:e} m beside its path"));
        }
    }
    passed(format!("{} steps, no force", own.reports.len()))
}

fn positions(setup: &ParticipantSetup) -> Vec<LedgerVector> {
    match setup {
        ParticipantSetup::Fluid(fluid) => {
            in_space!(fluid, fluid => fluid.particles.position.iter().map(lifted).collect())
        }
        ParticipantSetup::Solid(solid) => {
            in_space!(solid, solid => solid.particles.position.iter().map(lifted).collect())
        }
    }
}

pub(super) async fn rest(bench: &Bench) -> Finding {
    let scene = bench.fit(Scene { touching: true, ..bench.still() });
    let [own, _] = bench.completed(scene, Quirk::default()).await?;
    let fastest = own.field(bench.space, "velocity")?.iter().map(|v| v.norm()).fold(0.0, f64::max);
    // Differences of equal numbers are zero; 1e-12 m/s leaves room for sums in another order.
    if fastest <= 1e-12 {
        passed(format!("fastest {fastest:.1e} m/s"))
    } else {
        Err(format!("it moves by itself with {fastest:e} m/s"))
    }
}

pub(super) async fn action_reaction(bench: &Bench) -> Finding {
    let [own, dummy] = bench.completed(bench.pushing(), Quirk::default()).await?;
    if gross(&own.reports) == 0.0 {
        return Err("no force is reported although water presses on the solid".into());
    }
    let (mut worst, mut momentum) = (0.0f64, 0.0f64);
    for (ours, theirs) in own.reports.iter().zip(&dummy.reports) {
        for (ours, theirs) in ours.budgets.iter().zip(&theirs.budgets) {
            let off = imbalance(&ours.interface, &theirs.interface, TorqueCheck::Central);
            worst = worst.max(off.force).max(off.torque);
            momentum = momentum.max(ours.momentum_residual());
            if off.force.is_nan() || off.torque.is_nan() || ours.momentum_residual().is_nan() {
                return Err("the momentum budget holds NaN".into());
            }
        }
    }
    if worst > ROUND_OFF {
        return Err(format!("forces or torques are off by {worst:.1e} of gross, allowed {ROUND_OFF:e}"));
    }
    if momentum > ROUND_OFF {
        return Err(format!(
            "the change of momentum is off by {momentum:.1e} of gross from the impulse of the forces, allowed {ROUND_OFF:e}"
        ));
    }
    passed(format!("balance {worst:.1e}, momentum budget {momentum:.1e} of gross"))
}

/// Largest difference of the forces of two runs, relative to gross; those of `other` are turned back by a quarter if
/// `turned`.
fn difference(one: &Record, other: &Record, turned: bool) -> Result<f64, String> {
    if one.reports.len() != other.reports.len() || one.reports.is_empty() {
        return Err(format!("{} and {} steps were reported", one.reports.len(), other.reports.len()));
    }
    let mut worst = 0.0f64;
    for (a, b) in one.reports.iter().zip(&other.reports) {
        for (a, b) in a.budgets.iter().zip(&b.budgets) {
            let force = b.interface.force;
            let back = if turned { LedgerVector::new(force.y, -force.x, force.z) } else { force };
            let off = (a.interface.force - back).norm() / a.interface.gross_force.max(f64::MIN_POSITIVE);
            worst = if off.is_nan() { f64::INFINITY } else { worst.max(off) };
        }
    }
    Ok(worst)
}

fn invariant(worst: f64) -> Finding {
    if worst <= ROUND_OFF_OF_PAIRS {
        passed(format!("forces agree to {worst:.1e} of gross"))
    } else {
        Err(format!("forces differ by {worst:.1e} of gross, allowed {ROUND_OFF_OF_PAIRS:e}"))
    }
}

pub(super) async fn galilean(bench: &Bench) -> Finding {
    if !bench.takes_free_bodies {
        return not_offered("it takes clamped bodies only, which cannot move with the water");
    }
    let scene = bench.pushing();
    let [still, _] = bench.completed(scene, Quirk::default()).await?;
    let moving = Scene { velocity: bench.vector([1.5, 0.5, -0.7]), ..scene };
    let [moving, _] = bench.completed(moving, Quirk::default()).await?;
    invariant(difference(&still, &moving, false)?)
}

pub(super) async fn quarter_turn(bench: &Bench) -> Finding {
    let scene = bench.pushing();
    let [upright, _] = bench.completed(scene, Quirk::default()).await?;
    let [turned, _] = bench.completed(Scene { turned: true, ..scene }, Quirk::default()).await?;
    invariant(difference(&upright, &turned, true)?)
}

/// The scene in `refinement` times as many steps.
fn refined(scene: Scene, refinement: u32) -> Scene {
    Scene { time_step: scene.time_step / f64::from(refinement), steps: scene.steps * refinement, ..scene }
}

/// Smallest order that counts as second: errors are not yet in their limit at these steps.
const SECOND_ORDER: f64 = 1.8;
/// A difference below this [m] is round-off and has no order.
const EXACT: f64 = 1e-14;

pub(super) async fn oscillator(bench: &Bench) -> Finding {
    if bench.role == Role::Fluid || bench.kind != CouplingKind::Loads {
        return not_offered(
            "only the forces on samples can be prescribed exactly: a solid that is coupled by loads",
        );
    }
    if !bench.takes_free_bodies {
        return not_offered("it takes clamped bodies only");
    }
    const RATE: f64 = 200.0;
    const AMPLITUDE: f64 = 1e-3;
    let scene = Scene { steps: 50, ..bench.still() };
    let quirk = Quirk { spring: Some((RATE, AMPLITUDE)), ..Quirk::default() };
    let start = positions(&scene.setup(bench.role));
    let exact = AMPLITUDE * ((RATE * scene.duration()).cos() - 1.0);
    let mut errors = Vec::new();
    for refinement in [1, 2, 4] {
        let [own, _] = bench.completed(refined(scene, refinement), quirk).await?;
        let ends = own.field(bench.space, "position")?;
        let mean = ends.iter().zip(&start).map(|(x, from)| x.x - from.x).sum::<f64>();
        errors.push((mean / start.len() as f64 - exact).abs());
    }
    let order = (errors[1] / errors[2]).log2();
    // The midpoint rule is off by (ω dt)²/6 of ω t amplitudes; ten times that is another method.
    let allowed = 10.0 * AMPLITUDE * (RATE * scene.time_step).powi(2);
    let text = format!("order {order:.2}; errors {:.1e}, {:.1e}, {:.1e} m", errors[0], errors[1], errors[2]);
    if errors[2] <= EXACT || order >= SECOND_ORDER && errors[0] < allowed { passed(text) } else { Err(text) }
}

pub(super) async fn convergence(bench: &Bench) -> Finding {
    let scene = Scene { steps: 40, ..bench.pushing() };
    let mut ends = Vec::new();
    // The first step resolves the waves of the solid.
    for refinement in [2, 4, 8] {
        let [own, _] = bench.completed(refined(scene, refinement), Quirk::default()).await?;
        ends.push(own.field(bench.space, "position")?);
    }
    let distance = |a: &[LedgerVector], b: &[LedgerVector]| {
        let squares: f64 = a.iter().zip(b).map(|(a, b)| (a - b).norm_squared()).sum();
        (squares / a.len().max(1) as f64).sqrt()
    };
    let (coarse, fine) = (distance(&ends[0], &ends[1]), distance(&ends[1], &ends[2]));
    let order = (coarse / fine).log2();
    let text = format!("order {order:.2}; differences {coarse:.1e}, {fine:.1e} m");
    if fine <= EXACT || order >= SECOND_ORDER { passed(text) } else { Err(text) }
}

pub(super) async fn determinism(bench: &Bench) -> Finding {
    if !bench.description.capabilities.deterministic {
        return not_offered("the capability `deterministic` is not declared");
    }
    let mut states = Vec::new();
    for _ in 0..2 {
        let [own, _] = bench.completed(bench.pushing(), Quirk::default()).await?;
        states.push(own.state);
    }
    // Debug of a float shows all its bits but those of a NaN.
    if format!("{:?}", states[0]) == format!("{:?}", states[1]) {
        passed("two runs, all bits of the final state")
    } else {
        Err("two runs of one set-up end in different states".into())
    }
}

pub(super) async fn latency(bench: &Bench) -> Finding {
    let scene = bench.fit(Scene { touching: true, steps: 200, ..bench.still() });
    let [_, dummy] = bench.completed(scene, Quirk::default()).await?;
    let mut half_steps: Vec<f64> = dummy.reports.iter().map(|report| 0.5e6 * report.elapsed).collect();
    half_steps.sort_unstable_by(f64::total_cmp);
    let at = |part: usize| half_steps.get(half_steps.len() * part / 100).copied().unwrap_or(f64::NAN);
    passed(format!("half-step {:.0} us in the middle, {:.0} us at 99 %", at(50), at(99)))
}
