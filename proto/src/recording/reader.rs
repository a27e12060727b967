//! Reading a recording: one pass checks every record and notes where frames stand.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use bytes::Bytes;
use prost::Message;
use sph::coupling::solver::Role;

use super::{
    Attempt, HEAD_BYTES, MAGIC, Moment, RECORD_BYTES, RecordKind, RecordingError, VERSION, record_head,
};
use crate::convert::{self, Convert};
use crate::limits::MAX_FRAME_BYTES;
use crate::transport::codec::{self, Counted};
use crate::wire;

/// A recording whose records have all been checked.
#[derive(Debug)]
pub struct Recording {
    path: PathBuf,
    file: BufReader<File>,
    attempts: Vec<Attempt>,
    /// Where the record of each frame begins.
    frames: BTreeMap<(Moment, Role), u64>,
    complete: bool,
}

impl Recording {
    /// Opens the recording at `path` and checks all of it.
    ///
    /// # Errors
    /// When it cannot be read, is of another form, or is damaged.
    pub fn open(path: &Path) -> Result<Self, RecordingError> {
        let file = File::open(path).map_err(|e| RecordingError::new(path, format!("cannot be read: {e}")))?;
        let mut recording = Self {
            path: path.to_owned(),
            file: BufReader::new(file),
            attempts: Vec::new(),
            frames: BTreeMap::new(),
            complete: false,
        };
        recording.check_head()?;
        recording.scan()?;
        Ok(recording)
    }

    /// Where it stands.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Attempts at the run, in their order; at least one.
    pub fn attempts(&self) -> &[Attempt] {
        &self.attempts
    }

    /// Whether the run was recorded to its end.
    pub fn is_complete(&self) -> bool {
        self.complete
    }

    /// Moments of the frames of `role`, in order.
    pub(crate) fn moments(&self, role: Role) -> Vec<Moment> {
        self.frames.keys().filter(|(_, of)| *of == role).map(|(moment, _)| *moment).collect()
    }

    /// The frame of `role` at `at`, if there is one.
    pub(crate) fn frame(&mut self, at: Moment, role: Role) -> Result<Option<wire::Frame>, RecordingError> {
        let Some(offset) = self.frames.get(&(at, role)).copied() else { return Ok(None) };
        self.file.seek(SeekFrom::Start(offset)).map_err(|e| self.error(format!("cannot be read: {e}")))?;
        match self.record(offset)? {
            Some((RecordKind::Frame(_), payload)) => self.decode(offset, payload).map(Some),
            _ => Err(self.error(format!("changed at byte {offset} while it was read"))),
        }
    }

    fn error(&self, problem: impl Into<String>) -> RecordingError {
        RecordingError::new(&self.path, problem)
    }

    fn check_head(&mut self) -> Result<(), RecordingError> {
        let mut head = [0; MAGIC.len() + 2];
        let read = self.file.read_exact(&mut head);
        if read.is_err() || !head.starts_with(MAGIC) {
            return Err(self.error("is no recording; make one by `run CASE --record FILE`"));
        }
        let version = u16::from_le_bytes([head[MAGIC.len()], head[MAGIC.len() + 1]]);
        if version != VERSION {
            let text = format!("is of version {version}, this program reads version {VERSION}");
            return Err(self.error(format!("{text}; use the program that wrote it")));
        }
        Ok(())
    }

    fn scan(&mut self) -> Result<(), RecordingError> {
        let mut offset = HEAD_BYTES;
        while let Some((kind, payload)) = self.record(offset)? {
            let length = payload.len();
            match kind {
                RecordKind::Attempt => {
                    let attempt = self.decode(offset, payload)?;
                    let attempt = Attempt::from_wire(&attempt, &convert::Path::root("attempt"))
                        .map_err(|e| self.error(format!("at byte {offset}: {e}")))?;
                    self.attempts.push(attempt);
                }
                RecordKind::Frame(role) => self.note(offset, role, payload)?,
                RecordKind::End => {
                    self.complete = true;
                    break;
                }
            }
            // Lengths are limited to some megabytes.
            offset += u64::try_from(RECORD_BYTES + length).unwrap_or(u64::MAX - offset);
        }
        if self.attempts.is_empty() {
            return Err(self.error("holds no run; it was cut off before the first step"));
        }
        Ok(())
    }

    fn note(&mut self, offset: u64, role: Role, payload: Bytes) -> Result<(), RecordingError> {
        if self.attempts.is_empty() {
            return Err(self.error(format!("has a frame at byte {offset} before any attempt")));
        }
        let frame: wire::Frame = self.decode(offset, payload)?;
        if frame.farewell.is_some() {
            return Ok(());
        }
        let moment = Moment::of(&frame).map_err(|e| self.error(format!("at byte {offset}: {e}")))?;
        self.frames.insert((moment, role), offset);
        Ok(())
    }

    /// The record at `offset`, where the file stands; `None` when it is not there in full.
    fn record(&mut self, offset: u64) -> Result<Option<(RecordKind, Bytes)>, RecordingError> {
        let mut head = [0; RECORD_BYTES];
        if !self.read(&mut head)? {
            return Ok(None);
        }
        let Some(kind) = RecordKind::named(head[0]) else {
            return Err(self.error(format!("is damaged at byte {offset}: kind of record {}", head[0])));
        };
        let length = u32::from_le_bytes([head[1], head[2], head[3], head[4]]);
        let length = usize::try_from(length).unwrap_or(usize::MAX);
        if length > MAX_FRAME_BYTES {
            return Err(self.error(format!(
                "is damaged at byte {offset}: a record of {length} bytes, at most {MAX_FRAME_BYTES} are allowed"
            )));
        }
        let mut payload = vec![0; length];
        if !self.read(&mut payload)? {
            return Ok(None);
        }
        if record_head(kind, &payload) != Some(head) {
            return Err(self.error(format!("is damaged at byte {offset}: its checksum is wrong")));
        }
        Ok(Some((kind, payload.into())))
    }

    /// Fills `bytes`; tells whether the file had so many.
    fn read(&mut self, bytes: &mut [u8]) -> Result<bool, RecordingError> {
        match self.file.read_exact(bytes) {
            Ok(()) => Ok(true),
            Err(e) if e.kind() == ErrorKind::UnexpectedEof => Ok(false),
            Err(e) => Err(self.error(format!("cannot be read: {e}"))),
        }
    }

    fn decode<M: Message + Default + Counted>(
        &self,
        offset: u64,
        payload: Bytes,
    ) -> Result<M, RecordingError> {
        codec::decode(payload).map_err(|e| self.error(format!("is damaged at byte {offset}: {e}")))
    }
}
