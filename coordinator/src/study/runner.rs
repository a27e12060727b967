//! Runs one study member in process and measures its cost.

use std::path::Path;

use proto::trace;

use crate::failure::Failure;
use crate::messages::Messages;
use crate::results::directory::Existing;
use crate::run::{RunOptions, RunOutcome, RunRequest};

/// A run and its cost.
pub struct MeasuredRun {
    /// What the run gave.
    pub outcome: Result<RunOutcome, Failure>,
    /// CPU time of this process during the run, outputs included \[s\].
    pub cpu_seconds: f64,
}

/// Runs `case_file` with all results in `out`, which are replaced; `None` for threads on all cores.
pub fn run(case_file: &Path, out: &Path, threads: Option<u16>) -> MeasuredRun {
    let request = RunRequest {
        case: case_file.to_owned(),
        overrides: Vec::new(),
        out: Some(out.to_owned()),
        existing: Existing::Replace,
        options: RunOptions { threads, messages: Messages::Warnings, ..RunOptions::default() },
    };
    let before = trace::process_cpu();
    let outcome = crate::run::run(&request);
    MeasuredRun { outcome, cpu_seconds: trace::process_cpu().saturating_sub(before).as_secs_f64() }
}
