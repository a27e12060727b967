//! Requests from outside during a run.

use terminal::stop::StopSignals;
use tokio::sync::mpsc;

use crate::failure::Failure;
use crate::messages::Messages;

/// Requests that may wait; more are refused or wait with their sender.
const PENDING: usize = 4;

/// A request from outside during a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutsideRequest {
    /// To end at the end of the granted steps, outputs complete.
    AtBoundary,
    /// To end at once.
    Now,
    /// A checkpoint at the end of the granted steps.
    Checkpoint,
}

/// The first request to end stops the run at a step boundary, the second one at once.
///
/// The sender is for requests that come another way.
pub(super) fn watch_signals(
    messages: Messages,
) -> Result<(mpsc::Sender<OutsideRequest>, mpsc::Receiver<OutsideRequest>), Failure> {
    let mut signals =
        StopSignals::listen().map_err(|e| Failure::internal(format!("cannot watch for signals: {e}")))?;
    let (sender, requests) = mpsc::channel(PENDING);
    let others = sender.clone();
    tokio::spawn(async move {
        for request in [OutsideRequest::AtBoundary, OutsideRequest::Now] {
            signals.next().await;
            if sender.send(request).await.is_err() {
                return;
            }
            if request == OutsideRequest::AtBoundary {
                messages.notice("\nstopping at the next step boundary; a second signal aborts at once");
            }
        }
    });
    Ok((others, requests))
}
