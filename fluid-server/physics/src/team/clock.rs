//! Where the time of a part goes, and what it sends.

use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use super::transport::Channel;

/// Messages that were sent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sent {
    /// Their number.
    pub messages: u64,
    /// Their bytes.
    pub bytes: u64,
}

/// The clock of one part.
#[derive(Clone, Copy, Debug, Default)]
pub struct Clock {
    worked: Duration,
    waited: [Duration; Channel::ALL.len()],
    sent: [Sent; Channel::ALL.len()],
    /// Since when the solver works.
    working_since: Option<Instant>,
}

impl Clock {
    /// The solver begins to work.
    pub(super) fn begin(&mut self) {
        self.working_since = Some(Instant::now());
    }

    /// It ends.
    pub(super) fn end(&mut self) {
        self.worked += self.working_since.take().map_or(Duration::ZERO, |since| since.elapsed());
    }

    /// Adds a wait that began at `since`.
    pub(super) fn waited(&mut self, channel: Channel, since: Instant) {
        self.waited[channel.index()] += since.elapsed();
    }

    /// Adds a message of `bytes`.
    pub(super) fn sends(&mut self, channel: Channel, bytes: usize) {
        let sent = &mut self.sent[channel.index()];
        sent.messages += 1;
        sent.bytes += bytes as u64;
    }

    /// Time in which the part has computed.
    pub fn computing(&self) -> Duration {
        let worked = self.worked + self.working_since.map_or(Duration::ZERO, |since| since.elapsed());
        // It waits for calls when it does not work.
        worked.saturating_sub(self.waiting(Channel::Agreement) + self.waiting(Channel::Copies))
    }

    /// Time in which it has waited for messages on `channel`.
    pub fn waiting(&self, channel: Channel) -> Duration {
        self.waited[channel.index()]
    }

    /// What it has sent on `channel`.
    pub fn sent(&self, channel: Channel) -> Sent {
        self.sent[channel.index()]
    }
}
