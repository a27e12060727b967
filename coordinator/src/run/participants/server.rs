//! One server of a run with its connection.

use proto::description::{Description, OpenReport};
use proto::transport::client::{Deadlines, ParticipantClient};
use proto::{RpcCode, RpcError};
use sph::coupling::solver::Role;

use super::launch::Server;
use crate::failure::{Failure, Kind};
use crate::results::process::Process;

/// One server with its connection and its answers.
pub struct RemoteParticipant {
    /// Its answer to the set-up.
    pub report: OpenReport,
    pub(crate) server: Server,
    pub(crate) client: ParticipantClient,
    /// Whether it can save its state.
    pub(crate) saves: bool,
}

impl RemoteParticipant {
    /// Address at which it was reached.
    pub fn address(&self) -> &str {
        &self.server.address
    }

    /// Whether it was started for this run.
    pub fn is_child(&self) -> bool {
        self.server.is_child()
    }

    /// Resources used so far, where the server is a child of this process.
    pub fn process(&self) -> Process {
        self.server.process_id().map(Process::of).unwrap_or_default()
    }
}

/// A connection to `server`, and its description.
pub(super) async fn describe(
    server: &Server,
    deadlines: Deadlines,
) -> Result<(ParticipantClient, Description), RpcError> {
    let client = ParticipantClient::connect_secured(&server.address, deadlines, &server.security);
    let mut client = client.await?;
    let description = client.describe().await?;
    Ok((client, description))
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

/// A failed call to the server of `role` while the run is being set up, where a lost server is not started again.
pub(crate) fn at_start(role: Role, error: RpcError) -> Failure {
    let lost = error.code == RpcCode::Unavailable;
    let mut failure = Failure::from(error);
    if lost {
        let was = format!("the {role} server was lost before the first step: {}", failure.message);
        failure.message = format!("{was}; look at its log, and repeat the command when it runs again");
    }
    failure
}
