//! The command line.

mod check;
mod colour;
mod conform;
mod converge;
mod many;
mod new;
mod node;
mod options;
mod overlay;
mod replay;
mod report;
mod resume;
mod run;
mod schema;
mod security;
mod set;
mod sweep;
mod view;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

use self::check::CheckArguments;
use self::conform::ConformArguments;
use self::converge::{ConvergeArguments, EnsembleArguments};
use self::new::NewArguments;
use self::node::{GuardArguments, NodeArguments};
use self::overlay::OverlayArguments;
use self::replay::{CompareArguments, ReplayArguments};
use self::report::ReportArguments;
use self::resume::ResumeArguments;
use self::run::RunArguments;
use self::schema::SchemaArguments;
use self::sweep::SweepArguments;
use self::view::ViewArguments;
use crate::failure::{Failure, Kind};
use crate::run::participants::guard::Guard;

/// Couples a fluid solver and an elastic-solid solver in lock-step and audits their interface.
///
/// Start with `run cases/drifting_body_coarse.toml`. cases/FORMAT.md lists every key of a case file.
#[derive(Debug, Parser)]
#[command(name = "coordinator", version, after_help = exit_codes())]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Run a case; starts the servers it needs on this machine by default.
    ///
    /// A case with a fluid needs a fluid server, one with solids a solid server. The results are summary.json,
    /// report.html, probes.csv, ledger.csv, case.toml with every default, snapshots/ for ParaView, final/ from which
    /// another case can start, checkpoints/ from which `resume` continues, and logs/ of the servers. Ctrl-C, SIGTERM
    /// and SIGHUP stop at a step boundary with a checkpoint and outputs complete; a second Ctrl-C or SIGTERM aborts at
    /// once. SIGHUP stays ignored where it was at the start, as by `nohup`.
    #[command(after_help = exit_codes())]
    Run(RunArguments),
    /// Continue a run from its newest good checkpoint; the results are bit-identical to those of a run that was not stopped.
    ///
    /// Servers come from where the case says; thread counts and addresses may differ.
    #[command(after_help = exit_codes())]
    Resume(ResumeArguments),
    /// Check a case without running it: errors, particle counts, time-step limits, forecast run time.
    #[command(after_help = exit_codes())]
    Check(CheckArguments),
    /// Write a case file to start from: commented, and ready to run.
    ///
    /// Asks on a terminal, or takes `--template NAME`. Beside the case it writes case.schema.json, by which editors complete
    /// and explain keys. Nothing is overwritten.
    #[command(after_help = exit_codes())]
    New(NewArguments),
    /// Print the JSON Schema of case files, by which editors complete, explain and check keys.
    #[command(after_help = exit_codes())]
    Schema(SchemaArguments),
    /// Run a case over values of its keys: a grid, values side by side, a Latin hypercube, seeds.
    ///
    /// Runs here, several at a time, or writes the files for Slurm or Snakemake. Finished members are kept, so that the same
    /// command continues a sweep that was stopped; members that fail are named, and the others go ahead. Writes sweep.csv, a
    /// row for each member, sweep.html with the probes on common axes, and manifest.json. Try: `sweep CASE --over
    /// fluid.sound_speed_m_s=20,30,40 --jobs 2`.
    #[command(after_help = exit_codes())]
    Sweep(SweepArguments),
    /// Say whether a case is converged: three spacings and two sound speeds, observed orders, estimated errors.
    ///
    /// The finest run is the case as it is; all runs together cost about 2.3 times as much. Finished runs are kept. Writes
    /// convergence.html, family.json and members.csv.
    #[command(after_help = exit_codes())]
    Converge(ConvergeArguments),
    /// Run a case with several seeds, where the motion is chaotic: mean and spread of key figures.
    ///
    /// Finished runs are kept. Writes ensemble.html, family.json and members.csv.
    #[command(after_help = exit_codes())]
    Ensemble(EnsembleArguments),
    /// Lay finished runs over each other: probes on common axes, peaks, differences from the first.
    #[command(after_help = exit_codes())]
    Overlay(OverlayArguments),
    /// Show the folder of a run, finished or running, in a browser of this machine.
    ///
    /// Serves a page at a port of 127.0.0.1 and prints its address: the particles over time, probes, balances. It reads
    /// the folder and changes nothing. `run --view` also has buttons for a checkpoint and to stop.
    #[command(after_help = exit_codes())]
    View(ViewArguments),
    /// Show what accuracy costs: runs cases with known answers over resolution, scheme and step, error against CPU time.
    ///
    /// The quick study takes under five minutes, `--full` as long as it says first. Finished runs are kept, so that a
    /// study that was stopped continues. Writes report.html, report.csv and report.png.
    #[command(after_help = exit_codes())]
    Report(ReportArguments),
    /// Examine a running solver of any make: life cycle, refusals, damaged frames, invariances, order, checkpoints.
    ///
    /// It plays coordinator and partner, takes some seconds, prints a line for each check and leaves the solver free.
    /// What the solver does not offer is printed as such. Try: `conform 127.0.0.1:7001 --junit conform.xml`.
    #[command(after_help = exit_codes())]
    Conform(ConformArguments),
    /// Run one solver alone, its partner played from a recording, and compare what it sends with the recording.
    ///
    /// Make the recording by `run CASE --record FILE`. The solver comes from where `run` takes it and leaves the results of a
    /// run. The exit code is 10 when it sends other bits than the recorded one.
    #[command(after_help = exit_codes())]
    Replay(ReplayArguments),
    /// Compare two recordings and report the first half-step and field in which they differ.
    #[command(after_help = exit_codes())]
    Compare(CompareArguments),
    /// A fluid server; `run` starts it.
    #[command(name = "node-fluid", hide = true, disable_help_flag = true)]
    NodeFluid(NodeArguments),
    /// A solid server; `run` starts it.
    #[command(name = "node-solid", hide = true, disable_help_flag = true)]
    NodeSolid(NodeArguments),
    /// Ends another program with the coordinator; `run` starts it.
    #[command(name = Guard::COMMAND, hide = true)]
    NodeGuard(GuardArguments),
}

