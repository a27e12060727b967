//! The hidden sub-command by which this program starts itself as a guard.

use std::process::ExitCode;

use clap::Args;

use crate::run::participants::guard;

/// Arguments of a guard.
#[derive(Debug, Args)]
pub(super) struct GuardArguments {
    process: i32,
}

impl GuardArguments {
    pub(super) fn execute(&self) -> ExitCode {
        guard::watch(self.process);
        ExitCode::SUCCESS
    }
}
