//! Parts as threads of one process.

use std::sync::mpsc::{Receiver, Sender, channel};

use super::transport::{Lost, Transport};

/// The end of one part.
#[derive(Debug)]
pub struct ThreadTransport {
    rank: usize,
    to: Vec<Sender<Vec<u8>>>,
    from: Vec<Receiver<Vec<u8>>>,
}

impl ThreadTransport {
    /// The ends of `size` parts, by rank.
    pub fn of_parts(size: usize) -> Vec<Self> {
        let (mut senders, mut receivers): (Vec<_>, Vec<_>) =
            (0..size).map(|_| (Vec::with_capacity(size), Vec::with_capacity(size))).unzip();
        for to in &mut senders {
            for from in &mut receivers {
                let (sender, receiver) = channel();
                to.push(sender);
                from.push(receiver);
            }
        }
        let ends = senders.into_iter().zip(receivers).enumerate();
        ends.map(|(rank, (to, from))| Self { rank, to, from }).collect()
    }
}

impl Transport for ThreadTransport {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.to.len()
    }

    fn send(&mut self, to: usize, message: Vec<u8>) -> Result<(), Lost> {
        self.to[to].send(message).map_err(|_| Lost { rank: to })
    }

    fn receive(&mut self, from: usize) -> Result<Vec<u8>, Lost> {
        self.from[from].recv().map_err(|_| Lost { rank: from })
    }
}
