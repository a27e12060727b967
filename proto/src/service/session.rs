//! The run that a server holds: one object, one life cycle.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use sph::coupling::driver::Link;
use sph::coupling::solver::{ParticleFields, Role, Solver};
use sph::coupling::stage::ClockState;
use sph::setup::RunPlan;
use tokio::sync::mpsc;
use tokio_util::sync::CancellationToken;
use tonic::Status;
use tonic::metadata::MetadataMap;

use super::saver::Saver;
use super::{ServeError, ServeOptions, SolverFactory};
use crate::description::Description;
use crate::error::status_text;
use crate::transport::peer::{GrpcPeer, PeerSlot};
use crate::transport::token::Token;

/// Everything that a server is, besides its transport.
pub(crate) struct Host {
    pub(super) factory: Box<dyn SolverFactory>,
    pub(super) description: Description,
    pub(super) options: ServeOptions,
    pub(super) pool: Arc<rayon::ThreadPool>,
    /// Cancelled when the server ends; the token of every run is its child.
    pub(super) shutdown: CancellationToken,
    slot: Mutex<Option<Session>>,
    serial: AtomicU64,
}

/// The host as the transport's services.
pub(crate) struct Skin(pub(super) Arc<Host>);

/// Tells runs of one server apart, also runs of one name.
pub(super) type Serial = u64;

/// A run from `Open` to `Close`.
pub(super) struct Session {
    pub(super) serial: Serial,
    pub(super) run_id: String,
    pub(super) token: Token,
    pub(super) state: State,
    /// Side that the run's solver plays, known once it is open.
    pub(super) role: Role,
    /// Counts the restores of the run, by all servers alike.
    pub(super) epoch: u32,
    /// Asks the compute thread for checkpoints.
    pub(super) saver: Option<Saver>,
    /// Ends everything that belongs to the run; cancelled by `Close`, by shutdown and when the coordinator is gone.
    pub(super) cancel: CancellationToken,
    /// Ends a wait for the partner; a child of `cancel`.
    pub(super) abort: CancellationToken,
    /// Cancelled when the run no longer is.
    pub(super) gone: CancellationToken,
    /// Where the partner's Exchange is awaited.
    pub(super) peer_slot: Option<PeerSlot>,
    holder: String,
    opened: Instant,
    last_call: Instant,
}

/// Where a run is in its life cycle, with what it has there.
pub(super) enum State {
    /// `Open` is at work.
    Opening,
    /// Waits for `Link`.
    Open(Box<Ready>),
    /// Waits for `Run`.
    Linked(Box<Linked>),
    /// The compute thread has the solver.
    Running,
    /// Waits for `Close`.
    Ended,
}

/// A solver with its set-up.
pub(super) struct Ready {
    pub(super) solver: Box<dyn Solver>,
    pub(super) setup: RunPlan,
    /// Where a restored run continues.
    pub(super) resume: Option<ClockState>,
}

/// A solver that knows its partner.
pub(super) struct Linked {
    pub(super) ready: Ready,
    pub(super) link: Link,
    pub(super) peer: Option<GrpcPeer>,
    pub(super) snapshots: Option<mpsc::Sender<(u64, ParticleFields)>>,
}

impl State {
    fn name(&self) -> &'static str {
        match self {
            State::Opening | State::Open(_) => "OPEN",
            State::Linked(_) => "LINKED",
            State::Running => "RUNNING",
            State::Ended => "ENDED",
        }
    }
}

impl Session {
    /// The answer to `call` in a state that does not allow it.
    pub(super) fn refused(&self, call: &str, expected: &str) -> Status {
        let at_work = if matches!(self.state, State::Opening) { ", `Open` still at work" } else { "" };
        Status::failed_precondition(status_text(format!(
            "`{call}` is not allowed in state {}{at_work}; expected: {expected}",
            self.state.name()
        )))
    }
}

impl Host {
    pub(super) fn new(factory: Box<dyn SolverFactory>, options: ServeOptions) -> Result<Self, ServeError> {
        let threads = options.threads.max(1);
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .thread_name(|k| format!("compute-{k}"))
            .build()
            .map_err(|e| ServeError::Threads { threads, reason: e.to_string() })?;
        let mut description = factory.describe();
        description.limits = options.limits();
        Ok(Self {
            factory,
            description,
            options,
            pool: Arc::new(pool),
            shutdown: CancellationToken::new(),
            slot: Mutex::new(None),
            serial: AtomicU64::new(0),
        })
    }
}

