//! Parts as threads of one process.

use std::sync::mpsc::{Receiver, Sender, channel};

use super::transport::{Channel, Lost, Transport};

/// The end of one part.
#[derive(Debug)]
pub struct ThreadTransport {
    rank: usize,
    /// By part, then by channel.
    to: Vec<Vec<Sender<Vec<u8>>>>,
    from: Vec<Vec<Receiver<Vec<u8>>>>,
}

impl ThreadTransport {
    /// The ends of `size` parts, by rank.
    pub fn of_parts(size: usize) -> Vec<Self> {
        let (mut senders, mut receivers): (Vec<_>, Vec<_>) =
            (0..size).map(|_| (Vec::with_capacity(size), Vec::with_capacity(size))).unzip();
        for to in &mut senders {
            for from in &mut receivers {
                let (of_sender, of_receiver) = Channel::ALL.map(|_| channel()).into_iter().unzip();
                to.push(of_sender);
                from.push(of_receiver);
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

    fn shares_cores(&self) -> bool {
        true
    }

    fn send(&mut self, to: usize, channel: Channel, message: Vec<u8>) -> Result<(), Lost> {
        self.to[to][channel.index()].send(message).map_err(|_| Lost { rank: to })
    }

    fn receive(&mut self, from: usize, channel: Channel) -> Result<Vec<u8>, Lost> {
        self.from[from][channel.index()].recv().map_err(|_| Lost { rank: from })
    }
}
