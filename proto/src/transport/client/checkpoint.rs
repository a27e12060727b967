//! Saving and restoring the state of a server's run.

use std::time::Duration;

use super::{ParticipantClient, within};
use crate::checkpoint::{CheckpointAssembler, CheckpointData, RestoreReport};
use crate::error::{RpcCode, RpcError};
use crate::wire;

impl ParticipantClient {
    /// The state at the boundary of `step` completed steps, where the solver must be waiting for a grant.
    ///
    /// # Errors
    /// When the solver is elsewhere, or does not answer.
    pub async fn checkpoint(&mut self, step: u64) -> Result<CheckpointData, RpcError> {
        let (run_id, token) = self.opened("Checkpoint")?;
        let request = token.attach(wire::CheckpointRequest { run_id, epoch: self.epoch, step });
        let deadline = self.deadlines.call;
        let mut chunks =
            within(deadline, "Checkpoint", &self.address, self.inner.checkpoint(request)).await?;
        let mut assembler = CheckpointAssembler::new(u64::MAX);
        loop {
            let chunk = within_stream(deadline, "Checkpoint", &self.address, chunks.message()).await?;
            let Some(chunk) = chunk else {
                let text = "the stream ended before its trailer";
                return Err(self.error(RpcCode::Malformed, "Checkpoint", text));
            };
            if let Some(data) = self.accept("Checkpoint", assembler.take(chunk.part.map(Into::into)))? {
                return Ok(data);
            }
        }
    }

    /// Replaces the state of the run just opened by `checkpoint`; the run then continues under `epoch`, at least 1 and
    /// the same on both sides.
    ///
    /// # Errors
    /// When the server refuses it, naming the difference, or holds something else afterwards; the run is then over.
    pub async fn restore(
        &mut self,
        checkpoint: &CheckpointData,
        epoch: u32,
    ) -> Result<RestoreReport, RpcError> {
        let (run_id, token) = self.opened("Restore")?;
        let chunks: Vec<_> = checkpoint
            .parts()
            .map(|part| wire::RestoreChunk { run_id: run_id.clone(), epoch, part: Some(part.into()) })
            .collect();
        let request = token.attach(tokio_stream::iter(chunks));
        let answer = self.inner.restore(request);
        let reply = within(self.deadlines.open, "Restore", &self.address, answer).await?;
        if *reply.sha256 != checkpoint.sha256 {
            let text = "the server holds another state than the one that it was given";
            return Err(self.error(RpcCode::Malformed, "Restore", text));
        }
        self.epoch = epoch;
        self.accept("Restore", RestoreReport::from_wire(&reply, self.dimensions))
    }
}

/// The next message of a stream, bounded in time.
async fn within_stream<T>(
    deadline: Duration,
    call: &'static str,
    address: &str,
    message: impl Future<Output = Result<Option<T>, tonic::Status>>,
) -> Result<Option<T>, RpcError> {
    within(deadline, call, address, async { message.await.map(tonic::Response::new) }).await
}
