//! The compute thread of a run, and the stream of its events.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc as std_mpsc;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use sph::coupling::driver::{self, Command, Event};
use sph::coupling::exchange::Exchange;
use sph::coupling::solver::ParticleFields;
use tokio::sync::mpsc;
use tokio_util::sync::CancellationToken;
use tonic::{Status, Streaming};

use super::reply::panic_text;
use super::saver::{Pending, Saver};
use super::session::{Host, Linked, Serial, Session, State};
use crate::convert::{BatchItem, Beat, Phase, decode_command, encode_batch};
use crate::error::status_text;
use crate::limits::BEAT_INTERVAL;
use crate::transport::peer::PeerMonitor;
use crate::wire;

/// Events that may wait for the coordinator; then the solver waits.
const PENDING_EVENTS: usize = 4096;
/// Events in one message.
const LARGEST_BATCH: usize = 256;
/// Messages that may wait for the transport.
const PENDING_BATCHES: usize = 4;

/// What the tasks of a run know of its session.
pub(super) struct RunHandle {
    serial: Serial,
    run_id: String,
    epoch: u32,
    cancel: CancellationToken,
    abort: CancellationToken,
}

impl RunHandle {
    pub(super) fn serial(&self) -> Serial {
        self.serial
    }

    pub(super) fn of(session: &Session) -> Self {
        Self {
            serial: session.serial,
            run_id: session.run_id.clone(),
            epoch: session.epoch,
            cancel: session.cancel.clone(),
            abort: session.abort.clone(),
        }
    }
}

/// What the compute thread says.
enum Said {
    Item(BatchItem),
    /// It panicked with this text.
    Panicked(String),
}

/// How far a run is, for signs of life.
struct Pulse {
    completed: AtomicU64,
    granted: AtomicU64,
    last_step: Mutex<Instant>,
    /// The last event is on its way.
    ended: AtomicBool,
    peer: Option<Arc<PeerMonitor>>,
}

impl Pulse {
    fn step_completed(&self, completed: u64) {
        self.completed.store(completed, Ordering::Relaxed);
        *self.last_step.lock().unwrap_or_else(PoisonError::into_inner) = Instant::now();
    }

    fn beat(&self) -> Beat {
        let step = self.completed.load(Ordering::Relaxed);
        let phase = if self.peer.as_ref().is_some_and(|peer| peer.is_waiting()) {
            Phase::WaitingForPartner
        } else if step >= self.granted.load(Ordering::Relaxed) {
            Phase::WaitingForGrant
        } else {
            Phase::Computing
        };
        let last_step = *self.last_step.lock().unwrap_or_else(PoisonError::into_inner);
        let awaited = self.peer.as_ref().and_then(|peer| peer.awaited());
        Beat { step, phase, since_last_step: last_step.elapsed().as_secs_f64(), awaited }
    }
}

/// Starts the compute thread of a run and the tasks around it; answers the stream of its events.
pub(super) fn start(
    host: Arc<Host>,
    run: RunHandle,
    linked: Linked,
    inbound: Streaming<wire::Command>,
) -> Result<mpsc::Receiver<Result<wire::EventBatch, Status>>, Status> {
    let (said, says) = mpsc::channel(PENDING_EVENTS);
    let (orders, ordered) = std_mpsc::channel();
    let (batches, stream) = mpsc::channel(PENDING_BATCHES);
    let pulse = Arc::new(Pulse {
        completed: AtomicU64::new(linked.link.resume.map_or(0, |state| state.step)),
        granted: AtomicU64::new(0),
        last_step: Mutex::new(Instant::now()),
        ended: AtomicBool::new(false),
        peer: linked.peer.as_ref().map(|peer| peer.monitor()),
    });
    let pending = Pending::default();
    let saver = Saver::new(orders.clone(), pending.clone());
    host.with_session(run.serial, |session| session.saver = Some(saver));
    let pool = host.pool.clone();
    let thread_pulse = pulse.clone();
    let thread = std::thread::Builder::new().name("run".into()).spawn(move || {
        let panicked = said.clone();
        let computing = AssertUnwindSafe(|| {
            pool.install(move || compute(linked, &ordered, &said, &thread_pulse, &pending))
        });
        if let Err(panic) = catch_unwind(computing) {
            // The receiver is closed when the coordinator is gone too.
            drop(panicked.blocking_send(Said::Panicked(panic_text(&*panic))));
        }
    });
    if let Err(error) = thread {
        host.remove(run.serial);
        return Err(Status::internal(format!("cannot start the compute thread: {error}")));
    }
    let over = CancellationToken::new();
    let commands = Commands {
        run_id: run.run_id.clone(),
        epoch: run.epoch,
        cancel: run.cancel.clone(),
        abort: run.abort.clone(),
        over: over.clone(),
        orders,
        pulse: pulse.clone(),
        answers: batches.clone(),
    };
    tokio::spawn(commands.forward(inbound));
    tokio::spawn(forward_events(host, run, over, says, pulse, batches));
    Ok(stream)
}

