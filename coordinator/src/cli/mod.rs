//! The command line.

mod colour;

use std::ffi::OsString;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};
use proto::security::ClientFiles;
use sph::setup::CouplingKind;
use sph::solver::Role;

use crate::failure::{Failure, Kind};
use crate::results::directory::{Existing, OutputDirectory};
use crate::run::origin::Origin;
use crate::run::participants::guard::{self, Guard};
use crate::run::participants::launch::Source;

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
    /// Run a case; starts the servers it needs on this machine unless told otherwise.
    ///
    /// A case with a fluid needs a fluid server, one with solids a solid server. The results are summary.json,
    /// report.html, probes.csv, ledger.csv, case.toml with every default, snapshots/ for ParaView, final/ from which
    /// another case can start, checkpoints/ from which `resume` continues, and logs/ of the servers. Ctrl-C, SIGTERM
    /// and SIGHUP stop at a step boundary with a checkpoint and outputs complete; a second Ctrl-C or SIGTERM gives up at
    /// once. SIGHUP stays ignored where it was at the start, as by `nohup`.
    #[command(after_help = exit_codes())]
    Run(RunArguments),
    /// Go on with a run from its newest good checkpoint, to the same bits as if it had never been stopped.
    ///
    /// Servers come from where the case says; thread counts and addresses may be others than before.
    #[command(after_help = exit_codes())]
    Resume(ResumeArguments),
    /// Check a case without running it: mistakes, particle counts, time-step limits, forecast run time.
    #[command(after_help = exit_codes())]
    Check(CheckArguments),
    /// Show what accuracy costs: runs cases with known answers over resolution, scheme and step, error against CPU time.
    ///
    /// The quick study takes under five minutes, `--full` as long as it says first. Finished runs are kept, so that a
    /// study that was stopped goes on. Writes report.html, report.csv and report.png.
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
    /// Compare two recordings and tell the first half-step and field in which they differ.
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

/// Arguments of a guard.
#[derive(Debug, Args)]
struct GuardArguments {
    process: i32,
}

/// Arguments that go to the server as they are.
#[derive(Debug, Args)]
struct NodeArguments {
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    arguments: Vec<String>,
}

/// Arguments of `run`.
#[derive(Debug, Args)]
pub struct RunArguments {
    /// Case file, TOML; see cases/FORMAT.md.
    pub case: PathBuf,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub new: NewRunOptions,
}

/// How a case is run anew, and where its results go.
#[derive(Debug, Args)]
pub struct NewRunOptions {
    /// Folder for the results [default: results/ and the name of the case file, with `_replay` for a replay].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Replace the results of an earlier run in that folder, which are refused otherwise. Files of a run go by their names;
    /// a folder that no run wrote to is refused.
    #[arg(long)]
    pub force: bool,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub options: RunOptions,
}

impl NewRunOptions {
    /// Makes the folder; without `--out` it has the name of `case` with `suffix`. The run starts from `origin`.
    ///
    /// # Errors
    /// When it cannot be, or holds results that must stay.
    pub fn create(&self, case: &Path, suffix: &str, origin: &Origin) -> Result<OutputDirectory, Failure> {
        let name = case.file_stem().unwrap_or(case.as_os_str()).to_string_lossy();
        let out = self.out.clone().unwrap_or_else(|| Path::new("results").join(format!("{name}{suffix}")));
        origin.must_not_be_in(&out)?;
        let existing = if self.force { Existing::Replace } else { Existing::Refuse };
        Ok(OutputDirectory::create(&out, existing)?)
    }
}

/// Arguments of `replay`.
#[derive(Debug, Args)]
pub struct ReplayArguments {
    /// Case file of the recorded run.
    pub case: PathBuf,
    /// Recording of the whole run.
    pub recording: PathBuf,
    /// Side that runs; the other is played.
    #[arg(long, value_name = "SIDE", value_parser = crate::replay::side)]
    pub side: Role,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub new: NewRunOptions,
}

/// Arguments of `compare`.
#[derive(Debug, Args)]
pub struct CompareArguments {
    /// A recording.
    pub first: PathBuf,
    /// Another one.
    pub second: PathBuf,
}

/// Arguments of `resume`.
#[derive(Debug, Args)]
pub struct ResumeArguments {
    /// Folder with the results of the run.
    pub folder: PathBuf,
    /// End at this time instead, in seconds; also goes on with a run that reached its end.
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    pub until: Option<f64>,
    /// Let another build of a solver take over; the results need not be those of an undisturbed run then.
    #[arg(long)]
    pub accept_other_build: bool,
    /// Continue though tables or snapshots were changed or removed since the run wrote them: with what is there, which
    /// `summary.json` says.
    #[arg(long)]
    pub accept_changed_outputs: bool,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub options: RunOptions,
}

