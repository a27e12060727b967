//! Starting servers as child processes of the coordinator, and ending them.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{ExitStatus, Stdio};
use std::time::Duration;

use proto::transport::security::{AccessToken, ClientFiles, ClientSecurity};
use sph::coupling::solver::Role;
use tokio::io::{AsyncBufReadExt, AsyncWriteExt, BufReader};
use tokio::process::{Child, Command};
use tokio::task::JoinHandle;

use crate::failure::Failure;
use crate::run::participants::guard::Guard;
use crate::run::participants::logs;

/// Longest wait for the address of a child.
const START_DEADLINE: Duration = Duration::from_secs(30);
/// A child that has not ended by then, after its input was closed, is killed.
const END_DEADLINE: Duration = Duration::from_secs(5);
/// A child whose connection broke is given so long to show how it ended.
const STATUS_DEADLINE: Duration = Duration::from_millis(500);
/// The same of another program, which may have processes of its own to end first.
const OTHER_STATUS_DEADLINE: Duration = Duration::from_secs(5);

/// Where a server comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Source {
    /// This executable, run again with a hidden sub-command.
    Own,
    /// The fluid server in so many processes, by the program beside this executable and `mpirun`.
    Ranks(u16),
    /// Another program with its arguments; it takes `--listen ADDR` too and prints `LISTEN <addr>`. It ends with
    /// this process, whether or not it watches its standard input.
    Program(Vec<String>),
    /// A server that already listens.
    Address(String),
}

/// What servers are started with.
#[derive(Clone, Copy, Debug)]
pub struct Launch<'a> {
    /// Compute threads of a built-in server.
    pub threads: usize,
    /// Files for the call of a partner elsewhere.
    pub files: &'a ClientFiles,
    /// What the user's files say.
    pub security: &'a ClientSecurity,
    /// Folder of logs.
    pub logs: &'a Path,
    /// File for its part of a trace.
    pub trace: Option<&'a Path>,
}

/// A server that is ready for a connection.
#[derive(Debug)]
pub struct Server {
    /// Side that it plays.
    pub role: Role,
    /// `host:port` at which it listens.
    pub address: String,
    /// What is shown to it.
    pub security: ClientSecurity,
    child: Option<Started>,
}

/// A server that this process has started.
#[derive(Debug)]
struct Started {
    child: Child,
    program: String,
    log: PathBuf,
    guard: Option<Guard>,
    /// Puts what it prints after its address into the log.
    printing: Option<JoinHandle<()>>,
}

impl Server {
    /// Attaches to or starts the server of `role`. A child demands an access token, or may do so, which goes through the
    /// pipe to its standard input.
    ///
    /// # Errors
    /// When the program cannot be started, ends at once, or prints no address in time.
    pub async fn start(role: Role, source: &Source, with: Launch<'_>) -> Result<Self, Failure> {
        let command = match source {
            Source::Address(address) => {
                let (address, security) = (address.clone(), with.security.clone());
                return Ok(Self { role, address, security, child: None });
            }
            Source::Own => {
                let mut command = Command::new(this_program(role)?);
                command.arg(format!("node-{role}"));
                with_own_options(command, with.threads, with)
            }
            Source::Ranks(count) => {
                let program = this_program(role)?.with_file_name(RANKS_PROGRAM);
                if !program.is_file() {
                    return Err(no_ranks_program(&program));
                }
                let mut command = Command::new(LAUNCHER);
                command.args(["-n", &count.to_string()]).arg(program);
                with_own_options(command, with.threads.div_ceil(usize::from(*count)), with)
            }
            Source::Program(words) => {
                let [program, arguments @ ..] = words.as_slice() else {
                    return Err(Failure::input(format!("the command of the {role} server is empty")));
                };
                let mut command = Command::new(program);
                command.args(arguments).args(LISTEN).env(AccessToken::ANNOUNCEMENT, "1");
                command
            }
        };
        // Another program may have been given the user's token by its arguments.
        let given = with.security.access().filter(|_| matches!(source, Source::Program(_)));
        let fresh = given.is_none();
        let access = given.map_or_else(AccessToken::fresh, Ok).map_err(Failure::internal)?;
        let (mut started, printed) = Started::spawn(role, command, with.logs, *source != Source::Own)?;
        started.send_token(&access).await;
        let address = started.address(role, printed).await?;
        // A program may listen elsewhere: no secret travels there unencrypted.
        let security = if fresh && !is_private(&address) {
            with.security.clone()
        } else {
            with.security.with_access(&access)
        };
        Ok(Self { role, address, security, child: Some(started) })
    }

