//! The thread that writes outputs: a slow disk delays no one while its queue has room, and a disk that hangs ends the
//! run within a deadline.

use std::fs::File;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use tokio::sync::{OwnedSemaphorePermit, Semaphore, mpsc, oneshot};

use crate::failure::Failure;
use crate::results::recorder::{Recorded, Recorder, RecorderState};

/// Orders that may wait: steps and rows of probes, some kB each.
const PENDING_ORDERS: usize = 4096;
/// Frames of particles that may wait; they are large.
const PENDING_FRAMES: usize = 4;

type Task = Box<dyn FnOnce(&mut Recorder) -> Result<(), Failure> + Send>;

enum Order {
    Do(Task, Option<OwnedSemaphorePermit>),
    Finish(oneshot::Sender<Result<Recorded, Failure>>),
}

/// A recorder on a thread of its own. Dropping it leaves the files as they are.
pub struct Writer {
    orders: mpsc::Sender<Order>,
    frames: Arc<Semaphore>,
    /// The first problem; nothing is written after it.
    problem: Arc<Mutex<Option<Failure>>>,
    /// Answers when the thread has ended.
    ended: oneshot::Receiver<()>,
    deadline: Duration,
}

impl Writer {
    /// Starts the thread of `recorder`; waiting for the disk takes at most `deadline`.
    ///
    /// # Errors
    /// When there is no thread to be had.
    pub fn start(recorder: Recorder, deadline: Duration) -> Result<Self, Failure> {
        let (orders, ordered) = mpsc::channel(PENDING_ORDERS);
        let (end, ended) = oneshot::channel();
        let problem = Arc::new(Mutex::new(None));
        let first = problem.clone();
        let work = move || {
            write(recorder, ordered, &first);
            // An aborted run does not wait for this.
            let _ = end.send(());
        };
        let thread = std::thread::Builder::new().name("outputs".into()).spawn(work);
        thread.map_err(|e| Failure::internal(format!("cannot start the thread of the outputs: {e}")))?;
        let frames = Arc::new(Semaphore::new(PENDING_FRAMES));
        Ok(Self { orders, frames, problem, ended, deadline })
    }

    /// Has `task` done after those before it.
    ///
    /// # Errors
    /// When one before failed, or the disk does not take them.
    pub async fn order(
        &self,
        task: impl FnOnce(&mut Recorder) -> Result<(), Failure> + Send + 'static,
    ) -> Result<(), Failure> {
        self.send(Order::Do(Box::new(task), None)).await
    }

    /// Has `task` done, which holds the particles of a frame.
    ///
    /// # Errors
    /// As [`Writer::order`].
    pub async fn order_frame(
        &self,
        task: impl FnOnce(&mut Recorder) -> Result<(), Failure> + Send + 'static,
    ) -> Result<(), Failure> {
        let room = self.within(self.frames.clone().acquire_owned()).await?;
        // Never closed.
        self.send(Order::Do(Box::new(task), room.ok())).await
    }

    /// As [`Recorder::state`], after all orders before.
    ///
    /// # Errors
    /// As [`Writer::order`].
    pub async fn state(&self, step: u64) -> Result<(RecorderState, [File; 2]), Failure> {
        let (reply, answer) = oneshot::channel();
        self.order(move |recorder| {
            let state = recorder.state(step);
            let failed = state.as_ref().err().cloned().map_or(Ok(()), Err);
            // The caller waits, or the run was aborted.
            drop(reply.send(state));
            failed
        })
        .await?;
        self.within(answer).await?.map_err(|_| self.problem())?
    }

    /// Completes all tables.
    ///
    /// # Errors
    /// When anything could not be written.
    pub async fn finish(self) -> Result<Recorded, Failure> {
        let (reply, answer) = oneshot::channel();
        self.send(Order::Finish(reply)).await?;
        self.within(answer).await?.map_err(|_| self.problem())?
    }

    /// Ends the thread and leaves the files as they are, for another writer.
    ///
    /// # Errors
    /// When the disk hangs. What went wrong otherwise is of no matter any more.
    pub async fn close(self) -> Result<(), Failure> {
        let Self { orders, ended, deadline, .. } = self;
        drop(orders);
        match tokio::time::timeout(deadline, ended).await {
            Ok(_) => Ok(()),
            Err(_) => Err(hangs(deadline)),
        }
    }

    async fn send(&self, order: Order) -> Result<(), Failure> {
        if let Some(problem) = self.first_problem() {
            return Err(problem);
        }
        self.within(self.orders.send(order)).await?.map_err(|_| self.problem())
    }

