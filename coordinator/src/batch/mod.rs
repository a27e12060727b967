//! Many runs of one case: each in a folder of its own, several at a time, kept when they are finished.
//!
//! A member is prepared first: its resolved case is written into its folder. `member::make` then makes it from this file
//! alone, so that a job of a cluster does the same as a thread here.

pub mod member;

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError, mpsc};
use std::time::{Duration, Instant};

use terminal::stop::StopSignals;

use self::member::{Finished, Maker};
use crate::case::overrides::Override;
use crate::failure::{Failure, Kind};
use crate::messages::Messages;
use crate::run::RunOptions;

/// Time between two lines about runs that take long.
const SILENCE: Duration = Duration::from_secs(60);

/// Folder of the members in that of a batch.
const MEMBERS: &str = "members";

/// Runs to be made.
#[derive(Clone, Debug)]
pub struct Batch<'a> {
    /// Case file.
    pub case: &'a Path,
    /// How all are run.
    pub options: &'a RunOptions,
    /// Folder of all; each member has one of its own in it.
    pub folder: &'a Path,
    /// Runs at a time.
    pub jobs: usize,
    /// Repeat runs that are finished.
    pub fresh: bool,
}

/// One run.
#[derive(Clone, Debug, PartialEq)]
pub struct Member {
    /// Name of its folder and of itself in messages.
    pub label: String,
    /// What it sets over the case.
    pub overrides: Vec<Override>,
}

/// What became of a member, in words.
pub fn line(outcome: &Result<Finished, Failure>) -> String {
    match outcome {
        Ok(run) if run.kept => "kept".to_owned(),
        Ok(run) => {
            let from = run.resumed_from.map_or(String::new(), |step| format!("continued from step {step}, "));
            format!("{from}{} steps in {:.1} s", run.steps, run.wall_seconds)
        }
        Err(failure) => format!("failed: {}", failure.message),
    }
}

impl Batch<'_> {
    /// Folder of the member called `label`.
    pub fn folder_of(&self, label: &str) -> PathBuf {
        folder_of(self.folder, label)
    }

    /// Makes all `members` and calls `each` with the place of a member, once it has ended, and what it gave.
    ///
    /// # Errors
    /// When a file cannot be written, the batch is stopped from outside, or this program is at fault; finished runs are kept.
    /// A member that fails for reasons of its own is in the result.
    pub fn run(
        &self,
        members: &[Member],
        mut each: impl FnMut(usize, &Result<Finished, Failure>),
    ) -> Result<Vec<Result<Finished, Failure>>, Failure> {
        self.options.force_arithmetic()?;
        member::must_suit_many(self.options)?;
        let jobs = self.jobs.clamp(1, members.len().max(1));
        let maker = Maker::new(&options_of_one(self.options, jobs), self.fresh);
        let waiting = Mutex::new((0..members.len()).collect::<VecDeque<usize>>());
        let stopped = AtomicBool::new(false);
        let mut outcomes: Vec<Option<Result<Finished, Failure>>> = members.iter().map(|_| None).collect();
        let mut ended: Option<Failure> = None;
        std::thread::scope(|scope| {
            let (sender, results) = mpsc::channel();
            let signals = Signals::watch(scope, &stopped);
            for _ in 0..jobs {
                let (sender, maker, waiting, stopped) = (sender.clone(), &maker, &waiting, &stopped);
                scope.spawn(move || {
                    while !stopped.load(Ordering::Relaxed) {
                        let next = waiting.lock().unwrap_or_else(PoisonError::into_inner).pop_front();
                        let Some(place) = next else { return };
                        let Member { label, overrides } = &members[place];
                        let made = maker.prepare_and_make(self.case, overrides, &self.folder_of(label));
                        if made.as_ref().is_err_and(ends_all) {
                            stopped.store(true, Ordering::Relaxed);
                        }
                        if sender.send((place, made)).is_err() {
                            return;
                        }
                    }
                });
            }
            drop(sender);
            let start = Instant::now();
            let mut done = 0;
            loop {
                match results.recv_timeout(SILENCE) {
                    Ok((place, made)) => {
                        done += 1;
                        match made {
                            Err(failure) if ends_all(&failure) => drop(ended.get_or_insert(failure)),
                            made => {
                                each(place, &made);
                                outcomes[place] = Some(made);
                            }
                        }
                    }
                    Err(mpsc::RecvTimeoutError::Timeout) => self.options.messages.progress(format_args!(
                        "{done} of {} runs done, {} min so far",
                        members.len(),
                        start.elapsed().as_secs() / 60
                    )),
                    Err(mpsc::RecvTimeoutError::Disconnected) => break,
                }
            }
            signals.end();
        });
        if let Some(failure) = ended {
            return Err(failure);
        }
        if stopped.load(Ordering::Relaxed) {
            return Err(Failure::new(Kind::Stopped, "stopped from outside between two runs"));
        }
        let all: Option<Vec<_>> = outcomes.into_iter().collect();
        all.ok_or_else(|| Failure::internal("a member of the batch has no outcome"))
    }
}

/// Whether a failure would meet every other member too.
fn ends_all(failure: &Failure) -> bool {
    matches!(failure.kind, Kind::Stopped | Kind::Output | Kind::Internal)
}

/// Folder of the member called `label` in that of its batch.
pub fn folder_of(batch: &Path, label: &str) -> PathBuf {
    batch.join(MEMBERS).join(label)
}

/// Options of one of several runs at a time: cores are shared, and no run prints what does not name it.
fn options_of_one(options: &RunOptions, jobs: usize) -> RunOptions {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let share = u16::try_from((cores / jobs).max(1)).unwrap_or(u16::MAX);
    RunOptions {
        threads: options.threads.or((jobs > 1).then_some(share)),
        messages: options.messages.min(if jobs > 1 { Messages::None } else { Messages::Warnings }),
        ..options.clone()
    }
}

/// Listens for a request to end that comes while no run does.
struct Signals(tokio::sync::oneshot::Sender<()>);

impl Signals {
    fn watch<'scope>(scope: &'scope std::thread::Scope<'scope, '_>, stopped: &'scope AtomicBool) -> Self {
        let (end, ended) = tokio::sync::oneshot::channel();
        scope.spawn(move || {
            // Without it a request between two runs is lost, and no more.
            let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
            let Ok(runtime) = runtime else { return };
            runtime.block_on(async {
                let Ok(mut signals) = StopSignals::listen() else { return };
                tokio::select! {
                    () = signals.next() => stopped.store(true, Ordering::Relaxed),
                    _ = ended => {}
                }
            });
        });
        Self(end)
    }

    fn end(self) {
        // A listener that has left is none the less ended.
        let _ = self.0.send(());
    }
}
