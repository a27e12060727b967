//! `coordinator resume`: a run goes on from its newest good checkpoint.

use std::path::Path;
use std::sync::Arc;

use crate::checkpoint::{Disk, RunCheckpoint, Store};
use crate::cli::ResumeArguments;
use crate::failure::Failure;
use crate::output::directory::{self, OutputDirectory};
use crate::run::{self, Job};

/// Goes on with the run in a folder as the command line says.
///
/// # Errors
/// When there is no good checkpoint, when it is of another case, format, build or arithmetic path, and as
/// [`run::run`].
pub fn resume(arguments: &ResumeArguments) -> Result<(), Failure> {
    arguments.options.force_arithmetic()?;
    let out = &arguments.folder;
    let directory = Arc::new(OutputDirectory::reopen(out)?);
    let mut case = run::load(&directory.file(directory::CASE))?;
    let checkpoint = newest(&directory)?;
    if let Some(difference) = checkpoint.case_difference(&case.identity()) {
        return Err(Failure::input(format!(
            "the case in `{}` is not the one of the checkpoint; they differ {difference}\n\
             give the case back its old values, or start it anew by `run`",
            out.display()
        )));
    }
    if let Some(time) = arguments.until {
        case.set_end_time(time).map_err(|problem| Failure::input(format!("`--until`: {problem}")))?;
    }
    if !arguments.options.quiet {
        terminal::note(format_args!("going on at step {}, t = {} s", checkpoint.step, checkpoint.time));
    }
    let resumed = run::execute(&Job {
        case,
        directory,
        options: arguments.options.clone(),
        resume: Some(checkpoint),
        accept_other_build: arguments.accept_other_build,
        alone: None,
    });
    resumed.map(drop)
}

/// The newest good checkpoint of the run in `directory`; says which are not good, and removes them.
///
/// # Errors
/// When there is none.
pub fn newest(directory: &OutputDirectory) -> Result<RunCheckpoint, Failure> {
    let store = Store::new(directory.file(directory::CHECKPOINTS));
    let found = store.newest();
    for problem in &found.passed_over {
        terminal::note(format_args!("passed over: {problem}"));
    }
    let Some(checkpoint) = found.checkpoint else {
        let list = found.passed_over.join("\n  ");
        return Err(Failure::input(format!(
            "`{}` holds no good checkpoint; start the run anew by `run`\n  {list}",
            directory.path().display()
        )));
    };
    store.forget_after(&mut Disk, checkpoint.step)?;
    Ok(checkpoint)
}

/// The command that goes on with the run in `folder`.
pub fn command(folder: &Path) -> String {
    format!("coordinator resume {}", folder.display())
}
