//! Options of all commands that run a case.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

use super::headings::{CHECKPOINTS, COMPUTING, FRAMES, RESULTS, SCREEN, SOLVERS};
use super::security::SecurityArguments;
use crate::messages::Messages;
use crate::run::participants::launch::Source;
use crate::run::{OnReservations, Placement, RelayOptions, RunOptions, ServerOptions};

/// How a case is run, new or resumed.
#[derive(Debug, Args)]
pub(super) struct RunOptionArguments {
    /// Run the solvers as threads of this process instead of servers; the results are bit-identical.
    #[arg(long, conflicts_with_all = ["fluid", "solid", "fluid_bin", "solid_bin", "fluid_ranks"])]
    #[arg(help_heading = SOLVERS)]
    in_process: bool,
    /// Use the fluid server that listens at this address, over the case's `[servers]`.
    #[arg(long, value_name = "HOST:PORT", conflicts_with = "fluid_bin", help_heading = SOLVERS)]
    fluid: Option<String>,
    /// Use the solid server that listens at this address, over the case's `[servers]`.
    #[arg(long, value_name = "HOST:PORT", conflicts_with = "solid_bin", help_heading = SOLVERS)]
    solid: Option<String>,
    /// Start this program as the fluid server: it gets `--listen ADDR` and prints `LISTEN <addr>` when ready.
    #[arg(long, value_name = "PROGRAM", help_heading = SOLVERS, hide_short_help = true)]
    fluid_bin: Option<PathBuf>,
    /// Start this program as the solid server, likewise.
    #[arg(long, value_name = "PROGRAM", help_heading = SOLVERS, hide_short_help = true)]
    solid_bin: Option<PathBuf>,
    /// Compute the fluid in so many processes, which `mpirun` starts from the program `fluid-server-mpi` beside this one;
    /// the results are bit-identical.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    #[arg(conflicts_with_all = ["fluid", "fluid_bin"], help_heading = SOLVERS, hide_short_help = true)]
    fluid_ranks: Option<u16>,
    /// TLS and token settings for remote servers.
    #[command(flatten)]
    security: SecurityArguments,
    /// Compute threads of each built-in solver; the results do not depend on it [default: all cores, shared by numbers
    /// of particles].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    #[arg(help_heading = COMPUTING)]
    threads: Option<u16>,
    /// How built-in solvers compute sums over neighbours: `portable` or `avx2` [default: the fastest of this machine]; it
    /// decides the last bits of results.
    #[arg(long, value_name = "PATH", help_heading = COMPUTING, hide_short_help = true)]
    arithmetic: Option<sph::lanes::Path>,
    /// Steps that solvers may take before they wait for the coordinator; 1 is strict lock-step.
    #[arg(long, value_name = "STEPS", default_value_t = 64, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    #[arg(help_heading = COMPUTING, hide_short_help = true)]
    window: u64,
    /// Take a checkpoint at every multiple of this number of steps, over the case's `[checkpoint]`.
    #[arg(long, value_name = "STEPS", value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    #[arg(help_heading = CHECKPOINTS)]
    checkpoint_every_steps: Option<u64>,
    /// Take a checkpoint after every so many seconds of wall time, likewise.
    #[arg(long, value_name = "S", value_parser = positive_seconds, help_heading = CHECKPOINTS)]
    checkpoint_every_wall: Option<f64>,
    /// Restart lost servers at most this often, likewise.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(..=1000))]
    #[arg(help_heading = CHECKPOINTS, hide_short_help = true)]
    max_restarts: Option<u64>,
    /// Treat a server as lost after this many seconds without a sign of life, over the case's `[deadlines]`.
    #[arg(long, value_name = "S", value_parser = positive_seconds)]
    #[arg(help_heading = SOLVERS, hide_short_help = true)]
    silence: Option<f64>,
    /// Pass the half-step frames through the coordinator instead of directly between the servers; the results are
    /// bit-identical.
    #[arg(long, conflicts_with = "in_process", help_heading = FRAMES, hide_short_help = true)]
    relay: bool,
    /// Address at which the coordinator waits for the fluid server to relay its frames; must be within its reach [default:
    /// 127.0.0.1:0, any free port].
    #[arg(long, value_name = "IP:PORT", help_heading = FRAMES, hide_short_help = true)]
    relay_listen: Option<SocketAddr>,
    /// Relay at an address beyond this machine without certificate: everyone on the way can read the frames.
    #[arg(long, requires = "relay_listen", help_heading = FRAMES, hide_short_help = true)]
    relay_insecure: bool,
    /// Record the half-step frames to this file, for `compare` and `replay`; relays them.
    #[arg(long, value_name = "FILE", conflicts_with = "in_process", help_heading = FRAMES)]
    record: Option<PathBuf>,
    /// Write a trace of solvers and coordinator to this file, for ui.perfetto.dev; servers that this command did not
    /// start from its own program are not in it.
    #[arg(long, value_name = "FILE", help_heading = RESULTS)]
    trace: Option<PathBuf>,
    /// Serve a page on this machine that shows the run while it runs, and print its address; the results are
    /// bit-identical.
    #[arg(long, help_heading = SCREEN)]
    view: bool,
    /// Fail, with an exit code of its own, when the run reaches its end with reservations about its answer; the results
    /// are complete all the same.
    #[arg(long, help_heading = RESULTS)]
    strict: bool,
    /// No progress bar and no run header: only the verdict, warnings and errors.
    #[arg(long, short, help_heading = SCREEN)]
    quiet: bool,
    /// Print all that decides the results: constants, active terms, solvers, thresholds of the laws that no case sets.
    /// `report.html` and `summary.json` always hold them.
    #[arg(long, short, conflicts_with = "quiet", help_heading = SCREEN)]
    verbose: bool,
}

