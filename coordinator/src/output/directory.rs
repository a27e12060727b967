//! The output folder of a run: who may write into it, and how a file becomes complete.

use std::fs::{self, File, TryLockError};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Suffix of a file that is still being written.
pub const PARTIAL: &str = ".partial";

/// Present, and locked, while a run writes into the folder; removed when all outputs are complete.
pub const MARKER: &str = "run.partial";

/// Verdict and figures of the run.
pub const SUMMARY: &str = "summary.json";
/// Probe values over time.
pub const PROBES: &str = "probes.csv";
/// Interface ledger over time.
pub const LEDGER: &str = "ledger.csv";
/// Particles around the guilty one.
pub const DIVERGENCE: &str = "divergence.csv";
/// The case as resolved.
pub const CASE: &str = "case.toml";
/// Pictures and facts.
pub const REPORT: &str = "report.html";
/// Folder of particle files.
pub const SNAPSHOTS: &str = "snapshots";
/// Folder of checkpoints.
pub const CHECKPOINTS: &str = "checkpoints";
/// Folder of final states.
pub const FINAL: &str = "final";

/// Files of a run at the top of its folder.
const TOP_FILES: [&str; 6] = [SUMMARY, PROBES, LEDGER, CASE, REPORT, DIVERGENCE];
/// Sides as they appear in file names.
const SIDES: [&str; 2] = ["fluid", "solid"];

/// An output that cannot be written, or must not be.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The file system refused.
    #[error("cannot {action} `{}`: {cause}; {hint}", path.display())]
    File {
        /// What was tried.
        action: &'static str,
        /// On which file or folder.
        path: PathBuf,
        /// What the system says.
        cause: io::Error,
        /// What to do about it.
        hint: &'static str,
    },
    /// Writing would destroy something.
    #[error("output folder `{}` {reason}; {hint}", path.display())]
    Refused {
        /// The folder.
        path: PathBuf,
        /// What is in the way.
        reason: String,
        /// What to do about it.
        hint: &'static str,
    },
    /// A file or its content is not as it must be.
    #[error("`{}`: {reason}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
}

impl OutputError {
    /// A refusal of the file system with the remedy that fits its cause.
    pub fn file(action: &'static str, path: &Path, cause: io::Error) -> Self {
        let hint = match cause.kind() {
            io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
                "make it writable or choose another folder with `--out`"
            }
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded | io::ErrorKind::FileTooLarge => {
                "free some space or choose a folder on another disk with `--out`"
            }
            io::ErrorKind::NotADirectory => {
                "a part of this path is a file: choose another folder with `--out`"
            }
            io::ErrorKind::NotFound => "check the path",
            _ => "check the disk or choose another folder with `--out`",
        };
        Self::File { action, path: path.to_path_buf(), cause, hint }
    }

    /// A file whose content is not as it must be.
    pub fn content(path: &Path, reason: impl Into<String>) -> Self {
        Self::Content { path: path.to_path_buf(), reason: reason.into() }
    }
}

/// What to do with the results of an earlier run in the same folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Existing {
    /// Leave them and refuse to start.
    Refuse,
    /// Remove the files that the earlier run wrote, and nothing else.
    Replace,
}

/// The output folder of a run, held by this process until dropped.
#[derive(Debug)]
pub struct OutputDirectory {
    path: PathBuf,
    /// Open and locked for as long as the run lasts.
    _marker: File,
}

impl OutputDirectory {
    /// Takes `path` as the output folder, creating it where needed.
    ///
    /// # Errors
    /// When the folder holds anything and `existing` says to refuse, when it holds files of the names that a run
    /// writes but no run wrote them, when another run is writing into it, or when it cannot be written to. Nothing
    /// has been changed in any of these cases.
    pub fn create(path: &Path, existing: Existing) -> Result<Self, OutputError> {
        let refused = |reason: &str, hint| {
            Err(OutputError::Refused { path: path.to_path_buf(), reason: reason.to_string(), hint })
        };
        if path.exists() && !path.is_dir() {
            return refused("is a file", "choose another folder with `--out`");
        }
        fs::create_dir_all(path).map_err(|e| OutputError::file("create output folder", path, e))?;
        let empty = fs::read_dir(path)
            .map_err(|e| OutputError::file("read output folder", path, e))?
            .next()
            .is_none();
        if !empty && existing == Existing::Refuse {
            return refused(
                "exists and is not empty, so nothing was written",
                "choose another folder with `--out`, or add `--force` to replace the results of the earlier run in it",
            );
        }
        let of_a_run = path.join(SUMMARY).exists() || path.join(MARKER).exists();
        if let Some(name) = TOP_FILES.iter().find(|name| !of_a_run && path.join(name).exists()) {
            return refused(
                &format!("holds a `{name}` that no run wrote, so nothing was written"),
                "choose another folder with `--out`",
            );
        }
        let marker = take_marker(path)?;
        remove_results(path)?;
        for folder in [SNAPSHOTS, FINAL] {
            let folder = path.join(folder);
            fs::create_dir_all(&folder).map_err(|e| OutputError::file("create folder", &folder, e))?;
        }
        Ok(Self { path: path.to_path_buf(), _marker: marker })
    }

