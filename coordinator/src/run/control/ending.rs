//! Failures of a run and how it ends.

use std::time::Duration;

use sph::coupling::driver::Command;
use sph::coupling::solver::{Fault, Role};
use sph::setup::BreachAction;

use super::Control;
use super::faults::{RANK_CONSEQUENCE, kind_of, rank};
use crate::failure::{Failure, Kind};
use crate::run::participants::Participants;

/// A loss within this time after a pause is its consequence: servers abort when the coordinator does not answer.
const PAUSE_MATTERS: Duration = Duration::from_secs(30);

/// How a run ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Ending {
    /// The end time was reached.
    Completed,
    /// Stopped from outside at a step boundary.
    Stopped,
    /// Out of order.
    Failed(Failure),
    /// A solver or the connection to it was lost: with the other, or another in its place, the run may continue.
    Lost {
        /// Solvers that were lost; none when only the connection between them was.
        roles: Vec<Role>,
        /// Step in which they were missed.
        step: u64,
        /// What happened.
        failure: Failure,
    },
}

impl Control {
    /// Acts on a broken balance as the case says.
    pub(super) fn breached(&mut self, failure: Failure, participants: &Participants) {
        match self.action {
            BreachAction::Warn => {}
            BreachAction::StopAndCheckpoint if self.can_save => {
                self.breach.get_or_insert(failure);
                self.stopping = true;
            }
            BreachAction::Stop | BreachAction::StopAndCheckpoint => {
                self.fail(failure);
                participants.command_all(Command::Abort);
            }
        }
    }

    pub(super) fn lost(&mut self, role: Role, mut failure: Failure, participants: &Participants) {
        if let Some((gap, _)) = self.interrupted.filter(|(_, when)| when.elapsed() < PAUSE_MATTERS) {
            let text = format!("; before that this coordinator did not run for {:.0} s", gap.as_secs_f64());
            failure.message.push_str(&text);
        }
        if !self.running.contains(&role) {
            // Its final report came already.
            return;
        }
        self.running.retain(|r| *r != role);
        match &mut self.failure {
            // Both are lost, whoever was missed first.
            Some(first) if failure.kind == Kind::Lost && !self.lost.is_empty() => {
                first.message.push_str(&format!("; lost the {role} solver too: {}", failure.message));
            }
            _ => {
                let step = self.lockstep.completed();
                self.fail(Failure::new(
                    failure.kind,
                    format!("lost the {role} solver after {step} completed steps: {}", failure.message),
                ));
            }
        }
        if failure.kind == Kind::Lost {
            self.lost.push(role);
        }
        participants.command_all(Command::Abort);
    }

    /// Keeps the first failure: what follows it are consequences.
    pub(super) fn fail(&mut self, failure: Failure) {
        self.failure.get_or_insert(failure);
    }

    /// Step in which a lost participant was missed: that in which its partner waited, where known.
    fn missed(&self) -> u64 {
        let waited = self.faults.iter().find_map(|(_, fault)| match fault {
            Fault::Peer { at, .. } | Fault::Aborted { at } => Some(at.step),
            _ => None,
        });
        waited.unwrap_or_else(|| self.lockstep.completed())
    }

    pub(super) fn ending(&mut self) -> Ending {
        if let Some((role, fault)) = self.faults.iter().min_by_key(|(_, fault)| rank(fault)) {
            // A participant that was only ordered to abort is not the cause.
            if self.failure.is_none() || rank(fault) < RANK_CONSEQUENCE {
                let failure = Failure::new(kind_of(fault), format!("{role} solver: {fault}"));
                return match fault {
                    Fault::Peer { at, .. } if !self.stopping => {
                        Ending::Lost { roles: Vec::new(), step: at.step, failure }
                    }
                    _ => Ending::Failed(failure),
                };
            }
        }
        if let Some(mut failure) = self.failure.take() {
            for (role, fault) in &self.faults {
                if let Fault::Peer { at, .. } | Fault::Aborted { at } = fault {
                    failure.message.push_str(&format!("; the {role} solver was in {at} then"));
                }
            }
            return if self.lost.is_empty() || self.stopping {
                Ending::Failed(failure)
            } else {
                Ending::Lost { roles: self.lost.clone(), step: self.missed(), failure }
            };
        }
        if let Some(breach) = self.breach.take() {
            return Ending::Failed(breach);
        }
        if !self.running.is_empty() {
            let roles: Vec<String> = self.running.iter().map(Role::to_string).collect();
            let message = format!("no final report from the {} solver", roles.join(" and the "));
            let failure = Failure::new(Kind::Lost, message);
            return Ending::Lost { roles: self.running.clone(), step: self.missed(), failure };
        }
        if self.finished.values().all(|reached_end| *reached_end) {
            Ending::Completed
        } else {
            Ending::Stopped
        }
    }
}
