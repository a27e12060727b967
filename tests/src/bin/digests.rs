//! Digests of the states that the shipped cases reach in their first steps, to compare two builds bit by bit.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use tests::first_steps::first_steps;
use tests::source_tree::case_files;

/// Runs the first steps of every shipped case and prints a line for each side: case, side, step, time, digest.
///
/// Two builds compute the same bits if they print the same lines; run both on one machine, since the arithmetic path and
/// the system's mathematical functions decide last bits.
#[derive(Debug, Parser)]
struct Arguments {
    /// Steps of each case.
    #[arg(long, default_value_t = 300, value_parser = clap::value_parser!(u64).range(1..))]
    steps: u64,
    /// Only cases with this in their path.
    #[arg(long, value_name = "TEXT", default_value = "")]
    only: String,
    /// Case files instead of the shipped ones.
    cases: Vec<PathBuf>,
}

fn main() -> ExitCode {
    terminal::program::run(|| {
        let arguments = Arguments::parse();
        let cases = if arguments.cases.is_empty() { case_files() } else { arguments.cases.clone() };
        let chosen = cases.iter().filter(|path| path.to_string_lossy().contains(&arguments.only));
        let failed = chosen.filter(|path| !print_digests(path, arguments.steps)).count();
        if failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
    })
}

/// Prints the lines of one case; whether it ran.
fn print_digests(path: &Path, steps: u64) -> bool {
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    match first_steps(path, steps) {
        Ok(sides) => {
            for side in &sides {
                terminal::say(format_args!(
                    "{name:<34} {:<5} {:>6} {:<12.6e} {}",
                    side.role.to_string(),
                    side.step,
                    side.time,
                    side.digest
                ));
            }
            true
        }
        Err(message) => {
            terminal::note(format_args!("error: {message}"));
            false
        }
    }
}
