//! `tidelock overlay`.

use std::path::PathBuf;

use clap::Args;
use terminal::say;

use crate::failure::Failure;
use crate::overlay::output::{PAGE, lines};
use crate::overlay::{self, OverlayRequest};

/// Arguments of `overlay`.
#[derive(Debug, Args)]
pub(super) struct OverlayArguments {
    /// Folders with the results of runs; the others are compared with the first.
    #[arg(required = true, num_args = 1..)]
    runs: Vec<PathBuf>,
    /// Probe column to show, such as `tip_displacement_y_m`; repeat for several [default: all].
    #[arg(long = "column", value_name = "COLUMN")]
    columns: Vec<String>,
    /// Folder for overlay.html and overlay.csv; an earlier overlay in it is replaced.
    #[arg(long, value_name = "DIR", default_value = "results/overlay")]
    out: PathBuf,
}

impl OverlayArguments {
    pub(super) fn execute(self) -> Result<(), Failure> {
        let Self { runs, columns, out } = self;
        let request = OverlayRequest { runs, columns, out };
        lines(&overlay::make(&request)?).iter().for_each(say);
        say(format_args!("page: {}", request.out.join(PAGE).display()));
        Ok(())
    }
}
