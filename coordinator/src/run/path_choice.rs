//! Which path the half-step frames of a run take.

use std::net::SocketAddr;

use proto::recording::Recording;
use proto::transport::security::ServerSecurity;
use sph::setup::CouplingKind;

use super::attempt::Attempt;
use super::completion;
use super::job::Job;
use super::participants::frame_path::{FramePath, RelayPlan};
use super::request::{RelayOptions, ServerOptions};
use crate::failure::Failure;

impl Attempt<'_> {
    /// The path between the sides, and the kinds of coupling that it allows.
    pub(super) fn frame_path(
        &self,
        servers: &ServerOptions,
        kinds: Vec<CouplingKind>,
    ) -> Result<(FramePath<'_>, Vec<CouplingKind>), Failure> {
        let Job { case, replay, .. } = self.job;
        if let Some(replay) = replay {
            let recording = Recording::open(&replay.recording)?;
            let recorded = recording.attempts().iter().map(|attempt| attempt.coupling_kind).collect();
            return Ok((FramePath::Recording(recording), recorded));
        }
        let default = case.is_relayed().then(RelayOptions::default);
        let Some(relay) = servers.relay.clone().or(default) else {
            return Ok((FramePath::Direct, kinds));
        };
        let files = servers.files(&case.servers.files);
        let security = Box::new(ServerSecurity::between(&files).map_err(Failure::input)?);
        let listen = relay.listen.unwrap_or_else(|| SocketAddr::from(([127, 0, 0, 1], 0)));
        if listen.ip().is_unspecified() {
            return Err(Failure::input(format!(
                "`--relay-listen {listen}`: names no address that the fluid server could call; give one of this machine"
            )));
        }
        if !(listen.ip().is_loopback() || security.has_tls() || relay.insecure) {
            return Err(Failure::input(format!(
                "`--relay-listen {listen}` reaches beyond this machine, where frames would travel in the clear; give a \
                 certificate that names this address (`--tls-ca`, `--tls-cert`, `--tls-key`), or add `--relay-insecure` to \
                 accept that risk"
            )));
        }
        Ok((
            FramePath::Relay(RelayPlan {
                listen,
                security,
                recording: self.recording,
                case_name: case.name.clone(),
                case_digest: completion::digest(&case.identity()),
                first_step: self.from.map_or(0, |checkpoint| checkpoint.step),
                epoch: self.from.map_or(0, |_| u32::try_from(self.number + 1).unwrap_or(u32::MAX)),
            }),
            kinds,
        ))
    }
}
