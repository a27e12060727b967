//! `coordinator resume`: a run continues from its newest good checkpoint.

use std::path::Path;
use std::sync::Arc;

use sph::solver::Role;

use crate::checkpoint::{RunCheckpoint, Store};
use crate::cli::ResumeArguments;
use crate::failure::Failure;
use crate::results::directory::OutputDirectory;
use crate::results::names;
use crate::results::recorder::Recorder;
use crate::results::table::Changed;
use crate::run::origin;
use crate::run::{self, Job, Resumption};

/// Continues the run in a folder as the command line says. Nothing in the folder is changed before all solvers have taken
/// the checkpoint over.
///
/// # Errors
/// When there is no good checkpoint, when it is of another case, format, build or arithmetic path, when outputs are not as
/// they were, and as [`run::run`].
pub fn resume(arguments: &ResumeArguments) -> Result<(), Failure> {
    arguments.options.force_arithmetic()?;
    let out = &arguments.folder;
    let directory = Arc::new(OutputDirectory::reopen(out)?);
    let checkpoint = newest(&directory)?;
    let origin = checkpoint.outputs.origin.clone();
    let mut case = origin::reload(&directory, &origin)?;
    if let Some(difference) = checkpoint.case_difference(&case.identity()) {
        return Err(Failure::input(format!(
            "the case in `{}` is not the one of the checkpoint; they differ {difference}\n\
             give the case back its old values, or repeat the run by `run --force`",
            out.display()
        )));
    }
    if let Some(time) = arguments.until {
        case.set_end_time(time).map_err(|problem| Failure::input(format!("`--until`: {problem}")))?;
    }
    let changed = if arguments.accept_changed_outputs { Changed::Accept } else { Changed::Refuse };
    if changed == Changed::Refuse {
        let takes_part = [(Role::Fluid, case.has_fluid()), (Role::Solid, case.has_solid())];
        let roles: Vec<Role> =
            takes_part.into_iter().filter_map(|(role, does)| does.then_some(role)).collect();
        Recorder::examine(&directory, &case, &roles, &checkpoint.outputs.recorder)?;
    }
    if !arguments.options.quiet {
        terminal::note(format_args!("continuing at step {}, t = {} s", checkpoint.step, checkpoint.time));
    }
    let accept_other_build = arguments.accept_other_build;
    let resumed = run::execute(&Job {
        case,
        origin,
        directory,
        options: arguments.options.clone(),
        resume: Some(Resumption { checkpoint, accept_other_build, changed }),
        alone: None,
    });
    resumed.map(drop)
}

/// The newest good checkpoint of the run in `directory`; says which are not good.
///
/// # Errors
/// When there is none.
pub fn newest(directory: &OutputDirectory) -> Result<RunCheckpoint, Failure> {
    let found = Store::new(directory.file(names::CHECKPOINTS)).newest();
    for problem in &found.passed_over {
        terminal::note(format_args!("passed over: {problem}"));
    }
    found.checkpoint.ok_or_else(|| {
        let list = found.passed_over.join("\n  ");
        Failure::input(format!(
            "`{}` holds no good checkpoint; repeat the run by `run --force`\n  {list}",
            directory.path().display()
        ))
    })
}

/// The command that goes on with the run in `folder`.
pub fn command(folder: &Path) -> String {
    format!("coordinator resume {}", folder.display())
}
