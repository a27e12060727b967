//! The solvers of a run, wherever they compute.

use sph::coupling::solver::Role;
use sph::setup::CouplingKind;

use crate::results::summary::Participant;
use crate::run::participants::in_process::ThreadParticipant;
use crate::run::participants::remote::Remote;

/// The solvers of a run.
pub(super) enum Solvers {
    Threads(Vec<ThreadParticipant>),
    Servers(Remote),
}

impl Solvers {
    /// The servers, unless the solvers are threads.
    pub(super) fn remote(&self) -> Option<&Remote> {
        match self {
            Solvers::Threads(_) => None,
            Solvers::Servers(remote) => Some(remote),
        }
    }

    /// The servers, to be changed.
    pub(super) fn remote_mut(&mut self) -> Option<&mut Remote> {
        match self {
            Solvers::Threads(_) => None,
            Solvers::Servers(remote) => Some(remote),
        }
    }

    /// The kind of coupling that the servers agreed on.
    pub(super) fn coupling_kind(&self) -> Option<CouplingKind> {
        self.remote().and_then(|remote| remote.servers.first()).map(|server| server.report.coupling_kind)
    }

    /// What deserves a second look about the start, in the words of the solvers.
    pub(super) fn remarks(&self) -> Vec<String> {
        match self {
            Solvers::Threads(threads) => threads.iter().flat_map(|t| t.remarks.clone()).collect(),
            Solvers::Servers(remote) => {
                remote.servers.iter().flat_map(|s| s.report.remarks.clone()).collect()
            }
        }
    }

    /// Where the solver of `role` ran and what it used; taken before it ends.
    pub(super) fn participant(&self, role: Role) -> Participant {
        let server = self.remote().and_then(|r| r.servers.iter().find(|server| server.report.role == role));
        match server {
            Some(server) => Participant {
                solver: format!("{} {}", server.report.name, server.report.version),
                address: server.address().to_owned(),
                process: server.process(),
                ..Participant::default()
            },
            None => Participant {
                solver: format!("{role}-server {}", env!("CARGO_PKG_VERSION")),
                address: "in-process".into(),
                ..Participant::default()
            },
        }
    }

    /// Ends the solvers.
    pub(super) async fn end(&mut self) {
        match std::mem::replace(self, Solvers::Threads(Vec::new())) {
            Solvers::Threads(threads) => threads.into_iter().for_each(ThreadParticipant::join),
            Solvers::Servers(remote) => remote.end().await,
        }
    }

    /// Ends the solvers though one of them may be frozen.
    pub(super) async fn kill(self) {
        match self {
            // A thread that hangs cannot be ended.
            Solvers::Threads(_) => {}
            Solvers::Servers(remote) => remote.kill().await,
        }
    }

    /// Whether this program can start those of `roles` again.
    pub(super) fn may_restart(&self, roles: &[Role]) -> bool {
        self.remote().is_some_and(|remote| {
            remote.servers.iter().all(|s| !roles.contains(&s.report.role) || s.is_child())
        })
    }
}
