//! How a call asks the compute thread for a checkpoint.

use std::sync::mpsc as std_mpsc;
use std::sync::{Arc, Mutex, PoisonError};

use sph::coupling::driver::{Checkpoint, Command};
use tokio::sync::oneshot;
use tonic::Status;

/// The call that waits for the compute thread's next checkpoint.
#[derive(Clone, Default)]
pub(super) struct Pending(Arc<Mutex<Option<oneshot::Sender<Checkpoint>>>>);

impl Pending {
    fn slot(&self) -> std::sync::MutexGuard<'_, Option<oneshot::Sender<Checkpoint>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Hands `checkpoint` to the call that waits for it.
    pub(super) fn answer(&self, checkpoint: Checkpoint) {
        if let Some(asker) = self.slot().take() {
            // A call that was cancelled needs none.
            drop(asker.send(checkpoint));
        }
    }
}

/// Asks the compute thread of a run for checkpoints.
pub(super) struct Saver {
    orders: std_mpsc::Sender<Command>,
    pending: Pending,
}

impl Saver {
    pub(super) fn new(orders: std_mpsc::Sender<Command>, pending: Pending) -> Self {
        Self { orders, pending }
    }

    /// Asks for the state at the boundary where the thread waits.
    pub(super) fn ask(&self) -> Result<oneshot::Receiver<Checkpoint>, Status> {
        let mut slot = self.pending.slot();
        if slot.as_ref().is_some_and(|asker| !asker.is_closed()) {
            return Err(Status::failed_precondition(
                "another `Checkpoint` is at work; expected: one at a time",
            ));
        }
        let (asker, answer) = oneshot::channel();
        *slot = Some(asker);
        // A thread that has just ended lets go of its end, and the answer fails.
        let _ = self.orders.send(Command::Checkpoint);
        Ok(answer)
    }
}

impl Drop for Saver {
    /// The compute thread has ended: there will be no answer.
    fn drop(&mut self) {
        self.pending.slot().take();
    }
}
