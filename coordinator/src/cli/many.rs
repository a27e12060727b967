//! Options of all commands that run a case several times.

use std::path::PathBuf;

use clap::Args;

use super::options::RunOptionArguments;
use super::set::SetArguments;
use crate::family::figures::Figure;
use crate::messages::Messages;
use crate::run::{RunOptions, RunRequest};

/// How several runs are made, and what is read off them.
#[derive(Debug, Args)]
pub(super) struct ManyRunsArguments {
    #[command(flatten)]
    set: SetArguments,
    /// Key figure; repeat for several [default: largest, smallest and last value of every probe column]. Write `largest
    /// COLUMN`, `smallest COLUMN` or `mean COLUMN`, each with ` from T to T s` where it is of a part of the run, `COLUMN at T
    /// s`, `last COLUMN`, `COLUMN rises to LEVEL` or `COLUMN falls to LEVEL`.
    #[arg(long = "figure", value_name = "FIGURE")]
    pub(super) figures: Vec<Figure>,
    /// Runs at a time; the cores are shared among them unless `--threads` says otherwise.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(super) jobs: u16,
    /// Repeat finished runs; otherwise those that this build has finished in that folder are kept, and interrupted ones
    /// continue from their last checkpoint.
    #[arg(long)]
    pub(super) fresh: bool,
    /// Folder for all runs and the results.
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    #[command(flatten)]
    pub(super) options: RunOptionArguments,
}

/// What [`ManyRunsArguments`] say.
pub(super) struct ManyRuns {
    /// What the runs have in common.
    pub run: RunRequest,
    /// Key figures.
    pub figures: Vec<Figure>,
    /// Runs at a time.
    pub jobs: usize,
    /// Repeat finished runs.
    pub fresh: bool,
}

impl ManyRunsArguments {
    /// Runs of `case`, by default in `results/` and its name with `suffix`.
    pub(super) fn of(self, case: PathBuf, suffix: &str) -> ManyRuns {
        let out = self.out.unwrap_or_else(|| crate::run::default_folder(&case, suffix));
        let run = RunRequest {
            case,
            overrides: self.set.overrides,
            out: Some(out),
            options: self.options.into(),
            ..RunRequest::default()
        };
        ManyRuns { run, figures: self.figures, jobs: self.jobs.into(), fresh: self.fresh }
    }
}

/// Prints a line about a run, where messages are wanted.
pub(super) fn progress(options: &RunOptions) -> impl Fn(&str) + use<> {
    let shown = options.messages >= Messages::All;
    move |line| {
        if shown {
            terminal::note(line);
        }
    }
}
