//! The way of the half-step frames of a run.

use std::net::SocketAddr;

use proto::recording::Recording;
use proto::security::ServerSecurity;
use sph::setup::CouplingKind;

use super::{Attempt, Job, completion};
use crate::failure::Failure;
use crate::run::participants::frame_path::{Between, Relayed};

impl Attempt<'_> {
    /// The way between the sides, and the kinds of coupling that it allows.
    pub(super) fn between(
        &self,
        kinds: Vec<CouplingKind>,
    ) -> Result<(Between<'_>, Vec<CouplingKind>), Failure> {
        let Job { case, options, alone, .. } = self.job;
        if let Some((_, path)) = alone {
            let recording = Recording::open(path)?;
            let recorded = recording.attempts().iter().map(|attempt| attempt.coupling_kind).collect();
            return Ok((Between::Recording(recording), recorded));
        }
        let relayed = options.relay || options.record.is_some() || options.relay_listen.is_some();
        if !(relayed || case.is_relayed()) {
            return Ok((Between::Direct, kinds));
        }
        let files = options.security.over(&case.servers.files);
        let security = Box::new(ServerSecurity::between(&files).map_err(Failure::input)?);
        let listen = options.relay_listen.unwrap_or_else(|| SocketAddr::from(([127, 0, 0, 1], 0)));
        if listen.ip().is_unspecified() {
            return Err(Failure::input(format!(
                "`--relay-listen {listen}`: names no address that the fluid server could call; give one of this machine"
            )));
        }
        if !(listen.ip().is_loopback() || security.has_tls() || options.relay_insecure) {
            return Err(Failure::input(format!(
                "`--relay-listen {listen}` reaches beyond this machine, where frames would travel in the clear; give a \
                 certificate that names this address (`--tls-ca`, `--tls-cert`, `--tls-key`), or add `--relay-insecure` to \
                 accept that risk"
            )));
        }
        Ok((
            Between::Relay(Relayed {
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
