//! Ends a server program when the coordinator that started it is gone, however it went.
//!
//! Built-in servers watch their standard input for that. Another program need not: for each one a guard runs beside
//! it, this executable with a hidden sub-command, and watches in its place.

use std::io::Read;
use std::process::Stdio;
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process_group, test_kill_process_group};
use tokio::process::{Child, Command};

/// Time between the request to end and the end by force.
const GRACE: Duration = Duration::from_secs(5);
/// Time between looks whether the program has ended.
const LOOK: Duration = Duration::from_millis(50);

/// A guard of one program, in the coordinator's hand.
#[derive(Debug)]
pub struct Guard(Child);

impl Guard {
    /// Sub-command by which this executable becomes a guard.
    pub const COMMAND: &'static str = "node-guard";

    /// Starts the guard of the process group led by `process`.
    ///
    /// # Errors
    /// When this executable cannot be started again.
    pub fn start(process: u32) -> std::io::Result<Self> {
        Command::new(std::env::current_exe()?)
            .args([Self::COMMAND, &process.to_string()])
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .kill_on_drop(true)
            .process_group(0)
            .spawn()
            .map(Self)
    }

    /// Ends the guard; its program stays.
    pub async fn end(mut self) {
        // A guard that is gone already needs no more.
        drop(self.0.kill().await);
    }
}

/// Waits until standard input closes, as it does when the coordinator ends, then ends the process group of `process`.
pub fn watch(process: i32) {
    let mut buffer = [0; 64];
    let mut stdin = std::io::stdin().lock();
    while matches!(stdin.read(&mut buffer), Ok(count) if count > 0) {}
    let Some(group) = Pid::from_raw(process) else { return };
    // Errors say that the group has ended.
    let _ = kill_process_group(group, Signal::TERM);
    let asked = Instant::now();
    while test_kill_process_group(group).is_ok() {
        if asked.elapsed() > GRACE {
            let _ = kill_process_group(group, Signal::KILL);
            return;
        }
        std::thread::sleep(LOOK);
    }
}