impl From<RunOptionArguments> for RunOptions {
    fn from(arguments: RunOptionArguments) -> Self {
        Self {
            threads: arguments.threads,
            arithmetic: arguments.arithmetic,
            window: arguments.window,
            checkpoint_every_steps: arguments.checkpoint_every_steps,
            checkpoint_every_wall: arguments.checkpoint_every_wall.map(Duration::from_secs_f64),
            max_restarts: arguments.max_restarts,
            trace: arguments.trace.clone(),
            view: arguments.view,
            reservations: if arguments.strict { OnReservations::Fail } else { OnReservations::Report },
            messages: match (arguments.quiet, arguments.verbose) {
                (true, _) => Messages::Verdict,
                (false, false) => Messages::All,
                (false, true) => Messages::Details,
            },
            solvers: arguments.placement(),
        }
    }
}

impl RunOptionArguments {
    /// Compute threads asked for.
    pub(super) fn threads(&self) -> Option<u16> {
        self.threads
    }

    fn placement(self) -> Placement {
        if self.in_process {
            return Placement::Threads;
        }
        let relayed = self.relay || self.record.is_some() || self.relay_listen.is_some();
        let relay =
            RelayOptions { listen: self.relay_listen, insecure: self.relay_insecure, record: self.record };
        Placement::Servers(Box::new(ServerOptions {
            fluid: source(self.fluid, self.fluid_bin).or(self.fluid_ranks.map(Source::Ranks)),
            solid: source(self.solid, self.solid_bin),
            security: self.security.into(),
            silence: self.silence.map(Duration::from_secs_f64),
            relay: relayed.then_some(relay),
        }))
    }
}

fn source(address: Option<String>, program: Option<PathBuf>) -> Option<Source> {
    let program = || program.map(|program| Source::Program(vec![program.to_string_lossy().into_owned()]));
    address.map(Source::Address).or_else(program)
}

/// A positive number of seconds.
fn positive_seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if seconds > 0.0 && seconds <= 1e9 => Ok(seconds),
        _ => Err("must be a number of seconds above 0 and at most 1e9".into()),
    }
}
