//! The command line.

mod check;
mod conform;
mod converge;
mod headings;
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
mod setting_up;
mod sweep;
mod topics;
mod view;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use fluid_server::FluidFactory;
use proto::transport::node::NodeArgs;
use solid_server::SolidFactory;
use terminal::style::{Style, Tone};

use self::check::CheckArguments;
use self::conform::ConformArguments;
use self::converge::{ConvergeArguments, EnsembleArguments};
use self::new::NewArguments;
use self::node::GuardArguments;
use self::overlay::OverlayArguments;
use self::replay::{CompareArguments, ReplayArguments};
use self::report::ReportArguments;
use self::resume::ResumeArguments;
use self::run::RunArguments;
use self::schema::SchemaArguments;
use self::setting_up::{CompletionsArguments, ManArguments};
use self::sweep::SweepArguments;
use self::view::ViewArguments;
use crate::failure::{Failure, Kind};
use crate::run::participants::guard::Guard;

/// Couples a fluid and a solid solver in lock-step and audits their interface.
///
/// Start with `tidelock run cases/drifting_body_coarse.toml`. cases/FORMAT.md lists every key of a case file.
#[derive(Debug, Parser)]
#[command(version, after_help = exit_codes(), after_long_help = exit_codes())]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Run a case; starts the servers it needs on this machine
    ///
    /// A case with a fluid needs a fluid server, one with solids a solid server. The results are summary.json,
    /// report.html, probes.csv, ledger.csv, case.toml with every default, snapshots/ for ParaView, final/ from which
    /// another case can start, checkpoints/ from which `resume` continues, and logs/ of the servers. Ctrl-C, SIGTERM
    /// and SIGHUP stop at a step boundary with a checkpoint and outputs complete; a second Ctrl-C or SIGTERM aborts at
    /// once. SIGHUP stays ignored where it was at the start, as by `nohup`.
    Run(RunArguments),
    /// Continue a run from its newest good checkpoint
    ///
    /// The results are bit-identical to those of a run that was not stopped. Servers come from where the case says; thread
    /// counts and addresses may differ.
    Resume(ResumeArguments),
    /// Write a case file to start from, commented and ready to run
    ///
    /// Asks on a terminal, or takes `--template NAME`. Beside the case it writes case.schema.json, by which editors complete
    /// and explain keys. Nothing is overwritten.
    New(NewArguments),
    /// Print the JSON Schema of case files
    ///
    /// Editors complete, explain and check keys by it.
    Schema(SchemaArguments),
    /// Check a case without running it: verdict, cost, warnings
    ///
    /// Reports all errors of the file at once, or in six lines what a run would be and cost, and what deserves a second look.
    /// `-v` adds particle counts, time-step limits, constants and active terms.
    Check(CheckArguments),
    /// Run a case over values of its keys
    ///
    /// A grid, values side by side, a Latin hypercube, or seeds.
    /// Runs here, several at a time, or writes the files for Slurm or Snakemake. Finished members are kept, so that the same
    /// command continues a sweep that was stopped; members that fail are named, and the others go ahead. Writes sweep.csv, a
    /// row for each member, sweep.html with the probes on common axes, and manifest.json. Try: `sweep CASE --over
    /// fluid.sound_speed_m_s=20,30,40 --jobs 2`.
    Sweep(SweepArguments),
    /// Say whether a case is converged, with estimated errors
    ///
    /// Three spacings and two sound speeds give observed orders and estimated errors.
    /// The finest run is the case as it is; all runs together cost about 2.3 times as much. Finished runs are kept. Writes
    /// convergence.html, family.json and members.csv.
    Converge(ConvergeArguments),
    /// Run a case with several seeds: mean and spread of key figures
    ///
    /// For cases whose motion is chaotic. Finished runs are kept. Writes ensemble.html, family.json and members.csv.
    Ensemble(EnsembleArguments),
    /// Lay finished runs over each other: probes, peaks, differences
    ///
    /// Probes are on common axes; peaks and differences are from the first run.
    Overlay(OverlayArguments),
    /// Show the folder of a run, finished or running, in a browser
    ///
    /// Serves a page at a port of 127.0.0.1 and prints its address: the particles over time, probes, balances. It reads
    /// the folder and changes nothing. `run --view` also has buttons for a checkpoint and to stop.
    View(ViewArguments),
    /// Show what accuracy costs: error against CPU time
    ///
    /// Runs cases with known answers over resolution, scheme and step.
    /// The quick study takes under five minutes, `--full` as long as it says first. Finished runs are kept, so that a
    /// study that was stopped continues. Writes report.html, report.csv and report.png.
    Report(ReportArguments),
    /// Examine a running solver of any make
    ///
    /// Life cycle, refusals, damaged frames, invariances, order, checkpoints.
    /// It plays coordinator and partner, takes some seconds, prints a line for each check and leaves the solver free.
    /// What the solver does not offer is printed as such. Try: `conform 127.0.0.1:7001 --junit conform.xml`.
    Conform(ConformArguments),
    /// Run one solver alone, its partner played from a recording
    ///
    /// What it sends is compared with the recording.
    /// Make the recording by `run CASE --record FILE`. The solver comes from where `run` takes it and leaves the results of a
    /// run. The exit code is 10 when it sends other bits than the recorded one.
    Replay(ReplayArguments),
    /// Compare two recordings: the first half-step that differs
    ///
    /// Names the half-step and the field.
    Compare(CompareArguments),
    /// Serve the fluid solver, for runs on other machines
    ///
    /// Prints one line, `LISTEN <addr>`, when it is ready, logs to standard error (filter: RUST_LOG) and ends in order on
    /// SIGTERM, SIGINT or SIGHUP. `run` starts one by itself where the case names no address.
    #[command(name = "fluid-server", alias = "node-fluid")]
    FluidServer(NodeArgs),
    /// Serve the solid solver, likewise
    ///
    /// Prints one line, `LISTEN <addr>`, when it is ready, logs to standard error (filter: RUST_LOG) and ends in order on
    /// SIGTERM, SIGINT or SIGHUP. `run` starts one by itself where the case names no address.
    #[command(name = "solid-server", alias = "node-solid")]
    SolidServer(NodeArgs),
    /// Print completions for a shell
    ///
    /// For bash: `tidelock completions bash > ~/.local/share/bash-completion/completions/tidelock`. For zsh write to
    /// `_tidelock` in a folder of `fpath`, for fish to ~/.config/fish/completions/tidelock.fish.
    Completions(CompletionsArguments),
    /// Write man pages to a folder
    Man(ManArguments),
    /// Ends another program with the coordinator; `run` starts it.
    #[command(name = Guard::COMMAND, hide = true)]
    NodeGuard(GuardArguments),
}