    /// Takes the folder of an earlier run to go on with it: summary and report go, all else stays.
    ///
    /// # Errors
    /// When it is no folder of a run, when a run is writing into it, or when it cannot be written to.
    pub fn reopen(path: &Path) -> Result<Self, OutputError> {
        if !path.join(CHECKPOINTS).is_dir() {
            return Err(OutputError::Refused {
                path: path.to_path_buf(),
                reason: format!("has no folder `{CHECKPOINTS}`"),
                hint: "give the output folder of a run that took checkpoints",
            });
        }
        let marker = take_marker(path)?;
        for name in [SUMMARY, REPORT] {
            let file = path.join(name);
            match fs::remove_file(&file) {
                Err(e) if e.kind() != io::ErrorKind::NotFound => {
                    return Err(OutputError::file("remove", &file, e));
                }
                _ => {}
            }
        }
        Ok(Self { path: path.to_path_buf(), _marker: marker })
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Path of the file `name` in the folder.
    pub fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Path of the final state of `side`, `fluid` or `solid`.
    pub fn final_state(&self, side: &str) -> PathBuf {
        self.path.join(FINAL).join(format!("{side}.state"))
    }

    /// Declares all outputs complete: removes [`MARKER`].
    ///
    /// # Errors
    /// When the marker cannot be removed.
    pub fn complete(&self) -> Result<(), OutputError> {
        let marker = self.path.join(MARKER);
        fs::remove_file(&marker).map_err(|e| OutputError::file("remove", &marker, e))
    }
}

/// Creates and locks the marker; a lock tells a running run from one that was killed.
fn take_marker(path: &Path) -> Result<File, OutputError> {
    let file = path.join(MARKER);
    let mut marker = File::options()
        .create(true)
        .truncate(false)
        .write(true)
        .open(&file)
        .map_err(|e| OutputError::file("write to output folder", path, e))?;
    match marker.try_lock() {
        Err(TryLockError::WouldBlock) => Err(OutputError::Refused {
            path: path.to_path_buf(),
            reason: "is being written by another run".into(),
            hint: "wait for it to end or choose another folder with `--out`",
        }),
        // A file system without locks still has the marker.
        Ok(()) | Err(TryLockError::Error(_)) => {
            marker
                .write_all(b"A run is writing here, or was killed before its outputs were complete.\n")
                .map_err(|e| OutputError::file("write to", &file, e))?;
            Ok(marker)
        }
    }
}

/// Removes what an earlier run wrote, by the names that a run gives.
fn remove_results(path: &Path) -> Result<(), OutputError> {
    let tops = TOP_FILES.iter().map(|name| path.join(name));
    let states = SIDES.iter().map(|side| path.join(FINAL).join(format!("{side}.state")));
    let mut doomed: Vec<PathBuf> = tops.chain(states).collect();
    if let Ok(entries) = fs::read_dir(path.join(SNAPSHOTS)) {
        doomed.extend(
            entries.flatten().filter(|e| e.file_name().to_str().is_some_and(is_snapshot)).map(|e| e.path()),
        );
    }
    let checkpoints = path.join(CHECKPOINTS);
    match fs::remove_dir_all(&checkpoints) {
        Err(e) if !matches!(e.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => {
            return Err(OutputError::file("remove", &checkpoints, e));
        }
        _ => {}
    }
    for file in doomed {
        for file in [with_suffix(&file), file] {
            match fs::remove_file(&file) {
                Err(e) if !matches!(e.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => {
                    return Err(OutputError::file("remove", &file, e));
                }
                _ => {}
            }
        }
    }
    Ok(())
}

/// Whether a run gives this name to a file in its snapshot folder.
fn is_snapshot(name: &str) -> bool {
    let name = name.strip_suffix(PARTIAL).unwrap_or(name);
    SIDES.iter().filter_map(|side| name.strip_prefix(side)).any(|rest| {
        rest == ".pvd"
            || rest
                .strip_prefix('_')
                .and_then(|rest| rest.strip_suffix(".vtp"))
                .is_some_and(|digits| !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit()))
    })
}

/// `path` with [`PARTIAL`] appended to its name.
pub(super) fn with_suffix(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_os_string();
    name.push(PARTIAL);
    PathBuf::from(name)
}

/// Writes `path` under a name with [`PARTIAL`] and renames it when its content is on the disk.
///
/// # Errors
/// When the file cannot be written; its place is then as it was before.
pub fn write_file(
    path: &Path,
    content: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<(), OutputError> {
    let partial = with_suffix(path);
    let written = File::create(&partial).and_then(|file| {
        let mut writer = BufWriter::with_capacity(1 << 16, file);
        content(&mut writer)?;
        let file = writer.into_inner().map_err(io::IntoInnerError::into_error)?;
        file.sync_data()?;
        fs::rename(&partial, path)
    });
    written.map_err(|e| {
        // The cause of the failure is what matters; the remains carry a name that says what they are.
        let _ = fs::remove_file(&partial);
        OutputError::file("write", path, e)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn put(path: &Path, text: &str) {
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }

    #[test]
    fn a_folder_with_anything_in_it_is_refused_and_left_alone() {
        let root = tempfile::tempdir().unwrap();
        let file = root.path().join("notes.txt");
        put(&file, "mine");
        let message = OutputDirectory::create(root.path(), Existing::Refuse).unwrap_err().to_string();
        assert!(message.contains(root.path().to_str().unwrap()), "{message}");
        assert!(message.contains("--force") && message.contains("--out"), "{message}");
        assert_eq!(fs::read_dir(root.path()).unwrap().count(), 1);
    }

    #[test]
    fn replacing_removes_what_a_run_wrote_and_nothing_else() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("results");
        let run = OutputDirectory::create(&path, Existing::Refuse).unwrap();
        let old = ["summary.json", "probes.csv.partial", "snapshots/fluid_000001.vtp", "final/solid.state"];
        let mine = ["notes.txt", "snapshots/fluid_mean.vtp", "snapshots/solid_.vtp", "final/other.state"];
        for name in old.iter().chain(&mine) {
            put(&path.join(name), "x");
        }
        run.complete().unwrap();
        OutputDirectory::create(&path, Existing::Replace).unwrap();
        for name in old {
            assert!(!path.join(name).exists(), "{name}");
        }
        for name in mine {
            assert!(path.join(name).exists(), "{name}");
        }
    }

    #[test]
    fn a_case_file_that_no_run_wrote_survives_replacing() {
        let root = tempfile::tempdir().unwrap();
        let case = root.path().join(CASE);
        put(&case, "mine");
        let message = OutputDirectory::create(root.path(), Existing::Replace).unwrap_err().to_string();
        assert!(message.contains("case.toml"), "{message}");
        assert_eq!(fs::read_to_string(&case).unwrap(), "mine");
        assert!(!root.path().join(MARKER).exists());
    }

    #[test]
    fn a_folder_in_use_is_refused_until_its_run_ends_or_dies() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("a/b");
        let first = OutputDirectory::create(&path, Existing::Refuse).unwrap();
        assert!(path.join(MARKER).exists());
        let message = OutputDirectory::create(&path, Existing::Replace).unwrap_err().to_string();
        assert!(message.contains("another run"), "{message}");
        // Killed: the lock goes, the marker stays.
        drop(first);
        let second = OutputDirectory::create(&path, Existing::Replace).unwrap();
        second.complete().unwrap();
        assert!(!path.join(MARKER).exists());
    }

    #[test]
    fn errors_name_the_path_and_the_remedy() {
        let root = tempfile::tempdir().unwrap();
        let file = root.path().join("file");
        put(&file, "");
        for path in [file.clone(), file.join("below")] {
            let message = OutputDirectory::create(&path, Existing::Replace).unwrap_err().to_string();
            assert!(message.contains(path.to_str().unwrap()) && message.contains("--out"), "{message}");
        }
        let denied = OutputError::file("write", &file, io::Error::from(io::ErrorKind::PermissionDenied));
        assert!(denied.to_string().contains("make it writable"), "{denied}");
    }

    #[test]
    fn a_failed_write_leaves_the_old_content_and_no_remains() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("table");
        write_file(&path, |w| w.write_all(b"old")).unwrap();
        let failed = write_file(&path, |w| {
            w.write_all(b"half")?;
            Err(io::Error::from(io::ErrorKind::StorageFull))
        });
        assert!(failed.unwrap_err().to_string().contains("free some space"));
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(fs::read_dir(root.path()).unwrap().count(), 1);
    }
}
