//! The control loop of a run: grants, events, stops; outputs go to a writer.

pub mod ending;
mod faults;
pub mod lockstep;
mod stall;

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use proto::checkpoint::CheckpointData;
use sph::coupling::driver::{Command, Event, FailureReport, FinalReport};
use sph::coupling::ledger::{LedgerVector, TorqueCheck};
use sph::coupling::solver::{Fault, Role};
use sph::setup::{BreachAction, RunPlan};
use tokio::sync::mpsc::Receiver;
use tokio::time::Interval;

use crate::failure::{Failure, Kind};
use crate::results::recorder::Recorder;
use crate::results::writer::Writer;
use crate::run::checkpoint_scheduler::CheckpointScheduler;
use crate::run::control::lockstep::LockStep;
use crate::run::participants::{News, Participants};
use crate::run::signals::OutsideRequest;
use ending::Ending;
use stall::StepWatch;

/// A participant that does not end within this time after an abort is left behind.
const ABORT_DEADLINE: Duration = Duration::from_secs(20);

/// Time between looks at the own clock.
const TICK: Duration = Duration::from_secs(1);
/// From this time between two looks on, this process was stopped or starved.
const LONGEST_GAP: Duration = Duration::from_secs(5);

/// Where a run continues.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResumedAt {
    /// Completed steps.
    pub step: u64,
    /// Impulse that crossed the interface so far, on the fluid and on the solid \[N s/m\].
    pub impulse: [LedgerVector; 2],
}

/// How fast a run may and must go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// Largest number of steps granted ahead of the slowest participant; 1 is strict lock-step.
    pub window: u64,
    /// Least deadline of a step; it grows with the steps measured.
    pub step_deadline: Duration,
}

/// Drives `participants` to the end of the run.
///
/// `scheduler` takes checkpoints where all participants can save their state. A run that continues starts at `resumed`.
///
/// # Errors
/// When an output cannot be written; the participants have been ordered to abort.
pub async fn drive(
    participants: &mut Participants,
    run: &RunPlan,
    pace: Pace,
    resumed: Option<ResumedAt>,
    outputs: &Writer,
    scheduler: &mut CheckpointScheduler,
    requests: &mut Receiver<OutsideRequest>,
) -> Result<Ending, Failure> {
    let mut control = Control::new(participants.roles(), run, pace);
    control.can_save = participants.checkpoints;
    if let Some(resumed) = resumed {
        control.lockstep.resume(resumed.step, resumed.impulse);
        control.granted = resumed.step;
    }
    if control.can_save {
        participants.command_all(Command::Pause);
    }
    control.pace(participants, scheduler);
    let ending = control.run(participants, outputs, scheduler, requests).await;
    if ending.is_err() {
        participants.command_all(Command::Abort);
    }
    ending
}

/// A checkpoint that is being taken.
struct Taking {
    step: u64,
    sides: Vec<CheckpointData>,
}

fn ticks() -> Interval {
    let mut ticks = tokio::time::interval(TICK);
    ticks.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Skip);
    ticks
}

struct Control {
    lockstep: LockStep,
    action: BreachAction,
    window: u64,
    granted: u64,
    /// Participants that have not sent their last event.
    running: Vec<Role>,
    /// Those that have, and whether they reached the end time.
    finished: BTreeMap<Role, bool>,
    faults: Vec<(Role, Fault)>,
    failure: Option<Failure>,
    lost: Vec<Role>,
    /// A broken balance for which the run stops at a boundary.
    breach: Option<Failure>,
    /// A stop at a boundary was requested.
    stopping: bool,
    /// The participants have been ordered to.
    stop_sent: bool,
    steps: StepWatch,
    ticks: Interval,
    ticked: Instant,
    /// How long this process did not get to run, and when it did again.
    interrupted: Option<(Duration, Instant)>,
    can_save: bool,
    taking: Option<Taking>,
    /// A checkpoint is due at the end of the granted steps.
    checkpoint_due: bool,
    /// Boundary at which each participant pauses until it is ordered to stop.
    paused_at: BTreeMap<Role, u64>,
}