impl Host {
    /// The run held, if any. Held for moments only, never across an await.
    pub(super) fn slot(&self) -> MutexGuard<'_, Option<Session>> {
        // A panic elsewhere leaves the slot itself whole.
        self.slot.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes the server for a run.
    pub(super) fn reserve(
        &self,
        run_id: &str,
        token: Token,
        holder: &str,
    ) -> Result<Reservation<'_>, Status> {
        let mut slot = self.slot();
        if self.shutdown.is_cancelled() {
            return Err(Status::unavailable("the server is shutting down"));
        }
        if let Some(session) = slot.as_ref() {
            return Err(Status::resource_exhausted(status_text(format!(
                "busy: run `{}` is held by {} for {:.0} s, state {}; one run at a time",
                session.run_id,
                session.holder,
                session.opened.elapsed().as_secs_f64(),
                session.state.name()
            ))));
        }
        let serial = self.serial.fetch_add(1, Ordering::Relaxed);
        let cancel = self.shutdown.child_token();
        *slot = Some(Session {
            serial,
            run_id: run_id.to_owned(),
            token,
            state: State::Opening,
            role: Role::Fluid,
            epoch: 0,
            saver: None,
            abort: cancel.child_token(),
            cancel: cancel.clone(),
            gone: CancellationToken::new(),
            peer_slot: None,
            holder: if holder.is_empty() { "an unnamed coordinator".into() } else { holder.to_owned() },
            opened: Instant::now(),
            last_call: Instant::now(),
        });
        Ok(Reservation { host: self, serial, cancel, kept: false })
    }

    /// The session of `run_id`, when the caller may speak for it.
    pub(super) fn admit<'a>(
        slot: &'a mut Option<Session>,
        call: &str,
        run_id: &str,
        metadata: &MetadataMap,
    ) -> Result<&'a mut Session, Status> {
        match slot.as_mut() {
            None => Err(Status::failed_precondition(format!(
                "`{call}` is not allowed in state IDLE; expected: a run that was opened"
            ))),
            // First: whoever has no token learns nothing of the run.
            Some(session) if !session.token.admits(metadata) => Err(Status::permission_denied("not allowed")),
            Some(session) if session.run_id != run_id => Err(Status::failed_precondition(status_text(
                format!("`{call}` is for run {run_id:?}; expected: the run that is open here"),
            ))),
            Some(session) => {
                session.last_call = Instant::now();
                Ok(session)
            }
        }
    }

    /// The session of `serial`, if it still is.
    pub(super) fn with_session<T>(&self, serial: Serial, act: impl FnOnce(&mut Session) -> T) -> Option<T> {
        self.slot().as_mut().filter(|session| session.serial == serial).map(act)
    }

    /// Ends run `serial` whatever its state and frees the server.
    pub(super) fn remove(&self, serial: Serial) {
        let removed = {
            let mut slot = self.slot();
            if slot.as_ref().is_some_and(|session| session.serial == serial) { slot.take() } else { None }
        };
        // Freeing a large run takes time: outside the lock.
        if let Some(session) = removed {
            session.cancel.cancel();
            session.gone.cancel();
        }
    }

    /// Ends run `serial`, whose coordinator is gone: at once, or when its compute thread has ended.
    pub(super) fn abandon(&self, serial: Serial) {
        let ended = self.with_session(serial, |session| {
            session.cancel.cancel();
            !matches!(session.state, State::Running)
        });
        if ended == Some(true) {
            self.remove(serial);
        }
    }

    /// Ends run `serial` with the connection of its `Run`: a run that ends just before its coordinator vanishes may have
    /// sent all its events and waits for a `Close` that will not come.
    pub(super) async fn watch_connection(
        self: Arc<Self>,
        serial: Serial,
        gone: CancellationToken,
        ended: CancellationToken,
    ) {
        tokio::select! {
            () = gone.cancelled() => {}
            () = ended.cancelled() => self.abandon(serial),
        }
    }

    /// When the lease of run `serial` ends; `None` when the run no longer is.
    fn lease_end(&self, serial: Serial) -> Option<Instant> {
        self.with_session(serial, |session| match session.state {
            State::Running | State::Opening => Instant::now() + self.options.lease,
            State::Open(_) | State::Linked(_) | State::Ended => session.last_call + self.options.lease,
        })
    }

    /// Frees the server when no call for run `serial` has come within the lease.
    pub(super) async fn watch_lease(self: Arc<Self>, serial: Serial, gone: CancellationToken) {
        while let Some(end) = self.lease_end(serial) {
            if end <= Instant::now() {
                tracing::warn!(
                    lease_s = self.options.lease.as_secs_f64(),
                    "no call within the lease: run closed"
                );
                self.remove(serial);
                return;
            }
            tokio::select! {
                () = gone.cancelled() => return,
                () = tokio::time::sleep_until(end.into()) => {}
            }
        }
    }
}

/// A server taken for a run; given back when dropped before [`Reservation::keep`].
pub(super) struct Reservation<'a> {
    host: &'a Host,
    pub(super) serial: Serial,
    pub(super) cancel: CancellationToken,
    kept: bool,
}

impl Reservation<'_> {
    /// Keeps the run with its solver; false when it was closed meanwhile.
    pub(super) fn keep(mut self, ready: Ready) -> bool {
        self.kept = true;
        self.host
            .with_session(self.serial, |session| {
                session.role = ready.solver.role();
                session.state = State::Open(Box::new(ready));
                session.last_call = Instant::now();
            })
            .is_some()
    }
}

impl Drop for Reservation<'_> {
    fn drop(&mut self) {
        if !self.kept {
            self.host.remove(self.serial);
        }
    }
}
