//! Messages between the parts of one fluid.

use std::fmt::Debug;

/// What a message is for. A channel keeps the order of its messages, whatever waits in others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// What the first part does next.
    Calls,
    /// What all parts find together, and particles that change their owner.
    Agreement,
    /// Copies of particles.
    Copies,
}

impl Channel {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Calls, Self::Agreement, Self::Copies];

    /// Its place among all.
    pub fn index(self) -> usize {
        self as usize
    }
}

/// Sends and receives messages. Those from one part to another on one channel arrive in the order in which they were sent.
pub trait Transport: Send + Debug {
    /// Number of this part.
    fn rank(&self) -> usize;

    /// Number of parts.
    fn size(&self) -> usize;

    /// Whether parts share cores: then the time that one takes says nothing of its work.
    fn shares_cores(&self) -> bool;

    /// Sends `message` to part `to` on `channel`; does not wait until the other part asks for it.
    ///
    /// # Errors
    /// When the part does not answer any more.
    fn send(&mut self, to: usize, channel: Channel, message: Vec<u8>) -> Result<(), Lost>;

    /// Waits for the next message of part `from` on `channel`.
    ///
    /// # Errors
    /// When the part does not answer any more.
    fn receive(&mut self, from: usize, channel: Channel) -> Result<Vec<u8>, Lost>;
}

/// A part does not answer any more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lost {
    /// Number of the part.
    pub rank: usize,
}
