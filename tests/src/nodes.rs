//! Servers as processes that a test starts by itself.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

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
