//! A run: from a case file to results.

mod attempt;
pub mod checkpoint_scheduler;
pub(crate) mod completion;
pub mod control;
mod execution;
pub mod header;
pub(crate) mod job;
mod losses;
pub(crate) mod memory;
pub mod origin;
pub mod outcome;
mod page;
pub mod participants;
mod path_choice;
pub mod request;
pub mod signals;
mod solvers;
mod take_over;
pub mod trace;

use std::path::{Path, PathBuf};
use std::sync::Arc;

pub(crate) use execution::execute;
pub use outcome::RunOutcome;
pub use request::{OnReservations, Placement, RelayOptions, RunOptions, RunRequest, ServerOptions};

use self::job::Job;
use self::origin::Origin;
use crate::case::Case;
use crate::case::overrides::Override;
use crate::failure::Failure;
use crate::results::directory::{Existing, OutputDirectory};

/// Runs a case from its start.
///
/// # Errors
/// When the case is wrong, a server cannot be started, an output cannot be written, or the run was lost before it had
/// results. A run that ends before its end time has an outcome, which holds its failure.
pub fn run(request: &RunRequest) -> Result<RunOutcome, Failure> {
    request.options.force_arithmetic()?;
    let (case, origin) = origin::load_with(&request.case, &request.overrides)?;
    memory::check(&case)?;
    let out = request.out.clone().unwrap_or_else(|| default_folder(&request.case, ""));
    let directory = new_folder(&out, request.existing, &origin)?;
    let options = request.options.clone();
    execute(&Job { case, origin, directory, options, resume: None, replay: None })
}

/// Reads and checks a case file.
///
/// # Errors
/// All errors of the file.
pub fn load(path: &Path) -> Result<Case, Failure> {
    load_with(path, &[])
}

/// Reads and checks a case file with `overrides` set over its values.
///
/// # Errors
/// All errors of the file and of the overrides.
pub fn load_with(path: &Path, overrides: &[Override]) -> Result<Case, Failure> {
    origin::load_with(path, overrides).map(|(case, _)| case)
}

/// Folder for the results of the case at `path`, where none is given.
pub(crate) fn default_folder(path: &Path, suffix: &str) -> PathBuf {
    let name = path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy();
    Path::new("results").join(format!("{name}{suffix}"))
}

/// Makes the folder `out` for the results of a run that starts from `origin`.
///
/// # Errors
/// When it cannot be, or holds results that must stay.
pub(crate) fn new_folder(
    out: &Path,
    existing: Existing,
    origin: &Origin,
) -> Result<Arc<OutputDirectory>, Failure> {
    origin.must_not_be_in(out)?;
    Ok(Arc::new(OutputDirectory::create(out, existing)?))
}
