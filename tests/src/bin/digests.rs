//! Digests of the states that the shipped cases reach in their first steps, to compare two builds bit by bit.

use std::path::Path;
use std::process::ExitCode;

use clap::Parser;
use sph::coupling::solver::PartCounts;
use tests::first_steps::{ChosenCases, first_steps};

/// Runs the first steps of every shipped case and prints a line for each side: case, side, step, time, digest.
///
/// Two builds compute the same bits if they print the same lines; run both on one machine, since the arithmetic path and
/// the system's mathematical functions decide last bits.
#[derive(Debug, Parser)]
struct Arguments {
    /// Steps of each case.
    #[arg(long, default_value_t = 300, value_parser = clap::value_parser!(u64).range(1..))]
    steps: u64,
    /// Parts of the fluid, each with its own particles: their number changes no bit.
    #[arg(long, default_value_t = 1)]
    parts: usize,
    #[command(flatten)]
    cases: ChosenCases,
}

fn main() -> ExitCode {
    terminal::program::run(|| {
        let arguments = Arguments::parse();
        arguments.cases.for_each(|path| print_digests(path, arguments.steps, arguments.parts))
    })
}

/// Prints the lines of one case.
fn print_digests(path: &Path, steps: u64, parts: usize) -> Result<(), String> {
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    for side in &first_steps(path, steps, parts)? {
        terminal::say(format_args!(
            "{name:<34} {:<5} {:>6} {:<12.6e} {}",
            side.role.to_string(),
            side.step,
            side.time,
            side.digest
        ));
        if let Some(parts) = &side.parts {
            print_parts(&name, parts);
        }
    }
    Ok(())
}

/// Prints what each part did, beside the lines that are compared.
fn print_parts(name: &str, parts: &PartCounts) {
    for (number, part) in parts.each.iter().enumerate() {
        terminal::note(format_args!(
            "{name}: part {number}: {} particles, {} copies; computed {:.2} s, waited {:.2} s for copies and {:.2} s for \
             agreement; sent {} messages of {:.1} kB with copies and {} others of {:.1} kB",
            part.particles,
            part.copies,
            part.computing_seconds,
            part.waited_for_copies_seconds,
            part.waited_for_agreement_seconds,
            part.copy_messages,
            mean_kilobytes(part.copy_bytes, part.copy_messages),
            part.other_messages,
            mean_kilobytes(part.other_bytes, part.other_messages),
        ));
    }
    if let (Some(mean), Some(largest)) = (parts.mean_imbalance, parts.largest_imbalance) {
        terminal::note(format_args!(
            "{name}: imbalance of the work {:.1} % in the mean of builds of lists, at most {:.1} %",
            100.0 * mean,
            100.0 * largest
        ));
    }
}

/// Mean size of `messages` of `bytes` in all.
fn mean_kilobytes(bytes: u64, messages: u64) -> f64 {
    // Far below 2^53.
    1e-3 * bytes as f64 / messages.max(1) as f64
}
