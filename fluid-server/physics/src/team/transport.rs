//! Messages between the parts of one fluid.

use std::fmt::Debug;

/// Sends and receives messages. Those from one part to another arrive in the order in which they were sent.
pub trait Transport: Send + Debug {
    /// Number of this part.
    fn rank(&self) -> usize;

    /// Number of parts.
    fn size(&self) -> usize;

    /// Sends `message` to part `to`; does not wait until it is received.
    ///
    /// # Errors
    /// When the part does not answer any more.
    fn send(&mut self, to: usize, message: Vec<u8>) -> Result<(), Lost>;

    /// Waits for the next message of part `from`.
    ///
    /// # Errors
    /// When the part does not answer any more.
    fn receive(&mut self, from: usize) -> Result<Vec<u8>, Lost>;
}

/// A part does not answer any more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lost {
    /// Number of the part.
    pub rank: usize,
}
