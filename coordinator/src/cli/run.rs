//! `tidelock run`.

use std::path::PathBuf;

use clap::Args;

use super::headings::RESULTS;
use super::options::RunOptionArguments;
use super::set::SetArguments;
use crate::failure::Failure;
use crate::results::directory::Existing;
use crate::run::{self, RunOutcome, RunRequest};

/// Arguments of `run`.
#[derive(Debug, Args)]
pub(super) struct RunArguments {
    /// Case file, TOML; see cases/FORMAT.md.
    case: PathBuf,
    #[command(flatten)]
    set: SetArguments,
    #[command(flatten)]
    new: NewRunArguments,
}

/// How a case is run from its start, and where its results go.
#[derive(Debug, Args)]
pub(super) struct NewRunArguments {
    /// Folder for the results [default: results/ and the name of the case file, with `_replay` for a replay].
    #[arg(long, value_name = "DIR", help_heading = RESULTS)]
    pub(super) out: Option<PathBuf>,
    /// Replace the results of an earlier run in that folder, which are refused otherwise. Files of a run go by their names;
    /// a folder that no run wrote to is refused.
    #[arg(long, help_heading = RESULTS)]
    force: bool,
    #[command(flatten)]
    pub(super) options: RunOptionArguments,
}

impl NewRunArguments {
    /// What becomes of earlier results.
    pub(super) fn existing(&self) -> Existing {
        if self.force { Existing::Replace } else { Existing::Refuse }
    }
}

impl From<RunArguments> for RunRequest {
    fn from(RunArguments { case, set, new }: RunArguments) -> Self {
        Self {
            case,
            overrides: set.overrides,
            existing: new.existing(),
            out: new.out,
            options: new.options.into(),
        }
    }
}

impl RunArguments {
    pub(super) fn execute(self) -> Result<(), Failure> {
        run::run(&self.into()).and_then(RunOutcome::completed).map(drop)
    }
}
