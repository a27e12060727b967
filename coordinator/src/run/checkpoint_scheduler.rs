//! When checkpoints of a run are due, and writing them while the solvers continue.

use std::fs::File;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use proto::checkpoint::CheckpointData;
use sph::coupling::driver::TRACE;
use tokio::task::JoinHandle;
use tracing::trace_span;

use crate::checkpoint::{Disk, OriginDigests, OutputState, RunCheckpoint, Store, Written};
use crate::failure::Failure;
use crate::results::error::OutputError;
use crate::results::summary::Checkpoints;
use crate::results::writer::Writer;

/// When checkpoints are due.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Schedule {
    /// At every multiple of this number of steps.
    pub every_steps: Option<u64>,
    /// At the first boundary after this much wall time.
    pub every_wall: Duration,
}

/// What a checkpoint records of its case.
#[derive(Clone, Debug)]
pub struct CaseFacts {
    /// As `Case::identity` gives it.
    pub identity: String,
    /// What the run started from.
    pub origin: OriginDigests,
}

/// Takes checkpoints of one run.
pub struct CheckpointScheduler {
    store: Store,
    schedule: Schedule,
    case: CaseFacts,
    started: Instant,
    /// Wall time of the run before this process or attempt.
    wall_before: f64,
    last: Instant,
    requested: Instant,
    /// Longest wait for the disk.
    deadline: Duration,
    writing: Option<JoinHandle<Result<Written, OutputError>>>,
    figures: Checkpoints,
}

impl CheckpointScheduler {
    /// A scheduler of the checkpoints in `folder` of a run of `case`; one that is not on the disk within `deadline` ends the
    /// run.
    pub fn new(folder: PathBuf, schedule: Schedule, deadline: Duration, case: CaseFacts) -> Self {
        let now = Instant::now();
        Self {
            store: Store::new(folder),
            schedule,
            case,
            started: now,
            wall_before: 0.0,
            last: now,
            requested: now,
            deadline,
            writing: None,
            figures: Checkpoints::default(),
        }
    }

    /// The checkpoints.
    pub fn store(&self) -> &Store {
        &self.store
    }

    /// Continues from `checkpoint`.
    pub fn resume(&mut self, checkpoint: &RunCheckpoint) {
        self.wall_before = checkpoint.outputs.wall_seconds;
        self.started = Instant::now();
        self.last = self.started;
        self.figures.resumed_from.get_or_insert(checkpoint.step);
        self.figures.last_step = Some(checkpoint.step);
    }

    /// Wall time of the run so far \[s\].
    pub fn wall_seconds(&self) -> f64 {
        self.wall_before + self.started.elapsed().as_secs_f64()
    }

    /// The last boundary to which steps may be granted from that of `completed` on before a checkpoint.
    pub fn bound(&self, completed: u64) -> u64 {
        let next = |every: u64| (completed / every).saturating_add(1).saturating_mul(every);
        self.schedule.every_steps.map_or(u64::MAX, next)
    }

    /// Whether one is due by the steps at the boundary of `completed`, where none was taken yet.
    pub fn due_at(&self, completed: u64) -> bool {
        completed > 0
            && self.figures.last_step != Some(completed)
            && self.schedule.every_steps.is_some_and(|every| completed.is_multiple_of(every))
    }

    /// Whether one is due by the clock; never while another is being written.
    pub fn due_by_clock(&self) -> bool {
        self.writing.is_none() && self.last.elapsed() >= self.schedule.every_wall
    }

    /// Notes that the solvers' states were requested; the solvers wait.
    pub fn requested(&mut self) {
        self.requested = Instant::now();
    }

    /// Takes the solvers' states at the boundary of `step`; they need not wait any longer. Writing proceeds on a thread of its own.
    ///
    /// # Errors
    /// When the outputs, or the checkpoint before, could not be brought to the disk.
    pub async fn write(
        &mut self,
        step: u64,
        sides: Vec<CheckpointData>,
        outputs: &Writer,
    ) -> Result<(), Failure> {
        self.finish().await?;
        let (recorder, tables) = outputs.state(step).await?;
        let time = sides.first().map_or(0.0, |side| side.header.time);
        let CaseFacts { identity: case, origin } = self.case.clone();
        let outputs = OutputState { case, recorder, wall_seconds: self.wall_seconds(), origin };
        let checkpoint = RunCheckpoint { step, time, sides, outputs };
        self.figures.held_seconds += self.requested.elapsed().as_secs_f64();
        self.last = Instant::now();
        self.figures.last_step = Some(step);
        let store = self.store.clone();
        self.writing = Some(tokio::task::spawn_blocking(move || {
            let _span = trace_span!(target: TRACE, "write checkpoint").entered();
            write_files(&store, &checkpoint, &tables)
        }));
        Ok(())
    }

    /// Waits until the last checkpoint is on the disk.
    ///
    /// # Errors
    /// When it could not be written; earlier ones are as they were.
    pub async fn finish(&mut self) -> Result<(), Failure> {
        let Some(writing) = self.writing.as_mut() else { return Ok(()) };
        let Ok(written) = tokio::time::timeout(self.deadline, writing).await else {
            return Err(Failure::output(format!(
                "no checkpoint could be written within {} s (storage stalled?); check the disk, or raise `[deadlines] disk_s`",
                self.deadline.as_secs_f64()
            )));
        };
        self.writing = None;
        self.take(written)
    }

    /// Waits until a checkpoint that is being written is on the disk; without end when there is none.
    ///
    /// # Errors
    /// As [`CheckpointScheduler::finish`].
    pub async fn written(&mut self) -> Result<(), Failure> {
        let Some(writing) = self.writing.as_mut() else { return std::future::pending().await };
        // Without a deadline: the run continues meanwhile.
        let written = writing.await;
        self.writing = None;
        self.take(written)
    }

    fn take(
        &mut self,
        written: Result<Result<Written, OutputError>, tokio::task::JoinError>,
    ) -> Result<(), Failure> {
        let written = written.map_err(|e| Failure::internal(format!("writing a checkpoint failed: {e}")))?;
        let written = written?;
        self.figures.taken += 1;
        self.figures.largest_bytes = self.figures.largest_bytes.max(written.bytes);
        self.figures.written_seconds += written.duration.as_secs_f64();
        Ok(())
    }

    /// Figures for the summary.
    pub fn figures(&self) -> &Checkpoints {
        &self.figures
    }
}

/// Brings tables and checkpoint to the disk, in this order: what a checkpoint refers to is there before it.
fn write_files(store: &Store, checkpoint: &RunCheckpoint, tables: &[File]) -> Result<Written, OutputError> {
    for table in tables {
        table
            .sync_all()
            .map_err(|e| OutputError::file("sync", std::path::Path::new("tables of the run"), e))?;
    }
    store.write(&mut Disk, checkpoint)
}
