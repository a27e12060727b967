//! What a command answers on its standard output.

use std::fmt::Display;
use std::io::Write;

/// Prints a line. A reader that has seen enough, such as `head`, closes the pipe; that is no error.
pub fn say(line: impl Display) {
    let mut out = std::io::stdout().lock();
    drop(writeln!(out, "{line}").and_then(|()| out.flush()));
}
