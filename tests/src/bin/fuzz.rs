//! Feeds made-up input to everything that reads files, frames and command lines.

use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use clap::{Parser, ValueEnum};
use tests::bench::Bench;
use tests::fuzz::{Findings, Seeds, Target, fuzz_for};
use tests::nodes;

/// Damages good input by random and feeds it: nothing may panic, hang or take much memory. A finding is repeated by
/// `--target TARGET --first NUMBER --count 1` with the same seed.
#[derive(Debug, Parser)]
struct Arguments {
    /// What is fed [default: all targets in turn].
    #[arg(long)]
    target: Option<Target>,
    /// Number of inputs for each target.
    #[arg(long, default_value_t = 1_000_000)]
    count: u64,
    /// Longest time for all targets together, shared evenly, in seconds.
    #[arg(long)]
    seconds: Option<f64>,
    /// Start of the random numbers.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Number of the first input.
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// Program that makes a checkpoint to damage [default: `tidelock-node` beside this one].
    #[arg(long)]
    program: Option<PathBuf>,
    /// Folder for the inputs at which something panicked.
    #[arg(long)]
    keep: Option<PathBuf>,
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
    let targets = arguments.target.map_or_else(|| Target::value_variants().to_vec(), |target| vec![target]);
    let share = arguments.seconds.map_or(Duration::MAX, |seconds| {
        // At most seven targets.
        Duration::from_secs_f64(seconds.clamp(0.0, 1e9) / targets.len() as f64)
    });
    // Panics are counted and listed at the end.
    std::panic::set_hook(Box::new(|_| {}));
    let numbers = arguments.first..arguments.first.saturating_add(arguments.count);
    let mut good = true;
    for target in targets {
        let begun = Instant::now();
        let bench = Bench::new(&program.to_string_lossy());
        let seeds = Seeds::in_bench(&bench, target);
        // Making the seeds takes time as well.
        let longest = share.saturating_sub(begun.elapsed());
        let found = fuzz_for(target, &seeds, arguments.seed, numbers.clone(), longest);
        if let Err(error) = report(target, &found, arguments.keep.as_deref()) {
            terminal::note(format_args!("cannot write the inputs: {error}"));
            return ExitCode::FAILURE;
        }
        good &= found.inputs > 0 && found.panics.is_empty() && found.memory_growth < MEMORY_LIMIT;
    }
    if good { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Prints what was found, and writes the inputs at which something panicked to the folder `keep`.
fn report(target: Target, found: &Findings, keep: Option<&Path>) -> io::Result<()> {
    terminal::say(format_args!(
        "{target:?}: {} inputs, {} accepted, {} panics, slowest {:.3} s (input {}), memory grew by {} MiB",
        found.inputs,
        found.accepted,
        found.panics.len(),
        found.slowest.as_secs_f64(),
        found.slowest_input,
        found.memory_growth >> 20
    ));
    for panic in found.panics.iter().take(20) {
        terminal::say(format_args!("  input {}: {}", panic.number, panic.text));
    }
    let Some(folder) = keep else { return Ok(()) };
    std::fs::create_dir_all(folder)?;
    for panic in &found.panics {
        let name = format!("{}_{}", format!("{target:?}").to_lowercase(), panic.number);
        std::fs::write(folder.join(name), &panic.input)?;
    }
    Ok(())
}