/// Table of exit codes for the help.
fn exit_codes() -> String {
    let mut text = String::from("Exit codes:\n   0  success\n");
    for kind in Kind::ALL {
        text.push_str(&format!("  {:>2}  {}\n", kind.code(), kind.meaning()));
    }
    text
}

/// Runs the command line of this process.
pub fn main() -> ExitCode {
    // Without it only the message is lost.
    drop(proto::file_size::fail_beyond_largest_file());
    let result = match Cli::parse().command {
        Command::Run(arguments) => arguments.execute(),
        Command::Resume(arguments) => arguments.execute(),
        Command::Check(arguments) => arguments.execute(),
        Command::New(arguments) => arguments.execute(),
        Command::Schema(arguments) => arguments.execute(),
        Command::Sweep(arguments) => arguments.execute(),
        Command::Converge(arguments) => arguments.execute(),
        Command::Ensemble(arguments) => arguments.execute(),
        Command::Overlay(arguments) => arguments.execute(),
        Command::Report(arguments) => arguments.execute(),
        Command::View(arguments) => arguments.execute(),
        Command::Conform(arguments) => arguments.execute(),
        Command::Replay(arguments) => arguments.execute(),
        Command::Compare(arguments) => arguments.execute(),
        Command::NodeFluid(node) => return fluid_server::main_with(node.words("fluid-server")),
        Command::NodeSolid(node) => return solid_server::main_with(node.words("solid-server")),
        Command::NodeGuard(guard) => return guard.execute(),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => print_failure(&failure),
    }
}

/// Whether `words`, the program's name first, are a command line of this program, or the message that refuses them.
///
/// # Errors
/// The message.
pub fn accepts(words: &[OsString]) -> Result<(), String> {
    Cli::try_parse_from(words).map(drop).map_err(|e| e.to_string())
}

fn print_failure(failure: &Failure) -> ExitCode {
    // A list of errors comes with its own marks.
    let mark = if failure.message.starts_with("error") { "" } else { "error: " };
    terminal::note(format_args!("{mark}{}", failure.text(colour::on_stderr())));
    failure.exit_code()
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent_and_lists_the_exit_codes() {
        Cli::command().debug_assert();
        let help = Cli::command().render_long_help().to_string();
        for kind in Kind::ALL {
            assert!(help.contains(kind.meaning()), "{help}");
        }
        assert!(!help.contains("node-"));
    }

    #[test]
    fn exit_codes_differ() {
        let mut codes: Vec<u8> = Kind::ALL.iter().map(|kind| kind.code()).collect();
        codes.sort_unstable();
        codes.dedup();
        assert_eq!(codes.len(), Kind::ALL.len());
    }
}
