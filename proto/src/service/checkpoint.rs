//! Saving and restoring the state of a run.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use sph::coupling::driver::save;
use sph::coupling::solver::Solver;
use sph::coupling::stage::ClockState;
use tonic::{Request, Status, Streaming};

use super::reply::{Reply, invalid, panic_text};
use super::session::{Host, Ready, Serial, State};
use crate::checkpoint::{CheckpointAssembler, CheckpointData, CheckpointHeader, restore_solver};
use crate::convert::{count, encode_state, extent_to_wire};
use crate::error::status_text;
use crate::wire;

/// Takes a checkpoint of the run.
pub(super) async fn take(
    host: &Arc<Host>,
    request: Request<wire::CheckpointRequest>,
) -> Result<Reply<wire::CheckpointChunk>, Status> {
    let (metadata, _, request) = request.into_parts();
    let (answer, role_of) = {
        let mut slot = host.slot();
        let session = Host::admit(&mut slot, "Checkpoint", &request.run_id, &metadata)?;
        let (State::Running, Some(saver)) = (&session.state, &session.saver) else {
            return Err(session.refused("Checkpoint", "RUNNING, waiting for a grant"));
        };
        if request.epoch != session.epoch {
            let text = format!("`checkpoint.epoch` is {}; expected: {}", request.epoch, session.epoch);
            return Err(Status::failed_precondition(text));
        }
        (saver.ask()?, session.role)
    };
    let checkpoint = answer
        .await
        .map_err(|_| Status::failed_precondition("the run ended before the checkpoint was taken"))?;
    if checkpoint.step != request.step {
        return Err(Status::failed_precondition(format!(
            "`checkpoint.step` is {}; expected: {}, the steps that are completed",
            request.step, checkpoint.step
        )));
    }
    let header = CheckpointHeader::new(&host.description, role_of, &checkpoint);
    let encoding = tokio::task::spawn_blocking(move || CheckpointData::new(header, checkpoint));
    let data = encoding.await.map_err(|e| Status::internal(format!("`Checkpoint` failed: {e}")))?;
    let run_id = request.run_id;
    let chunks = data
        .parts()
        .map(move |part| Ok(wire::CheckpointChunk { run_id: run_id.clone(), part: Some(part.into()) }));
    Ok(Box::pin(tokio_stream::iter(chunks.collect::<Vec<_>>())))
}

/// Closes the run unless it was restored.
struct Restoring<'a> {
    host: &'a Host,
    serial: Serial,
    kept: bool,
}

impl Drop for Restoring<'_> {
    fn drop(&mut self) {
        if !self.kept {
            self.host.remove(self.serial);
        }
    }
}

/// Replaces the state of an opened run.
pub(super) async fn restore(
    host: &Arc<Host>,
    request: Request<Streaming<wire::RestoreChunk>>,
) -> Result<wire::RestoreReply, Status> {
    let (metadata, _, mut chunks) = request.into_parts();
    let (serial, run_id, ready) = {
        let mut slot = host.slot();
        // The run id comes with the first message; the token alone says whose call this is.
        let run_id = slot.as_ref().map(|session| session.run_id.clone()).unwrap_or_default();
        let session = Host::admit(&mut slot, "Restore", &run_id, &metadata)?;
        match std::mem::replace(&mut session.state, State::Opening) {
            State::Open(ready) => (session.serial, run_id, ready),
            other => {
                session.state = other;
                return Err(session.refused("Restore", "OPEN"));
            }
        }
    };
    let mut restoring = Restoring { host, serial, kept: false };
    let largest = largest_state(ready.solver.as_ref());
    let mut assembler = CheckpointAssembler::new(largest);
    let mut epoch = None;
    let data = loop {
        let Some(chunk) = chunks.message().await? else {
            return Err(Status::invalid_argument("`restore`: the stream ended before its trailer"));
        };
        if chunk.run_id != run_id || chunk.epoch == 0 || epoch.is_some_and(|epoch| epoch != chunk.epoch) {
            let text = format!(
                "`restore` is for run {:?}, epoch {}; expected: {run_id:?}, one epoch of at least 1",
                chunk.run_id, chunk.epoch
            );
            return Err(Status::failed_precondition(status_text(text)));
        }
        epoch = Some(chunk.epoch);
        if let Some(data) = assembler.take(chunk.part.map(Into::into)).map_err(|e| invalid(&e))? {
            break data;
        }
    };
    let role = ready.solver.role();
    let differences = data.header.differences(&host.description, role).concat();
    if !differences.is_empty() {
        let text = format!("the checkpoint is not of this solver:\n{}", differences.join("\n"));
        return Err(Status::failed_precondition(status_text(text)));
    }
    let pool = host.pool.clone();
    let sha256 = data.sha256;
    let work = tokio::task::spawn_blocking(move || pool.install(|| replace_state(ready, &data)));
    let (ready, clock) = work.await.map_err(|e| Status::internal(format!("`Restore` failed: {e}")))??;
    let reply = wire::RestoreReply {
        run_id,
        step: clock.step,
        time_s_bits: clock.time.to_bits(),
        sha256: sha256.to_vec().into(),
        extent: Some(extent_to_wire(ready.solver.extent())),
        time_step_limit_s: Some(ready.solver.time_step_limit()),
    };
    let held = host.with_session(serial, |session| {
        session.state = State::Open(ready);
        session.epoch = epoch.unwrap_or_default();
    });
    restoring.kept = held.is_some();
    match held {
        Some(()) => Ok(reply),
        None => Err(Status::failed_precondition("the run was closed while it was being restored")),
    }
}

/// Most bytes of a state of the run: some more than it has now, for what is there only after a step.
fn largest_state(solver: &dyn Solver) -> u64 {
    let clock = ClockState { step: 0, time: 0.0, time_step: 1.0, allowed_step: 1.0, elapsed_before: 0.0 };
    2 * count(encode_state(save(solver, &clock).state).len()) + (1 << 20)
}

fn replace_state(mut ready: Box<Ready>, data: &CheckpointData) -> Result<(Box<Ready>, ClockState), Status> {
    let restored =
        catch_unwind(AssertUnwindSafe(|| restore_solver(ready.solver.as_mut(), data))).map_err(|panic| {
            let text = format!("the solver failed in `Restore`: {}", panic_text(&*panic));
            Status::internal(status_text(text))
        })?;
    let clock = restored
        .map_err(|problem| Status::invalid_argument(status_text(format!("the checkpoint: {problem}"))))?;
    ready.resume = Some(clock);
    Ok((ready, clock))
}
