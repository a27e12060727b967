//! `tidelock view`.

use std::path::PathBuf;

use clap::Args;
use terminal::say;
use terminal::stop::StopSignals;

use crate::failure::Failure;
use crate::page::server;

/// Arguments of `view`.
#[derive(Debug, Args)]
pub(super) struct ViewArguments {
    /// Folder with the results of a run, finished or running.
    folder: PathBuf,
}

impl ViewArguments {
    pub(super) fn execute(&self) -> Result<(), Failure> {
        let failed = |e| Failure::internal(format!("cannot wait for a signal: {e}"));
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(failed)?;
        let _inside = runtime.enter();
        let mut signals = StopSignals::listen().map_err(failed)?;
        let server = server::of_folder(&self.folder)?;
        say(server.link());
        terminal::note("open this address in a browser; Ctrl-C ends");
        runtime.block_on(signals.next());
        server.end();
        Ok(())
    }
}
