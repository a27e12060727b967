//! The participants of a run, whether they are threads or servers: commands to them, events from them.

pub mod frame_path;
pub mod guard;
pub(crate) mod hints;
pub mod in_process;
pub mod launch;
mod logs;
pub mod remote;
pub mod restore;
pub mod server;
pub mod threads;

use std::sync::mpsc;

use proto::Beat;
use proto::checkpoint::CheckpointData;
use proto::transport::client::{CommandSender, ParticipantClient};
use sph::coupling::driver::{Command, Event};
use sph::coupling::solver::Role;
use tokio::sync::mpsc::{Receiver, Sender};
use tokio::sync::watch;

use crate::failure::{Failure, Kind};

/// Where commands to one participant go.
pub enum CommandChannel {
    /// A thread of this process.
    Thread(mpsc::Sender<Command>),
    /// A server.
    Server(CommandSender, Box<ParticipantClient>),
}

/// What a participant reports.
pub enum News {
    /// An event of its run.
    Event(Box<Event>),
    /// The checkpoint that it was asked for.
    Checkpoint(Box<CheckpointData>),
}

/// News, or why there will be no more of them.
pub type NewsResult = Result<News, Failure>;

/// All participants of a run.
pub struct Participants {
    lines: Vec<(Role, CommandChannel)>,
    news: Receiver<(Role, NewsResult)>,
    sender: Sender<(Role, NewsResult)>,
    /// Where signs of life of servers appear.
    beats: Vec<(Role, watch::Receiver<Option<Beat>>)>,
    /// Whether all of them can save their state.
    pub checkpoints: bool,
}

impl Participants {
    /// Participants that are reached by `lines` and heard through `news`, whose other end is `sender`.
    pub fn new(
        lines: Vec<(Role, CommandChannel)>,
        news: Receiver<(Role, NewsResult)>,
        sender: Sender<(Role, NewsResult)>,
        checkpoints: bool,
    ) -> Self {
        Self { lines, news, sender, beats: Vec::new(), checkpoints }
    }

    /// These, which are servers with the signs of life that appear in `beats`.
    pub fn with_beats(self, beats: Vec<(Role, watch::Receiver<Option<Beat>>)>) -> Self {
        Self { beats, ..self }
    }

    /// The last sign of life of the server that plays `role`.
    pub fn latest_beat(&self, role: Role) -> Option<Beat> {
        self.beats.iter().find(|(of, _)| *of == role).and_then(|(_, beats)| *beats.borrow())
    }

    /// Roles that are filled.
    pub fn roles(&self) -> Vec<Role> {
        self.lines.iter().map(|(role, _)| *role).collect()
    }

    /// Sends `command` to all; one that has ended takes none, and its last event says why.
    pub fn command_all(&self, command: Command) {
        for (_, line) in &self.lines {
            match line {
                CommandChannel::Thread(sender) => drop(sender.send(command)),
                CommandChannel::Server(sender, _) => drop(sender.send(command)),
            }
        }
    }

    /// Asks all for their state at the boundary of `step` completed steps, where they wait; it comes among the news.
    pub fn ask_for_checkpoints(&self, step: u64) {
        for (role, line) in &self.lines {
            match line {
                CommandChannel::Thread(sender) => drop(sender.send(Command::Checkpoint)),
                CommandChannel::Server(_, client) => {
                    let (role, mut client, sender) = (*role, client.as_ref().clone(), self.sender.clone());
                    tokio::spawn(async move {
                        let answer = client.checkpoint(step).await;
                        let news = answer
                            .map(|data| News::Checkpoint(Box::new(data)))
                            .map_err(|e| Failure::new(Kind::Lost, e.to_string()));
                        // A run that is over needs no checkpoint.
                        drop(sender.send((role, news)).await);
                    });
                }
            }
        }
    }

    /// The next news of any participant.
    pub async fn next_news(&mut self) -> Option<(Role, NewsResult)> {
        self.news.recv().await
    }
}
