//! What an earlier run left in an output folder: how it is recognised as that of a run, and its files by name.
//!
//! Nothing is removed but files that bear the name of a run's file, in a place where a run puts it. Folders go only when
//! that leaves them empty. Links are removed, never followed.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::error::OutputError;
use super::files::{remove_if_there, with_suffix};
use super::names::{self, CHECKPOINTS, FINAL, LOGS, MARKER, SNAPSHOTS, SUMMARY};
use super::{marker, snapshots, summary};

/// Whether `root` holds the marker or the summary of a run.
pub(super) fn carries_mark(root: &Path) -> bool {
    marker::text(&root.join(MARKER)).is_ok_and(|text| text.starts_with(marker::TEXT))
        || summary::is_of_a_run(&root.join(SUMMARY))
}

/// Files and folders of an earlier run, in the order in which they go.
#[derive(Debug, Default)]
pub(super) struct Remains {
    logs: Vec<PathBuf>,
    files: Vec<PathBuf>,
    folders: Vec<PathBuf>,
}

impl Remains {
    /// What an earlier run left in `root`. Nothing is changed.
    ///
    /// # Errors
    /// When something else has the name of a run's file or folder, or a checkpoint's folder holds what no run writes.
    pub fn of(root: &Path) -> Result<Self, OutputError> {
        let mut found = Self::default();
        for name in names::TOP_FILES {
            found.file(root, with_suffix(&root.join(name)))?;
            found.file(root, root.join(name))?;
        }
        for (folder, is_ours) in [
            (FINAL, names::is_final as fn(&str) -> bool),
            (SNAPSHOTS, snapshots::is_ours),
            (CHECKPOINTS, names::is_beside_checkpoints),
        ] {
            found.folder(root, folder, is_ours)?;
        }
        found.checkpoints(root)?;
        found.folders.extend([SNAPSHOTS, FINAL, CHECKPOINTS].map(|name| root.join(name)));
        let mut logs = Self::default();
        logs.folder(root, LOGS, names::is_log)?;
        found.logs = logs.files;
        Ok(found)
    }

    /// Notes the files in the folder `name` that are a run's.
    fn folder(&mut self, root: &Path, name: &str, is_ours: fn(&str) -> bool) -> Result<(), OutputError> {
        let folder = root.join(name);
        names_in(root, &folder)?
            .iter()
            .filter(|name| is_ours(name))
            .try_for_each(|name| self.file(root, folder.join(name)))
    }

    fn checkpoints(&mut self, root: &Path) -> Result<(), OutputError> {
        let checkpoints = root.join(CHECKPOINTS);
        for name in names_in(root, &checkpoints)?.iter().filter(|name| names::is_checkpoint(name)) {
            let place = checkpoints.join(name);
            let facts = fs::symlink_metadata(&place).map_err(|e| OutputError::file("look at", &place, e))?;
            if facts.is_symlink() {
                self.files.push(place);
                continue;
            }
            for file in names_in(root, &place)? {
                if !names::CHECKPOINT_FILES.contains(&file.as_str()) {
                    let reason = format!("holds `{CHECKPOINTS}/{name}/{file}`, which no run wrote");
                    return Err(refused(
                        root,
                        reason,
                        "move it elsewhere or choose another folder with `--out`",
                    ));
                }
                self.file(root, place.join(file))?;
            }
            self.folders.push(place);
        }
        Ok(())
    }

    /// Notes the file at `path`, if there is one.
    fn file(&mut self, root: &Path, path: PathBuf) -> Result<(), OutputError> {
        match fs::symlink_metadata(&path) {
            Ok(facts) if facts.is_file() || facts.is_symlink() => self.files.push(path),
            Ok(_) => {
                let name = path.strip_prefix(root).unwrap_or(&path).display();
                let reason = format!("holds `{name}`, which is no file though a run's file has that name");
                return Err(refused(root, reason, "move it elsewhere or choose another folder with `--out`"));
            }
            Err(e) if absent(&e) => {}
            Err(e) => return Err(OutputError::file("look at", &path, e)),
        }
        Ok(())
    }

    /// Whether there is nothing.
    pub fn is_empty(&self) -> bool {
        self.logs.is_empty() && self.files.is_empty()
    }

    /// Removes the logs of servers, and their folder where nothing else is in it.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn remove_logs(&self) -> Result<(), OutputError> {
        remove(&self.logs)?;
        let folder = self.logs.first().and_then(|log| log.parent());
        folder.map_or(Ok(()), remove_folder)
    }

    /// Removes all but the logs; folders with anything else in them stay.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn remove(&self) -> Result<(), OutputError> {
        remove(&self.files)?;
        self.folders.iter().try_for_each(|folder| remove_folder(folder))
    }
}

fn remove_folder(folder: &Path) -> Result<(), OutputError> {
    match fs::remove_dir(folder) {
        Err(e) if !absent(&e) && e.kind() != io::ErrorKind::DirectoryNotEmpty => {
            Err(OutputError::file("remove", folder, e))
        }
        _ => Ok(()),
    }
}

fn remove(files: &[PathBuf]) -> Result<(), OutputError> {
    files.iter().try_for_each(|file| remove_if_there(file).map_err(|e| OutputError::file("remove", file, e)))
}

fn absent(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory)
}

fn refused(root: &Path, reason: String, hint: &'static str) -> OutputError {
    OutputError::Refused {
        path: root.to_path_buf(),
        reason: format!("{reason}, so nothing was changed"),
        hint,
    }
}

/// Names of what is in `folder`, none where there is no folder; those that are no text are left out.
fn names_in(root: &Path, folder: &Path) -> Result<Vec<String>, OutputError> {
    let failed = |e| OutputError::file("read", folder, e);
    match fs::symlink_metadata(folder) {
        Ok(facts) if facts.is_dir() => {}
        Ok(_) => {
            let name = folder.strip_prefix(root).unwrap_or(folder).display();
            let reason = format!("holds `{name}`, which is no folder though a run's folder has that name");
            return Err(refused(root, reason, "move it elsewhere or choose another folder with `--out`"));
        }
        Err(e) if absent(&e) => return Ok(Vec::new()),
        Err(e) => return Err(failed(e)),
    }
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).map_err(failed)? {
        names.extend(entry.map_err(failed)?.file_name().into_string());
    }
    names.sort();
    Ok(names)
}

/// Pictures of the report in the folder of checkpoints `folder`, complete or not.
///
/// # Errors
/// When the folder cannot be read.
pub(crate) fn pictures_in(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        if entry.file_name().to_str().is_some_and(names::is_picture) {
            found.push(entry.path());
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests;