/// Runs the solver to its end on this thread.
fn compute(
    linked: Linked,
    orders: &std_mpsc::Receiver<Command>,
    said: &mpsc::Sender<Said>,
    pulse: &Pulse,
    pending: &Pending,
) {
    let Linked { mut ready, link, peer, snapshots } = linked;
    let monitor = peer.as_ref().map(|peer| peer.monitor());
    let exchange = peer.map(|peer| Box::new(peer) as Box<dyn Exchange>);
    let mut reporter = Reporter { said, snapshots, taken: 0, pulse, monitor, pending };
    driver::run(ready.solver.as_mut(), &ready.setup, &link, exchange, orders, &mut |event| {
        reporter.report(event);
    });
}

/// Turns the driver's events into what travels. Blocks only while the coordinator does not read.
struct Reporter<'a> {
    said: &'a mpsc::Sender<Said>,
    snapshots: Option<mpsc::Sender<(u64, ParticleFields)>>,
    taken: u64,
    pulse: &'a Pulse,
    monitor: Option<Arc<PeerMonitor>>,
    pending: &'a Pending,
}

impl Reporter<'_> {
    fn report(&mut self, event: Event) {
        let item = match event {
            Event::Step(report) => {
                self.pulse.step_completed(report.step + 1);
                BatchItem::Step(Box::new(report))
            }
            Event::Probes(values) => BatchItem::Probes(values),
            Event::Paused(held) => BatchItem::Paused(held),
            // Goes the way that the call for it came.
            Event::Checkpoint(checkpoint) => return self.pending.answer(*checkpoint),
            Event::Snapshot(fields) => {
                let (step, time) = (fields.step, fields.time);
                BatchItem::Snapshot { index: self.snapshot(fields), step, time }
            }
            Event::Finished(end) => {
                self.farewell(format!("finished at step {}", end.step));
                BatchItem::Finished {
                    step: end.step,
                    time: end.time,
                    reached_end: end.reached_end,
                    counts: end.counts,
                    state_index: self.snapshot(end.state),
                }
            }
            Event::Failed(end) => {
                self.farewell(end.fault.to_string());
                BatchItem::Failed {
                    fault: Box::new(end.fault),
                    step: end.step,
                    time: end.time,
                    counts: end.counts,
                    state_index: self.snapshot(end.state),
                }
            }
        };
        // A coordinator that is gone hears nothing; the run is cancelled elsewhere.
        drop(self.said.blocking_send(Said::Item(item)));
    }

    fn snapshot(&mut self, fields: ParticleFields) -> u64 {
        let index = self.taken;
        self.taken += 1;
        if let Some(snapshots) = &self.snapshots {
            drop(snapshots.blocking_send((index, fields)));
        }
        index
    }

    fn farewell(&self, reason: String) {
        if let Some(monitor) = &self.monitor {
            monitor.set_farewell(reason);
        }
    }
}

/// The way of commands to the compute thread.
struct Commands {
    run_id: String,
    epoch: u32,
    cancel: CancellationToken,
    abort: CancellationToken,
    /// The compute thread has ended.
    over: CancellationToken,
    orders: std_mpsc::Sender<Command>,
    pulse: Arc<Pulse>,
    answers: mpsc::Sender<Result<wire::EventBatch, Status>>,
}

