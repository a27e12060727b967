//! The page that shows a run while it runs.

use std::sync::{Arc, OnceLock};

use tokio::sync::mpsc::Sender;

use super::control::ending::Ending;
use super::job::Job;
use super::signals::OutsideRequest;
use crate::failure::Failure;
use crate::page::live::Live;
use crate::page::server::{Exhibit, Order, Server};

/// A page, and the way from its buttons to the run.
pub(super) struct RunPage {
    server: Server,
    live: Arc<Live>,
    orders: Arc<OnceLock<Sender<OutsideRequest>>>,
}

impl RunPage {
    /// Serves the page of `job` and prints its address.
    ///
    /// # Errors
    /// When it cannot be served.
    pub fn start(job: &Job) -> Result<Self, Failure> {
        let live = Arc::new(Live::default());
        let orders: Arc<OnceLock<Sender<OutsideRequest>>> = Arc::default();
        let way = orders.clone();
        let take = move |order: Order| {
            let request = match order {
                Order::Checkpoint => OutsideRequest::Checkpoint,
                Order::Stop => OutsideRequest::AtBoundary,
            };
            // One that waits already says the same.
            way.get().is_some_and(|sender| sender.try_send(request).is_ok())
        };
        let server = Server::start(Exhibit {
            folder: job.directory.path().to_owned(),
            live: Some(live.clone()),
            orders: Some(Box::new(take)),
        })?;
        job.options.messages.notice(format_args!("page of the run: {}", server.link()));
        Ok(Self { server, live, orders })
    }

    /// Where the run tells what it does.
    pub fn live(&self) -> &Arc<Live> {
        &self.live
    }

    /// Buttons of the page send requests to `sender` from here on.
    pub fn take_orders(&self, sender: Sender<OutsideRequest>) {
        // Called once.
        drop(self.orders.set(sender));
    }

    /// Ends the page.
    pub fn end(self, ending: Result<&Ending, &Failure>) {
        self.live.doing(match ending {
            Ok(Ending::Completed) => "ended: completed; report.html shows the results",
            Ok(Ending::Stopped) => "ended: stopped; report.html shows the results so far",
            Ok(Ending::Failed(_) | Ending::Lost { .. }) | Err(_) => "ended: failed; report.html shows why",
        });
        self.server.end();
    }
}
