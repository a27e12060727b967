//! Messages by MPI, for which there is a thread of its own.
//!
//! The thread works in rounds. In each it lends all messages that wait to MPI, in a scope of rsmpi which it leaves when they
//! are sent: the buffers outlive the requests. Meanwhile, and whenever there is nothing to send, it takes in what arrives.
//! Every part always takes in, so that every round ends whatever the program does.
//!
//! So messages travel while the program computes. Short ones are sent by the thread that has them, where none waits: the
//! library takes them in at once, while a core for the thread for MPI may be free only milliseconds later. The threads call
//! the library in turn.

use std::fmt;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use fluid::{Channel, Lost, Transport};
use mpi::Threading;
use mpi::request::StaticScope;
use mpi::topology::SimpleCommunicator;
use mpi::traits::*;

use super::launch;
use super::pause::{Aim, Patience, Pause};
use super::pieces::{Arrival, Assembly, BYE, NOTHING, PIECE, index, pieces, rank};

/// Largest message that is sent by the thread that has it: libraries send as much at once.
const SHORT: usize = 4000;

/// Why MPI could not be started.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// It can be started once in a process.
    #[error("MPI was started already in this process")]
    Again,
    /// The library allows no threads.
    #[error("the MPI library allows threads at level {given:?} only; {needed:?} is needed")]
    Threads {
        /// What is needed.
        needed: Threading,
        /// What the library gives.
        given: Threading,
    },
    /// The processes did not find each other.
    #[error(
        "{launched} processes were started, but MPI finds {found}; start them by the launcher of the MPI library that \
         this program was built with"
    )]
    Size {
        /// Number of processes by the launcher.
        launched: usize,
        /// Number of processes that MPI knows of.
        found: usize,
    },
    /// No thread could be made for it.
    #[error("cannot start the thread for MPI: {0}")]
    Thread(std::io::Error),
    /// The thread that starts MPI ended too early.
    #[error("the thread for MPI ended while it started")]
    Ended,
}

/// A message, its channel, and the part to which it goes.
type Order = (usize, Channel, Vec<u8>);

/// Messages of one part that have arrived, by channel.
type Inbox = Vec<Receiver<Vec<u8>>>;

/// What the thread reports when MPI has started.
struct Started {
    rank: usize,
    inboxes: Vec<Inbox>,
}

/// What the threads of a transport share.
#[derive(Debug, Default)]
struct Shared {
    /// Held during each call of the library.
    library: Mutex<()>,
    /// Number of messages on each channel that the thread for MPI has yet to send.
    waiting: [AtomicUsize; Channel::ALL.len()],
    /// Whether `receive` waits; the thread then polls eagerly.
    waited_for: AtomicBool,
}

impl Shared {
    fn library(&self) -> MutexGuard<'_, ()> {
        self.library.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Messages between the processes of an MPI program.
///
/// When it is dropped it takes leave of the other parts, and waits until all of them have done so.
pub struct MpiTransport {
    rank: usize,
    inboxes: Vec<Inbox>,
    /// `None` once it is dropped.
    orders: Option<Sender<Order>>,
    shared: Arc<Shared>,
    /// `None` once it is dropped.
    thread: Option<JoinHandle<()>>,
}

impl fmt::Debug for MpiTransport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("MpiTransport")
            .field("rank", &self.rank)
            .field("size", &self.inboxes.len())
            .finish_non_exhaustive()
    }
}

impl MpiTransport {
    /// Starts MPI.
    ///
    /// # Errors
    /// When it can not be started, or does not find the processes that were started with this one.
    pub fn start(patience: Patience) -> Result<Self, StartError> {
        let (orders, taken) = channel();
        let (started, ready) = sync_channel(1);
        let shared = Arc::new(Shared::default());
        let of_thread = Arc::clone(&shared);
        let thread = std::thread::Builder::new()
            .name("mpi".to_owned())
            .spawn(move || {
                let pause = Pause::new(patience);
                run(pause, &of_thread, &taken, |result| {
                    drop(started.send(result));
                });
            })
            .map_err(StartError::Thread)?;
        let Started { rank, inboxes } = ready.recv().map_err(|_| StartError::Ended)??;
        Ok(Self { rank, inboxes, orders: Some(orders), shared, thread: Some(thread) })
    }

