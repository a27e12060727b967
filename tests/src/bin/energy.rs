//! Whether the energy budgets of the shipped cases close in their first steps.

use std::path::Path;
use std::process::ExitCode;

use clap::Parser;
use tests::first_steps::{ChosenCases, LARGEST_ENERGY_RESIDUAL, first_steps};

/// Runs the first steps of every shipped case and prints for each side the largest residual of its energy budget over the
/// energy that was there to be spent; fails where one is above 0.1 %.
#[derive(Debug, Parser)]
struct Arguments {
    /// Steps of each case.
    #[arg(long, default_value_t = 300, value_parser = clap::value_parser!(u64).range(1..))]
    steps: u64,
    #[command(flatten)]
    cases: ChosenCases,
}

fn main() -> ExitCode {
    terminal::program::run(|| {
        let arguments = Arguments::parse();
        arguments.cases.for_each(|path| print_residuals(path, arguments.steps))
    })
}

/// Prints the lines of one case.
fn print_residuals(path: &Path, steps: u64) -> Result<(), String> {
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    let mut open = Vec::new();
    for side in &first_steps(path, steps, 1)? {
        let share = side.energy.residual_share();
        let text = share.map_or("none".into(), |share| format!("{share:.1e}"));
        terminal::say(format_args!("{name:<34} {:<5} {:>6} {text}", side.role.to_string(), side.step));
        if share.is_some_and(|share| share.is_nan() || share > LARGEST_ENERGY_RESIDUAL) {
            open.push(format!("{} {text}", side.role));
        }
    }
    if open.is_empty() {
        return Ok(());
    }
    Err(format!("{}: the energy budget does not close: {}", path.display(), open.join(", ")))
}
