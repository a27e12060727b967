//! Writing a recording beside a run.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::thread::JoinHandle;

use prost::Message;
use sph::coupling::solver::Role;
use tokio::sync::mpsc;

use super::{Attempt, MAGIC, RecordKind, RecordingError, VERSION, record_head};
use crate::convert::Convert;
use crate::wire;

/// Records that may wait for the disk; then the relay waits.
const PENDING_RECORDS: usize = 32;

/// What is to be written.
pub(crate) enum Record {
    Attempt(Box<Attempt>),
    Frame(Role, Box<wire::Frame>),
    End,
}

/// Writes a recording by a thread of its own. A disk that fails costs the recording, not the run.
#[derive(Debug)]
pub struct RecordingWriter {
    path: PathBuf,
    records: mpsc::Sender<Record>,
    thread: JoinHandle<Result<u64, RecordingError>>,
}

impl RecordingWriter {
    /// Begins the recording at `path`, which must not exist.
    ///
    /// # Errors
    /// When it exists or cannot be written.
    pub fn create(path: &Path) -> Result<Self, RecordingError> {
        let error = |problem: String| RecordingError::new(path, problem);
        let file = File::create_new(path).map_err(|e| match e.kind() {
            std::io::ErrorKind::AlreadyExists => {
                error("exists already; remove it or give another name".into())
            }
            _ => error(format!("cannot be created: {e}")),
        })?;
        let (records, queue) = mpsc::channel(PENDING_RECORDS);
        let of = path.to_owned();
        let thread = std::thread::Builder::new()
            .name("recording".into())
            .spawn(move || write(&of, file, queue))
            .map_err(|e| error(format!("no thread to write it: {e}")))?;
        Ok(Self { path: path.to_owned(), records, thread })
    }

    /// Where it is written.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Notes that the frames from here on belong to `attempt`.
    pub async fn attempt(&self, attempt: Attempt) {
        // A thread that has failed tells why in `finish`.
        drop(self.records.send(Record::Attempt(Box::new(attempt))).await);
    }

    /// Where frames go to be written; waits while the disk is behind.
    pub(crate) fn queue(&self) -> mpsc::Sender<Record> {
        self.records.clone()
    }

    /// Writes what waits, ends the recording and tells how many frames it holds.
    ///
    /// # Errors
    /// When it could not be written in full.
    pub async fn finish(self) -> Result<u64, RecordingError> {
        let Self { path, records, thread } = self;
        drop(records.send(Record::End).await);
        let joined = tokio::task::spawn_blocking(move || thread.join()).await;
        match joined {
            Ok(Ok(written)) => written,
            _ => Err(RecordingError::new(&path, "its thread failed")),
        }
    }
}

fn write(path: &Path, file: File, queue: mpsc::Receiver<Record>) -> Result<u64, RecordingError> {
    let written = write_records(file, queue);
    written.map_err(|e| {
        let error = RecordingError::new(path, format!("is incomplete, since it cannot be written: {e}"));
        terminal::note(format_args!("warning: {error}; the run continues without it"));
        error
    })
}

fn write_records(file: File, mut queue: mpsc::Receiver<Record>) -> std::io::Result<u64> {
    let mut out = BufWriter::new(file);
    out.write_all(MAGIC)?;
    out.write_all(&VERSION.to_le_bytes())?;
    let mut frames = 0;
    while let Some(record) = queue.blocking_recv() {
        let (kind, payload) = match record {
            Record::Attempt(attempt) => (RecordKind::Attempt, attempt.to_wire().encode_to_vec()),
            Record::Frame(role, frame) => (RecordKind::Frame(role), frame.encode_to_vec()),
            Record::End => (RecordKind::End, Vec::new()),
        };
        let head = record_head(kind, &payload).ok_or_else(|| {
            std::io::Error::other(format!("a record of {} bytes is too large", payload.len()))
        })?;
        out.write_all(&head)?;
        out.write_all(&payload)?;
        match kind {
            RecordKind::Frame(_) => frames += 1,
            RecordKind::Attempt => {}
            RecordKind::End => break,
        }
    }
    out.flush()?;
    out.get_ref().sync_all()?;
    Ok(frames)
}
