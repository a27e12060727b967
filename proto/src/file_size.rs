//! What happens to this process when it writes beyond the largest size of a file.

use std::io;

use rustix::process::Signal;
use tokio::runtime::Builder;
use tokio::signal::unix::{SignalKind, signal};

/// Makes a write beyond the largest size of a file (`ulimit -f`) fail as one to a full disk does. Without it the system ends
/// the process without a word (SIGXFSZ).
///
/// # Errors
/// When the system has no more handles.
pub fn fail_beyond_largest_file() -> io::Result<()> {
    let runtime = Builder::new_current_thread().enable_all().build()?;
    let _inside = runtime.enter();
    // That the listener goes at once does not matter: a handler, once set, stays in place of the default.
    signal(SignalKind::from_raw(Signal::XFSZ.as_raw())).map(drop)
}