/// How a case is run, new or resumed.
#[derive(Clone, Debug, Default, Args)]
pub struct RunOptions {
    /// Run the solvers as threads of this process instead of servers; the results have the same bits.
    #[arg(long, conflicts_with_all = ["fluid", "solid", "fluid_bin", "solid_bin"])]
    pub in_process: bool,
    /// Use the fluid server that listens at this address, over the case's `[servers]`.
    #[arg(long, value_name = "HOST:PORT", conflicts_with = "fluid_bin")]
    pub fluid: Option<String>,
    /// Use the solid server that listens at this address, over the case's `[servers]`.
    #[arg(long, value_name = "HOST:PORT", conflicts_with = "solid_bin")]
    pub solid: Option<String>,
    /// Start this program as the fluid server: it gets `--listen ADDR` and prints `LISTEN <addr>` when ready.
    #[arg(long, value_name = "PROGRAM")]
    pub fluid_bin: Option<PathBuf>,
    /// Start this program as the solid server, likewise.
    #[arg(long, value_name = "PROGRAM")]
    pub solid_bin: Option<PathBuf>,
    /// How servers elsewhere are known and know this program.
    #[command(flatten)]
    pub security: SecurityOptions,
    /// Compute threads of each built-in solver; the results do not depend on it [default: all cores, shared by numbers
    /// of particles].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// How built-in solvers compute sums over neighbours: `portable` or `avx2` [default: the fastest of this machine]; it
    /// decides the last bits of results.
    #[arg(long, value_name = "PATH")]
    pub arithmetic: Option<sph::lanes::Path>,
    /// Steps that solvers may take before they wait for the coordinator; 1 is strict lock-step.
    #[arg(long, value_name = "STEPS", default_value_t = 64, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    pub window: u64,
    /// Take a checkpoint at every multiple of this number of steps, over the case's `[checkpoint]`.
    #[arg(long, value_name = "STEPS", value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    pub checkpoint_every_steps: Option<u64>,
    /// Take a checkpoint after every so many seconds of wall time, likewise.
    #[arg(long, value_name = "S", value_parser = positive_seconds)]
    pub checkpoint_every_wall: Option<f64>,
    /// Start lost servers again at most this often, likewise.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(..=1000))]
    pub max_restarts: Option<u64>,
    /// Take a server for lost that gives no sign of life for this many seconds, over the case's `[deadlines]`.
    #[arg(long, value_name = "S", value_parser = positive_seconds)]
    pub silence: Option<f64>,
    /// Pass the half-step frames through the coordinator instead of directly between the servers; the results have the same
    /// bits.
    #[arg(long, conflicts_with = "in_process")]
    pub relay: bool,
    /// Address at which the coordinator waits for the fluid server to relay its frames; must be within its reach [default:
    /// 127.0.0.1:0, any free port].
    #[arg(long, value_name = "IP:PORT")]
    pub relay_listen: Option<SocketAddr>,
    /// Relay at an address beyond this machine without certificate: everyone on the way can read the frames.
    #[arg(long, requires = "relay_listen")]
    pub relay_insecure: bool,
    /// Record the half-step frames to this file, for `compare` and `replay`; relays them.
    #[arg(long, value_name = "FILE", conflicts_with = "in_process")]
    pub record: Option<PathBuf>,
    /// Write what solvers and coordinator do when to this file, for ui.perfetto.dev; servers that this command did not
    /// start from its own program are not in it.
    #[arg(long, value_name = "FILE")]
    pub trace: Option<PathBuf>,
    /// No progress bar and no run header.
    #[arg(long, short)]
    pub quiet: bool,
}

/// Files for servers that ask who calls, over the case's `[servers]`.
#[derive(Clone, Debug, Default, Args)]
pub struct SecurityOptions {
    /// Authorities' certificates (PEM) that servers at `https://` addresses must be signed by.
    #[arg(long, value_name = "FILE")]
    pub tls_ca: Option<PathBuf>,
    /// Certificate (PEM) to show to servers that demand one.
    #[arg(long, value_name = "FILE", requires = "tls_key")]
    pub tls_cert: Option<PathBuf>,
    /// Private key of that certificate (PEM).
    #[arg(long, value_name = "FILE", requires = "tls_cert")]
    pub tls_key: Option<PathBuf>,
    /// File with the access token of the servers.
    #[arg(long, value_name = "FILE")]
    pub token_file: Option<PathBuf>,
}

impl SecurityOptions {
    /// These files, those of the case where none is given.
    pub fn over(&self, case: &ClientFiles) -> ClientFiles {
        let identity = self.tls_cert.clone().zip(self.tls_key.clone());
        ClientFiles {
            authority: self.tls_ca.clone().or_else(|| case.authority.clone()),
            identity: identity.or_else(|| case.identity.clone()),
            token: self.token_file.clone().or_else(|| case.token.clone()),
        }
    }
}