    /// What `waiting` gives, unless the disk hangs.
    async fn within<T>(&self, waiting: impl Future<Output = T>) -> Result<T, Failure> {
        match tokio::time::timeout(self.deadline, waiting).await {
            Ok(answer) => Ok(answer),
            Err(_) => {
                let mut problem = self.problem.lock().unwrap_or_else(PoisonError::into_inner);
                Err(problem.get_or_insert(hangs(self.deadline)).clone())
            }
        }
    }

    fn first_problem(&self) -> Option<Failure> {
        self.problem.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Why the thread does not answer.
    fn problem(&self) -> Failure {
        self.first_problem().unwrap_or_else(|| Failure::internal("the thread of the outputs has ended"))
    }
}

fn hangs(deadline: Duration) -> Failure {
    Failure::output(format!(
        "no output could be written for {} s (storage stalled?); check the disk, or raise `[deadlines] disk_s`",
        deadline.as_secs_f64()
    ))
}

/// Carries out orders until there are no more, or one fails.
fn write(mut recorder: Recorder, mut orders: mpsc::Receiver<Order>, problem: &Mutex<Option<Failure>>) {
    while let Some(order) = orders.blocking_recv() {
        match order {
            Order::Do(task, _room) => {
                if let Err(failure) = task(&mut recorder) {
                    problem.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(failure);
                    return;
                }
            }
            Order::Finish(reply) => {
                drop(reply.send(recorder.finish()));
                return;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::case;
    use crate::failure::Kind;
    use crate::messages::Messages;
    use crate::results::directory::{Existing, OutputDirectory};
    use crate::results::names;
    use crate::results::progress::Progress;

    /// A recorder of the case with every key, in `out`.
    fn recorder(out: &Path) -> (Recorder, Arc<OutputDirectory>) {
        let text = include_str!("../case/testdata/everything.toml");
        let none = |_: &Path| Err("no such file".to_owned());
        let case = case::parse(text, "case.toml", Path::new("."), &none).unwrap();
        let directory = Arc::new(OutputDirectory::create(out, Existing::Refuse).unwrap());
        directory.begin().unwrap();
        let progress = Progress::new(&case, Messages::None);
        (Recorder::create(&directory, &case, &[], progress).unwrap(), directory)
    }

    fn in_runtime<T>(work: impl Future<Output = T>) -> T {
        tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap().block_on(work)
    }

    #[test]
    fn a_disk_that_hangs_is_an_output_failure_after_the_deadline() {
        let root = tempfile::tempdir().unwrap();
        let (recorder, _directory) = recorder(&root.path().join("out"));
        // The disk takes nothing until this is dropped.
        let (disk, hung) = std::sync::mpsc::channel::<()>();
        let hung = Arc::new(Mutex::new(hung));
        let failure = in_runtime(async {
            let writer = Writer::start(recorder, Duration::from_millis(50)).unwrap();
            let frame = || {
                let hung = hung.clone();
                writer.order_frame(move |_| {
                    let _ = hung.lock().unwrap_or_else(PoisonError::into_inner).recv();
                    Ok(())
                })
            };
            for _ in 0..PENDING_FRAMES {
                frame().await.unwrap();
            }
            let failure = frame().await.unwrap_err();
            // Later orders are refused at once, and the blocked thread does not hold up the end of the run.
            assert_eq!(writer.order(|_| Ok(())).await.unwrap_err(), failure);
            assert_eq!(writer.close().await.unwrap_err().kind, Kind::Output);
            failure
        });
        drop(disk);
        assert_eq!(failure.kind, Kind::Output);
        assert!(failure.message.contains("could be written for 0.05 s"), "{failure}");
        assert!(failure.message.contains("disk_s"), "{failure}");
    }

    #[test]
    fn whoever_waits_for_a_state_that_cannot_be_stored_learns_why() {
        let root = tempfile::tempdir().unwrap();
        // Two threads race for the answer.
        for attempt in 0..200 {
            let out = root.path().join(attempt.to_string());
            let (recorder, directory) = recorder(&out);
            // As a disk without room for a folder.
            std::fs::write(directory.file(names::CHECKPOINTS), "").unwrap();
            let failure = in_runtime(async {
                let writer = Writer::start(recorder, Duration::from_secs(60)).unwrap();
                writer.state(1).await.unwrap_err()
            });
            assert_eq!(failure.kind, Kind::Output, "{failure}");
            assert!(failure.message.contains(names::CHECKPOINTS), "{failure}");
        }
    }
}
