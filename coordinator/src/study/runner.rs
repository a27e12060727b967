//! One run of a study: in this process, without a word, its cost measured.

use std::path::Path;

use proto::trace;

use crate::cli::{NewRunOptions, RunArguments, RunOptions};
use crate::failure::Failure;

/// What became of a run.
pub struct Made {
    /// Whether it reached its end.
    pub outcome: Result<(), Failure>,
    /// CPU time of this process meanwhile, outputs included \[s\].
    pub cpu_seconds: f64,
}

/// Runs `case_file` with all results in `out`, which are replaced; `None` for threads on all cores.
pub fn run(case_file: &Path, out: &Path, threads: Option<u16>) -> Made {
    let arguments = RunArguments {
        case: case_file.to_owned(),
        new: NewRunOptions {
            out: Some(out.to_owned()),
            force: true,
            options: RunOptions {
                in_process: true,
                threads,
                window: 64,
                quiet: true,
                ..RunOptions::default()
            },
        },
    };
    let before = trace::process_cpu();
    let outcome = crate::run::run(&arguments);
    Made { outcome, cpu_seconds: trace::process_cpu().saturating_sub(before).as_secs_f64() }
}
