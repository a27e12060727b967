//! Good and bad clients in a row on one pair of servers.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use clap::Parser;
use tests::nodes;
use tests::soak::Soak;

/// Runs good and bad clients in a row on one pair of servers, a third of them bad: bytes that are no protocol, silent
/// connections, runs that break down, coordinators that are killed or go away. Memory, handles and threads must return to
/// the base.
#[derive(Debug, Parser)]
struct Arguments {
    /// Time to continue.
    #[arg(long, default_value_t = 60.0)]
    minutes: f64,
    /// Program under test [default: `tidelock-node` beside this one].
    #[arg(long)]
    program: Option<PathBuf>,
}

fn main() -> ExitCode {
    terminal::program::run(|| run(Arguments::parse()))
}

fn run(arguments: Arguments) -> ExitCode {
    let program = match nodes::program(arguments.program) {
        Ok(program) => program,
        Err(code) => return code,
    };
    let Ok(duration) = Duration::try_from_secs_f64(60.0 * arguments.minutes) else {
        terminal::note(format_args!("error: `--minutes {}`: must be a positive number", arguments.minutes));
        return ExitCode::from(2);
    };
    match Soak::new(&program).run(Instant::now() + duration) {
        Ok(soaked) => {
            terminal::say(format_args!("{} good runs, {} bad clients", soaked.good, soaked.bad));
            for (name, (base, end)) in ["fluid", "solid"].iter().zip(soaked.base.iter().zip(&soaked.end)) {
                terminal::say(format_args!("{name}: base {base:?}, end {end:?}"));
            }
            ExitCode::SUCCESS
        }
        Err(problem) => {
            terminal::say(format_args!("{problem}"));
            ExitCode::FAILURE
        }
    }
}
