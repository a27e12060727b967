//! How to wait for what only polling shows.

use std::time::{Duration, Instant};

/// How long to poll for messages at full speed, and how long to sleep between polls afterwards.
///
/// Polling gives the core to other threads that want it. With much less than a millisecond of it the sleeps of two
/// processes feed each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Patience {
    /// Polls without sleeping for this long while the program waits for a message.
    pub(super) eager: Duration,
    /// First sleep after that; each later one is twice as long.
    pub(super) shortest: Duration,
    /// The longest sleep while the program waits, or a message of this process is on its way.
    pub(super) longest: Duration,
    /// The longest sleep at other times: each poll takes a core from a thread that computes.
    pub(super) idle: Duration,
}

impl Default for Patience {
    fn default() -> Self {
        Self {
            eager: Duration::from_millis(10),
            shortest: Duration::from_micros(20),
            longest: Duration::from_micros(250),
            idle: Duration::from_millis(1),
        }
    }
}

/// What polling is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Aim {
    /// The program waits for a message.
    Awaited,
    /// A message of this process is on its way.
    Sending,
    /// Nothing is known to come.
    Idle,
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

    /// Yields, or sleeps until the time is over or the thread is unparked.
    pub(super) fn wait(&mut self, aim: Aim) {
        if aim == Aim::Awaited {
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
        let longest = if aim == Aim::Idle { self.patience.idle } else { self.patience.longest };
        std::thread::park_timeout(self.next.min(longest));
        self.next = (self.next * 2).min(longest);
    }
}
