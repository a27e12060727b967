//! `tidelock report`.

use std::path::PathBuf;

use clap::Args;
use terminal::say;

use crate::failure::Failure;
use crate::results::names;
use crate::study::{self, StudyRequest};

/// Arguments of `report`.
#[derive(Debug, Args)]
pub(super) struct ReportArguments {
    /// Cases to run; all when left out.
    cases: Vec<String>,
    /// Further resolutions, schemes, steps and cases.
    #[arg(long)]
    full: bool,
    /// Folder for the report and all runs.
    #[arg(long, value_name = "DIR", default_value = "results/report")]
    out: PathBuf,
    /// Repeat all runs; otherwise those that this build has finished in that folder are kept.
    #[arg(long)]
    fresh: bool,
    /// List the cases and what would be run.
    #[arg(long)]
    list: bool,
}

impl ReportArguments {
    pub(super) fn execute(self) -> Result<(), Failure> {
        let Self { cases, full, out, fresh, list } = self;
        let request = StudyRequest { cases, full, out, fresh };
        if list {
            study::list(&request)?.iter().for_each(say);
            return Ok(());
        }
        study::report(&request, |line| say(line))?;
        say(format_args!("report in {}", request.out.join(names::REPORT).display()));
        Ok(())
    }
}
