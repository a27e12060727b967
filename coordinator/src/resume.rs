//! A run continues from its newest good checkpoint.

use std::path::PathBuf;
use std::sync::Arc;

use sph::coupling::solver::Role;

use crate::checkpoint::{RunCheckpoint, Store};
use crate::failure::Failure;
use crate::messages::Messages;
use crate::results::directory::OutputDirectory;
use crate::results::names;
use crate::results::recorder::Recorder;
use crate::results::table::Changed;
use crate::run::job::{Job, Resumption};
use crate::run::origin::{self, Origin};
use crate::run::{self, RunOptions, RunOutcome};

/// A run that continues.
#[derive(Clone, Debug, Default)]
pub struct ResumeRequest {
    /// Folder with the results of the run.
    pub folder: PathBuf,
    /// Another end time \[s\]; also continues a run that reached its end.
    pub until: Option<f64>,
    /// Another build of a solver may take over; the results may then differ from those of an undisturbed run.
    pub accept_other_build: bool,
    /// What to do with outputs that were changed or removed since the run wrote them.
    pub changed: Changed,
    /// How it is run.
    pub options: RunOptions,
}

/// Continues the run in a folder. Nothing in the folder is changed before all solvers have taken the checkpoint over.
///
/// # Errors
/// When there is no good checkpoint, when it is of another case, format, build or arithmetic path, when outputs are not as
/// they were, and as [`run::run`].
pub fn resume(request: &ResumeRequest) -> Result<RunOutcome, Failure> {
    let options = request.options.clone();
    options.force_arithmetic()?;
    let out = &request.folder;
    let directory = Arc::new(OutputDirectory::reopen(out)?);
    let checkpoint = newest(&directory, options.messages)?;
    let mut case = origin::reload(&directory, &checkpoint.outputs.origin)?;
    if let Some(difference) = checkpoint.case_difference(&case.identity()) {
        return Err(Failure::input(format!(
            "the case in `{}` is not the one of the checkpoint; they differ {difference}\n\
             give the case back its old values, or repeat the run by `run --force`",
            out.display()
        )));
    }
    if let Some(time) = request.until {
        case.set_end_time(time).map_err(|problem| Failure::input(format!("`--until`: {problem}")))?;
    }
    let changed = request.changed;
    if changed == Changed::Refuse {
        let roles: Vec<Role> =
            [Role::Fluid, Role::Solid].into_iter().filter(|role| case.has(*role)).collect();
        Recorder::examine(&directory, &case, &roles, &checkpoint.outputs.recorder)?;
    }
    let (step, time) = (checkpoint.step, checkpoint.time);
    options.messages.progress(format_args!("continuing at step {step}, t = {time} s"));
    let resume = Some(Resumption { checkpoint, accept_other_build: request.accept_other_build, changed });
    run::execute(&Job { case, origin: Origin::default(), directory, options, resume, replay: None })
}

/// The newest good checkpoint of the run in `directory`; prints which are not good.
///
/// # Errors
/// When there is none.
fn newest(directory: &OutputDirectory, messages: Messages) -> Result<RunCheckpoint, Failure> {
    let found = Store::new(directory.file(names::CHECKPOINTS)).newest();
    for problem in &found.skipped {
        messages.notice(format_args!("skipped checkpoint {problem}"));
    }
    found.checkpoint.ok_or_else(|| {
        let list = found.skipped.join("\n  ");
        Failure::input(format!(
            "`{}` holds no good checkpoint; repeat the run by `run --force`\n  {list}",
            directory.path().display()
        ))
    })
}
