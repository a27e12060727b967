//! The output folder of a run: who may write into it.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use super::earlier::{self, Remains};
use super::error::{OutputError, refused};
use super::files::remove_if_there;
use super::marker::{self, take_marker};
use super::names::{CHECKPOINTS, FINAL, MARKER, REPORT, SNAPSHOTS, SUMMARY};

/// What to do with the results of an earlier run in the same folder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Existing {
    /// Leave them and refuse to start.
    #[default]
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
    /// Whether this process made the marker.
    is_new: bool,
    /// Whether anything else was changed; until then the marker goes with this value.
    changed: AtomicBool,
    /// What an earlier run left, until [`OutputDirectory::begin`].
    remains: Mutex<Remains>,
}

impl OutputDirectory {
    /// Takes `path` as the output folder, creating it where needed. Results of an earlier run in it stay until
    /// [`OutputDirectory::begin`]; only its logs go, as the servers write new ones before.
    ///
    /// # Errors
    /// When the folder holds anything and `existing` says to refuse, when it holds anything but no run's mark, when
    /// something in it has the name of a run's file but is none, when another run is writing into it, or when it cannot be
    /// written to. Nothing has been changed in any of these cases.
    pub fn create(path: &Path, existing: Existing) -> Result<Self, OutputError> {
        if path.exists() && !path.is_dir() {
            return refused(path, "is a file", "choose another folder with `--out`");
        }
        fs::create_dir_all(path).map_err(|e| OutputError::file("create output folder", path, e))?;
        let in_use = || {
            refused(
                path,
                "exists and is not empty, so nothing was written",
                "choose another folder with `--out`, or add `--force` to replace the results of the earlier run in it",
            )
        };
        if !is_empty(path)? {
            if existing == Existing::Refuse {
                return in_use();
            }
            if !earlier::carries_mark(path) {
                return refused(
                    path,
                    "is not empty and holds no results of a run (`run.partial`, or a `summary.json` that a run wrote), so \
                     nothing was changed",
                    "choose another folder with `--out`; `--force` replaces the results of an earlier run only",
                );
            }
        }
        let mut taken = Self::take(path)?;
        // Between the first look and the lock another run may have come and gone.
        if existing == Existing::Refuse && !is_empty(path)? {
            return in_use();
        }
        let remains = Remains::of(path)?;
        remains.remove_logs()?;
        // A folder without results is this run's from here on.
        taken.changed = AtomicBool::new(remains.is_empty());
        taken.remains = Mutex::new(remains);
        Ok(taken)
    }

    /// Begins to write a new run's results: removes those of an earlier one.
    ///
    /// # Errors
    /// When something cannot be removed, or a folder cannot be made.
    pub fn begin(&self) -> Result<(), OutputError> {
        self.changed.store(true, Ordering::Relaxed);
        let remains = std::mem::take(&mut *self.remains.lock().unwrap_or_else(PoisonError::into_inner));
        remains.remove()?;
        for folder in [SNAPSHOTS, FINAL] {
            let folder = self.path.join(folder);
            fs::create_dir_all(&folder).map_err(|e| OutputError::file("create folder", &folder, e))?;
        }
        Ok(())
    }

    /// Takes the folder of an earlier run to continue with it. Nothing in it is changed before
    /// [`OutputDirectory::take_over`].
    ///
    /// # Errors
    /// When it is no folder of a run, when a run is writing into it, or when it cannot be written to.
    pub fn reopen(path: &Path) -> Result<Self, OutputError> {
        if !path.join(CHECKPOINTS).is_dir() {
            return refused(
                path,
                &format!("has no folder `{CHECKPOINTS}`"),
                "give the output folder of a run that took checkpoints",
            );
        }
        Self::take(path)
    }

    fn take(path: &Path) -> Result<Self, OutputError> {
        let (marker, is_new) = take_marker(path)?;
        Ok(Self {
            path: path.to_path_buf(),
            _marker: marker,
            is_new,
            changed: AtomicBool::new(false),
            remains: Mutex::default(),
        })
    }

