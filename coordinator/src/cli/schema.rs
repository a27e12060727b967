//! `tidelock schema`.

use clap::Args;
use terminal::say;

use crate::failure::Failure;
use crate::new;

/// Arguments of `schema`.
#[derive(Debug, Args)]
pub(super) struct SchemaArguments {}

impl SchemaArguments {
    pub(super) fn execute(&self) -> Result<(), Failure> {
        say(new::schema().trim_end());
        Ok(())
    }
}
