//! `tidelock check`.

use std::path::PathBuf;

use clap::Args;
use terminal::say;

use super::set::SetArguments;
use crate::brief::Layout;
use crate::check;
use crate::failure::Failure;
use crate::quote;

/// Arguments of `check`.
#[derive(Debug, Args)]
pub(super) struct CheckArguments {
    /// Case file, TOML; see cases/FORMAT.md.
    case: PathBuf,
    #[command(flatten)]
    set: SetArguments,
    /// Draw the initial particles to this PNG.
    #[arg(long, value_name = "PNG")]
    picture: Option<PathBuf>,
    /// Print the case as resolved, with every default written out.
    #[arg(long)]
    resolved: bool,
    /// Also print counts, cuts, limits of the time step, constants, active terms and departures from what is recommended.
    #[arg(long, short, conflicts_with = "resolved")]
    verbose: bool,
}

impl CheckArguments {
    pub(super) fn execute(&self) -> Result<(), Failure> {
        let checked = check::check(&self.case, &self.set.overrides)?;
        if self.resolved {
            say(checked.case.recorded_toml().trim_end());
        } else {
            say(checked.brief(&self.case, Layout::of_output()));
        }
        if self.verbose {
            say(checked.details(Layout::of_output()).trim_end());
        }
        if let Some(picture) = &self.picture {
            check::draw(&checked.case, picture)?;
            terminal::note(format_args!("initial particles drawn to {}", quote::path(picture)));
        }
        Ok(())
    }
}
