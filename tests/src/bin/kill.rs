//! Kills servers and coordinators at chosen moments of runs and compares the results with those of undisturbed runs.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, ValueEnum};
use tests::kill::{Tally, Trials};
use tests::nodes;
use tests::random::RandomNumbers;

/// Kills servers and coordinators of short runs, without and with sub-steps of the solids: one, both or all, at random
/// times, at the start, while a checkpoint is written, during a resume, twice in a row, at each stage of the end, with a
/// recording. Every run must end with the undisturbed run's tables, frames and final states, byte for byte, and with no file
/// or process left over; one that was killed before its first checkpoint must say so, and is repeated.
#[derive(Debug, Parser)]
struct Arguments {
    /// How the solids step.
    #[arg(long, default_value = "both")]
    steps: Steps,
    /// Number of trials for each way of stepping; each kind of moment in turn.
    #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..))]
    times: u32,
    /// Only the moments with this in their name.
    #[arg(long, default_value = "")]
    only: String,
    /// Start of the random numbers.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Program under test [default: `tidelock-node` beside this one].
    #[arg(long)]
    program: Option<PathBuf>,
}

/// How the solids of a case step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Steps {
    /// As the stage rule says, with the fluid.
    Whole,
    /// By 4 sub-steps.
    Sub,
    /// One after the other.
    Both,
}

fn main() -> ExitCode {
    terminal::program::run(|| run(Arguments::parse()))
}

fn run(arguments: Arguments) -> ExitCode {
    let program = match nodes::program(arguments.program) {
        Ok(program) => program,
        Err(code) => return code,
    };
    let mut random = RandomNumbers::new(arguments.seed);
    let mut good = true;
    for (steps, name, substeps) in [(Steps::Whole, "stage rule", None), (Steps::Sub, "4 sub-steps", Some(4))]
    {
        if ![steps, Steps::Both].contains(&arguments.steps) {
            continue;
        }
        let trials = Trials::new(&program, |bench| bench.tank_to(0.02, substeps));
        let mut tally = Tally::default();
        trials.run(arguments.times, &arguments.only, &mut random, &mut tally);
        terminal::say(format_args!("{name}:\n{tally}"));
        good &= tally.problems.is_empty();
    }
    if good { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
