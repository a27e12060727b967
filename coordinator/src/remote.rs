//! Participants that are servers: start or attach, handshake, link.

use std::path::{Path, PathBuf};

use proto::client::{Deadlines, ParticipantClient, RunAccess};
use proto::description::{LinkPlan, OpenReport, Partner};
use proto::{RpcCode, RpcError, handshake};
use sph::exchange::Extent;
use sph::setup::{CouplingKind, ParticipantSetup};
use sph::solver::Role;
use tokio::sync::mpsc;

use crate::failure::{Failure, Kind};
use crate::launch::{Server, Source};
use crate::output::process::Process;
use crate::participants::{CommandLine, EventResult, Participants};

/// Events that may wait for the coordinator.
const PENDING_EVENTS: usize = 256;

/// One server with its connection and what it said.
pub struct RemoteParticipant {
    /// Its answer to the set-up.
    pub report: OpenReport,
    server: Server,
    client: ParticipantClient,
}

impl RemoteParticipant {
    /// Address at which it was reached.
    pub fn address(&self) -> &str {
        &self.server.address
    }

    /// Resources used so far, where the server is a child of this process.
    pub fn process(&self) -> Process {
        self.server.process_id().map(Process::of).unwrap_or_default()
    }
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
}

fn role_of(setup: &ParticipantSetup) -> Role {
    match setup {
        ParticipantSetup::Fluid(_) => Role::Fluid,
        ParticipantSetup::Solid(_) => Role::Solid,
    }
}

impl From<RpcError> for Failure {
    fn from(error: RpcError) -> Self {
        let kind = match error.code {
            RpcCode::InvalidArgument => Kind::Input,
            _ => Kind::Server,
        };
        Failure::new(kind, error.to_string())
    }
}

impl Remote {
    /// Starts or attaches to the servers of `plans`, compares what they say, and links them. The run is coupled by the
    /// first of `kinds` that all servers offer.
    ///
    /// # Errors
    /// When a server cannot be started or reached, is no fitting solver, or refuses the set-up; all differences
    /// between both sides are named at once.
    pub async fn start(
        mut plans: Vec<Plan>,
        kinds: &[CouplingKind],
        threads: Option<usize>,
        logs: &Path,
    ) -> Result<Self, Failure> {
        let holder = format!("coordinator, process {}", std::process::id());
        let access = RunAccess::new(&holder)?;
        let mut servers = Vec::new();
        for plan in &plans {
            let role = role_of(&plan.setup);
            let log: PathBuf = logs.join(format!("{role}-server.log"));
            let server = Server::start(role, &plan.source, threads, &log).await?;
            let unreachable = |e: RpcError| {
                let at = &server.address;
                Failure::server(format!(
                    "{e}; start a {role} server that listens at {at}, or give another address by `--{role}` or \
                     `[servers]` of the case"
                ))
            };
            let deadlines = Deadlines::default();
            let mut client =
                ParticipantClient::connect(&server.address, deadlines).await.map_err(unreachable)?;
            let description = client.describe().await.map_err(unreachable)?;
            servers.push((server, client, description));
        }
        let descriptions: Vec<_> = servers.iter().map(|(_, _, description)| description).collect();
        let kind = handshake::coupling_kind(kinds, &descriptions);
        for (plan, (server, _, description)) in plans.iter_mut().zip(&servers) {
            let role = role_of(&plan.setup);
            plan.setup.set_coupling_kind(kind);
            let reasons = handshake::unfit(description, role, plan.setup.run());
            if !reasons.is_empty() {
                let list = reasons.join("\n  ");
                let at = &server.address;
                return Err(Failure::server(format!(
                    "the server at {at} cannot be the {role} of this run:\n  {list}"
                )));
            }
        }
        let mut opened = Vec::new();
        for (plan, (server, mut client, _)) in plans.iter().zip(servers) {
            let report = client.open(&plan.setup, &access).await?;
            opened.push(RemoteParticipant { report, server, client });
        }
        let mut remote = Self { servers: opened };
        if let Err(failure) = remote.link().await {
            remote.end().await;
            return Err(failure);
        }
        Ok(remote)
    }

    async fn link(&mut self) -> Result<(), Failure> {
        let limits = self.servers.iter().map(|server| server.report.time_step_limit);
        let first_limit = limits.fold(f64::INFINITY, f64::min);
        let plan = |partner_extent: Extent, partner| LinkPlan { first_limit, partner_extent, partner };
        match self.servers.as_mut_slice() {
            [alone] => alone.client.link(&plan(Extent::default(), Partner::Alone)).await?,
            [fluid, solid] => {
                let differences = handshake::mismatches(&fluid.report, &solid.report);
                if !differences.is_empty() {
                    let list = differences.join("\n  ");
                    return Err(Failure::server(format!(
                        "fluid and solid server do not fit each other:\n  {list}"
                    )));
                }
                solid.client.link(&plan(fluid.report.extent.clone(), Partner::Listen)).await?;
                let address = Partner::Dial(solid.server.address.clone());
                fluid.client.link(&plan(solid.report.extent.clone(), address)).await?;
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
        let (events, received) = mpsc::channel::<(Role, EventResult)>(PENDING_EVENTS);
        let mut lines = Vec::new();
        for server in &mut self.servers {
            let role = server.report.role;
            let (commands, mut incoming) = server.client.run().await?;
            lines.push((role, CommandLine::Server(commands)));
            let events = events.clone();
            tokio::spawn(async move {
                while let Some(event) = incoming.recv().await {
                    let event = event.map_err(|e| Failure::new(Kind::Lost, e.to_string()));
                    if events.send((role, event)).await.is_err() {
                        return;
                    }
                }
            });
        }
        Ok(Participants::new(lines, received))
    }

    /// Closes the run on all servers and ends those that were started for it.
    pub async fn end(self) {
        for mut server in self.servers {
            // The run is over either way; a server that does not answer is ended all the same.
            drop(server.client.close().await);
            server.server.end().await;
        }
    }
}
