//! `tidelock resume`.

use std::path::PathBuf;

use clap::Args;

use super::options::RunOptionArguments;
use crate::failure::Failure;
use crate::results::table::Changed;
use crate::resume::{self, ResumeRequest};
use crate::run::RunOutcome;

/// Arguments of `resume`.
#[derive(Debug, Args)]
pub(super) struct ResumeArguments {
    /// Folder with the results of the run.
    folder: PathBuf,
    /// End at this time instead, in seconds; also continues a run that reached its end.
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    until: Option<f64>,
    /// Let another build of a solver take over; the results may then differ from those of an undisturbed run.
    #[arg(long)]
    accept_other_build: bool,
    /// Continue though tables or snapshots were changed or removed since the run wrote them: with what is there, as noted in
    /// `summary.json`.
    #[arg(long)]
    accept_changed_outputs: bool,
    #[command(flatten)]
    options: RunOptionArguments,
}

impl From<ResumeArguments> for ResumeRequest {
    fn from(arguments: ResumeArguments) -> Self {
        Self {
            folder: arguments.folder,
            until: arguments.until,
            accept_other_build: arguments.accept_other_build,
            changed: if arguments.accept_changed_outputs { Changed::Accept } else { Changed::Refuse },
            options: arguments.options.into(),
        }
    }
}

impl ResumeArguments {
    pub(super) fn execute(self) -> Result<(), Failure> {
        resume::resume(&self.into()).and_then(RunOutcome::completed).map(drop)
    }
}
