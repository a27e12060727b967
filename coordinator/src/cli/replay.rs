//! `tidelock replay` and `tidelock compare`.

use std::path::PathBuf;

use clap::Args;
use sph::coupling::solver::Role;
use terminal::say;

use super::run::NewRunArguments;
use crate::failure::Failure;
use crate::messages::Messages;
use crate::replay::{self, ReplayRequest};

/// Arguments of `replay`.
#[derive(Debug, Args)]
pub(super) struct ReplayArguments {
    /// Case file of the recorded run.
    case: PathBuf,
    /// Recording of the whole run.
    recording: PathBuf,
    /// Side that runs; the other is played.
    #[arg(long, value_name = "SIDE", value_parser = side)]
    side: Role,
    #[command(flatten)]
    new: NewRunArguments,
}

/// Arguments of `compare`.
#[derive(Debug, Args)]
pub(super) struct CompareArguments {
    /// A recording.
    first: PathBuf,
    /// Another one.
    second: PathBuf,
}

impl From<ReplayArguments> for ReplayRequest {
    fn from(ReplayArguments { case, recording, side, new }: ReplayArguments) -> Self {
        Self { case, recording, side, existing: new.existing(), out: new.out, options: new.options.into() }
    }
}

impl ReplayArguments {
    pub(super) fn execute(self) -> Result<(), Failure> {
        replay::replay(&self.into()).map(drop)
    }
}

impl CompareArguments {
    pub(super) fn execute(&self) -> Result<(), Failure> {
        let equal = replay::compare(&self.first, &self.second, Messages::All)?;
        say(format_args!("{equal} half-steps, equal to the last bit"));
        Ok(())
    }
}

/// The side of that name.
fn side(word: &str) -> Result<Role, String> {
    [Role::Fluid, Role::Solid]
        .into_iter()
        .find(|role| role.to_string() == word)
        .ok_or_else(|| "must be `fluid` or `solid`".into())
}
