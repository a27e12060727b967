//! Checks case files that are made to hurt, each in a process of its own.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use clap::Parser;
use tests::mutants::{Limits, Mutants};
use tests::nodes;

/// Sends case files that are made to hurt through `check`: each must be accepted or refused within the limits. The exit
/// code is 1 when one is not.
#[derive(Debug, Parser)]
struct Arguments {
    /// Of the cases with a replaced value, every so many-th.
    #[arg(long, default_value_t = 1)]
    stride: usize,
    /// Longest time of a check, in seconds.
    #[arg(long, default_value_t = 2.0)]
    seconds: f64,
    /// Largest address space of a check, in MiB.
    #[arg(long, default_value_t = 500)]
    mebibytes: u64,
    /// Checks at a time.
    #[arg(long, default_value_t = 1)]
    workers: usize,
    /// Run accepted cases, too, for at most three seconds each.
    #[arg(long)]
    run: bool,
    /// Program under test [default: `tidelock-node` beside this one].
    #[arg(long)]
    program: Option<PathBuf>,
}

fn main() -> ExitCode {
    terminal::program::run(|| run(Arguments::parse()))
}

fn run(arguments: Arguments) -> ExitCode {
    let program = match nodes::program(arguments.program) {
        Ok(program) => program,
        Err(code) => return code,
    };
    let mutants = Mutants::new(&program, arguments.stride);
    let limits =
        Limits { time: Duration::from_secs_f64(arguments.seconds), memory: arguments.mebibytes << 20 };
    let found = mutants.judge(limits, arguments.workers, arguments.run);
    terminal::say(format_args!(
        "{} cases checked, {} accepted, {} run",
        found.checks.len(),
        found.accepted(),
        found.runs.len()
    ));
    for check in found.checks.iter().take(5) {
        terminal::say(format_args!("  slowest: {:.2} s  {}", check.time.as_secs_f64(), check.name));
    }
    if let Some(check) = found.largest() {
        terminal::say(format_args!("  largest: {} MiB  {}", check.memory >> 20, check.name));
    }
    for code in [0, 2, 4, 5, 6] {
        let count = found.runs.iter().filter(|run| run.code == Some(code)).count();
        if count > 0 {
            terminal::say(format_args!("  runs that ended with {code}: {count}"));
        }
    }
    for run in found.runs.iter().filter(|run| matches!(run.code, Some(2 | 4))) {
        terminal::say(format_args!("  accepted, but its run ended with {:?}: {}", run.code, run.name));
    }
    found.faults.iter().for_each(|fault| terminal::say(format_args!("fault: {fault}")));
    if found.faults.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
