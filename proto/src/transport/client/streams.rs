//! The streams of a run: commands to the server, events and snapshots from it.

use std::time::Duration;

use sph::coupling::driver::{Command, Event, FailureReport, FinalReport};
use sph::coupling::solver::ParticleFields;
use tokio::sync::{mpsc, watch};
use tokio_util::sync::CancellationToken;
use tonic::Streaming;

use crate::convert::{BatchItem, Beat, SnapshotAssembler, decode_batch, encode_command};
use crate::error::{RpcCode, RpcError};
use crate::wire;

/// Events that may wait for the coordinator; then the server waits.
const PENDING_EVENTS: usize = 256;

/// Wait for the end of a stream after its last event.
const STREAM_END: Duration = Duration::from_secs(2);

/// Further wait for a sign of life when its time is over.
const SECOND_LOOK: Duration = Duration::from_millis(500);

/// The way of commands to a running participant. May be dropped or cloned freely.
#[derive(Clone, Debug)]
pub struct CommandSender {
    commands: mpsc::UnboundedSender<Command>,
    over: CancellationToken,
    address: String,
}

impl CommandSender {
    /// Sends a command without waiting.
    ///
    /// # Errors
    /// When the run is over; its last event tells why.
    pub fn send(&self, command: Command) -> Result<(), RpcError> {
        if self.over.is_cancelled() || self.commands.send(command).is_err() {
            return Err(RpcError::new(RpcCode::FailedPrecondition, "Run", &self.address, "the run is over"));
        }
        Ok(())
    }
}

/// Events of a running participant in their order, snapshots and final states complete. Dropping it gives the run up.
#[derive(Debug)]
pub struct EventReceiver {
    events: mpsc::Receiver<Result<Event, RpcError>>,
    latest_beat: watch::Receiver<Option<Beat>>,
}

impl EventReceiver {
    /// The next event; an error or `Finished` or `Failed` is the last, then there is `None`.
    ///
    /// Nothing is lost when the future is dropped before it completes.
    pub async fn recv(&mut self) -> Option<Result<Event, RpcError>> {
        self.events.recv().await
    }

    /// Where each sign of life of the server appears.
    pub fn beats(&self) -> watch::Receiver<Option<Beat>> {
        self.latest_beat.clone()
    }

    /// The server's last sign of life.
    pub fn latest_beat(&self) -> Option<Beat> {
        *self.latest_beat.borrow()
    }
}

/// Passes commands on until the run is over; keeps the server's request side open till then.
async fn forward_commands(
    run_id: String,
    epoch: u32,
    mut ordered: mpsc::UnboundedReceiver<Command>,
    to_server: mpsc::Sender<wire::Command>,
    over: CancellationToken,
) {
    loop {
        let command = tokio::select! {
            () = over.cancelled() => return,
            command = ordered.recv() => command,
        };
        let Some(command) = command else { break };
        // A server that takes no more tells why on the stream of events.
        drop(to_server.send(encode_command(&run_id, epoch, command)).await);
    }
    over.cancelled().await;
}

/// The last sign of life of a server.
#[derive(Clone, Copy, Debug)]
enum Heard {
    Nothing,
    Beat(Beat),
    /// The report of a step, after which so many were completed.
    Completed(u64),
}

/// A run on a server.
pub(super) struct Run {
    pub(super) run_id: String,
    pub(super) epoch: u32,
    pub(super) address: String,
    /// Longest wait for a sign of life.
    pub(super) silence: Duration,
}

impl Run {
    /// Starts to pass commands on `to_server`, and `batches` and `snapshots` back.
    pub(super) fn start(
        self,
        to_server: mpsc::Sender<wire::Command>,
        batches: Streaming<wire::EventBatch>,
        snapshots: Streaming<wire::SnapshotChunk>,
    ) -> (CommandSender, EventReceiver) {
        let (commands, ordered) = mpsc::unbounded_channel();
        let (events, received) = mpsc::channel(PENDING_EVENTS);
        let (beats, latest_beat) = watch::channel(None);
        let over = CancellationToken::new();
        let sender = CommandSender { commands, over: over.clone(), address: self.address.clone() };
        tokio::spawn(forward_commands(self.run_id.clone(), self.epoch, ordered, to_server, over.clone()));
        let streams = RunStreams {
            run: self,
            batches,
            snapshots,
            assembler: SnapshotAssembler::default(),
            events,
            beats,
            heard: Heard::Nothing,
            over,
        };
        tokio::spawn(streams.forward());
        (sender, EventReceiver { events: received, latest_beat })
    }
}

/// The server's streams of one run.
struct RunStreams {
    run: Run,
    batches: Streaming<wire::EventBatch>,
    snapshots: Streaming<wire::SnapshotChunk>,
    assembler: SnapshotAssembler,
    events: mpsc::Sender<Result<Event, RpcError>>,
    beats: watch::Sender<Option<Beat>>,
    /// What the last sign of life said.
    heard: Heard,
    /// Cancelled when no more events come.
    over: CancellationToken,
}

