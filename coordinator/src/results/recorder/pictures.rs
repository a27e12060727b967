//! Particles of the report's pictures, kept in the folder of checkpoints.

use std::path::PathBuf;

use sph::coupling::solver::Role;

use super::RecorderState;
use crate::case::Case;
use crate::results::directory::OutputDirectory;
use crate::results::earlier;
use crate::results::error::OutputError;
use crate::results::files::remove_if_there;
use crate::results::names;
use crate::results::plots::gallery::Pictures;
use crate::results::state;

/// Where the report's picture of `role` at `step` is kept.
pub(super) fn picture_file(directory: &OutputDirectory, role: Role, step: u64) -> PathBuf {
    directory.file(names::CHECKPOINTS).join(format!("picture_{role}_{step}.state"))
}

/// The report's pictures that `state` names, and which of them are there; one that is lost is noted in `news`.
pub(super) fn stored_pictures(
    directory: &OutputDirectory,
    case: &Case,
    state: &RecorderState,
    news: &mut Vec<String>,
) -> (Pictures, [Vec<u64>; 2]) {
    let mut pictures = Pictures::new(case.outputs.picture_times.clone());
    let mut stored = [Vec::new(), Vec::new()];
    for role in [Role::Fluid, Role::Solid] {
        for step in &state.pictures[role.index()] {
            match state::read(&picture_file(directory, role, *step)) {
                Ok(fields) if fields.step == *step => {
                    pictures.take(role, fields);
                    stored[role.index()].push(*step);
                }
                other => {
                    let why = other.map_or_else(|problem| problem, |of| format!("it is of step {}", of.step));
                    news.push(format!("the report lacks its picture of the {role} at step {step}: {why}"));
                }
            }
        }
    }
    (pictures, stored)
}

/// Removes what was stored for the report in the folder of checkpoints and does not belong to `state`.
///
/// # Errors
/// When the system refuses.
pub fn forget_others(directory: &OutputDirectory, state: &RecorderState) -> Result<(), OutputError> {
    let folder = directory.file(names::CHECKPOINTS);
    let kept: Vec<PathBuf> = [Role::Fluid, Role::Solid]
        .into_iter()
        .flat_map(|role| state.pictures[role.index()].iter().map(move |step| (role, *step)))
        .map(|(role, step)| picture_file(directory, role, step))
        .collect();
    let there = earlier::pictures_in(&folder).map_err(|e| OutputError::file("read", &folder, e))?;
    for path in there {
        if !kept.contains(&path) {
            remove_if_there(&path).map_err(|e| OutputError::file("remove", &path, e))?;
        }
    }
    Ok(())
}
