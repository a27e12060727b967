//! What every program of the workspace prints, in a way that no closed, full or lost terminal can end it.
//!
//! `println!` and `eprintln!` panic when the stream cannot be written: where a reader such as `head` has left, a disk is
//! full or a session has ended. The lints of the workspace deny them; all programs print by [`say`] and [`note`].

use std::fmt::Display;
use std::io::Write;

/// Prints a line of a command's answer to standard output. That it cannot be written is no error.
pub fn say(line: impl Display) {
    print(std::io::stdout().lock(), line);
}

/// Prints a line beside the answer to standard error: progress, warnings, errors. That it cannot be written is no error.
pub fn note(line: impl Display) {
    print(std::io::stderr().lock(), line);
}

/// One write for a line, so that those of several processes do not mix.
fn print(mut out: impl Write, line: impl Display) {
    drop(out.write_all(format!("{line}\n").as_bytes()).and_then(|()| out.flush()));
}