impl RunStreams {
    /// Passes events on until the last one, an error, or the end of the receiver.
    async fn forward(mut self) {
        let events = self.events.clone();
        let outcome = tokio::select! {
            () = events.closed() => return self.over.cancel(),
            outcome = self.forward_all() => outcome,
        };
        self.over.cancel();
        match outcome {
            // The end of the stream says that the server, too, has ended the run.
            Ok(()) => drop(tokio::time::timeout(STREAM_END, self.hear_out()).await),
            // Whoever stopped listening needs no error.
            Err(error) => drop(events.send(Err(error)).await),
        }
    }

    async fn forward_all(&mut self) -> Result<(), RpcError> {
        loop {
            let batch = self.next_batch().await?;
            if batch.run_id != self.run.run_id || batch.epoch != self.run.epoch {
                let text = format!(
                    "events are of run {:?}, epoch {}; expected {:?}, epoch {}",
                    batch.run_id, batch.epoch, self.run.run_id, self.run.epoch
                );
                return Err(self.malformed(text));
            }
            for item in decode_batch(&batch).map_err(|e| self.malformed(e.to_string()))? {
                if let Some((event, last)) = self.event(item).await?
                    && (self.events.send(Ok(event)).await.is_err() || last)
                {
                    return Ok(());
                }
            }
        }
    }

    async fn hear_out(&mut self) {
        while let Ok(Some(_)) = self.batches.message().await {}
    }

    async fn next_batch(&mut self) -> Result<wire::EventBatch, RpcError> {
        let mut heard = tokio::time::timeout(self.run.silence, self.batches.message()).await;
        if heard.is_err() {
            // A process that was stopped itself finds its time over before it has looked at what came meanwhile.
            heard = tokio::time::timeout(SECOND_LOOK, self.batches.message()).await;
        }
        match heard {
            Ok(Ok(Some(batch))) => Ok(batch),
            Ok(Ok(None)) => Err(self.lost("the server ended the stream before its last event")),
            Ok(Err(status)) => {
                let mut error = RpcError::from_status("Run", &self.run.address, &status);
                error.message = format!("{}; {}", error.message, self.doing());
                Err(error)
            }
            Err(_) => Err(self.silent()),
        }
    }

    /// An item as an event, and whether it is the last; `None` for a sign of life.
    async fn event(&mut self, item: BatchItem) -> Result<Option<(Event, bool)>, RpcError> {
        Ok(Some(match item {
            BatchItem::Beat(beat) => {
                self.heard = Heard::Beat(beat);
                self.beats.send_replace(Some(beat));
                return Ok(None);
            }
            BatchItem::Step(report) => {
                self.heard = Heard::Completed(report.step + 1);
                (Event::Step(*report), false)
            }
            BatchItem::Probes(values) => (Event::Probes(values), false),
            BatchItem::Paused(held) => (Event::Paused(held), false),
            BatchItem::Snapshot { index, .. } => (Event::Snapshot(self.snapshot(index).await?), false),
            BatchItem::Finished { step, time, reached_end, counts, state_index } => {
                let state = self.snapshot(state_index).await?;
                (Event::Finished(FinalReport { step, time, reached_end, counts, state }), true)
            }
            BatchItem::Failed { fault, step, time, counts, state_index } => {
                let state = self.snapshot(state_index).await?;
                (Event::Failed(FailureReport { fault: *fault, step, time, counts, state }), true)
            }
        }))
    }

    /// Snapshot number `expected`, which is next on its stream.
    async fn snapshot(&mut self, expected: u64) -> Result<ParticleFields, RpcError> {
        loop {
            let chunk = match tokio::time::timeout(self.run.silence, self.snapshots.message()).await {
                Ok(Ok(Some(chunk))) => chunk,
                Ok(Ok(None)) => {
                    return Err(
                        self.lost(&format!("the server ended its snapshots before number {expected}"))
                    );
                }
                Ok(Err(status)) => {
                    return Err(RpcError::from_status("Snapshots", &self.run.address, &status));
                }
                Err(_) => return Err(self.silent()),
            };
            match self.assembler.take(chunk).map_err(|e| self.malformed(e.to_string()))? {
                None => {}
                Some((index, snapshot)) if index == expected => return Ok(snapshot),
                Some((index, _)) => {
                    return Err(self.malformed(format!("snapshot {index} came, expected {expected}")));
                }
            }
        }
    }

    fn malformed(&self, message: impl Into<String>) -> RpcError {
        RpcError::new(RpcCode::Malformed, "Run", &self.run.address, message)
    }

    fn lost(&self, message: &str) -> RpcError {
        let message = format!("{message}; {}", self.doing());
        RpcError::new(RpcCode::Unavailable, "Run", &self.run.address, message)
    }

    /// What the server did when it was heard last.
    fn doing(&self) -> String {
        match self.heard {
            Heard::Nothing => "it never gave a sign of life".to_owned(),
            Heard::Beat(beat) => format!("at its last sign of life it was {beat}"),
            Heard::Completed(steps) => {
                format!("its last sign of life was a report, after {steps} completed steps")
            }
        }
    }

    fn silent(&self) -> RpcError {
        let doing = self.doing();
        let message = format!("no sign of life for {} s; {doing}", self.run.silence.as_secs_f64());
        RpcError::new(RpcCode::DeadlineExceeded, "Run", &self.run.address, message)
    }
}