impl Control {
    fn new(roles: Vec<Role>, run: &RunPlan, pace: Pace) -> Self {
        Self {
            lockstep: LockStep::new(roles.clone(), run.ledger, TorqueCheck::of(run)),
            action: run.ledger.action,
            window: pace.window.max(1),
            granted: 0,
            running: roles,
            finished: BTreeMap::new(),
            faults: Vec::new(),
            failure: None,
            lost: Vec::new(),
            breach: None,
            stopping: false,
            stop_sent: false,
            steps: StepWatch::new(pace.step_deadline),
            ticks: ticks(),
            ticked: Instant::now(),
            interrupted: None,
            can_save: false,
            taking: None,
            checkpoint_due: false,
            paused_at: BTreeMap::new(),
        }
    }

    async fn run(
        &mut self,
        participants: &mut Participants,
        outputs: &Writer,
        scheduler: &mut CheckpointScheduler,
        requests: &mut Receiver<OutsideRequest>,
    ) -> Result<Ending, Failure> {
        let mut since = None;
        while !self.running.is_empty() {
            let aborting = self.failure.is_some() || !self.faults.is_empty();
            if aborting {
                since.get_or_insert_with(Instant::now);
            }
            let final_reports_by = since.unwrap_or_else(Instant::now) + ABORT_DEADLINE;
            tokio::select! {
                biased;
                // First: a coordinator that was stopped must know it before it treats others as silent.
                _ = self.ticks.tick() => self.tick(participants),
                Some(request) = requests.recv() => self.request(request, participants, scheduler),
                written = scheduler.written() => written?,
                news = participants.next_news() => {
                    let Some((role, news)) = news else { break };
                    match news {
                        Ok(News::Event(event)) => self.event(role, *event, participants, outputs, scheduler).await?,
                        Ok(News::Checkpoint(side)) => self.saved(*side, participants, outputs, scheduler).await?,
                        Err(failure) => self.lost(role, failure, participants),
                    }
                }
                () = tokio::time::sleep_until(final_reports_by.into()), if aborting => break,
            }
        }
        scheduler.finish().await?;
        Ok(self.ending())
    }

    /// Grants what may be granted, or asks for what is due at the boundary where all wait.
    fn pace(&mut self, participants: &Participants, scheduler: &mut CheckpointScheduler) {
        if self.taking.is_some() || self.stop_sent || self.failure.is_some() || !self.faults.is_empty() {
            return;
        }
        let completed = self.lockstep.completed();
        self.checkpoint_due |= self.can_save && scheduler.due_by_clock();
        let all_pause =
            self.paused_at.len() == self.running.len() && self.paused_at.values().all(|at| *at == completed);
        if all_pause || completed == self.granted {
            let ends = all_pause || self.stopping;
            let due = ends || self.checkpoint_due || scheduler.due_at(completed);
            if self.can_save && due && completed > 0 {
                self.checkpoint_due = false;
                self.taking = Some(Taking { step: completed, sides: Vec::new() });
                scheduler.requested();
                participants.ask_for_checkpoints(completed);
                return;
            }
            if ends {
                self.stop_sent = true;
                participants.command_all(Command::Stop);
                return;
            }
        }
        let closing = self.stopping || self.checkpoint_due || !self.paused_at.is_empty();
        if !closing && completed + self.window / 2 >= self.granted {
            let bound = if self.can_save { scheduler.bound(completed) } else { u64::MAX };
            let granted = (completed + self.window).min(bound);
            if granted > self.granted {
                self.granted = granted;
                participants.command_all(Command::GrantThrough(granted));
            }
        }
    }

    /// Takes one side's share of a checkpoint; with the last the solvers continue.
    async fn saved(
        &mut self,
        side: CheckpointData,
        participants: &Participants,
        outputs: &Writer,
        scheduler: &mut CheckpointScheduler,
    ) -> Result<(), Failure> {
        let Some(taking) = self.taking.as_mut() else { return Ok(()) };
        if side.header.step != taking.step {
            let (role, step, wanted) = (side.header.role, side.header.step, taking.step);
            self.fail(Failure::internal(format!(
                "the {role} solver saved its state at step {step}, wanted was step {wanted}"
            )));
            participants.command_all(Command::Abort);
            return Ok(());
        }
        taking.sides.push(side);
        if taking.sides.len() < participants.roles().len() {
            return Ok(());
        }
        let Some(Taking { step, mut sides }) = self.taking.take() else { return Ok(()) };
        sides.sort_by_key(|side| side.header.role);
        scheduler.write(step, sides, outputs).await?;
        if self.stopping || !self.paused_at.is_empty() {
            // A run that ends has its checkpoint on the disk before anything else happens.
            scheduler.finish().await?;
            self.stop_sent = true;
            participants.command_all(Command::Stop);
            return Ok(());
        }
        self.pace(participants, scheduler);
        Ok(())
    }

