//! Damaged, wrong and missing frames: each must be named, within the deadline, and leave the server usable.

use std::time::Duration;

use sph::coupling::driver::{Command, Event};
use sph::coupling::solver::{Fault, Role};
use sph::coupling::stage::{Stage, StepStage};
use sph::setup::CouplingKind;

use super::bench::{Bench, Coupled, Record, grant};
use super::dummy::Quirk;
use super::scene::Scene;
use super::{Finding, not_offered, passed};
use crate::Phase;
use crate::convert::Choice;
use crate::limits::MAX_FRAME_BYTES;
use crate::transport::relay::{Direction, Pass, Tap};
use crate::wire;

/// Half-step at which damage is done.
const AT: StepStage = StepStage { step: 3, stage: Stage::Corrector };

fn toward(role: Role) -> Direction {
    match role {
        Role::Fluid => Direction::ToFluid,
        Role::Solid => Direction::ToSolid,
    }
}

fn is_at(frame: &wire::Frame) -> bool {
    frame.farewell.is_none() && frame.step == AT.step && frame.stage == AT.stage.code()
}

/// A tap that hands each frame toward the participant to `act`, together with the one before it.
fn tap(role: Role, mut act: impl FnMut(wire::Frame, Option<&wire::Frame>) -> Pass + Send + 'static) -> Tap {
    let mut last: Option<wire::Frame> = None;
    Box::new(move |direction, frame| {
        if direction != toward(role) {
            return Pass::On(vec![frame]);
        }
        let kept = frame.clone();
        let pass = if is_at(&frame) { act(frame, last.as_ref()) } else { Pass::On(vec![frame]) };
        last = Some(kept);
        pass
    })
}

/// Runs with `tap` and `quirk`; the participant must fail with a fault whose words hold one of `names`.
async fn named(bench: &Bench, quirk: Quirk, tap: Option<Tap>, names: &[&str]) -> Finding {
    let [own, _] = bench.run_coupled(bench.pushing(), quirk, tap).await?;
    reported(&own, names)
}

fn reported(own: &Record, names: &[&str]) -> Finding {
    let Some(fault) = &own.fault else {
        return Err(format!("the run went on to its end, {} steps", own.steps));
    };
    if own.steps > AT.step + 1 {
        return Err(format!("reported only after step {}: {fault}", own.steps));
    }
    let text = fault.to_string();
    let lower = text.to_lowercase();
    if names.iter().any(|name| lower.contains(&name.to_lowercase())) {
        passed(text)
    } else {
        Err(format!("not called by its name ({}): {text}", names.join(" or ")))
    }
}

/// The participant's answer to one frame that `spoil` changed.
async fn spoilt(bench: &Bench, names: &[&str], spoil: fn(&mut wire::Frame)) -> Finding {
    let tap = tap(bench.role, move |mut frame, _| {
        spoil(&mut frame);
        Pass::On(vec![frame])
    });
    named(bench, Quirk::default(), Some(tap), names).await
}

pub(super) async fn truncated(bench: &Bench) -> Finding {
    spoilt(bench, &["bytes", "length", "truncated", "size"], |frame| {
        for block in frame.blocks.iter_mut().take(1) {
            block.data = block.data.slice(..block.data.len().saturating_sub(8));
        }
    })
    .await
}

pub(super) async fn checksum(bench: &Bench) -> Finding {
    spoilt(bench, &["digest", "checksum"], |frame| frame.digest ^= 1).await
}

pub(super) async fn not_a_number(bench: &Bench) -> Finding {
    let quirk = Quirk { not_a_number: Some(AT), ..Quirk::default() };
    named(bench, quirk, None, &["nan", "finite", "not a number"]).await
}

pub(super) async fn duplicate(bench: &Bench) -> Finding {
    let again = tap(bench.role, |frame, last| Pass::On(vec![last.cloned().unwrap_or(frame)]));
    named(bench, Quirk::default(), Some(again), &["duplicate", "expected"]).await
}

pub(super) async fn early(bench: &Bench) -> Finding {
    spoilt(bench, &["expected"], |frame| frame.step += 1).await
}

pub(super) async fn epoch(bench: &Bench) -> Finding {
    spoilt(bench, &["epoch"], |frame| frame.epoch += 1).await
}

pub(super) async fn clock(bench: &Bench) -> Finding {
    spoilt(bench, &["time step", "clock"], |frame| frame.time_step_s_bits += 1).await
}

pub(super) async fn oversize(bench: &Bench) -> Finding {
    // A limit of the transport may show as a lost partner: the size is what matters to the user.
    spoilt(bench, &["larger", "large", "size", "limit", "lost"], |frame| {
        for block in frame.blocks.iter_mut().take(1) {
            block.data = vec![0; MAX_FRAME_BYTES + 1].into();
        }
    })
    .await
}

