//! Digests of the states that the shipped cases reach in their first steps, to compare two builds bit by bit.

use std::path::Path;
use std::process::ExitCode;

use clap::Parser;
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
    }
    Ok(())
}
