//! The control plane's calls.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};

use sph::coupling::driver::Link;
use sph::coupling::solver::ParticleFields;
use tokio::sync::mpsc;
use tokio_stream::Stream;
use tokio_stream::wrappers::ReceiverStream;
use tokio_util::sync::CancellationToken;
use tonic::{Request, Response, Status, Streaming};

use super::reply::{Reply, invalid, panic_text};
use super::session::{Host, Linked, Ready, Serial, Skin, State};
use super::{Opened, SetupProblems, checkpoint, compute, open_checked};
use crate::convert::{
    Convert, FrameReader, FrameWriter, Layout, Path, decode_setup, link_from_wire, snapshot_chunks,
};
use crate::description::{FrameField, LinkPlan, OpenReport, PROTOCOL, Partner};
use crate::error::status_text;
use crate::limits::MAX_NAME_BYTES;
use crate::transport::connection::Caller;
use crate::transport::peer::{self, GrpcPeer, PeerSlot};
use crate::transport::token::Token;
use crate::wire;
use crate::wire::open_request::Setup;

/// Snapshots that may wait for the coordinator; then the solver waits.
const PENDING_SNAPSHOTS: usize = 2;
/// Chunks of a snapshot that may wait for the transport.
const PENDING_CHUNKS: usize = 4;

#[tonic::async_trait]
impl wire::participant_server::Participant for Skin {
    type RunStream = Reply<wire::EventBatch>;
    type SnapshotsStream = Reply<wire::SnapshotChunk>;
    type CheckpointStream = Reply<wire::CheckpointChunk>;

    async fn describe(
        &self,
        _: Request<wire::DescribeRequest>,
    ) -> Result<Response<wire::Description>, Status> {
        Ok(Response::new(self.0.description.to_wire()))
    }

    async fn open(&self, request: Request<wire::OpenRequest>) -> Result<Response<wire::OpenReply>, Status> {
        let request = request.into_inner();
        let version = request.protocol.unwrap_or_default();
        if version.major != PROTOCOL.major {
            return Err(Status::unimplemented(format!(
                "`open.protocol` is {}.{}, this server speaks {PROTOCOL}",
                version.major, version.minor
            )));
        }
        let token = Token::parse(&request.token)
            .map_err(|problem| Status::invalid_argument(format!("`open.token`: {problem}")))?;
        if request.holder.len() > MAX_NAME_BYTES {
            return Err(Status::invalid_argument(format!(
                "`open.holder`: at most {MAX_NAME_BYTES} bytes are allowed"
            )));
        }
        let Some(setup) = request.setup else {
            return Err(Status::invalid_argument("`open.setup`: is missing, must be `fluid` or `solid`"));
        };
        let run = match &setup {
            Setup::Fluid(fluid) => &fluid.run,
            Setup::Solid(solid) => &solid.run,
        };
        let run_id = run.as_ref().map_or_else(String::new, |run| run.run_id.clone());
        let host = self.0.clone();
        let reservation = self.0.reserve(&run_id, token, &request.holder)?;
        let building = tokio::task::spawn_blocking({
            let cancel = reservation.cancel.clone();
            move || build(&host, &setup, &cancel)
        });
        let (ready, report) =
            building.await.map_err(|e| Status::internal(format!("`Open` failed: {e}")))??;
        let (serial, reply) = (reservation.serial, report.to_wire());
        if !reservation.keep(ready) {
            return Err(Status::failed_precondition("the run was closed while it was being opened"));
        }
        let host = self.0.clone();
        if let Some(gone) = self.0.with_session(serial, |session| session.gone.clone()) {
            tokio::spawn(host.watch_lease(serial, gone));
        }
        tracing::info!(run = run_id, holder = request.holder, "run opened");
        Ok(Response::new(reply))
    }

    async fn link(&self, request: Request<wire::LinkRequest>) -> Result<Response<wire::LinkReply>, Status> {
        let (metadata, _, request) = request.into_parts();
        let plan = {
            let mut slot = self.0.slot();
            let session = Host::admit(&mut slot, "Link", &request.run_id, &metadata)?;
            let State::Open(ready) = &session.state else { return Err(session.refused("Link", "OPEN")) };
            let plan = link_from_wire(&request, ready.setup.dimensions(), &Path::root("link"))
                .map_err(|e| invalid(&e))?;
            let peer = self.0.prepare_peer(&plan, ready, session.epoch, session.abort.clone())?;
            (session.serial, session.token.clone(), plan, peer)
        };
        let (serial, token, plan, peer) = plan;
        let (peer, waiting) = match (peer, &plan.partner) {
            (Some((peer, slot)), Partner::Dial(address)) => {
                peer::dial(address, &token, self.0.options.security.partner(), slot).await.map_err(
                    |problem| Status::unavailable(status_text(format!("the partner at {address} {problem}"))),
                )?;
                (Some(peer), None)
            }
            (Some((peer, slot)), _) => (Some(peer), Some(slot)),
            (None, _) => (None, None),
        };
        let LinkPlan { partner_extent, first_limit, partner_particles, .. } = plan;
        self.0
            .with_session(serial, |session| match std::mem::replace(&mut session.state, State::Opening) {
                State::Open(ready) => {
                    let link = Link { partner_extent, first_limit, resume: ready.resume, partner_particles };
                    session.state =
                        State::Linked(Box::new(Linked { ready: *ready, link, peer, snapshots: None }));
                    session.peer_slot = waiting;
                    Ok(())
                }
                other => {
                    session.state = other;
                    Err(session.refused("Link", "OPEN"))
                }
            })
            .unwrap_or_else(|| {
                Err(Status::failed_precondition("the run was closed while it was being linked"))
            })?;
        Ok(Response::new(wire::LinkReply { run_id: request.run_id }))
    }

