//! How to wait for what only polling shows.

use std::time::{Duration, Instant};

/// How long to poll for messages at full speed, and how long to sleep between polls afterwards.
///
/// Polling gives the core to other threads that want it. With much less than a millisecond of it the sleeps of two
/// processes feed each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Patience {
    /// Polls without sleeping for this long after something last happened.
    pub(super) eager: Duration,
    /// First sleep after that; each later one is twice as long.
    pub(super) shortest: Duration,
    /// The longest sleep.
    pub(super) longest: Duration,
}

impl Default for Patience {
    fn default() -> Self {
        Self {
            eager: Duration::from_millis(1),
            shortest: Duration::from_micros(20),
            longest: Duration::from_micros(250),
        }
    }
}

/// State of one wait.
#[derive(Debug)]
pub(super) struct Pause {
    patience: Patience,
    /// Since when it polls eagerly; `None` if it does not.
    since: Option<Instant>,
    next: Duration,
}

impl Pause {
    pub(super) fn new(patience: Patience) -> Self {
        Self { patience, since: None, next: patience.shortest }
    }

    /// To be called when something has happened.
    pub(super) fn reset(&mut self) {
        self.since = None;
        self.next = self.patience.shortest;
    }

    /// Yields, or sleeps until the time is over or the thread is unparked. Only when `eager` does it
    /// yield at first.
    pub(super) fn wait(&mut self, eager: bool) {
        if eager {
            let since = *self.since.get_or_insert_with(|| {
                self.next = self.patience.shortest;
                Instant::now()
            });
            if since.elapsed() < self.patience.eager {
                std::thread::yield_now();
                return;
            }
        } else {
            self.since = None;
        }
        std::thread::park_timeout(self.next);
        self.next = (self.next * 2).min(self.patience.longest);
    }
}
