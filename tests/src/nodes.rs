//! Servers as processes that a test starts by itself.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitCode, Stdio};

/// The program under test: `given`, or `tidelock-node` beside this program.
///
/// # Errors
/// When it is not there, which is said: the code with which to end.
pub fn program(given: Option<PathBuf>) -> Result<PathBuf, ExitCode> {
    let beside = || std::env::current_exe().ok().map(|own| own.with_file_name("tidelock-node"));
    given.or_else(beside).filter(|program| program.exists()).ok_or_else(|| {
        terminal::note(format_args!(
            "error: no program `tidelock-node` beside this one; build it by `cargo build --release -p tests`"
        ));
        ExitCode::from(2)
    })
}

/// A server process; it ends with this value.
#[derive(Debug)]
pub struct Node {
    child: Child,
    /// `host:port` at which it listens.
    pub address: String,
}

impl Node {
    /// Starts the server of `role`, "fluid" or "solid", of `program` with one thread and `arguments`.
    pub fn start(program: &Path, role: &str, arguments: &[&str]) -> Self {
        let mut command = Command::new(program);
        command.arg(format!("node-{role}")).args(["--threads", "1"]).args(arguments);
        let piped = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut child = piped.spawn().unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.as_mut().unwrap()).read_line(&mut line).unwrap();
        let address = line.strip_prefix("LISTEN ").expect("the server listens").trim().to_owned();
        Self { child, address }
    }

    /// Process id.
    pub fn process(&self) -> u32 {
        self.child.id()
    }
}

impl Drop for Node {
    fn drop(&mut self) {
        drop(self.child.kill());
        drop(self.child.wait());
    }
}
