//! Whether a solver may continue from a checkpoint.

use proto::checkpoint::CheckpointData;
use proto::description::Description;
use sph::coupling::solver::Role;

use crate::checkpoint::RunCheckpoint;
use crate::failure::Failure;

/// The checkpoint from which a run continues.
#[derive(Clone, Copy)]
pub struct Restore<'a> {
    /// State of both sides.
    pub checkpoint: &'a RunCheckpoint,
    /// Counts the times that the run was restored, from 1.
    pub epoch: u32,
    /// Another build of a solver may take over.
    pub accept_other_build: bool,
}

impl Restore<'_> {
    /// The state of `role`, as the solver that `description` describes may take it over.
    ///
    /// # Errors
    /// When it may not, with all differences.
    pub(super) fn side_for(&self, role: Role, description: &Description) -> Result<CheckpointData, Failure> {
        let side = self.checkpoint.sides.iter().find(|side| side.header.role == role);
        let mut side = side.cloned().ok_or_else(|| {
            Failure::input(format!("the checkpoint holds no {role} solver, but the case has one"))
        })?;
        let [fatal, build] = side.header.differences(description, role);
        if !fatal.is_empty() {
            let list = fatal.join("\n  ");
            return Err(Failure::input(format!(
                "the {role} solver cannot continue from the checkpoint:\n  {list}\nuse the program and a machine that wrote it"
            )));
        }
        if !build.is_empty() && !self.accept_other_build {
            let list = build.join("\n  ");
            return Err(Failure::input(format!(
                "the {role} solver is of another build than the checkpoint:\n  {list}\nuse the program that wrote it, or \
                 add `--accept-other-build`: the results may then differ from those of an undisturbed run"
            )));
        }
        side.header.name.clone_from(&description.name);
        side.header.version.clone_from(&description.version);
        side.header.build.clone_from(&description.build);
        Ok(side)
    }
}