pub(super) async fn sums(bench: &Bench) -> Finding {
    let tap = tap(bench.role, |mut frame, _| {
        let sums = frame.previous.as_mut().and_then(|previous| previous.sums.as_mut());
        if let Some(force) = sums.and_then(|sums| sums.force_n.as_mut()) {
            force.components[0] *= 1.001;
        }
        Pass::On(vec![frame])
    });
    let [own, _] = bench.run_coupled(bench.pushing(), Quirk::default(), Some(tap)).await?;
    match &own.fault {
        Some(Fault::Ledger(breach)) => passed(breach.to_string()),
        _ => reported(&own, &["ledger"]),
    }
}

pub(super) async fn provenance(bench: &Bench) -> Finding {
    let tap = tap(bench.role, |mut frame, _| {
        frame.previous.iter_mut().for_each(|previous| previous.used_digest ^= 1);
        Pass::On(vec![frame])
    });
    let [own, _] = bench.run_coupled(bench.pushing(), Quirk::default(), Some(tap)).await?;
    match &own.fault {
        Some(fault @ Fault::StaleFrame { .. }) => passed(fault.to_string()),
        _ => reported(&own, &["stale"]),
    }
}

pub(super) async fn vanished(bench: &Bench) -> Finding {
    let tap = tap(bench.role, |_, _| Pass::Cut);
    named(bench, Quirk::default(), Some(tap), &["lost", "ended", "farewell", "cancel", "broke"]).await
}

pub(super) async fn frozen(bench: &Bench) -> Finding {
    let tap: Tap = Box::new({
        let (role, mut silent) = (bench.role, false);
        move |direction, frame| {
            silent |= direction == toward(role) && is_at(&frame);
            let dropped = silent && direction == toward(role);
            Pass::On(if dropped { Vec::new() } else { vec![frame] })
        }
    });
    let mut run = bench.couple(bench.pushing(), Quirk::default(), Some(tap)).await?;
    run.commands.iter().for_each(grant);
    // A beat comes each second; the second one must show the wait.
    tokio::time::sleep(Duration::from_millis(2500)).await;
    let beat = run.events[0].latest_beat();
    drop(run.commands[0].send(Command::Abort));
    let own = bench.collect(&mut run.events[0]).await?;
    for client in &mut run.clients {
        drop(client.close().await);
    }
    let Some(beat) = beat else { return Err("no beat within 2.5 s".into()) };
    if beat.phase != Phase::WaitingForPartner {
        return Err(format!("while it waits for its partner its beats say {:?}", beat.phase));
    }
    match own.fault {
        Some(Fault::Aborted { .. }) => passed("beats say that it waits for its partner; the abort ends it"),
        Some(other) => Err(format!("after the abort it says: {other}")),
        None => Err("after the abort it says that it finished".into()),
    }
}

/// Particles whose states fill more than 4 MiB.
const MANY: u32 = 100_000;

pub(super) async fn large_frame(bench: &Bench) -> Finding {
    if bench.role == Role::Fluid || bench.kind == CouplingKind::Loads {
        return not_offered("the partner's frames are as small as its sets in this role and kind");
    }
    let scene = Scene { spare_water: MANY, steps: 2, ..bench.pushing() };
    let mut run = bench.couple(scene, Quirk::default(), None).await?;
    run.commands.iter().for_each(grant);
    let largest = largest_frame(bench, &mut run).await;
    for client in &mut run.clients {
        drop(client.close().await);
    }
    let largest = largest?;
    if largest > u64::from(MANY) {
        passed(format!("{largest} particles in a frame"))
    } else {
        Err(format!("{largest} particles were counted in the partner's frame, sent were more than {MANY}"))
    }
}

/// Particles of the partner in the largest frame of a run.
async fn largest_frame(bench: &Bench, run: &mut Coupled) -> Result<u64, String> {
    let mut largest = 0;
    loop {
        match tokio::time::timeout(bench.deadline, run.events[0].recv()).await {
            Ok(Some(Ok(Event::Step(report)))) => largest = report.interface_particles[1].max(largest),
            Ok(Some(Ok(Event::Finished(_)))) => return Ok(largest),
            Ok(Some(Ok(Event::Failed(report)))) => return Err(format!("{}", report.fault)),
            Ok(Some(Ok(_))) => {}
            Ok(Some(Err(error))) => return Err(error.to_string()),
            Ok(None) | Err(_) => return Err("the run does not come to its end".into()),
        }
    }
}
