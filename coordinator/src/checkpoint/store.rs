//! The folder of checkpoints: each is written beside its place and renamed when it is on the disk; two are kept.

use std::fs;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use proto::checkpoint::CheckpointData;

use crate::case::MOST_PARTICLES;

use super::disk::Files;
use super::manifest::{FileFacts, Manifest, data_file, digest};
use super::{OutputState, RunCheckpoint};
use crate::results::error::OutputError;
use crate::results::files::open_regular;
use crate::results::names::{
    CHECKPOINT_FILES, COORDINATOR_FILE, MANIFEST, PARTIAL, checkpoint_name, checkpoint_step, is_checkpoint,
};

/// Checkpoints that are kept.
const KEPT: usize = 2;
/// Longest manifest that is read \[bytes\].
const LONGEST_MANIFEST: u64 = 1 << 20;
/// Largest file of the coordinator that is read \[bytes\].
const LARGEST_OUTPUTS: u64 = 1 << 30;
/// Largest state of a solver that is read \[bytes\]: a kilobyte for each of the particles that a case may have.
const LARGEST_STATE: u64 = (MOST_PARTICLES as u64) << 10;

/// The checkpoints of one run.
#[derive(Clone, Debug)]
pub struct Store {
    folder: PathBuf,
}

/// A checkpoint that was written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Written {
    /// Completed steps.
    pub step: u64,
    /// Size.
    pub bytes: u64,
    /// Wall time that writing took.
    pub duration: Duration,
}

/// The newest good checkpoint, and what is wrong with those that are newer.
#[derive(Debug)]
pub struct NewestCheckpoint {
    /// The checkpoint, if any is good.
    pub checkpoint: Option<RunCheckpoint>,
    /// Why others were skipped, each with its folder.
    pub skipped: Vec<String>,
}

impl Store {
    /// The checkpoints in `folder`, which need not be there.
    pub fn new(folder: PathBuf) -> Self {
        Self { folder }
    }

    /// Names of the checkpoints that are there, half-written ones too.
    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(&self.folder).into_iter().flatten().flatten();
        entries
            .filter_map(|entry| entry.file_name().into_string().ok().filter(|name| is_checkpoint(name)))
            .collect()
    }

    /// Steps of the checkpoints that are there, whatever their state, newest first.
    fn steps(&self) -> Vec<u64> {
        let mut steps: Vec<u64> = self.names().iter().filter_map(|name| checkpoint_step(name)).collect();
        steps.sort_unstable_by(|a, b| b.cmp(a));
        steps
    }

    /// Writes `checkpoint` and removes those before the last two.
    ///
    /// At any moment there is a good one, if there was one before: the new one gets its name when all of it is on the
    /// disk, and only then an old one goes.
    ///
    /// # Errors
    /// When the disk is full or refuses; earlier checkpoints are as they were.
    pub fn write(&self, files: &mut dyn Files, checkpoint: &RunCheckpoint) -> Result<Written, OutputError> {
        let started = Instant::now();
        let place = self.folder.join(checkpoint_name(checkpoint.step));
        let partial = self.folder.join(format!("{}{PARTIAL}", checkpoint_name(checkpoint.step)));
        let failed = |e| OutputError::file("write checkpoint", &place, e);
        // A run that continues from this very boundary finds it written already. To replace it by the same data for another
        // build of a solver would leave none for a moment.
        if let Ok(present) = self.load(checkpoint.step)
            && same_data(&present, checkpoint)
        {
            return Ok(Written { step: checkpoint.step, bytes: 0, duration: started.elapsed() });
        }
        if !self.folder.is_dir() {
            files.create_folder(&self.folder).map_err(failed)?;
            if let Some(parent) = self.folder.parent() {
                files.sync(parent).map_err(failed)?;
            }
        }
        let written = self.write_files(files, checkpoint, &partial);
        let bytes = written.inspect_err(|_| {
            // Half a checkpoint only takes room; what matters is why.
            let _ = remove(files, &partial);
        });
        let bytes = bytes.map_err(failed)?;
        remove(files, &place).map_err(failed)?;
        files.rename(&partial, &place).map_err(failed)?;
        files.sync(&self.folder).map_err(failed)?;
        for step in self.steps().into_iter().filter(|step| *step < checkpoint.step).skip(KEPT - 1) {
            let old = self.folder.join(checkpoint_name(step));
            remove(files, &old).map_err(|e| OutputError::file("remove checkpoint", &old, e))?;
        }
        Ok(Written { step: checkpoint.step, bytes, duration: started.elapsed() })
    }

    fn write_files(
        &self,
        files: &mut dyn Files,
        checkpoint: &RunCheckpoint,
        partial: &Path,
    ) -> io::Result<u64> {
        remove(files, partial)?;
        files.create_folder(partial)?;
        let outputs = checkpoint.outputs.to_bytes().map_err(io::Error::other)?;
        let manifest = Manifest::of(checkpoint, FileFacts::of(COORDINATOR_FILE, &outputs)).text();
        let names: Vec<String> = checkpoint.sides.iter().map(|side| data_file(side.header.role)).collect();
        let sides = names.iter().zip(&checkpoint.sides).map(|(name, side)| (name.as_str(), &*side.data));
        let mut bytes = 0;
        for (name, content) in
            sides.chain([(COORDINATOR_FILE, outputs.as_slice()), (MANIFEST, manifest.as_bytes())])
        {
            let path = partial.join(name);
            files.write(&path, content)?;
            files.sync(&path)?;
            bytes += content.len() as u64;
        }
        files.sync(partial)?;
        Ok(bytes)
    }

    /// The newest good checkpoint.
    pub fn newest(&self) -> NewestCheckpoint {
        let mut found = NewestCheckpoint { checkpoint: None, skipped: Vec::new() };
        for step in self.steps() {
            match self.load(step) {
                Ok(checkpoint) => {
                    found.checkpoint = Some(checkpoint);
                    break;
                }
                Err(problem) => {
                    let place = self.folder.join(checkpoint_name(step));
                    found.skipped.push(format!("`{}`: {problem}", place.display()));
                }
            }
        }
        found
    }

    /// Removes checkpoints other than that of `step`: newer ones, which are damaged, older ones than are kept, and
    /// those that a killed run left half written.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn clear(&self, files: &mut dyn Files, step: u64) -> Result<(), OutputError> {
        let kept: Vec<u64> = self.steps().into_iter().filter(|older| *older <= step).take(KEPT).collect();
        for name in self.names() {
            if checkpoint_step(&name).is_none_or(|step| !kept.contains(&step)) {
                let place = self.folder.join(name);
                remove(files, &place).map_err(|e| OutputError::file("remove checkpoint", &place, e))?;
            }
        }
        Ok(())
    }

    /// The checkpoint of `step`, every digest compared.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn load(&self, step: u64) -> Result<RunCheckpoint, String> {
        let folder = self.folder.join(checkpoint_name(step));
        let text = read(&folder.join(MANIFEST), LONGEST_MANIFEST, None)?;
        let text = String::from_utf8(text).map_err(|_| format!("`{MANIFEST}` is no text"))?;
        let manifest = Manifest::parse(&text).map_err(|problem| format!("`{MANIFEST}` {problem}"))?;
        if manifest.step != step {
            return Err(format!("`{MANIFEST}` is of step {}", manifest.step));
        }
        let mut sides = Vec::new();
        for side in &manifest.sides {
            if side.data.file != data_file(side.role) {
                return Err(format!("`{MANIFEST}` names a file `{}`", side.data.file));
            }
            let data = read_checked(&folder, &side.data, LARGEST_STATE)?;
            let sha256 = proto::checkpoint::digest(&data);
            sides.push(CheckpointData { header: manifest.header(side)?, data: data.into(), sha256 });
        }
        if manifest.outputs.file != COORDINATOR_FILE {
            return Err(format!("`{MANIFEST}` names a file `{}`", manifest.outputs.file));
        }
        let outputs = read_checked(&folder, &manifest.outputs, LARGEST_OUTPUTS)?;
        let outputs = OutputState::parse(&outputs)
            .map_err(|e| format!("`{COORDINATOR_FILE}` is of another build of the coordinator: {e}"))?;
        if digest(outputs.case.as_bytes()) != manifest.case_digest {
            return Err(format!("`{COORDINATOR_FILE}` holds another case than `{MANIFEST}` says"));
        }
        Ok(RunCheckpoint { step, time: manifest.time_s, sides, outputs })
    }
}