    /// Begins to change the folder of an earlier run: its summary and its report are out of date from here on.
    ///
    /// # Errors
    /// When one of them cannot be removed.
    pub fn take_over(&self) -> Result<(), OutputError> {
        self.changed.store(true, Ordering::Relaxed);
        for name in [SUMMARY, REPORT] {
            let file = self.path.join(name);
            remove_if_there(&file).map_err(|e| OutputError::file("remove", &file, e))?;
        }
        Ok(())
    }

    /// Whether anything in the folder was changed.
    pub fn is_changed(&self) -> bool {
        self.changed.load(Ordering::Relaxed)
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

impl Drop for OutputDirectory {
    fn drop(&mut self) {
        if self.is_new && !self.is_changed() {
            // What was refused matters more than that this remains.
            let _ = fs::remove_file(self.path.join(MARKER));
        }
    }
}

/// Whether there is nothing in `path` but, at most, the marker of a run that was killed before it wrote anything.
fn is_empty(path: &Path) -> Result<bool, OutputError> {
    let failed = |e| OutputError::file("read output folder", path, e);
    for entry in fs::read_dir(path).map_err(failed)? {
        let name = entry.map_err(failed)?.file_name();
        let ours = |text: String| text.is_empty() || text.starts_with(marker::TEXT);
        if name != MARKER || !marker::text(&path.join(MARKER)).is_ok_and(ours) {
            return Ok(false);
        }
    }
    Ok(true)
}

#[cfg(test)]
mod tests {
    use std::io;

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
    fn a_folder_without_a_mark_of_a_run_is_refused_and_left_alone() {
        let foreign = [
            ("notes.txt", "mine"),
            ("case.toml", "mine"),
            ("checkpoints/model.pt", "mine"),
            ("summary.json", "{\"loss\": 0.1}"),
            ("run.partial", "mine"),
            ("run.partial/part", "mine"),
        ];
        for (name, text) in foreign {
            let root = tempfile::tempdir().unwrap();
            put(&root.path().join(name), text);
            put(&root.path().join("probes.csv"), "t_s\n");
            let message = OutputDirectory::create(root.path(), Existing::Replace).unwrap_err().to_string();
            assert!(
                message.contains("no results of a run") && message.contains("--out"),
                "{name}: {message}"
            );
            assert_eq!(fs::read_to_string(root.path().join(name)).unwrap(), text);
            assert_eq!(fs::read_dir(root.path()).unwrap().count(), 2, "{name}");
        }
    }

    #[test]
    fn a_marker_that_no_run_wrote_is_not_written_over() {
        let root = tempfile::tempdir().unwrap();
        put(&root.path().join(MARKER), "mine");
        put(&root.path().join("checkpoints/x"), "");
        let message = OutputDirectory::reopen(root.path()).unwrap_err().to_string();
        assert!(message.contains("no run wrote") && message.contains("move that file"), "{message}");
        assert_eq!(fs::read_to_string(root.path().join(MARKER)).unwrap(), "mine");
        // Nor is what a link of that name points to.
        fs::remove_file(root.path().join(MARKER)).unwrap();
        std::os::unix::fs::symlink(root.path().join("elsewhere"), root.path().join(MARKER)).unwrap();
        assert!(OutputDirectory::reopen(root.path()).unwrap_err().to_string().contains("no run wrote"));
        assert!(!root.path().join("elsewhere").exists());
    }

    #[test]
    fn a_folder_that_is_reopened_changes_when_it_is_taken_over() {
        let root = tempfile::tempdir().unwrap();
        for name in [SUMMARY, REPORT, "checkpoints/x"] {
            put(&root.path().join(name), "x");
        }
        let there = |name: &str| root.path().join(name).exists();
        let refused = OutputDirectory::reopen(root.path()).unwrap();
        assert!(there(MARKER) && !refused.is_changed());
        drop(refused);
        assert!(there(SUMMARY) && there(REPORT) && !there(MARKER));
        let resumed = OutputDirectory::reopen(root.path()).unwrap();
        resumed.take_over().unwrap();
        assert!(resumed.is_changed() && !there(SUMMARY) && !there(REPORT));
        drop(resumed);
        // As after a loss: the next one leaves the marker.
        assert!(there(MARKER));
        drop(OutputDirectory::reopen(root.path()).unwrap());
        assert!(there(MARKER) && there("checkpoints/x"));
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
}
