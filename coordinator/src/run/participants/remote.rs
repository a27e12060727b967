//! Participants that are servers: start or attach, handshake, link.

use std::path::Path;
use std::time::Duration;

use proto::description::{LinkPlan, Partner};
use proto::handshake;
use proto::recording::player::Replayed;
use proto::transport::client::{Deadlines, RunAccess};
use proto::transport::security::{ClientFiles, ClientSecurity};
use sph::coupling::audit::PartnerParticles;
use sph::coupling::exchange::Extent;
use sph::coupling::solver::Role;
use sph::in_space;
use sph::setup::{AnySolidSetup, CouplingKind, ParticipantSetup};
use tokio::sync::mpsc;

use super::frame_path::{FramePath, OpenPath};
use super::launch::{Launch, Server, Source};
use super::restore::Restore;
use super::server::{RemoteParticipant, at_start, describe};
use super::threads::Threads;
use super::{CommandChannel, News, NewsResult, Participants, hints};
use crate::failure::{Failure, Kind};
use crate::messages::Messages;
use crate::run::trace;

/// Events that may wait for the coordinator.
const PENDING_EVENTS: usize = 256;

/// Wait for a server to close a run.
const CLOSE_DEADLINE: Duration = Duration::from_secs(5);

/// How the process of a server ended.
#[derive(Clone, Debug)]
pub struct End {
    /// Side that it played.
    pub role: Role,
    /// Exit code or signal.
    pub status: String,
    /// The last lines of its log, where it was another program than this one; for the end of a message.
    pub last_words: String,
}

/// What servers are started with.
pub struct Start<'a> {
    /// Kinds of coupling that the run may use, the preferred one first.
    pub kinds: &'a [CouplingKind],
    /// Compute threads of each.
    pub threads: Threads,
    /// Folder of their logs.
    pub logs: &'a Path,
    /// Longest waits.
    pub deadlines: Deadlines,
    /// How servers are known and know this program.
    pub security: &'a ClientFiles,
    /// Where the run continues.
    pub restore: Option<Restore<'a>>,
    /// Counts the attempts at the run from 0.
    pub attempt: usize,
    /// The path of the frames.
    pub frame_path: FramePath<'a>,
    /// Folder for their parts of a trace, where one is wanted.
    pub trace: Option<&'a Path>,
    /// What is printed.
    pub messages: Messages,
}

/// What a server is started for.
pub struct Plan {
    /// Set-up of the run.
    pub setup: ParticipantSetup,
    /// Where the server comes from.
    pub source: Source,
}

/// All servers of a run.
pub struct Remote {
    /// Servers in the order of the plans.
    pub servers: Vec<RemoteParticipant>,
    frame_path: OpenPath,
}

impl Remote {
    /// Starts or attaches to the servers of `plans`, compares what they say, and links them. The run is coupled by the
    /// first of `with.kinds` that all servers offer.
    ///
    /// # Errors
    /// When a server cannot be started or reached, is no fitting solver, or refuses the set-up; all differences
    /// between both sides are named at once.
    pub async fn start(mut plans: Vec<Plan>, with: Start<'_>) -> Result<Self, Failure> {
        let holder = format!("coordinator, process {}", std::process::id());
        let access = RunAccess::new(&holder)?;
        let security = ClientSecurity::load(with.security).map_err(Failure::input)?;
        for warning in security.warnings().iter().filter(|_| with.attempt == 0) {
            with.messages.warning(warning);
        }
        let mut servers = Vec::new();
        for plan in &plans {
            let role = plan.setup.role();
            let part = with.trace.map(|folder| trace::part_of(folder, role, with.attempt));
            let launch = Launch {
                threads: with.threads.for_role(role),
                files: with.security,
                security: &security,
                logs: with.logs,
                trace: part.as_deref(),
            };
            let mut server = Server::start(role, &plan.source, launch).await?;
            match describe(&server, with.deadlines).await {
                Ok((client, description)) => servers.push((server, client, description)),
                Err(error) => return Err(hints::unreachable(error, &mut server).await),
            }
        }
        let descriptions: Vec<_> = servers.iter().map(|(_, _, description)| description).collect();
        let kind = handshake::coupling_kind(with.kinds, &descriptions);
        for (plan, (server, _, description)) in plans.iter_mut().zip(&servers) {
            let role = plan.setup.role();
            plan.setup.set_coupling_kind(kind);
            let reasons = handshake::unfit(description, role, &plan.setup.plan());
            if !reasons.is_empty() {
                let list = reasons.join("\n  ");
                let at = &server.address;
                return Err(Failure::server(format!(
                    "the server at {at} cannot be the {role} of this run:\n  {list}"
                )));
            }
        }
        let mut opened = Vec::new();
        for (plan, (server, mut client, description)) in plans.iter().zip(servers) {
            let role = plan.setup.role();
            let side = with.restore.map(|restore| restore.side_for(role, &description)).transpose()?;
            let saves = description.capabilities.checkpoint;
            let mut report = client.open(&plan.setup, &access).await.map_err(|e| at_start(role, e))?;
            if let (Some(side), Some(restore)) = (side, with.restore) {
                let restored = client.restore(&side, restore.epoch).await.map_err(|e| at_start(role, e))?;
                report.extent = restored.extent;
                report.time_step_limit = restored.time_step_limit;
            }
            opened.push(RemoteParticipant { report, server, client, saves });
        }
        let mut remote = Self { servers: opened, frame_path: OpenPath::Direct };
        let solid = plans.iter().find_map(|plan| match &plan.setup {
            ParticipantSetup::Solid(setup) => Some(setup),
            ParticipantSetup::Fluid(_) => None,
        });
        if let Err(failure) = remote.link(solid, with.frame_path, &access, &security).await {
            remote.end().await;
            return Err(failure);
        }
        Ok(remote)
    }

