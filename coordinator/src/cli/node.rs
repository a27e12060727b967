//! Hidden sub-commands by which this program starts itself again: as a server or as a guard.

use std::ffi::OsString;
use std::process::ExitCode;

use clap::Args;

use crate::run::participants::guard;

/// Arguments of a guard.
#[derive(Debug, Args)]
pub(super) struct GuardArguments {
    process: i32,
}

/// Arguments that go to the server as they are.
#[derive(Debug, Args)]
pub(super) struct NodeArguments {
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    arguments: Vec<String>,
}

impl GuardArguments {
    pub(super) fn execute(&self) -> ExitCode {
        guard::watch(self.process);
        ExitCode::SUCCESS
    }
}

impl NodeArguments {
    /// The command line of the server `program`.
    pub(super) fn words(self, program: &str) -> Vec<OsString> {
        std::iter::once(program.to_owned()).chain(self.arguments).map(OsString::from).collect()
    }
}
