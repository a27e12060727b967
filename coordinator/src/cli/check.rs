//! `coordinator check`.

use std::path::PathBuf;

use clap::Args;
use terminal::say;

use super::set::SetArguments;
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
}

impl CheckArguments {
    pub(super) fn execute(&self) -> Result<(), Failure> {
        let checked = check::check(&self.case, &self.set.overrides)?;
        let text = if self.resolved { checked.case.recorded_toml() } else { checked.text() };
        say(text.trim_end());
        if let Some(picture) = &self.picture {
            check::draw(&checked.case, picture)?;
            terminal::note(format_args!("initial particles drawn to {}", quote::path(picture)));
        }
        Ok(())
    }
}