    /// Notes when this process did not get to run.
    fn tick(&mut self, participants: &Participants) {
        let gap = self.ticked.elapsed();
        self.ticked = Instant::now();
        if gap > LONGEST_GAP {
            self.interrupted = Some((gap, self.ticked));
            self.steps.rest();
        }
        self.find_stalled(participants);
    }

    fn request(
        &mut self,
        request: OutsideRequest,
        participants: &Participants,
        scheduler: &mut CheckpointScheduler,
    ) {
        match request {
            OutsideRequest::Checkpoint => {
                self.checkpoint_due |= self.can_save;
                self.pace(participants, scheduler);
            }
            OutsideRequest::AtBoundary => {
                self.stopping = true;
                self.pace(participants, scheduler);
            }
            OutsideRequest::Now => {
                self.stopping = true;
                self.fail(Failure::new(
                    Kind::Stopped,
                    "aborted at the second signal; outputs end where they are",
                ));
                participants.command_all(Command::Abort);
            }
        }
    }

    async fn event(
        &mut self,
        role: Role,
        event: Event,
        participants: &Participants,
        outputs: &Writer,
        scheduler: &mut CheckpointScheduler,
    ) -> Result<(), Failure> {
        match event {
            Event::Step(report) => {
                let Some(matched) = self.lockstep.report(role, report) else { return Ok(()) };
                self.steps.completed(&matched);
                let breach = matched.breaches.first().cloned();
                outputs.order(move |recorder| recorder.step(&matched)).await?;
                if let Some((side, breach)) = breach {
                    let whose = side.map(|role| format!(" of the {role}")).unwrap_or_default();
                    self.breached(Failure::new(Kind::Ledger, format!("{breach}{whose}")), participants);
                }
                self.pace(participants, scheduler);
            }
            Event::Paused(held) => {
                self.paused_at.insert(role, held.step);
                self.pace(participants, scheduler);
            }
            // Servers answer beside their events, threads by `News::Checkpoint`.
            Event::Checkpoint(_) => {}
            Event::Probes(values) => outputs.order(move |recorder| recorder.probes(role, values)).await?,
            Event::Snapshot(fields) => {
                outputs.order_frame(move |recorder| recorder.snapshot(role, fields)).await?;
            }
            Event::Finished(report) => {
                self.running.retain(|r| *r != role);
                self.finished.insert(role, report.reached_end);
                let FinalReport { state, counts, .. } = report;
                outputs.order_frame(move |recorder| recorder.final_state(role, &state, counts)).await?;
            }
            Event::Failed(report) => {
                let FailureReport { fault, state, counts, .. } = report;
                let divergence = match &fault {
                    Fault::Diverged(divergence) => Some(divergence.clone()),
                    _ => None,
                };
                let last_frame = move |recorder: &mut Recorder| {
                    recorder.final_state(role, &state, counts)?;
                    if let Some(divergence) = &divergence {
                        recorder.divergence(divergence, &state)?;
                    }
                    recorder.snapshot(role, state)
                };
                outputs.order_frame(last_frame).await?;
                if let Fault::Aborted { at } = &fault
                    && self.failure.is_none()
                    && self.faults.is_empty()
                {
                    // Not by an order from here.
                    let aborted = format!("it aborted the run at {at}");
                    self.lost(role, Failure::new(Kind::Lost, aborted), participants);
                    return Ok(());
                }
                self.running.retain(|r| *r != role);
                self.faults.push((role, fault));
                participants.command_all(Command::Abort);
            }
        }
        Ok(())
    }
}