    /// Whether this coordinator started it.
    pub fn is_child(&self) -> bool {
        self.child.is_some()
    }

    /// Process id of a child that this coordinator started.
    pub fn process_id(&self) -> Option<u32> {
        self.child.as_ref().and_then(|started| started.child.id())
    }

    /// Program and log of a child that this coordinator started.
    pub fn program(&self) -> Option<(&str, &Path)> {
        self.child.as_ref().map(|started| (started.program.as_str(), started.log.as_path()))
    }

    /// The last lines of the log of a child that this coordinator started from another program than its own, for a message.
    pub fn last_words(&self) -> String {
        let other = self.child.as_ref().filter(|started| started.is_other());
        other.map_or_else(String::new, |started| logs::tail(&started.log))
    }

    /// How a child ended that this coordinator started; `None` when it has not ended.
    pub async fn ended(&mut self) -> Option<ExitStatus> {
        let started = self.child.as_mut()?;
        let deadline = if started.is_other() { OTHER_STATUS_DEADLINE } else { STATUS_DEADLINE };
        let status = tokio::time::timeout(deadline, started.child.wait()).await.ok()?.ok()?;
        if let Some(printing) = started.printing.take() {
            // A process that it has left behind may hold the pipe open.
            drop(tokio::time::timeout(STATUS_DEADLINE, printing).await);
        }
        Some(status)
    }

    /// Ends a child that this coordinator started at once, whatever it does.
    pub async fn kill(mut self) {
        if let Some(mut started) = self.child.take() {
            started.unguard().await;
            // Nothing is left to do when even this fails: the child is reaped by the system.
            drop(started.child.kill().await);
        }
    }

    /// Ends a child that this coordinator started: closes its input, waits, kills it if need be.
    pub async fn end(mut self) {
        let Some(mut started) = self.child.take() else { return };
        started.unguard().await;
        drop(started.child.stdin.take());
        if tokio::time::timeout(END_DEADLINE, started.child.wait()).await.is_err() {
            // Nothing is left to do when even this fails: the child is reaped by the system.
            drop(started.child.kill().await);
        }
    }
}

const LISTEN: [&str; 2] = ["--listen", "127.0.0.1:0"];

/// Starts the processes of an MPI program.
const LAUNCHER: &str = "mpirun";
/// The fluid server in several processes.
const RANKS_PROGRAM: &str = "fluid-server-mpi";

fn this_program(role: Role) -> Result<PathBuf, Failure> {
    std::env::current_exe()
        .map_err(|e| Failure::server(format!("cannot find this executable to start the {role} server: {e}")))
}

fn no_ranks_program(program: &Path) -> Failure {
    Failure::input(format!(
        "`--fluid-ranks` needs the program `{}`, which is not there; build it with `cargo build --release -p \
         {RANKS_PROGRAM} --features mpi`, which takes an MPI library, and put it beside this program",
        program.display()
    ))
}

/// The command of one of our servers with `threads` compute threads in each of its processes.
fn with_own_options(mut command: Command, threads: usize, with: Launch<'_>) -> Command {
    command.args(LISTEN).args(["--exit-with-parent", "--token-stdin"]);
    command.args(["--threads", &threads.to_string()]);
    // It may have to dial a partner elsewhere.
    if let Some(authority) = &with.files.authority {
        command.arg("--partner-ca").arg(authority);
    }
    if let Some((certificate, key)) = &with.files.identity {
        command.arg("--partner-cert").arg(certificate).arg("--partner-key").arg(key);
    }
    if let Some(trace) = with.trace {
        command.arg("--trace").arg(trace);
    }
    if let Some(path) = sph::lanes::forced() {
        command.args(["--arithmetic", path.option()]);
    }
    command
}

