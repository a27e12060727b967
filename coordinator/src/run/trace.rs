//! The trace of a run: each process writes its part, and the end of the run makes one file of them.

use std::path::{Path, PathBuf};

use proto::trace::{self, Part};
use sph::coupling::solver::Role;
use tempfile::TempDir;

use crate::failure::Failure;

/// A trace being recorded.
pub struct Trace {
    path: PathBuf,
    folder: TempDir,
    own: Part,
}

/// Name of the coordinator's own part; before those of the servers in order.
const OWN: &str = "coordinator";

/// Where the server of `role` writes its part in `folder`; each attempt at a run has a part of its own.
pub fn part_of(folder: &Path, role: Role, attempt: usize) -> PathBuf {
    folder.join(format!("{role}-{attempt}"))
}

impl Trace {
    /// Records this process from here on; the trace goes to `path`, the parts beside it.
    ///
    /// # Errors
    /// When the file cannot be written, or this process records already.
    pub fn start(path: &Path) -> Result<Self, Failure> {
        let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let folder = std::fs::create_dir_all(parent)
            .and_then(|()| tempfile::Builder::new().prefix("trace-").tempdir_in(parent))
            .map_err(|e| failed(path, &e))?;
        let own = Part::create(&folder.path().join(OWN), OWN).map_err(|e| failed(path, &e))?;
        trace::record(own.clone()).map_err(|e| Failure::internal(format!("`--trace`: {e}")))?;
        Ok(Self { path: path.to_owned(), folder, own })
    }

    /// Folder of the parts.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// Makes one file of all parts; the servers have ended.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn finish(self) -> Result<(), Failure> {
        let entries = self.own.flush().and_then(|()| std::fs::read_dir(self.folder.path()));
        let mut parts = entries
            .and_then(|entries| entries.map(|entry| Ok(entry?.path())).collect::<Result<Vec<_>, _>>())
            .map_err(|e| failed(&self.path, &e))?;
        parts.sort();
        trace::join(&self.path, &parts).map_err(|e| failed(&self.path, &e))
    }
}

fn failed(path: &Path, error: &std::io::Error) -> Failure {
    Failure::output(format!("the trace `{}` cannot be written: {error}", path.display()))
}
