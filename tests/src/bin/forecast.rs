//! The forecast of `check` against measured CPU time, for the first steps of the shipped cases.

use std::path::Path;
use std::process::ExitCode;

use clap::Parser;
use tests::first_steps::{ChosenCases, cpu_time};

/// Runs steps of every shipped case on one thread for each side, and prints a line for each: case, steps, measured CPU
/// time of a step, forecast of it, forecast over measured.
#[derive(Debug, Parser)]
struct Arguments {
    /// CPU time of each case \[s\].
    #[arg(long, default_value_t = 1.0)]
    seconds: f64,
    /// Prints the work of a step in each unit, too.
    #[arg(long)]
    work: bool,
    #[command(flatten)]
    cases: ChosenCases,
}

fn main() -> ExitCode {
    terminal::program::run(|| {
        let arguments = Arguments::parse();
        arguments.cases.for_each(|path| print_case(path, &arguments))
    })
}

/// Prints the line of one case.
fn print_case(path: &Path, arguments: &Arguments) -> Result<(), String> {
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    let measured = cpu_time(path, arguments.seconds)?;
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
    Ok(())
}