    /// The path of the frames, in words.
    pub fn frames(&self) -> String {
        match &self.frame_path {
            OpenPath::Direct => "directly between the solvers".into(),
            OpenPath::Relay { relay } => format!("relayed by the coordinator at {}", relay.address()),
            OpenPath::Player(_) => "those of the partner from a recording".into(),
        }
    }

    /// What came of a replay so far; `None` for a run of its own.
    pub fn replayed(&self) -> Option<Replayed> {
        match &self.frame_path {
            OpenPath::Player(player) => Some(player.replayed()),
            OpenPath::Direct | OpenPath::Relay { .. } => None,
        }
    }

    async fn link(
        &mut self,
        solid_setup: Option<&AnySolidSetup>,
        path: FramePath<'_>,
        access: &RunAccess,
        security: &ClientSecurity,
    ) -> Result<(), Failure> {
        let limits = self.servers.iter().map(|server| server.report.time_step_limit);
        let first_limit = limits.fold(f64::INFINITY, f64::min);
        let plan = |partner_extent: Extent, partner| LinkPlan {
            first_limit,
            partner_extent,
            partner,
            partner_particles: None,
        };
        if let Some(setup) = solid_setup {
            for server in self.servers.iter().filter(|server| server.report.role == Role::Solid) {
                let differences = handshake::other_bodies(setup, &server.report);
                if !differences.is_empty() {
                    let list = differences.join("\n  ");
                    return Err(Failure::server(format!(
                        "the solid server at {} does not move the bodies of the set-up:\n  {list}",
                        server.address()
                    )));
                }
            }
        }
        match self.servers.as_mut_slice() {
            [alone] => match path {
                FramePath::Recording(recording) => {
                    self.frame_path = OpenPath::Player(alone.replay(recording, access, security).await?);
                }
                FramePath::Direct | FramePath::Relay(_) => {
                    alone.client.link(&plan(Extent::default(), Partner::Alone)).await?
                }
            },
            [fluid, solid] => {
                let differences = handshake::mismatches(&fluid.report, &solid.report);
                if !differences.is_empty() {
                    let list = differences.join("\n  ");
                    return Err(Failure::server(format!(
                        "fluid and solid server do not fit each other:\n  {list}"
                    )));
                }
                let listens = plan(fluid.report.extent.clone(), Partner::Listen);
                solid.client.link(&listens).await.map_err(|e| at_start(Role::Solid, e))?;
                let mut dialled = solid.server.address.clone();
                if let FramePath::Relay(relayed) = path {
                    let relay = relayed.start(fluid, solid, first_limit).await?;
                    dialled = relay.address();
                    self.frame_path = OpenPath::Relay { relay };
                }
                let dials = LinkPlan {
                    partner_particles: solid_setup
                        .map(|setup| in_space!(setup, setup => PartnerParticles::of(setup))),
                    ..plan(solid.report.extent.clone(), Partner::Dial(dialled))
                };
                fluid.client.link(&dials).await.map_err(|e| at_start(Role::Fluid, e))?;
            }
            _ => return Err(Failure::internal("a run has one fluid and one solid server at most")),
        }
        Ok(())
    }

    /// Starts the run on all servers; they wait for a grant.
    ///
    /// # Errors
    /// When a server does not take it up.
    pub async fn run(&mut self) -> Result<Participants, Failure> {
        let (events, received) = mpsc::channel::<(Role, NewsResult)>(PENDING_EVENTS);
        let mut lines = Vec::new();
        let mut beats = Vec::new();
        for server in &mut self.servers {
            let role = server.report.role;
            let (commands, mut incoming) = server.client.run().await.map_err(|e| at_start(role, e))?;
            lines.push((role, CommandChannel::Server(commands, Box::new(server.client.clone()))));
            beats.push((role, incoming.beats()));
            let events = events.clone();
            tokio::spawn(async move {
                while let Some(event) = incoming.recv().await {
                    let event = event
                        .map(|event| News::Event(Box::new(event)))
                        .map_err(|e| Failure::new(Kind::Lost, e.to_string()));
                    if events.send((role, event)).await.is_err() {
                        return;
                    }
                }
            });
        }
        let checkpoints = self.servers.iter().all(|server| server.saves);
        Ok(Participants::new(lines, received, events, checkpoints).with_beats(beats))
    }

    /// How the processes of the servers of `roles` ended that were started for the run; those that have not are left out.
    pub async fn ends(&mut self, roles: &[Role]) -> Vec<End> {
        let mut ends = Vec::new();
        for server in self.servers.iter_mut().filter(|server| roles.contains(&server.report.role)) {
            let ended = server.server.ended().await;
            ends.extend(ended.map(|status| End {
                role: server.report.role,
                status: status.to_string(),
                last_words: server.server.last_words(),
            }));
        }
        ends
    }

    /// Ends the servers that were started for the run, those that do not answer too, and closes the run on the others.
    pub async fn kill(self) {
        for mut server in self.servers {
            if server.is_child() {
                server.server.kill().await;
            } else {
                // One that does not answer frees itself after its lease.
                let closing = tokio::time::timeout(CLOSE_DEADLINE, server.client.close());
                drop(closing.await);
            }
        }
    }

    /// Closes the run on all servers and ends those that were started for it.
    pub async fn end(self) {
        for mut server in self.servers {
            // The run is over either way; a server that does not answer in time is ended all the same, or frees itself.
            drop(tokio::time::timeout(CLOSE_DEADLINE, server.client.close()).await);
            server.server.end().await;
        }
    }
}