    /// Sends a short `message`: the library takes it in before the other process does.
    fn send_at_once(&self, to: usize, channel: Channel, message: &[u8]) {
        let process = SimpleCommunicator::world();
        let process = process.process_at_rank(rank(to));
        mpi::request::scope(|scope| {
            for (tag, bytes) in pieces(channel, message, PIECE) {
                let library = self.shared.library();
                let mut open = process.immediate_send_with_tag(scope, bytes, tag).test();
                drop(library);
                while let Err(request) = open {
                    std::thread::yield_now();
                    let _library = self.shared.library();
                    open = request.test();
                }
            }
        });
    }

    fn wake(&self) {
        if let Some(thread) = &self.thread {
            thread.thread().unpark();
        }
    }
}

impl Transport for MpiTransport {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.inboxes.len()
    }

    fn shares_cores(&self) -> bool {
        // Where the launcher does not say how many are here, all may be.
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let here = launch::launched().and_then(|launched| launched.here).unwrap_or(self.size());
        here > cores
    }

    fn send(&mut self, to: usize, channel: Channel, message: Vec<u8>) -> Result<(), Lost> {
        if to >= self.size() {
            return Err(Lost { rank: to });
        }
        let orders = self.orders.as_ref().ok_or(Lost { rank: to })?;
        // Messages on a channel keep their order.
        let waiting = &self.shared.waiting[channel.index()];
        if message.len() <= SHORT && waiting.load(Ordering::Acquire) == 0 {
            self.send_at_once(to, channel, &message);
            return Ok(());
        }
        waiting.fetch_add(1, Ordering::Relaxed);
        orders.send((to, channel, message)).map_err(|_| Lost { rank: to })?;
        self.wake();
        Ok(())
    }

    fn receive(&mut self, from: usize, channel: Channel) -> Result<Vec<u8>, Lost> {
        let lost = Lost { rank: from };
        let inbox = self.inboxes.get(from).and_then(|inbox| inbox.get(channel.index())).ok_or(lost)?;
        match inbox.try_recv() {
            Ok(message) => return Ok(message),
            Err(TryRecvError::Disconnected) => return Err(lost),
            Err(TryRecvError::Empty) => {}
        }
        self.shared.waited_for.store(true, Ordering::Relaxed);
        self.wake();
        let message = inbox.recv();
        self.shared.waited_for.store(false, Ordering::Relaxed);
        message.map_err(|_| lost)
    }
}

impl Drop for MpiTransport {
    fn drop(&mut self) {
        self.orders = None;
        self.wake();
        if let Some(thread) = self.thread.take() {
            // It panics only if MPI misbehaves, and has said so then.
            drop(thread.join());
        }
    }
}

/// The whole life of the thread, from the start of MPI to its end.
fn run(
    pause: Pause,
    shared: &Shared,
    orders: &Receiver<Order>,
    report: impl FnOnce(Result<Started, StartError>),
) {
    let needed = Threading::Serialized;
    let Some((universe, given)) = mpi::initialize_with_threading(needed) else {
        report(Err(StartError::Again));
        return;
    };
    if given < needed {
        report(Err(StartError::Threads { needed, given }));
        return;
    }
    let world = universe.world();
    let rank = index(world.rank());
    let size = index(world.size());
    if let Some(launched) = launch::launched().and_then(|launched| launched.processes).filter(|n| *n != size)
    {
        report(Err(StartError::Size { launched, found: size }));
        return;
    }
    let (outlets, inboxes) = (0..size)
        .map(|_| {
            let (outlets, inbox) = Channel::ALL.map(|_| channel()).into_iter().unzip();
            (Some(outlets), inbox)
        })
        .unzip();
    let mut post = Post { assembly: Assembly::new(size), world, outlets, pause, shared };
    report(Ok(Started { rank, inboxes }));
    post.serve(orders);
    post.close(rank);
    // `universe` ends MPI here, in the thread that started it.
}