/// The command line of the program `name`.
fn command(name: &'static str) -> clap::Command {
    let of_commands = |sub: clap::Command| match sub.get_name() {
        "fluid-server" | "solid-server" => sub,
        _ => sub.after_help(SEE_CODES).after_long_help(SEE_CODES),
    };
    topics::grouped(Cli::command().name(name).long_version(version()).mut_subcommands(of_commands))
}

/// Stands under the help of each command.
const SEE_CODES: &str = "`tidelock --help` lists the exit codes.";

/// Version, protocol, and what the program was built for.
fn version() -> String {
    let (version, protocol) = (env!("CARGO_PKG_VERSION"), proto::description::PROTOCOL);
    let (target, libc) = (env!("TIDELOCK_TARGET"), env!("TIDELOCK_LIBC"));
    format!("{version}\nprotocol {protocol}; built for {target}{libc}")
}

/// Table of exit codes for the help.
fn exit_codes() -> String {
    let mut text = String::from("Exit codes:\n");
    for (code, meaning) in Kind::codes() {
        text.push_str(&format!("  {code:>2}  {meaning}\n"));
    }
    text
}

/// Runs the command line of this process, the program `name`.
pub fn main(name: &'static str) -> ExitCode {
    // Without it only the message is lost.
    drop(proto::file_size::fail_beyond_largest_file());
    let parsed = Cli::from_arg_matches(&command(name).get_matches()).unwrap_or_else(|e| e.exit());
    let result = match parsed.command {
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
        Command::Completions(arguments) => arguments.execute(),
        Command::Man(arguments) => arguments.execute(),
        Command::FluidServer(node) => return node.serve(FluidFactory::default()),
        Command::SolidServer(node) => return node.serve(SolidFactory),
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
    let style = Style::of_errors();
    let marked = failure.message.starts_with("error");
    let mark = if marked { String::new() } else { format!("{} ", style.paint(Tone::Bad, "error:")) };
    terminal::note(format_args!("{mark}{}", failure.text(style.is_coloured())));
    failure.exit_code()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent_and_lists_the_exit_codes() {
        command("tidelock").debug_assert();
        let help = command("tidelock").render_long_help().to_string();
        for kind in Kind::ALL {
            assert!(help.contains(kind.meaning()), "{help}");
        }
        assert!(!help.contains("node-"));
    }

    #[test]
    fn the_version_is_that_of_the_program_that_was_called() {
        for name in ["tidelock", "coordinator"] {
            let version = command(name).render_long_version();
            let first = format!("{name} {}", env!("CARGO_PKG_VERSION"));
            assert_eq!(version.lines().next(), Some(first.as_str()), "{version}");
        }
    }

    #[test]
    fn exit_codes_differ() {
        let mut codes: Vec<u8> = Kind::ALL.iter().map(|kind| kind.code()).collect();
        codes.sort_unstable();
        codes.dedup();
        assert_eq!(codes.len(), Kind::ALL.len());
    }
}
