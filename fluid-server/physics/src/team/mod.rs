//! The parts of one fluid: messages between them, and what they find together.
//!
//! ```text
//! transport   messages between parts
//! threads     parts as threads of one process
//! clock       where the time of a part goes, and what it sends
//! ```

pub mod clock;
pub mod threads;
pub mod transport;

use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Instant;

use serde::Serialize;
use serde::de::DeserializeOwned;
use sph::coupling::driver::TRACE;
use tracing::trace_span;

use clock::Clock;
use transport::{Channel, Lost, Transport};

/// The parts of a fluid as one of them sees them; by default it is alone.
///
/// All parts must make the same calls in the same order. A part that does not answer ends the others: a fluid without one
/// of its parts is none.
#[derive(Clone, Debug, Default)]
pub struct Team {
    others: Option<Arc<Others>>,
}

#[derive(Debug)]
struct Others {
    rank: usize,
    size: usize,
    shares_cores: bool,
    /// Only the thread of the solver uses it: the lock is always free.
    post: Mutex<Post>,
    /// Whether a solver has the turn.
    taken: Mutex<bool>,
    free: Condvar,
}

#[derive(Debug)]
struct Post {
    transport: Box<dyn Transport>,
    clock: Clock,
}

/// A call of the solver under way, until it is dropped: its time counts as work.
#[derive(Debug)]
pub struct Working(Option<Arc<Others>>);

impl Drop for Working {
    fn drop(&mut self) {
        if let Some(others) = &self.0 {
            others.post.lock().unwrap_or_else(PoisonError::into_inner).clock.end();
        }
    }
}

/// The right of a solver to make the others work, until it is dropped: they work for one at a time.
#[derive(Debug)]
pub struct Turn(Option<Arc<Others>>);

impl Drop for Turn {
    fn drop(&mut self) {
        if let Some(others) = &self.0 {
            *others.taken.lock().unwrap_or_else(PoisonError::into_inner) = false;
            others.free.notify_one();
        }
    }
}

impl Team {
    /// The team of the parts that `transport` joins.
    pub fn new(transport: Box<dyn Transport>) -> Self {
        let (rank, size, shares_cores) = (transport.rank(), transport.size(), transport.shares_cores());
        Self {
            others: (size > 1).then(|| {
                Arc::new(Others {
                    rank,
                    size,
                    shares_cores,
                    post: Mutex::new(Post { transport, clock: Clock::default() }),
                    taken: Mutex::new(false),
                    free: Condvar::new(),
                })
            }),
        }
    }

    /// Waits until no other solver has the turn, and takes it.
    pub fn turn(&self) -> Turn {
        if let Some(others) = &self.others {
            let mut taken = others.taken.lock().unwrap_or_else(PoisonError::into_inner);
            while *taken {
                taken = others.free.wait(taken).unwrap_or_else(PoisonError::into_inner);
            }
            *taken = true;
        }
        Turn(self.others.clone())
    }

    /// Whether there is one part only.
    pub fn is_alone(&self) -> bool {
        self.others.is_none()
    }

    /// Number of this part.
    pub fn rank(&self) -> usize {
        self.others.as_ref().map_or(0, |others| others.rank)
    }

    /// Number of parts.
    pub fn size(&self) -> usize {
        self.others.as_ref().map_or(1, |others| others.size)
    }

    /// Whether parts share cores.
    pub fn shares_cores(&self) -> bool {
        self.others.as_ref().is_some_and(|others| others.shares_cores)
    }

    /// Starts the clock of a call of the solver.
    pub fn work(&self) -> Working {
        self.with(|post| post.clock.begin());
        Working(self.others.clone())
    }

    /// Where the time of this part has gone, and what it has sent.
    pub fn clock(&self) -> Clock {
        self.with(|post| post.clock).unwrap_or_default()
    }

    /// Sends `message` to part `to`, which is another one.
    pub fn send(&self, to: usize, channel: Channel, message: Vec<u8>) {
        self.with(|post| {
            post.clock.sends(channel, message.len());
            post.transport.send(to, channel, message).unwrap_or_else(lost_part);
        });
    }

    /// Waits for the next message of part `from`, which is another one.
    pub fn receive(&self, from: usize, channel: Channel) -> Vec<u8> {
        let _span = match channel {
            Channel::Calls => trace_span!(target: TRACE, "wait for call").entered(),
            Channel::Agreement => trace_span!(target: TRACE, "wait for agreement", part = from).entered(),
            Channel::Copies => trace_span!(target: TRACE, "wait for copies", part = from).entered(),
        };
        let message = self.with(|post| {
            let since = Instant::now();
            let message = post.transport.receive(from, channel).unwrap_or_else(lost_part);
            post.clock.waited(channel, since);
            message
        });
        message.unwrap_or_default()
    }

