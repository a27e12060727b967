//! Starting servers as child processes of the coordinator, and ending them.

use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

use proto::security::ClientFiles;
use sph::solver::Role;
use tokio::io::{AsyncBufReadExt, BufReader};
use tokio::process::{Child, Command};

use crate::failure::Failure;
use crate::guard::Guard;
use crate::output::files::fresh;

/// A child that has not reported its address by then is given up.
const START_DEADLINE: Duration = Duration::from_secs(30);
/// A child that has not ended by then, after its input was closed, is killed.
const END_DEADLINE: Duration = Duration::from_secs(5);

/// Where a server comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Source {
    /// This executable, run again with a hidden sub-command.
    Own,
    /// Another program with its arguments; it takes `--listen ADDR` besides and prints `LISTEN <addr>`. It ends with
    /// this process, whether or not it watches its standard input.
    Program(Vec<String>),
    /// A server that already listens.
    Address(String),
}

/// A server that is ready for a connection.
#[derive(Debug)]
pub struct Server {
    /// Side that it plays.
    pub role: Role,
    /// `host:port` at which it listens.
    pub address: String,
    child: Option<Child>,
    guard: Option<Guard>,
}

impl Server {
    /// Attaches to or starts the server of `role`, one of ours with compute `threads`; a child's log goes to `log`, its part of a trace to `trace`.
    ///
    /// # Errors
    /// When the program cannot be started, ends at once, or prints no address in time.
    pub async fn start(
        role: Role,
        source: &Source,
        threads: usize,
        security: &ClientFiles,
        log: &Path,
        trace: Option<&Path>,
    ) -> Result<Self, Failure> {
        let mut command = match source {
            Source::Address(address) => {
                return Ok(Self { role, address: address.clone(), child: None, guard: None });
            }
            Source::Own => {
                let own = std::env::current_exe().map_err(|e| {
                    Failure::server(format!("cannot find this executable to start the {role} server: {e}"))
                })?;
                let mut command = Command::new(own);
                command.arg(format!("node-{role}"));
                command
            }
            Source::Program(words) => {
                let [program, arguments @ ..] = words.as_slice() else {
                    return Err(Failure::input(format!("the command of the {role} server is empty")));
                };
                let mut command = Command::new(program);
                command.args(arguments);
                command
            }
        };
        command.args(["--listen", "127.0.0.1:0"]);
        if *source == Source::Own {
            command.arg("--exit-with-parent");
            command.args(["--threads", &threads.to_string()]);
            // It may have to dial a partner elsewhere.
            if let Some(authority) = &security.authority {
                command.arg("--partner-ca").arg(authority);
            }
            if let Some((certificate, key)) = &security.identity {
                command.arg("--partner-cert").arg(certificate).arg("--partner-key").arg(key);
            }
            if let Some(trace) = trace {
                command.arg("--trace").arg(trace);
            }
            if let Some(path) = sph::lanes::forced() {
                command.args(["--arithmetic", path.option()]);
            }
        }
        let errors = fresh(log).map_err(|e| {
            Failure::output(format!("cannot write the {role} server's log `{}`: {e}", log.display()))
        })?;
        let program = command.as_std().get_program().to_string_lossy().into_owned();
        let mut child = command
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
                     `[servers]` of the case"
                ))
            })?;
        let guard = match (source, child.id()) {
            (Source::Program(_), Some(process)) => Some(Guard::start(process).map_err(|e| {
                Failure::server(format!("cannot start the guard of the {role} server `{program}`: {e}"))
            })?),
            _ => None,
        };
        let address = Self::read_address(role, &program, &mut child, log).await?;
        Ok(Self { role, address, child: Some(child), guard })
    }

    async fn read_address(
        role: Role,
        program: &str,
        child: &mut Child,
        log: &Path,
    ) -> Result<String, Failure> {
        let Some(output) = child.stdout.take() else {
            return Err(Failure::internal(format!("no pipe to the {role} server")));
        };
        let mut lines = BufReader::new(output).lines();
        let first = tokio::time::timeout(START_DEADLINE, lines.next_line()).await;
        let problem = match first {
            Ok(Ok(Some(line))) => match line.strip_prefix("LISTEN ") {
                Some(address) => {
                    let address = address.trim().to_owned();
                    // A program that prints on must not meet a closed pipe.
                    tokio::spawn(async move { while let Ok(Some(_)) = lines.next_line().await {} });
                    return Ok(address);
                }
                None => format!("it printed {line:?} where `LISTEN <addr>` was expected"),
            },
            Ok(Ok(None)) => "it ended before it listened".to_owned(),
            Ok(Err(e)) => format!("its output cannot be read: {e}"),
            Err(_) => format!("it did not listen within {} s", START_DEADLINE.as_secs()),
        };
        Err(Failure::server(format!("the {role} server `{program}` is not usable: {problem}{}", tail(log))))
    }

    /// Whether this coordinator started it.
    pub fn is_child(&self) -> bool {
        self.child.is_some()
    }

    /// Process id of a child that this coordinator started.
    pub fn process_id(&self) -> Option<u32> {
        self.child.as_ref().and_then(Child::id)
    }

    /// Ends a child that this coordinator started at once, whatever it does.
    pub async fn kill(mut self) {
        if let Some(guard) = self.guard.take() {
            guard.end().await;
        }
        if let Some(child) = self.child.as_mut() {
            // Nothing is left to tell when even this fails: the child is reaped by the system.
            drop(child.kill().await);
        }
    }

    /// Ends a child that this coordinator started: closes its input, waits, kills it if need be.
    pub async fn end(mut self) {
        if let Some(guard) = self.guard.take() {
            guard.end().await;
        }
        let Some(child) = self.child.as_mut() else { return };
        drop(child.stdin.take());
        if tokio::time::timeout(END_DEADLINE, child.wait()).await.is_err() {
            // Nothing is left to tell when even this fails: the child is reaped by the system.
            drop(child.kill().await);
        }
    }
}

/// Last lines of a log, for a message.
pub fn tail(log: &Path) -> String {
    const LINES: usize = 12;
    let text = std::fs::read_to_string(log).unwrap_or_default();
    let lines: Vec<&str> = text.lines().collect();
    if lines.is_empty() {
        return String::new();
    }
    let last = &lines[lines.len().saturating_sub(LINES)..];
    format!("\nlast lines of its log `{}`:\n  {}", log.display(), last.join("\n  "))
}
