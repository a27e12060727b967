//! Feeds made-up input to everything that reads files, frames and command lines.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use tests::bench::Bench;
use tests::fuzz::{Target, fuzz};
use tests::nodes;

/// Damages good input by dice and feeds it: nothing may panic, hang or take much memory. A finding is repeated by
/// `--first NUMBER --count 1` with the same seed.
#[derive(Debug, Parser)]
struct Arguments {
    /// What is fed.
    #[arg(long)]
    target: Target,
    /// Number of inputs.
    #[arg(long, default_value_t = 1_000_000)]
    count: u64,
    /// Start of the random numbers.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Number of the first input.
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// Program that makes a checkpoint to damage [default: `tidelock-node` beside this one].
    #[arg(long)]
    program: Option<PathBuf>,
}

/// A process that grows by more than this has taken memory that no small input is worth: a scene of the largest allowed number
/// of particles takes less.
const MEMORY_LIMIT: u64 = 4 << 30;

fn main() -> ExitCode {
    terminal::program::run(|| run(Arguments::parse()))
}

fn run(arguments: Arguments) -> ExitCode {
    let program = match nodes::program(arguments.program) {
        Ok(program) => program,
        Err(code) => return code,
    };
    let bench = Bench::new(&program.to_string_lossy());
    let seeds = bench.fuzz_seeds(arguments.target);
    // Panics are counted and told at the end.
    let printing = std::panic::take_hook();
    std::panic::set_hook(Box::new(|_| {}));
    let found = fuzz(arguments.target, &seeds, arguments.seed, arguments.first, arguments.count);
    std::panic::set_hook(printing);
    terminal::say(format_args!(
        "{:?}: {} inputs, {} taken for good, {} panics, slowest {:.3} s (input {}), memory grew by {} MiB",
        arguments.target,
        found.inputs,
        found.accepted,
        found.panics.len(),
        found.slowest.as_secs_f64(),
        found.slowest_input,
        found.memory_growth >> 20
    ));
    for (number, text) in found.panics.iter().take(20) {
        terminal::say(format_args!("  input {number}: {text}"));
    }
    if found.panics.is_empty() && found.memory_growth < MEMORY_LIMIT {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}
