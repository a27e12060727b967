//! The main function that both server programs share.

use std::ffi::OsString;
use std::io::{Read, Write};
use std::net::SocketAddr;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use clap::{CommandFactory, FromArgMatches, Parser};
use terminal::stop::StopSignals;
use tokio_util::sync::CancellationToken;
use tracing_subscriber::filter::{LevelFilter, Targets};

use crate::description::Description;
use crate::service::{ServeError, ServeOptions, Server, SolverFactory};
use crate::trace::{self, Part};
use crate::transport::security::{AccessToken, ServerFiles, ServerSecurity};

/// Command line was wrong, or asked for what is not allowed.
const EXIT_USAGE: u8 = 2;
/// The address is taken.
const EXIT_ADDRESS: u8 = 3;
/// The server failed.
const EXIT_FAILED: u8 = 1;

/// Options of a server program.
#[derive(Clone, Debug, Parser)]
#[command(
    version,
    about = "A solver that takes part in coupled runs.",
    long_about = "A solver that takes part in coupled runs. It prints one line, `LISTEN <addr>`, when it is ready, logs \
                  to stderr (filter: RUST_LOG) and ends in order on SIGTERM, SIGINT or SIGHUP; a second SIGTERM or SIGINT ends it at \
                  once. SIGHUP stays ignored where it was at the start. With `--exit-with-parent` the first of them is left to \
                  the program that started this one.",
    after_help = "Exit codes: 0 ended in order, 1 failed, 2 wrong usage, 3 the address is taken, 70 a fault of \
                  this program."
)]
pub struct NodeArgs {
    /// Address to listen on; port 0 takes any free one.
    #[arg(long, value_name = "ADDR", default_value = "127.0.0.1:0")]
    pub listen: SocketAddr,
    /// Compute threads; all cores when left out.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// How sums over neighbours are computed, where the solver does so in lanes: `portable` or `avx2` [default: the
    /// fastest of this machine]; it decides the last bits of results.
    #[arg(long, value_name = "PATH")]
    pub arithmetic: Option<sph::lanes::Path>,
    /// Close an idle run after this many seconds without a call.
    #[arg(long, value_name = "S", default_value_t = 120, value_parser = clap::value_parser!(u64).range(1..))]
    pub lease: u64,
    /// Who may speak.
    #[command(flatten)]
    pub security: ServerFiles,
    /// Demand the token in the first line of standard input with every call; so does TIDELOCK_TOKEN_STDIN=1 in the
    /// environment, unless there is a token file.
    #[arg(long, conflicts_with = "token_file")]
    pub token_stdin: bool,
    /// Listen beyond this machine without certificate or token: everyone who reaches the port can read along or use
    /// the server.
    #[arg(long)]
    pub insecure: bool,
    /// End when standard input closes, as it does when the program that started this one ends; so does
    /// TIDELOCK_TOKEN_STDIN=1 in the environment.
    #[arg(long)]
    pub exit_with_parent: bool,
    /// Write what the compute thread does when to this file, as a part of the trace of `run --trace`.
    #[arg(long, value_name = "FILE")]
    pub trace: Option<PathBuf>,
}

impl NodeArgs {
    /// The arguments of a program that is the solver of `description`; the first is its name.
    ///
    /// # Errors
    /// The exit code of a program that has printed its help, its version or what is wrong with the arguments.
    pub fn of_program(
        description: &Description,
        args: impl IntoIterator<Item = OsString>,
    ) -> Result<Self, ExitCode> {
        // Without it only the message is lost.
        drop(crate::file_size::fail_beyond_largest_file());
        Self::parse_for(description, args).map_err(|error| {
            // Help and version are no errors; nothing is left to print to when even stderr is gone.
            drop(error.print());
            if error.use_stderr() { ExitCode::from(EXIT_USAGE) } else { ExitCode::SUCCESS }
        })
    }

    fn parse_for(
        description: &Description,
        args: impl IntoIterator<Item = OsString>,
    ) -> Result<Self, clap::Error> {
        let command = Self::command().name(description.name.clone()).version(description.version.clone());
        Self::from_arg_matches(&command.try_get_matches_from(args)?)
    }

    /// Serves the solver of `factory` until it is stopped.
    pub fn serve(&self, factory: impl SolverFactory) -> ExitCode {
        self.serve_boxed(Box::new(factory))
    }

    /// Compiled once, here, and not again in every program.
    fn serve_boxed(&self, factory: Box<dyn SolverFactory>) -> ExitCode {
        let security = match self.load_security() {
            Ok(security) => security,
            Err(problem) => {
                terminal::note(format_args!("error: {problem}"));
                return ExitCode::from(EXIT_USAGE);
            }
        };
        let part = match self.record(&factory.describe().name) {
            Ok(part) => part,
            Err(problem) => {
                terminal::note(format_args!("error: {problem}"));
                return ExitCode::from(EXIT_USAGE);
            }
        };
        if let Some(refusal) = security.refusal(&self.listen).filter(|_| !self.insecure) {
            terminal::note(format_args!("error: {refusal}"));
            return ExitCode::from(EXIT_USAGE);
        }
        if let Some(Err(problem)) = self.arithmetic.map(sph::lanes::force) {
            terminal::note(format_args!("error: {problem}"));
            return ExitCode::from(EXIT_USAGE);
        }
        for warning in security.warnings() {
            tracing::warn!("{warning}");
        }
        // Two workers for I/O: one may be busy with a large message while the other serves frames.
        let runtime = match tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build()
        {
            Ok(runtime) => runtime,
            Err(error) => {
                terminal::note(format_args!("error: cannot start the runtime: {error}"));
                return ExitCode::from(EXIT_FAILED);
            }
        };
        let code = match runtime.block_on(serve(self, security, factory)) {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => {
                terminal::note(format_args!("error: {error}"));
                ExitCode::from(if matches!(error, ServeError::Bind { .. }) {
                    EXIT_ADDRESS
                } else {
                    EXIT_FAILED
                })
            }
        };
        // A solver in the middle of a step must not hold up the end.
        runtime.shutdown_timeout(Duration::from_secs(1));
        if let Some(Err(problem)) = part.map(|part| part.flush()) {
            tracing::error!("the trace is not complete: {problem}");
        }
        code
    }

