//! The forecast of `check` against measured CPU time, for the first steps of the shipped cases.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use tests::first_steps::cpu_time;
use tests::source_tree::case_files;

/// Runs steps of every shipped case on one thread for each side, and prints a line for each: case, steps, measured CPU
/// time of a step, forecast of it, forecast over measured.
#[derive(Debug, Parser)]
struct Arguments {
    /// CPU time of each case \[s\].
    #[arg(long, default_value_t = 1.0)]
    seconds: f64,
    /// Only cases with this in their path.
    #[arg(long, value_name = "TEXT", default_value = "")]
    only: String,
    /// Prints the work of a step in each unit, too.
    #[arg(long)]
    work: bool,
    /// Case files instead of the shipped ones.
    cases: Vec<PathBuf>,
}

fn main() -> ExitCode {
    terminal::program::run(|| {
        let arguments = Arguments::parse();
        let cases = if arguments.cases.is_empty() { case_files() } else { arguments.cases.clone() };
        let chosen = cases.iter().filter(|path| path.to_string_lossy().contains(&arguments.only));
        let failed = chosen.filter(|path| !print_case(path, &arguments)).count();
        if failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
    })
}

/// Prints the line of one case; whether it ran.
fn print_case(path: &Path, arguments: &Arguments) -> bool {
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    match cpu_time(path, arguments.seconds) {
        Ok(measured) => {
            let forecast = measured.work.seconds();
            terminal::say(format_args!(
                "{name:<34} {:>7} {:.4e} {forecast:.4e} {:.3}",
                measured.steps,
                measured.seconds_per_step,
                forecast / measured.seconds_per_step
            ));
            if arguments.work {
                terminal::say(format_args!("    {:?}", measured.work.amounts()));
            }
            true
        }
        Err(message) => {
            terminal::note(format_args!("error: {message}"));
            false
        }
    }
}
