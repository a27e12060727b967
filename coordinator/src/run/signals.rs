//! Requests from outside to end a run.

use terminal::stop::StopSignals;
use tokio::sync::mpsc;

use crate::failure::Failure;
use crate::messages::Messages;

/// A request from outside to end the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopRequest {
    /// At the end of the granted steps, outputs complete.
    AtBoundary,
    /// At once.
    Now,
}

/// The first request to end stops the run at a step boundary, the second one at once.
pub(super) fn watch_signals(messages: Messages) -> Result<mpsc::Receiver<StopRequest>, Failure> {
    let mut signals =
        StopSignals::listen().map_err(|e| Failure::internal(format!("cannot watch for signals: {e}")))?;
    let (sender, requests) = mpsc::channel(4);
    tokio::spawn(async move {
        for request in [StopRequest::AtBoundary, StopRequest::Now] {
            signals.next().await;
            if sender.send(request).await.is_err() {
                return;
            }
            if request == StopRequest::AtBoundary {
                messages.notice("\nstopping at the next step boundary; a second signal aborts at once");
            }
        }
    });
    Ok(requests)
}