impl Commands {
    /// Forwards commands until the run is over; gives it up when the coordinator does or is gone.
    async fn forward(self, mut inbound: Streaming<wire::Command>) {
        loop {
            let message = tokio::select! {
                () = self.over.cancelled() => return,
                () = self.cancel.cancelled() => break,
                message = inbound.message() => message,
            };
            let command = match message {
                Ok(Some(message)) => self.check(&message),
                // The coordinator keeps its side open until the last event, or is gone.
                Ok(None) | Err(_) => break,
            };
            match command {
                Ok(command) => self.order(command),
                Err(status) => {
                    drop(self.answers.send(Err(status)).await);
                    break;
                }
            }
        }
        if !self.pulse.ended.load(Ordering::Relaxed) {
            // First: the end of the compute thread must find the run given up.
            self.cancel.cancel();
            self.order(Command::Abort);
        }
    }

    fn order(&self, command: Command) {
        if let Command::GrantThrough(step) = command {
            self.pulse.granted.fetch_max(step, Ordering::Relaxed);
        }
        // The thread may just have ended by itself.
        let _ = self.orders.send(command);
        if command == Command::Abort {
            // The order is read between steps; this ends a wait for the partner.
            self.abort.cancel();
        }
    }

    fn check(&self, message: &wire::Command) -> Result<Command, Status> {
        if message.run_id != self.run_id || message.epoch != self.epoch {
            let text = format!(
                "a command is for run {:?}, epoch {}; expected: {:?}, epoch {}",
                message.run_id, message.epoch, self.run_id, self.epoch
            );
            return Err(Status::failed_precondition(status_text(text)));
        }
        decode_command(message).map_err(|e| Status::invalid_argument(status_text(e.to_string())))
    }
}

/// Sends events in batches, with a sign of life when there is none, and ends the run with the last.
async fn forward_events(
    host: Arc<Host>,
    run: RunHandle,
    over: CancellationToken,
    mut says: mpsc::Receiver<Said>,
    pulse: Arc<Pulse>,
    batches: mpsc::Sender<Result<wire::EventBatch, Status>>,
) {
    let mut beats = tokio::time::interval(BEAT_INTERVAL);
    beats.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Skip);
    let mut heard = Vec::with_capacity(LARGEST_BATCH);
    let mut listening = true;
    let mut defect = None;
    // Whether the run had been given up when its last event came: a coordinator that has heard that event may close the run
    // before the compute thread has ended, which gives nothing up.
    let mut given_up = None;
    loop {
        let mut items: Vec<BatchItem> = Vec::new();
        tokio::select! {
            biased;
            count = says.recv_many(&mut heard, LARGEST_BATCH) => {
                if count == 0 {
                    break;
                }
            }
            () = batches.closed(), if listening => {
                listening = false;
                if !pulse.ended.load(Ordering::Relaxed) {
                    run.cancel.cancel();
                }
                continue;
            }
            _ = beats.tick() => items.push(BatchItem::Beat(pulse.beat())),
        }
        for said in heard.drain(..) {
            match said {
                Said::Item(item) => items.push(item),
                Said::Panicked(text) => defect = Some(text),
            }
        }
        if items.iter().any(|item| matches!(item, BatchItem::Finished { .. } | BatchItem::Failed { .. })) {
            pulse.ended.store(true, Ordering::Relaxed);
            given_up.get_or_insert(run.cancel.is_cancelled());
        }
        if listening && !items.is_empty() {
            drop(batches.send(Ok(encode_batch(&run.run_id, run.epoch, &items))).await);
        }
    }
    if let Some(text) = defect {
        tracing::error!("the solver panicked: {text}");
        drop(batches.send(Err(Status::internal(status_text(format!("the solver failed: {text}"))))).await);
        host.remove(run.serial);
    }
    over.cancel();
    // Decided under the lock, as Close does: whoever cancelled the run does not come back for it, or waits for its end.
    let closed = host
        .with_session(run.serial, |session| {
            let closed = session.cancel.is_cancelled();
            if !closed {
                session.state = State::Ended;
            }
            session.saver = None;
            closed
        })
        .unwrap_or(true);
    if closed {
        host.remove(run.serial);
    }
    let abandoned = given_up.unwrap_or_else(|| run.cancel.is_cancelled());
    tracing::info!(run = run.run_id, abandoned, "run ended");
}