    async fn run(
        &self,
        request: Request<Streaming<wire::Command>>,
    ) -> Result<Response<Self::RunStream>, Status> {
        let host = self.0.clone();
        let (metadata, extensions, commands) = request.into_parts();
        let mut slot = self.0.slot();
        // The run id comes with each command; the token alone says whose call this is.
        let Some(run_id) = slot.as_ref().map(|session| session.run_id.clone()) else {
            return Err(Status::failed_precondition("`Run` is not allowed in state IDLE; expected: LINKED"));
        };
        let session = Host::admit(&mut slot, "Run", &run_id, &metadata)?;
        match std::mem::replace(&mut session.state, State::Running) {
            State::Linked(linked) => {
                let run = compute::RunHandle::of(session);
                if let Some(caller) = Caller::of(&extensions) {
                    let (gone, ended) = (session.gone.clone(), caller.ended());
                    tokio::spawn(host.clone().watch_connection(run.serial(), gone, ended));
                }
                drop(slot);
                let guard = StreamGuard { host: host.clone(), serial: run.serial(), complete: false };
                let events = compute::start(host, run, *linked, commands)?;
                Ok(Response::new(Box::pin(EventStream { events: ReceiverStream::new(events), guard })))
            }
            other => {
                session.state = other;
                Err(session.refused("Run", "LINKED"))
            }
        }
    }

    async fn snapshots(
        &self,
        request: Request<wire::SnapshotsRequest>,
    ) -> Result<Response<Self::SnapshotsStream>, Status> {
        let (metadata, _, request) = request.into_parts();
        let receiver = {
            let mut slot = self.0.slot();
            let session = Host::admit(&mut slot, "Snapshots", &request.run_id, &metadata)?;
            match &mut session.state {
                State::Linked(linked) if linked.snapshots.is_none() => {
                    let (sender, receiver) = mpsc::channel(PENDING_SNAPSHOTS);
                    linked.snapshots = Some(sender);
                    receiver
                }
                _ => return Err(session.refused("Snapshots", "LINKED, one stream only")),
            }
        };
        let (sender, chunks) = mpsc::channel(PENDING_CHUNKS);
        tokio::spawn(send_snapshots(request.run_id, receiver, sender));
        Ok(Response::new(Box::pin(ReceiverStream::new(chunks))))
    }

    async fn checkpoint(
        &self,
        request: Request<wire::CheckpointRequest>,
    ) -> Result<Response<Self::CheckpointStream>, Status> {
        checkpoint::take(&self.0, request).await.map(Response::new)
    }

    async fn restore(
        &self,
        request: Request<Streaming<wire::RestoreChunk>>,
    ) -> Result<Response<wire::RestoreReply>, Status> {
        checkpoint::restore(&self.0, request).await.map(Response::new)
    }

    async fn close(
        &self,
        request: Request<wire::CloseRequest>,
    ) -> Result<Response<wire::CloseReply>, Status> {
        let (metadata, _, request) = request.into_parts();
        let (serial, running, gone) = {
            let mut slot = self.0.slot();
            if slot.as_ref().is_none_or(|session| session.run_id != request.run_id) {
                return Ok(Response::new(wire::CloseReply { closed: false }));
            }
            let session = Host::admit(&mut slot, "Close", &request.run_id, &metadata)?;
            session.cancel.cancel();
            (session.serial, matches!(session.state, State::Running), session.gone.clone())
        };
        if running {
            // The compute thread ends at its next boundary and then frees the server.
            gone.cancelled().await;
        } else {
            self.0.remove(serial);
        }
        Ok(Response::new(wire::CloseReply { closed: true }))
    }
}