/// What sends and receives.
struct Post<'a> {
    world: SimpleCommunicator,
    assembly: Assembly,
    /// Where to put what comes from each part, by channel; `None` once it has taken leave.
    outlets: Vec<Option<Vec<Sender<Vec<u8>>>>>,
    pause: Pause,
    shared: &'a Shared,
}

impl Post<'_> {
    /// Carries out orders and takes in messages until no more orders can come.
    fn serve(&mut self, orders: &Receiver<Order>) {
        loop {
            let mut batch: Vec<Order> = Vec::new();
            let closed = loop {
                match orders.try_recv() {
                    Ok(order) => batch.push(order),
                    Err(TryRecvError::Empty) => break false,
                    Err(TryRecvError::Disconnected) => break true,
                }
            };
            if !batch.is_empty() {
                self.round(&batch);
                for (_, channel, _) in &batch {
                    self.shared.waiting[channel.index()].fetch_sub(1, Ordering::Release);
                }
            } else if closed {
                return;
            } else {
                self.take_in_or_pause(Aim::Idle);
            }
        }
    }

    /// Sends `batch`; takes in meanwhile.
    fn round(&mut self, batch: &[Order]) {
        mpi::request::scope(|scope| {
            let mut open = Vec::with_capacity(batch.len());
            let library = self.shared.library();
            for (to, channel, message) in batch {
                let process = self.world.process_at_rank(rank(*to));
                for (tag, bytes) in pieces(*channel, message, PIECE) {
                    open.push(process.immediate_send_with_tag(scope, bytes, tag));
                }
            }
            drop(library);
            loop {
                let library = self.shared.library();
                open = open.into_iter().filter_map(|request| request.test().err()).collect();
                drop(library);
                if open.is_empty() {
                    break;
                }
                self.take_in_or_pause(Aim::Sending);
            }
        });
    }

    /// Takes in one piece of a message, or pauses if none is there: for a message that the program waits for, or `otherwise`.
    fn take_in_or_pause(&mut self, otherwise: Aim) {
        if self.take_in() {
            self.pause.reset();
        } else {
            let is_awaited = self.shared.waited_for.load(Ordering::Relaxed);
            self.pause.wait(if is_awaited { Aim::Awaited } else { otherwise });
        }
    }

    /// Takes in one piece of a message, if one is there.
    fn take_in(&mut self) -> bool {
        let library = self.shared.library();
        let Some(matched) = self.world.any_process().immediate_matched_probe() else {
            return false;
        };
        let taken = self.assembly.take(matched);
        drop(library);
        match taken {
            (from, Arrival::Whole(channel, message)) => {
                if let Some(outlets) = &self.outlets[from] {
                    // Not wanted any more where the transport is being dropped.
                    drop(outlets[channel.index()].send(message));
                }
            }
            (_, Arrival::Part) => {}
            (from, Arrival::Bye) => self.outlets[from] = None,
        }
        true
    }

    /// Takes leave of the other parts and waits until all of them have done so.
    fn close(&mut self, own: usize) {
        let size = self.outlets.len();
        let library = self.shared.library();
        let mut byes: Vec<_> = (0..size)
            .filter(|to| *to != own)
            .map(|to| {
                let process = self.world.process_at_rank(rank(to));
                process.immediate_send_with_tag(StaticScope, NOTHING, BYE)
            })
            .collect();
        drop(library);
        self.outlets[own] = None;
        loop {
            let library = self.shared.library();
            byes = byes.into_iter().filter_map(|bye| bye.test().err()).collect();
            drop(library);
            if byes.is_empty() && self.outlets.iter().all(Option::is_none) {
                return;
            }
            self.take_in_or_pause(Aim::Sending);
        }
    }
}
