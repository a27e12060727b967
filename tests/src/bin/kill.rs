//! Kills servers and coordinators at chosen moments of runs and compares the results with those of undisturbed runs.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, ValueEnum};
use tests::bench::Bench;
use tests::kill::{Tally, Trials};
use tests::nodes;
use tests::random::RandomNumbers;

/// Kills servers and coordinators of short runs, in the plane without and with sub-steps of the solids, and in space: one,
/// both or all, at random times, at the start, while a checkpoint is written, during a resume, twice in a row, at each
/// stage of the end, with a recording. Every run must end with the undisturbed run's tables, frames and final states,
/// byte for byte, and with no file or process left over; one that was killed before its first checkpoint must say so,
/// and is repeated.
#[derive(Debug, Parser)]
struct Arguments {
    /// What is run.
    #[arg(long, default_value = "all")]
    scene: Scene,
    /// Number of trials for each scene; each kind of moment in turn.
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

/// What is run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Scene {
    /// A tank in the plane, whose solids step with the fluid.
    Tank,
    /// The same with 4 sub-steps of the solids.
    SubSteps,
    /// A tank in space with a rigid ball and an elastic post.
    Space,
    /// One after the other.
    All,
}

/// Writes the case of a scene on a bench.
type Write = fn(&Bench) -> PathBuf;

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
    let scenes: [(Scene, &str, Write); 3] = [
        (Scene::Tank, "tank, stage rule", |bench| bench.tank_to(0.02, None)),
        (Scene::SubSteps, "tank, 4 sub-steps", |bench| bench.tank_to(0.02, Some(4))),
        (Scene::Space, "tank in space", |bench| bench.space_to(0.3)),
    ];
    for (scene, name, write) in scenes {
        if ![scene, Scene::All].contains(&arguments.scene) {
            continue;
        }
        let trials = Trials::new(&program, write);
        let mut tally = Tally::default();
        trials.run(arguments.times, &arguments.only, &mut random, &mut tally);
        terminal::say(format_args!("{name}:\n{tally}"));
        good &= tally.problems.is_empty();
    }
    if good { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
