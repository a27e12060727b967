//! The path of the half-step frames between the solvers: direct, through a relay, or from a recording.

use std::net::SocketAddr;

use proto::description::{LinkPlan, Partner};
use proto::recording::player::Player;
use proto::recording::{self, Recording, RecordingError, RecordingWriter};
use proto::transport::client::RunAccess;
use proto::transport::relay::FrameRelay;
use proto::transport::security::{ClientSecurity, ServerSecurity};
use sph::coupling::solver::Role;

use super::server::RemoteParticipant;
use crate::failure::Failure;

/// The planned path of the half-step frames between fluid and solid.
pub enum FramePath<'a> {
    /// From one server to the other.
    Direct,
    /// Through this process.
    Relay(RelayPlan<'a>),
    /// Those of one side come from a recording.
    Recording(Recording),
}

/// How frames are relayed.
pub struct RelayPlan<'a> {
    /// Where the fluid calls.
    pub listen: SocketAddr,
    /// For the call of the fluid, and for that to the solid.
    pub security: Box<ServerSecurity>,
    /// Where copies go.
    pub recording: Option<&'a RecordingWriter>,
    /// Name of the case.
    pub case_name: String,
    /// Digest of what decides its results.
    pub case_digest: String,
    /// Completed steps at the start.
    pub first_step: u64,
    /// Counts the restores.
    pub epoch: u32,
}

/// The path in use; it ends with the run.
pub(crate) enum OpenPath {
    Direct,
    Relay { relay: FrameRelay },
    Player(Player),
}

impl From<RecordingError> for Failure {
    fn from(error: RecordingError) -> Self {
        Failure::output(error.to_string())
    }
}

impl RelayPlan<'_> {
    /// Starts the relay of `fluid` and `solid`, which have been opened.
    pub(crate) async fn start(
        &self,
        fluid: &RemoteParticipant,
        solid: &RemoteParticipant,
        first_limit: f64,
    ) -> Result<FrameRelay, Failure> {
        let near = |address: &str| {
            let bare = address.rsplit_once("://").map_or(address, |(_, bare)| bare);
            let host = bare.rsplit_once(':').map_or(bare, |(host, _)| host);
            host.ends_with("localhost")
                || host.trim_matches(['[', ']']).parse().is_ok_and(|ip: std::net::IpAddr| ip.is_loopback())
        };
        if self.listen.ip().is_loopback() && !near(&fluid.server.address) {
            return Err(Failure::input(format!(
                "frames cannot be relayed: the fluid server at {} does not reach {} of this machine; give an address that it \
                 reaches by `--relay-listen IP:PORT`",
                fluid.server.address, self.listen
            )));
        }
        if let Some(recording) = self.recording {
            let solver = |side: &RemoteParticipant| format!("{} {}", side.report.name, side.report.version);
            recording
                .attempt(recording::Attempt {
                    run_id: fluid.report.run_id.clone(),
                    case_name: self.case_name.clone(),
                    case_digest: self.case_digest.clone(),
                    solvers: [solver(fluid), solver(solid)],
                    coupling_kind: fluid.report.coupling_kind,
                    epoch: self.epoch,
                    first_step: self.first_step,
                    first_limit,
                    extents: [fluid.report.extent.clone(), solid.report.extent.clone()],
                })
                .await;
        }
        FrameRelay::start(self.listen, &solid.server.address, self.security.as_ref().clone(), self.recording)
            .map_err(Failure::server)
    }
}

impl RemoteParticipant {
    /// Links this side to a player of the other.
    pub(crate) async fn replay(
        &mut self,
        recording: Recording,
        access: &RunAccess,
        security: &ClientSecurity,
    ) -> Result<Player, Failure> {
        let role = self.report.role;
        let Some(attempt) = recording.attempts().first().cloned() else {
            return Err(Failure::internal("a recording has an attempt"));
        };
        let player = Player::start(recording, role, access).map_err(Failure::input)?;
        let partner = player.address().map_or(Partner::Listen, |address| Partner::Dial(address.to_string()));
        let partner_extent = attempt.extents[role.partner().index()].clone();
        let plan = LinkPlan {
            first_limit: attempt.first_limit,
            partner_extent,
            partner,
            // A recording may be of a run that began from a checkpoint.
            partner_particles: None,
        };
        self.client.link(&plan).await?;
        if role == Role::Solid {
            player.dial(&self.server.address, security).await.map_err(Failure::server)?;
        }
        Ok(player)
    }
}
