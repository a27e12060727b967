//! The states that a run starts from, where its case has `start_from`: read once, and kept with the checkpoints, so that
//! the run can be resumed without the folder of the earlier one.

use std::cell::RefCell;
use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use sph::coupling::solver::{ParticleFields, Role};

use crate::case::overrides::Override;
use crate::case::{self, Case};
use crate::checkpoint::OriginDigests;
use crate::failure::Failure;
use crate::results::directory::OutputDirectory;
use crate::results::error::OutputError;
use crate::results::names;
use crate::results::state;

/// The states that a run starts from; none for a run whose case says how it starts.
#[derive(Clone, Debug, Default)]
pub struct Origin {
    states: Vec<(Role, ParticleFields)>,
    /// Files that were read.
    files: Vec<PathBuf>,
}

/// Reads and checks the case file at `path`, with the states that it starts from.
///
/// # Errors
/// All errors of the file.
pub fn load(path: &Path) -> Result<(Case, Origin), Failure> {
    load_with(path, &[])
}

/// As [`load`], with `overrides` set over the values of the file.
///
/// # Errors
/// All errors of the file and of the overrides.
pub fn load_with(path: &Path, overrides: &[Override]) -> Result<(Case, Origin), Failure> {
    let origin = RefCell::new(Origin::default());
    let read = |path: &Path| {
        let state = state::read(path)?;
        let mut origin = origin.borrow_mut();
        origin.states.extend(role_of(path).map(|role| (role, state.clone())));
        origin.files.push(path.to_path_buf());
        Ok(state)
    };
    let case = case::load_with(path, overrides, &read).map_err(|errors| Failure::case_errors(&errors))?;
    Ok((case, origin.into_inner()))
}

/// Reads and checks the case file of the run in `directory`; the states that it started from are those kept there, which
/// must have `digests`.
///
/// # Errors
/// All errors of the file; a state that is not there or is another one.
pub fn reload(directory: &OutputDirectory, digests: &OriginDigests) -> Result<Case, Failure> {
    let mut kept = Vec::new();
    for role in [Role::Fluid, Role::Solid] {
        if let Some(digest) = &digests[role.index()] {
            kept.push((role, kept_state(directory, role, digest)?));
        }
    }
    let read = |path: &Path| {
        let found = kept.iter().find(|(role, _)| role_of(path) == Some(*role));
        found
            .map(|(_, state)| state.clone())
            .ok_or_else(|| "the checkpoint knows of no such state".to_owned())
    };
    case::load(&directory.file(names::CASE), &read).map_err(|errors| Failure::case_errors(&errors))
}

fn kept_state(directory: &OutputDirectory, role: Role, digest: &str) -> Result<ParticleFields, Failure> {
    let path = kept_file(directory, role);
    let problem = match state::read(&path) {
        Ok(state) if state::digest(&state) == digest => return Ok(state),
        Ok(_) => format!("`{}` is another state than that of the checkpoint", path.display()),
        Err(problem) => problem,
    };
    Err(Failure::input(format!(
        "{problem}; the run started from this state and cannot continue without it: put the file back as the run left it, or \
         repeat the run by `run --force`"
    )))
}

/// The side whose final state the file at `path` is, by its name.
fn role_of(path: &Path) -> Option<Role> {
    let stem = path.file_stem()?.to_str()?;
    [Role::Fluid, Role::Solid].into_iter().find(|role| role.to_string() == stem)
}

/// Where the state that `role` started from is kept.
fn kept_file(directory: &OutputDirectory, role: Role) -> PathBuf {
    directory.file(names::CHECKPOINTS).join(format!("start_{role}.state"))
}

impl Origin {
    /// That none of the states lies in `out`, where the results go: the run would remove what it starts from.
    ///
    /// # Errors
    /// When one does, also by a link or by another spelling of the path.
    pub fn must_not_be_in(&self, out: &Path) -> Result<(), Failure> {
        let id = |path: &Path| fs::metadata(path).map(|facts| (facts.dev(), facts.ino())).ok();
        let Some(written) = id(&out.join(names::FINAL)) else { return Ok(()) };
        let lies_there = |file: &&PathBuf| {
            let real = fs::canonicalize(file).ok();
            real.and_then(|file| id(file.parent()?)) == Some(written)
        };
        match self.files.iter().find(lies_there) {
            None => Ok(()),
            Some(file) => Err(Failure::input(format!(
                "`start_from`: `{}` lies in the output folder `{}`, whose final states the run replaces; choose another \
                 folder with `--out`",
                file.display(),
                out.display()
            ))),
        }
    }

    /// Digests of the states.
    pub fn digests(&self) -> OriginDigests {
        let mut digests = [None, None];
        for (role, state) in &self.states {
            digests[role.index()] = Some(state::digest(state));
        }
        digests
    }

    /// Keeps the states in `directory`.
    ///
    /// # Errors
    /// When they cannot be written.
    pub fn keep(&self, directory: &OutputDirectory) -> Result<(), OutputError> {
        if self.states.is_empty() {
            return Ok(());
        }
        let folder = directory.file(names::CHECKPOINTS);
        fs::create_dir_all(&folder).map_err(|e| OutputError::file("create folder", &folder, e))?;
        self.states.iter().try_for_each(|(role, state)| state::write(&kept_file(directory, *role), state))
    }
}