impl Host {
    /// The peer that `plan` asks for, with its end for the transport.
    fn prepare_peer(
        &self,
        plan: &LinkPlan,
        ready: &Ready,
        epoch: u32,
        abort: CancellationToken,
    ) -> Result<Option<(GrpcPeer, PeerSlot)>, Status> {
        let run = &ready.setup;
        let coupling = match (&plan.partner, &run.coupling) {
            (Partner::Alone, None) => return Ok(None),
            (Partner::Alone, Some(_)) => {
                return Err(Status::invalid_argument(
                    "`link.partner`: is `alone`, but the run was opened with a coupling",
                ));
            }
            (_, None) => {
                return Err(Status::invalid_argument(
                    "`link.partner`: the run was opened without a coupling, must be `alone`",
                ));
            }
            (_, Some(coupling)) => coupling,
        };
        let role = ready.solver.role();
        let extent = ready.solver.extent().version;
        let layout = |role| Layout {
            fields: FrameField::sent_by(role, coupling.law, coupling.kind),
            dimensions: run.dimensions(),
        };
        let writer = FrameWriter::new(&run.run_id, epoch, layout(role), extent);
        let partner_extent = plan.partner_extent.clone();
        let reader = FrameReader::new(&run.run_id, epoch, layout(role.partner()), partner_extent);
        Ok(Some(GrpcPeer::new(writer, reader, abort, self.options.partner_deadline)))
    }
}

/// Events of a run on their way; dropped before its end when the coordinator is gone.
struct EventStream {
    events: ReceiverStream<Result<wire::EventBatch, Status>>,
    guard: StreamGuard,
}

/// Frees the server when the stream of events was not heard to its end.
struct StreamGuard {
    host: Arc<Host>,
    serial: Serial,
    complete: bool,
}

impl Stream for EventStream {
    type Item = Result<wire::EventBatch, Status>;

    fn poll_next(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Self::Item>> {
        let item = Pin::new(&mut self.events).poll_next(context);
        self.guard.complete |= matches!(item, Poll::Ready(None));
        item
    }
}

impl Drop for StreamGuard {
    fn drop(&mut self) {
        if !self.complete {
            self.host.abandon(self.serial);
        }
    }
}

/// Checks a set-up and builds its solver: the long part of `Open`.
fn build(host: &Host, setup: &Setup, cancel: &CancellationToken) -> Result<(Ready, OpenReport), Status> {
    let setup = decode_setup(setup).map_err(|e| invalid(&e))?;
    let role = setup.role();
    let description = &host.description;
    if !description.roles.contains(&role) {
        let text =
            format!("`open.setup`: is for a {role}, but {} plays {:?}", description.name, description.roles);
        return Err(Status::invalid_argument(text));
    }
    let dimensions = setup.dimensions();
    if !description.dimensions.iter().any(|offered| usize::try_from(*offered) == Ok(dimensions)) {
        let offered: Vec<String> = description.dimensions.iter().map(u32::to_string).collect();
        let text = format!(
            "`open.{role}.run.dimensions`: is {dimensions}, but {} computes in {}",
            description.name,
            offered.join(" or ")
        );
        return Err(Status::invalid_argument(text));
    }
    if cancel.is_cancelled() {
        return Err(Status::cancelled("the run was closed while it was being opened"));
    }
    let run = setup.plan();
    let opened = catch_unwind(AssertUnwindSafe(|| host.pool.install(|| open_checked(&*host.factory, setup))));
    let (Opened { solver, constants, facts, bodies }, time_step_limit) = opened
        .map_err(|panic| {
            Status::internal(status_text(format!("the solver failed in `Open`: {}", panic_text(&*panic))))
        })?
        .map_err(|SetupProblems(problems)| Status::invalid_argument(status_text(problems.join("\n"))))?;
    let fields = |role| match &run.coupling {
        Some(coupling) => {
            let fields = FrameField::sent_by(role, coupling.law, coupling.kind);
            fields.iter().map(|field| field.spec(dimensions)).collect()
        }
        None => Vec::new(),
    };
    let report = OpenReport {
        run_id: run.run_id.clone(),
        role,
        protocol: PROTOCOL,
        name: description.name.clone(),
        version: description.version.clone(),
        arithmetic: description.arithmetic.clone(),
        coupling_kind: run.coupling.map(|coupling| coupling.kind).unwrap_or_default(),
        constants,
        fields_sent: fields(role),
        fields_needed: fields(role.partner()),
        extent: solver.extent().clone(),
        time_step_limit,
        counts: solver.counts(),
        facts,
        bodies,
        remarks: solver.remarks(),
    };
    Ok((Ready { solver, setup: run, resume: None }, report))
}

/// Cuts snapshots into chunks and sends them while anybody listens.
async fn send_snapshots(
    run_id: String,
    mut snapshots: mpsc::Receiver<(u64, ParticleFields)>,
    chunks: mpsc::Sender<Result<wire::SnapshotChunk, Status>>,
) {
    while let Some((index, snapshot)) = snapshots.recv().await {
        for chunk in snapshot_chunks(&run_id, index, snapshot) {
            if chunks.send(Ok(chunk)).await.is_err() {
                return;
            }
        }
    }
}
