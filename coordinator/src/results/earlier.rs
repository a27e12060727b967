//! What an earlier run left in an output folder: how it is known to be one of ours, and its files by name.
//!
//! Nothing is removed but files that bear the name of a run's file, in a place where a run puts it. Folders go only when
//! that leaves them empty. Links are removed, never followed.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::directory::{CHECKPOINTS, FINAL, LOGS, MARKER, OutputError, SIDES, SNAPSHOTS, SUMMARY, TOP_FILES};
use super::files::{PARTIAL, remove_if_there, with_suffix};
use super::{marker, summary};
use crate::checkpoint;

/// Whether `root` holds the marker or the summary of a run.
pub(super) fn carries_mark(root: &Path) -> bool {
    marker::text(&root.join(MARKER)).is_ok_and(|text| text.starts_with(marker::TEXT))
        || summary::is_of_a_run(&root.join(SUMMARY))
}

/// Files and folders of an earlier run, in the order in which they go.
#[derive(Debug, Default)]
pub(super) struct Remains {
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
        for name in TOP_FILES {
            found.file(root, with_suffix(&root.join(name)))?;
            found.file(root, root.join(name))?;
        }
        for (folder, is_ours) in [
            (FINAL, is_final as fn(&str) -> bool),
            (SNAPSHOTS, is_snapshot),
            (LOGS, is_log),
            (CHECKPOINTS, is_beside_checkpoints),
        ] {
            let folder = root.join(folder);
            for name in names_in(root, &folder)?.iter().filter(|name| is_ours(name)) {
                found.file(root, folder.join(name))?;
            }
        }
        found.checkpoints(root)?;
        found.folders.extend([SNAPSHOTS, FINAL, CHECKPOINTS, LOGS].map(|name| root.join(name)));
        Ok(found)
    }

    fn checkpoints(&mut self, root: &Path) -> Result<(), OutputError> {
        let checkpoints = root.join(CHECKPOINTS);
        for name in names_in(root, &checkpoints)?.iter().filter(|name| checkpoint::is_name(name)) {
            let place = checkpoints.join(name);
            let facts = fs::symlink_metadata(&place).map_err(|e| OutputError::file("look at", &place, e))?;
            if facts.is_symlink() {
                self.files.push(place);
                continue;
            }
            for file in names_in(root, &place)? {
                if !checkpoint::FILES.contains(&file.as_str()) {
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

    /// Removes it all; folders with anything else in them stay.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn remove(&self) -> Result<(), OutputError> {
        for file in &self.files {
            remove_if_there(file).map_err(|e| OutputError::file("remove", file, e))?;
        }
        for folder in &self.folders {
            match fs::remove_dir(folder) {
                Err(e) if !absent(&e) && e.kind() != io::ErrorKind::DirectoryNotEmpty => {
                    return Err(OutputError::file("remove", folder, e));
                }
                _ => {}
            }
        }
        Ok(())
    }
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

fn is_number(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit())
}

/// Whether a run gives this name to a final state.
fn is_final(name: &str) -> bool {
    let name = name.strip_suffix(PARTIAL).unwrap_or(name);
    name.strip_suffix(".state").is_some_and(|side| SIDES.contains(&side))
}

/// Whether a run gives this name to a file in its snapshot folder.
fn is_snapshot(name: &str) -> bool {
    let name = name.strip_suffix(PARTIAL).unwrap_or(name);
    SIDES.iter().filter_map(|side| name.strip_prefix(side)).any(|rest| {
        let digits = rest.strip_prefix('_').and_then(|rest| rest.strip_suffix(".vtp"));
        rest == ".pvd" || digits.is_some_and(is_number)
    })
}

/// Whether a run gives this name to a server's log.
fn is_log(name: &str) -> bool {
    SIDES
        .iter()
        .filter_map(|side| name.strip_prefix(side)?.strip_prefix("-server")?.strip_suffix(".log"))
        .any(|number| number.is_empty() || number.strip_prefix('-').is_some_and(is_number))
}

/// Whether a run gives this name to a file beside its checkpoints: a picture of the report, or the state it started from.
fn is_beside_checkpoints(name: &str) -> bool {
    let start = name.strip_suffix(PARTIAL).unwrap_or(name).strip_prefix("start_");
    is_picture(name) || start.is_some_and(is_final)
}

/// Whether a run gives this name to the particles of a picture of the report.
fn is_picture(name: &str) -> bool {
    let name = name.strip_suffix(PARTIAL).unwrap_or(name);
    let picture = name.strip_prefix("picture_").and_then(|rest| rest.strip_suffix(".state"));
    let step = |side| picture?.strip_prefix(side)?.strip_prefix('_');
    SIDES.into_iter().filter_map(step).any(is_number)
}

/// Pictures of the report in the folder of checkpoints `folder`, complete or not.
///
/// # Errors
/// When the folder cannot be read.
pub(crate) fn pictures_in(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        if entry.file_name().to_str().is_some_and(is_picture) {
            found.push(entry.path());
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests;
