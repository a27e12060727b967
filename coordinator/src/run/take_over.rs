//! When a run begins to change the folder of an earlier one: not before all solvers are ready, of a run that continues with
//! its checkpoint taken over.

use super::attempt::Attempt;
use super::job::Job;
use crate::checkpoint::{Disk, RunCheckpoint, Store};
use crate::failure::Failure;
use crate::results::error::OutputError;
use crate::results::files::write_file;
use crate::results::names;
use crate::results::recorder;
use crate::results::table::Changed;

impl Job {
    /// Writes the case as resolved, with what was set over its file.
    fn write_case(&self) -> Result<(), OutputError> {
        let resolved = self.case.recorded_toml();
        write_file(&self.directory.file(names::CASE), |file| {
            std::io::Write::write_all(file, resolved.as_bytes())
        })
    }

    /// What to do with outputs that are not as they were.
    pub(super) fn changed(&self) -> Changed {
        self.resume.as_ref().map_or(Changed::Refuse, |resume| resume.changed)
    }
}

impl Attempt<'_> {
    /// Makes the folder that of a new run, whose solvers are all ready.
    pub(super) fn begin(&self) -> Result<(), Failure> {
        let job = self.job;
        job.directory.begin()?;
        job.write_case()?;
        Ok(job.origin.keep(&job.directory)?)
    }

    /// Makes the folder that of a run which continues from `checkpoint`, all of whose solvers have taken it over.
    pub(super) fn take_over(&self, checkpoint: &RunCheckpoint, store: &Store) -> Result<(), Failure> {
        let directory = &self.job.directory;
        directory.take_over()?;
        if self.job.resume.is_some() && self.number == 0 {
            self.job.write_case()?;
        }
        store.clear(&mut Disk, checkpoint.step)?;
        Ok(recorder::forget_other_pictures(directory, &checkpoint.outputs.recorder)?)
    }
}
