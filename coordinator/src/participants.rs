//! The participants of a run, whether they are threads or servers: commands to them, events from them.

use std::sync::mpsc;

use proto::client::CommandSender;
use sph::driver::{Command, Event};
use sph::solver::Role;
use tokio::sync::mpsc::Receiver;

use crate::failure::Failure;

/// The way to one participant.
pub enum CommandLine {
    /// A thread of this process.
    Thread(mpsc::Sender<Command>),
    /// A server.
    Server(CommandSender),
}

/// An event, or why there will be no more of them.
pub type EventResult = Result<Event, Failure>;

/// All participants of a run.
pub struct Participants {
    lines: Vec<(Role, CommandLine)>,
    events: Receiver<(Role, EventResult)>,
}

impl Participants {
    /// Participants that are reached by `lines` and heard through `events`.
    pub fn new(lines: Vec<(Role, CommandLine)>, events: Receiver<(Role, EventResult)>) -> Self {
        Self { lines, events }
    }

    /// Roles that are filled.
    pub fn roles(&self) -> Vec<Role> {
        self.lines.iter().map(|(role, _)| *role).collect()
    }

    /// Sends `command` to all; one that has ended takes none, and its last event tells why.
    pub fn command_all(&self, command: Command) {
        for (_, line) in &self.lines {
            match line {
                CommandLine::Thread(sender) => drop(sender.send(command)),
                CommandLine::Server(sender) => drop(sender.send(command)),
            }
        }
    }

    /// The next event of any participant; `None` when all have gone.
    pub async fn next_event(&mut self) -> Option<(Role, EventResult)> {
        self.events.recv().await
    }
}
