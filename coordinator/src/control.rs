//! The control loop of a run: grants, events, stops; outputs go to a recorder.

use std::collections::BTreeMap;
use std::time::Duration;

use sph::driver::{Command, Event, FinalReport};
use sph::ledger::TorqueCheck;
use sph::setup::{BreachAction, RunSetup};
use sph::solver::{Fault, Role};
use tokio::sync::mpsc::Receiver;

use crate::failure::{Failure, Kind};
use crate::lockstep::LockStep;
use crate::participants::Participants;
use crate::recorder::Recorder;

/// A participant that does not end within this time after the run was given up is left behind.
const ABORT_DEADLINE: Duration = Duration::from_secs(20);

/// A wish from outside to end the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopWish {
    /// At the end of the granted steps, outputs complete.
    AtBoundary,
    /// At once.
    Now,
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Ending {
    /// The end time was reached.
    Completed,
    /// Stopped from outside at a step boundary.
    Stopped,
    /// Out of order.
    Failed(Failure),
}

/// Drives `participants` to the end of the run.
///
/// `window` is the largest number of steps granted ahead of the slowest participant; 1 is strict lock-step.
///
/// # Errors
/// When an output cannot be written; the participants have been told to give up.
pub async fn drive(
    participants: &mut Participants,
    run: &RunSetup,
    window: u64,
    recorder: &mut Recorder<'_>,
    wishes: &mut Receiver<StopWish>,
) -> Result<Ending, Failure> {
    let mut control = Control::new(participants.roles(), run, window);
    participants.command_all(Command::GrantThrough(control.granted));
    let ending = control.run(participants, recorder, wishes).await;
    if ending.is_err() {
        participants.command_all(Command::Abort);
    }
    ending
}

struct Control {
    lockstep: LockStep,
    stop_on_breach: bool,
    window: u64,
    granted: u64,
    /// Participants that have not sent their last event.
    running: Vec<Role>,
    finished: BTreeMap<Role, FinalReport>,
    faults: Vec<(Role, Fault)>,
    failure: Option<Failure>,
    stopping: bool,
}

impl Control {
    fn new(roles: Vec<Role>, run: &RunSetup, window: u64) -> Self {
        Self {
            lockstep: LockStep::new(roles.clone(), run.ledger, TorqueCheck::of(run)),
            stop_on_breach: run.ledger.action == BreachAction::Stop,
            window: window.max(1),
            granted: window.max(1),
            running: roles,
            finished: BTreeMap::new(),
            faults: Vec::new(),
            failure: None,
            stopping: false,
        }
    }

    async fn run(
        &mut self,
        participants: &mut Participants,
        recorder: &mut Recorder<'_>,
        wishes: &mut Receiver<StopWish>,
    ) -> Result<Ending, Failure> {
        while !self.running.is_empty() {
            let given_up = self.failure.is_some() || !self.faults.is_empty();
            tokio::select! {
                biased;
                Some(wish) = wishes.recv() => self.wish(wish, participants),
                event = participants.next_event() => {
                    let Some((role, event)) = event else { break };
                    match event {
                        Ok(event) => self.event(role, event, participants, recorder)?,
                        Err(failure) => self.lost(role, failure, participants),
                    }
                }
                () = tokio::time::sleep(ABORT_DEADLINE), if given_up => break,
            }
        }
        Ok(self.ending())
    }

    fn wish(&mut self, wish: StopWish, participants: &Participants) {
        self.stopping = true;
        match wish {
            StopWish::AtBoundary => participants.command_all(Command::Stop),
            StopWish::Now => {
                self.fail(Failure::new(
                    Kind::Stopped,
                    "given up at the second signal; outputs end where they are",
                ));
                participants.command_all(Command::Abort);
            }
        }
    }

    fn event(
        &mut self,
        role: Role,
        event: Event,
        participants: &Participants,
        recorder: &mut Recorder<'_>,
    ) -> Result<(), Failure> {
        match event {
            Event::Step(report) => {
                let Some(matched) = self.lockstep.report(role, report) else { return Ok(()) };
                recorder.step(&matched)?;
                if let (Some((side, breach)), true) = (matched.breaches.first(), self.stop_on_breach) {
                    let whose = side.map(|role| format!(" of the {role}")).unwrap_or_default();
                    self.fail(Failure::new(Kind::Ledger, format!("{breach}{whose}")));
                    participants.command_all(Command::Abort);
                } else if self.lockstep.completed() + self.window / 2 >= self.granted && !self.stopping {
                    self.granted = self.lockstep.completed() + self.window;
                    participants.command_all(Command::GrantThrough(self.granted));
                }
            }
            Event::Probes(values) => recorder.probes(role, values)?,
            Event::Snapshot(fields) => recorder.snapshot(role, fields)?,
            Event::Finished(report) => {
                recorder.final_state(role, &report.state, report.counts)?;
                self.running.retain(|r| *r != role);
                self.finished.insert(role, report);
            }
            Event::Failed(report) => {
                recorder.final_state(role, &report.state, report.counts)?;
                recorder.snapshot(role, report.state)?;
                self.running.retain(|r| *r != role);
                self.faults.push((role, report.fault));
                participants.command_all(Command::Abort);
            }
        }
        Ok(())
    }

    fn lost(&mut self, role: Role, failure: Failure, participants: &Participants) {
        self.running.retain(|r| *r != role);
        let step = self.lockstep.completed();
        self.fail(Failure::new(
            failure.kind,
            format!("lost the {role} solver after {step} completed steps: {}", failure.message),
        ));
        participants.command_all(Command::Abort);
    }

    /// Keeps the first failure: what follows it are consequences.
    fn fail(&mut self, failure: Failure) {
        self.failure.get_or_insert(failure);
    }

    fn ending(&mut self) -> Ending {
        if let Some((role, fault)) = self.faults.iter().min_by_key(|(_, fault)| rank(fault)) {
            // A participant that was only told to give up is not the cause.
            if self.failure.is_none() || rank(fault) < RANK_CONSEQUENCE {
                return Ending::Failed(Failure::new(kind_of(fault), format!("{role} solver: {fault}")));
            }
        }
        if let Some(failure) = self.failure.take() {
            return Ending::Failed(failure);
        }
        if !self.running.is_empty() {
            let roles: Vec<String> = self.running.iter().map(Role::to_string).collect();
            let message = format!("no last word from the {} solver", roles.join(" and the "));
            return Ending::Failed(Failure::new(Kind::Lost, message));
        }
        if self.finished.values().all(|report| report.reached_end) {
            Ending::Completed
        } else {
            Ending::Stopped
        }
    }
}

/// From this rank on a fault is what another failure left behind.
const RANK_CONSEQUENCE: u8 = 5;

/// Causes before consequences: when one side diverges, the other only sees its partner go.
fn rank(fault: &Fault) -> u8 {
    match fault {
        Fault::Diverged(_) => 0,
        Fault::StaleFrame { .. } => 1,
        Fault::Ledger(_) => 2,
        Fault::Coverage { .. } => 3,
        Fault::Clock { .. } => 4,
        Fault::Peer { .. } => RANK_CONSEQUENCE,
        Fault::Aborted { .. } => RANK_CONSEQUENCE + 1,
    }
}

fn kind_of(fault: &Fault) -> Kind {
    match fault {
        Fault::Diverged(_) => Kind::Diverged,
        Fault::StaleFrame { .. } | Fault::Ledger(_) => Kind::Ledger,
        Fault::Coverage { .. } | Fault::Clock { .. } | Fault::Peer { .. } => Kind::Lost,
        Fault::Aborted { .. } => Kind::Stopped,
    }
}