    /// Starts the log, and where one is wanted the trace, in which this process is called `title`.
    ///
    /// # Errors
    /// What is wrong with the file of the trace.
    pub fn record(&self, title: &str) -> Result<Option<Part>, String> {
        let (filter, warning) = log_filter(std::env::var("RUST_LOG").ok());
        let mut part = None;
        match &self.trace {
            None => trace::log(filter),
            Some(path) => {
                let file = Part::create(path, title)
                    .map_err(|e| format!("`--trace {}` cannot be written: {e}", path.display()))?;
                trace::record_with_log(file.clone(), filter).map_err(|e| format!("`--trace`: {e}"))?;
                part = Some(file);
            }
        }
        if let Some(warning) = warning {
            tracing::warn!("{warning}");
        }
        Ok(part)
    }

    /// Who may speak, by files and by what the program that started this one says.
    fn load_security(&self) -> Result<ServerSecurity, String> {
        let security = ServerSecurity::load(&self.security)?;
        if self.token_stdin || (is_announced() && self.security.token_file.is_none()) {
            return AccessToken::receive(&mut std::io::stdin().lock()).map(|token| security.private(token));
        }
        Ok(security)
    }
}

/// Runs a server program: parses `args` (the first is the program's name), serves until it is stopped.
pub fn main_with(args: impl IntoIterator<Item = OsString>, factory: impl SolverFactory) -> ExitCode {
    match NodeArgs::of_program(&factory.describe(), args) {
        Ok(args) => args.serve(factory),
        Err(code) => code,
    }
}

/// Whether a coordinator has started this program: it sends a token, and keeps standard input open as long as it wants it.
fn is_announced() -> bool {
    std::env::var_os(AccessToken::ANNOUNCEMENT).is_some_and(|value| value == "1")
}

/// What RUST_LOG asks for, a level, or levels by target, and what is wrong with it.
fn log_filter(asked: Option<String>) -> (Targets, Option<String>) {
    let default = Targets::new().with_default(LevelFilter::INFO);
    // Empty is the same as unset.
    let Some(text) = asked.filter(|text| !text.is_empty()) else { return (default, None) };
    match text.parse() {
        Ok(filter) => (filter, None),
        Err(e) => {
            let warning = format!(
                "RUST_LOG is `{text}` ({e}), must be a level, or levels by target, such as `info,proto=debug`; \
                 the log is that of `info`"
            );
            (default, Some(warning))
        }
    }
}

async fn serve(
    args: &NodeArgs,
    security: ServerSecurity,
    factory: Box<dyn SolverFactory>,
) -> Result<(), ServeError> {
    let lease = Duration::from_secs(args.lease);
    let mut options = ServeOptions { lease, security, ..ServeOptions::default() };
    if let Some(threads) = args.threads {
        options.threads = usize::from(threads);
    }
    let server = Server::bind(args.listen)?;
    let stop = CancellationToken::new();
    let has_parent = args.exit_with_parent || is_announced();
    stop_on_signals(&stop, has_parent)
        .map_err(|e| ServeError::Transport(format!("cannot watch for signals: {e}")))?;
    if has_parent {
        stop_with_input(&stop)
            .map_err(|e| ServeError::Transport(format!("cannot watch standard input: {e}")))?;
    }
    let mut stdout = std::io::stdout();
    // Whoever closed the pipe does not wait for the address.
    drop(writeln!(stdout, "LISTEN {}", server.address()).and_then(|()| stdout.flush()));
    tracing::info!(address = %server.address(), threads = options.threads, "listening");
    server.serve(factory, options, stop.cancelled()).await
}

/// Ends in order at the first request, at once at the second. A batch system asks all processes of a job at once: where
/// the one that started this server is among them, it ends the run with a checkpoint, for which it needs the server.
fn stop_on_signals(stop: &CancellationToken, has_parent: bool) -> std::io::Result<()> {
    let mut signals = StopSignals::listen()?;
    let stop = stop.clone();
    tokio::spawn(async move {
        signals.next().await;
        if has_parent {
            tracing::info!("asked to end; the program that started this server decides when the run is over");
        } else {
            stop.cancel();
        }
        signals.next().await;
        std::process::exit(i32::from(EXIT_FAILED));
    });
    Ok(())
}

/// Ends in order when standard input closes. Reading blocks, so it has a thread of its own that may be left behind.
fn stop_with_input(stop: &CancellationToken) -> std::io::Result<()> {
    let stop = stop.clone();
    std::thread::Builder::new().name("stdin".into()).spawn(move || {
        let mut buffer = [0; 64];
        let mut stdin = std::io::stdin().lock();
        while matches!(stdin.read(&mut buffer), Ok(count) if count > 0) {}
        stop.cancel();
    })?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::log_filter;

    #[test]
    fn a_log_filter_that_cannot_be_read_is_warned_of() {
        for readable in [None, Some(""), Some("debug"), Some("info,proto=trace")] {
            assert_eq!(log_filter(readable.map(str::to_owned)).1, None, "{readable:?}");
        }
        let warning = log_filter(Some("proto=loud".into())).1.expect("a level that is none");
        assert!(warning.contains("RUST_LOG is `proto=loud`") && warning.contains("`info,proto=debug`"));
    }
}
