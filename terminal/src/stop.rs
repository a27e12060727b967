//! Signals that ask a program to end in order: SIGINT, SIGTERM, and SIGHUP where it is not ignored.

use std::io;

use tokio::signal::unix::{Signal, SignalKind, signal};

/// Where Linux lists which signals a process ignores.
const STATUS: &str = "/proc/self/status";

/// The signals of this process that ask it to end.
#[derive(Debug)]
pub struct StopSignals {
    interrupt: Signal,
    terminate: Signal,
    hangup: Option<Signal>,
    /// Whether one has come.
    asked: bool,
}

impl StopSignals {
    /// Listens from here on. A program that was started with SIGHUP ignored, as `nohup` does, keeps ignoring it.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn listen() -> io::Result<Self> {
        let status = std::fs::read_to_string(STATUS).unwrap_or_default();
        let hangup = if hangup_is_ignored(&status) { None } else { Some(signal(SignalKind::hangup())?) };
        Ok(Self {
            interrupt: signal(SignalKind::interrupt())?,
            terminate: signal(SignalKind::terminate())?,
            hangup,
            asked: false,
        })
    }

    /// Waits for the next request to end.
    ///
    /// SIGHUP asks once, and only as the first one: a terminal that closes sends it through the shell and by itself, which
    /// is no second request.
    pub async fn next(&mut self) {
        loop {
            let hangup = async {
                match &mut self.hangup {
                    Some(hangup) => hangup.recv().await,
                    None => std::future::pending().await,
                }
            };
            tokio::select! {
                _ = self.interrupt.recv() => break,
                _ = self.terminate.recv() => break,
                _ = hangup => if !self.asked { break },
            }
        }
        self.asked = true;
    }
}

/// Ignores such signals from here on, in a process whose end another one decides.
///
/// # Errors
/// When the system refuses.
pub fn ignore() -> io::Result<()> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_io().build()?;
    let _entered = runtime.enter();
    // What a signal does by default stays replaced when no one listens any more.
    StopSignals::listen().map(drop)
}

/// Whether a process with this `status` ignores SIGHUP. Where that is unknown it counts as ignored, so that the signal keeps
/// the effect that it has.
fn hangup_is_ignored(status: &str) -> bool {
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    // Signal 1 has the lowest bit.
    mask.is_none_or(|mask| mask & 1 == 1)
}

#[cfg(test)]
mod tests {
    use super::hangup_is_ignored;

    #[test]
    fn the_lowest_bit_of_the_mask_says_whether_hangups_are_ignored() {
        let status =
            |mask: &str| format!("Name:\tx\nSigBlk:\t0000000000000001\nSigIgn:\t{mask}\nSigCgt:\t0001\n");
        assert!(!hangup_is_ignored(&status("0000000000001000")));
        assert!(hangup_is_ignored(&status("0000000000001001")));
        assert!(hangup_is_ignored(""), "unknown: the signal keeps its effect");
        assert!(hangup_is_ignored(&status("no number")));
    }
}