/// Whether the solvers' states of two checkpoints are the same, whoever wrote them.
fn same_data(one: &RunCheckpoint, other: &RunCheckpoint) -> bool {
    let data = |of: &RunCheckpoint| -> Vec<_> {
        of.sides.iter().map(|side| (side.header.role, side.sha256)).collect()
    };
    data(one) == data(other)
}

/// Content of a file of at most `largest` bytes, and of `exact` where that is given.
fn read(path: &Path, largest: u64, exact: Option<u64>) -> Result<Vec<u8>, String> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let cannot = |e: io::Error| format!("`{name}` cannot be read: {e}");
    let (file, length) = open_regular(path).map_err(cannot)?;
    if let Some(exact) = exact.filter(|exact| *exact != length) {
        return Err(format!("`{name}` has {length} bytes, must have {exact}"));
    }
    if length > largest {
        return Err(format!("`{name}` has {length} bytes, at most {largest} are allowed"));
    }
    let mut content = Vec::new();
    // Grows with what comes, whatever length the file claims.
    file.take(largest).read_to_end(&mut content).map_err(cannot)?;
    Ok(content)
}

/// Content of a file as the manifest has it. Its size is compared before anything is read.
fn read_checked(folder: &Path, facts: &FileFacts, largest: u64) -> Result<Vec<u8>, String> {
    let content = read(&folder.join(&facts.file), largest, Some(facts.bytes))?;
    if digest(&content) != facts.sha256 {
        return Err(format!("`{}` is damaged: its digest does not fit its content", facts.file));
    }
    Ok(content)
}

/// Removes the files of a checkpoint, and its folder when that leaves it empty; of a link the link itself.
fn remove(files: &mut dyn Files, folder: &Path) -> io::Result<()> {
    match fs::symlink_metadata(folder) {
        Ok(facts) if facts.is_dir() => {}
        Ok(facts) if facts.is_symlink() => return files.remove_file(folder),
        // A file of that name is no checkpoint.
        Ok(_) => return Ok(()),
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(()),
        Err(e) => return Err(e),
    }
    for path in CHECKPOINT_FILES.map(|name| folder.join(name)) {
        if fs::symlink_metadata(&path).is_ok() {
            files.remove_file(&path)?;
        }
    }
    match files.remove_folder(folder) {
        // What else is in it is not the run's.
        Err(e) if e.kind() == io::ErrorKind::DirectoryNotEmpty => Ok(()),
        removed => removed,
    }
}

#[cfg(test)]
mod tests;
