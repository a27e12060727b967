//! The parts of one fluid: messages between them, and what they find together.
//!
//! ```text
//! transport   messages between parts
//! threads     parts as threads of one process
//! ```

pub mod threads;
pub mod transport;

use std::ops::AddAssign;
use std::sync::{Arc, Condvar, Mutex, PoisonError};

use serde::Serialize;
use serde::de::DeserializeOwned;
use sph::sums::{PairwiseSums, pairwise_sum};

use transport::{Lost, Transport};

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
    /// Only the thread of the solver uses it: the lock is always free.
    transport: Mutex<Box<dyn Transport>>,
    /// Whether a solver has the turn.
    taken: Mutex<bool>,
    free: Condvar,
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
        let (rank, size) = (transport.rank(), transport.size());
        Self {
            others: (size > 1).then(|| {
                Arc::new(Others {
                    rank,
                    size,
                    transport: Mutex::new(transport),
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

    /// Sends `message` to part `to`, which is another one.
    pub fn send(&self, to: usize, message: Vec<u8>) {
        self.with(|transport| transport.send(to, message));
    }

    /// Waits for the next message of part `from`, which is another one.
    pub fn receive(&self, from: usize) -> Vec<u8> {
        self.with(|transport| transport.receive(from)).unwrap_or_default()
    }

    fn with<T>(&self, work: impl FnOnce(&mut dyn Transport) -> Result<T, Lost>) -> Option<T> {
        let others = self.others.as_ref()?;
        let mut transport = others.transport.lock().unwrap_or_else(PoisonError::into_inner);
        match work(&mut **transport) {
            Ok(done) => Some(done),
            Err(Lost { rank }) => panic!("part {rank} of the fluid does not answer any more"),
        }
    }

    /// Sends `value` to part `to`.
    pub fn send_value<T: Serialize>(&self, to: usize, value: &T) {
        self.send(to, written(value));
    }

    /// Waits for a value of part `from`.
    pub fn receive_value<T: DeserializeOwned>(&self, from: usize) -> T {
        read(&self.receive(from))
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
        if self.rank() > 0 {
            return self.receive_from_first();
        }
        self.send_to_all(&joined);
        joined
    }

    /// Sends `value` of part 0 to all others, which [`Team::receive_from_first`].
    pub fn send_to_all<T: Serialize>(&self, value: &T) {
        self.handed_on(written(value));
    }

    /// Waits for what part 0 sends to all others.
    pub fn receive_from_first<T: DeserializeOwned>(&self) -> T {
        read(&self.handed_on(Vec::new()))
    }

    /// The message of part 0, which each part hands on to others.
    fn handed_on(&self, own: Vec<u8>) -> Vec<u8> {
        let (rank, size) = (self.rank(), self.size());
        let (mut message, mut distance) = (own, size.next_power_of_two());
        while distance > 1 {
            distance /= 2;
            if rank % (2 * distance) == distance {
                message = self.receive(rank - distance);
            } else if rank % (2 * distance) == 0 && rank + distance < size {
                self.send(rank + distance, message.clone());
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

    /// The sum over the tasks of all parts, of which this one has `sums`, the first that of task number `first`.
    pub fn sum<T>(&self, first: usize, sums: &[T]) -> T
    where
        T: Clone + Default + AddAssign + Serialize + DeserializeOwned,
    {
        if self.is_alone() {
            return pairwise_sum(sums);
        }
        self.join(PairwiseSums::of(first, sums.iter().cloned()), PairwiseSums::join).total()
    }
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