/// A positive number of seconds.
fn positive_seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if seconds > 0.0 && seconds <= 1e9 => Ok(seconds),
        _ => Err("must be a number of seconds above 0 and at most 1e9".into()),
    }
}

impl RunOptions {
    /// Makes this process compute as `--arithmetic` says.
    ///
    /// # Errors
    /// When the machine cannot.
    pub fn force_arithmetic(&self) -> Result<(), Failure> {
        self.arithmetic.map_or(Ok(()), |path| sph::lanes::force(path).map_err(Failure::input))
    }

    /// Where the fluid server comes from, if the command line says so.
    pub fn fluid_source(&self) -> Option<Source> {
        source(self.fluid.as_ref(), self.fluid_bin.as_ref())
    }

    /// Where the solid server comes from, if the command line says so.
    pub fn solid_source(&self) -> Option<Source> {
        source(self.solid.as_ref(), self.solid_bin.as_ref())
    }
}

fn source(address: Option<&String>, program: Option<&PathBuf>) -> Option<Source> {
    match (address, program) {
        (Some(address), _) => Some(Source::Address(address.clone())),
        (None, Some(program)) => Some(Source::Program(vec![program.to_string_lossy().into_owned()])),
        (None, None) => None,
    }
}

/// Arguments of `check`.
#[derive(Debug, Args)]
pub struct CheckArguments {
    /// Case file, TOML; see cases/FORMAT.md.
    pub case: PathBuf,
    /// Draw the initial particles to this PNG.
    #[arg(long, value_name = "PNG")]
    pub picture: Option<PathBuf>,
    /// Print the case as resolved, with every default written out.
    #[arg(long)]
    pub resolved: bool,
}

/// Arguments of `report`.
#[derive(Debug, Args)]
pub struct ReportArguments {
    /// Cases to run; all when left out.
    pub cases: Vec<String>,
    /// Further resolutions, schemes, steps and cases.
    #[arg(long)]
    pub full: bool,
    /// Folder for the report and all runs.
    #[arg(long, value_name = "DIR", default_value = "results/report")]
    pub out: PathBuf,
    /// Make all runs anew; else those that this build has finished in that folder are kept.
    #[arg(long)]
    pub fresh: bool,
    /// List the cases and what would be run.
    #[arg(long)]
    pub list: bool,
}

/// Arguments of `conform`.
#[derive(Debug, Args)]
pub struct ConformArguments {
    /// Address of the solver.
    #[arg(value_name = "HOST:PORT")]
    pub address: Option<String>,
    /// Write the outcome to this file as JUnit XML.
    #[arg(long, value_name = "FILE")]
    pub junit: Option<PathBuf>,
    /// Kind of coupling to examine [default: the first that the solver offers].
    #[arg(long, value_name = "KIND", value_parser = crate::conform::coupling_kind)]
    pub kind: Option<CouplingKind>,
    /// Only checks with this in their name.
    #[arg(long, value_name = "TEXT")]
    pub only: Option<String>,
    /// Address of another process of the same solver, into which checkpoints are restored.
    #[arg(long, value_name = "HOST:PORT")]
    pub fresh: Option<String>,
    /// How the solver is known and knows this program.
    #[command(flatten)]
    pub security: SecurityOptions,
    /// Longest wait for any one answer, in seconds.
    #[arg(long, value_name = "S", default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..=600))]
    pub deadline: u64,
    /// List the checks.
    #[arg(long)]
    pub list: bool,
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
        Command::Run(arguments) => crate::run::run(&arguments),
        Command::Resume(arguments) => crate::resume::resume(&arguments),
        Command::Check(arguments) => crate::check::check(&arguments),
        Command::Report(arguments) => crate::study::report(&arguments),
        Command::Conform(arguments) => crate::conform::conform(&arguments),
        Command::Replay(arguments) => crate::replay::replay(&arguments),
        Command::Compare(arguments) => crate::replay::compare(&arguments),
        Command::NodeFluid(node) => return fluid_server::main_with(server_arguments("fluid-server", node)),
        Command::NodeGuard(guarded) => {
            guard::watch(guarded.process);
            return ExitCode::SUCCESS;
        }
        Command::NodeSolid(node) => return solid_server::main_with(server_arguments("solid-server", node)),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => report(&failure),
    }
}

/// Whether `words`, the program's name first, are a command line of this program, or the message that refuses them.
///
/// # Errors
/// The message.
pub fn accepts(words: &[OsString]) -> Result<(), String> {
    Cli::try_parse_from(words).map(drop).map_err(|e| e.to_string())
}

fn server_arguments(name: &str, node: NodeArguments) -> Vec<OsString> {
    std::iter::once(name.to_owned()).chain(node.arguments).map(OsString::from).collect()
}

fn report(failure: &Failure) -> ExitCode {
    // A list of mistakes comes with its own marks.
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