    fn with<T>(&self, work: impl FnOnce(&mut Post) -> T) -> Option<T> {
        let others = self.others.as_ref()?;
        Some(work(&mut others.post.lock().unwrap_or_else(PoisonError::into_inner)))
    }

    /// Sends `value` to part `to`.
    pub fn send_value<T: Serialize>(&self, to: usize, value: &T) {
        self.send(to, Channel::Agreement, written(value));
    }

    /// Waits for a value of part `from`.
    pub fn receive_value<T: DeserializeOwned>(&self, from: usize) -> T {
        read(&self.receive(from, Channel::Agreement))
    }

    /// Makes all others do what `call` says, which is their [`Team::next_call`]. Part 0 does so.
    pub fn call<T: Serialize>(&self, call: &T) {
        self.handed_on(Channel::Calls, written(call));
    }

    /// Waits for what part 0 wants done.
    pub fn next_call<T: DeserializeOwned>(&self) -> T {
        read(&self.handed_on(Channel::Calls, Vec::new()))
    }

    /// The values of all parts joined in their order, which part 0 gets; others get their own ones, or those of some.
    pub fn join_at_first<T: Serialize + DeserializeOwned>(&self, own: T, join: impl Fn(&mut T, T)) -> T {
        let (rank, size) = (self.rank(), self.size());
        let (mut value, mut distance) = (own, 1);
        while distance < size {
            if rank % (2 * distance) == distance {
                self.send_value(rank - distance, &value);
                break;
            }
            if rank + distance < size {
                join(&mut value, self.receive_value(rank + distance));
            }
            distance *= 2;
        }
        value
    }

    /// The values of all parts joined in their order.
    pub fn join<T: Serialize + DeserializeOwned>(&self, own: T, join: impl Fn(&mut T, T)) -> T {
        if self.is_alone() {
            return own;
        }
        let joined = self.join_at_first(own, join);
        let message = if self.rank() > 0 { Vec::new() } else { written(&joined) };
        let message = self.handed_on(Channel::Agreement, message);
        if self.rank() > 0 { read(&message) } else { joined }
    }

    /// The message of part 0, which each part hands on to others.
    fn handed_on(&self, channel: Channel, own: Vec<u8>) -> Vec<u8> {
        let (rank, size) = (self.rank(), self.size());
        let (mut message, mut distance) = (own, size.next_power_of_two());
        while distance > 1 {
            distance /= 2;
            if rank % (2 * distance) == distance {
                message = self.receive(rank - distance, channel);
            } else if rank % (2 * distance) == 0 && rank + distance < size {
                self.send(rank + distance, channel, message.clone());
            }
        }
        message
    }

    /// The value of each part.
    pub fn all<T: Serialize + DeserializeOwned>(&self, own: T) -> Vec<T> {
        self.join(vec![own], |all: &mut Vec<T>, more| all.extend(more))
    }

    /// The largest value.
    pub fn largest(&self, own: f64) -> f64 {
        self.join(own, |largest, other| *largest = largest.max(other))
    }

    /// Whether it holds for any part.
    pub fn any(&self, own: bool) -> bool {
        self.join(own, |any, other| *any |= other)
    }

    /// Values that one part each has found; zero where none has.
    pub fn complete(&self, own: Vec<Option<f64>>) -> Vec<f64> {
        let all = self.join(own, |all, others| {
            all.iter_mut().zip(others).for_each(|(value, other)| *value = value.or(other));
        });
        all.into_iter().map(Option::unwrap_or_default).collect()
    }
}

/// A fluid without one of its parts is none.
fn lost_part<T>(lost: Lost) -> T {
    panic!("part {} of the fluid does not answer any more", lost.rank)
}

/// `value` as a message. All parts are of one program: what one writes the others can read.
fn written<T: Serialize>(value: &T) -> Vec<u8> {
    match postcard::to_stdvec(value) {
        Ok(message) => message,
        Err(error) => panic!("a message between parts of the fluid can not be written: {error}"),
    }
}

fn read<T: DeserializeOwned>(message: &[u8]) -> T {
    match postcard::from_bytes(message) {
        Ok(value) => value,
        Err(error) => panic!("a message between parts of the fluid can not be read: {error}"),
    }
}