/// Whether what is sent to `address` stays on this machine or is encrypted.
fn is_private(address: &str) -> bool {
    let host = address.rsplit_once(':').map_or(address, |(host, _)| host);
    let bare = host.strip_prefix("http://").unwrap_or(host).trim_matches(['[', ']']);
    address.starts_with("https://")
        || bare == "localhost"
        || bare.parse().is_ok_and(|ip: std::net::IpAddr| ip.is_loopback())
}

impl Started {
    /// The process, and its log for what it prints.
    fn spawn(role: Role, mut command: Command, logs: &Path, guarded: bool) -> Result<(Self, File), Failure> {
        let (errors, log) = logs::create(logs, role)?;
        let printed = errors.try_clone().map_err(|e| {
            Failure::output(format!("cannot use the log `{}` of the {role} server: {e}", log.display()))
        })?;
        let program = command.as_std().get_program().to_string_lossy().into_owned();
        let child = command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(errors)
            .kill_on_drop(true)
            // Ctrl-C goes to the whole terminal group; the coordinator alone decides when a run stops.
            .process_group(0)
            .spawn()
            .map_err(|e| {
                Failure::server(format!(
                    "cannot start the {role} server `{program}`: {e}; check the path given by --{role}-bin or by \
                     `[servers]` of the case, and that of `{LAUNCHER}` for --{role}-ranks"
                ))
            })?;
        let guard = child.id().filter(|_| guarded).map(Guard::start).transpose().map_err(|e| {
            Failure::server(format!("cannot start the guard of the {role} server `{program}`: {e}"))
        })?;
        Ok((Self { child, program, log, guard, printing: None }, printed))
    }

    /// Sends the access token through the pipe, which then stays open as long as the child is wanted.
    async fn send_token(&mut self, access: &AccessToken) {
        if let Some(input) = &mut self.child.stdin {
            // A child that has ended, or has closed its input, shows when its address is read.
            let _ = input.write_all(access.line().as_bytes()).await;
        }
    }

    /// The address that the child prints; what follows it goes into `log`.
    async fn address(&mut self, role: Role, mut log: File) -> Result<String, Failure> {
        let Some(output) = self.child.stdout.take() else {
            return Err(Failure::internal(format!("no pipe to the {role} server")));
        };
        let mut lines = BufReader::new(output).lines();
        let first = tokio::time::timeout(START_DEADLINE, lines.next_line()).await;
        let problem = match first {
            Ok(Ok(Some(line))) => match line.strip_prefix("LISTEN ") {
                Some(address) => {
                    let address = address.trim().to_owned();
                    // A program that prints on must not meet a closed pipe, whether or not the log can be written.
                    self.printing = Some(tokio::spawn(async move {
                        while let Ok(Some(line)) = lines.next_line().await {
                            drop(writeln!(log, "{line}"));
                        }
                    }));
                    return Ok(address);
                }
                None => format!("it printed {line:?} where `LISTEN <addr>` was expected"),
            },
            Ok(Ok(None)) => "it ended before it listened".to_owned(),
            Ok(Err(e)) => format!("its output cannot be read: {e}"),
            Err(_) => format!("it did not listen within {} s", START_DEADLINE.as_secs()),
        };
        Err(Failure::server(format!(
            "the {role} server `{}` is not usable: {problem}{}",
            self.program,
            logs::tail(&self.log)
        )))
    }

    /// Whether it is another program than this one.
    fn is_other(&self) -> bool {
        self.guard.is_some()
    }

    async fn unguard(&mut self) {
        if let Some(guard) = self.guard.take() {
            guard.end().await;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::is_private;

    #[test]
    fn only_addresses_of_this_machine_and_encrypted_ones_are_private() {
        for (address, private) in [
            ("127.0.0.1:7001", true),
            ("[::1]:7001", true),
            ("localhost:7001", true),
            ("http://127.0.0.1:7001", true),
            ("https://192.0.2.1:7001", true),
            ("192.0.2.1:7001", false),
            ("127.0.0.1.example.org:7001", false),
        ] {
            assert_eq!(is_private(address), private, "{address}");
        }
    }
}
