//! Kills servers and coordinators in the middle of runs and compares the results with those of undisturbed runs.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use tests::kill::{Dice, Tally, Trials};

/// Kills fluid server, solid server and coordinator in turn at random times of short runs, without and with sub-steps of
/// the solids. Every run must end with the undisturbed run's tables, frames and final states, byte for byte.
#[derive(Debug, Parser)]
struct Arguments {
    /// Number of kills for each of both cases.
    #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..))]
    times: u32,
    /// Start of the random numbers.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Program under test [default: `tidelock-node` beside this one].
    #[arg(long)]
    program: Option<PathBuf>,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let beside = || std::env::current_exe().ok().map(|own| own.with_file_name("tidelock-node"));
    let Some(program) = arguments.program.or_else(beside).filter(|program| program.exists()) else {
        eprintln!(
            "error: no program `tidelock-node` beside this one; build it by `cargo build --release -p tests`"
        );
        return ExitCode::from(2);
    };
    let mut dice = Dice::new(arguments.seed);
    let mut good = true;
    for (name, substeps) in [("stage rule", None), ("4 sub-steps", Some(4))] {
        let trials = Trials::new(&program, |bench| bench.tank_to(0.02, substeps));
        let mut tally = Tally::default();
        trials.run(arguments.times, &mut dice, &mut tally);
        println!(
            "{name}: {} of {} end bit-equal, {} of them started anew",
            tally.equal, tally.trials, tally.anew
        );
        for problem in &tally.problems {
            println!("  {problem}");
        }
        good &= tally.equal == tally.trials;
    }
    if good { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
