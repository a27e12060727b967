//! What every program of the workspace shares with its terminal: how it prints, how it is stopped and how it ends.
//!
//! `println!` and `eprintln!` panic when the stream cannot be written: where a reader such as `head` has left, a disk is
//! full or a session has ended. The lints of the workspace deny them; all programs print by [`say`] and [`note`].
//! [`program`] gives a panic its exit code, [`stop`] listens to the signals that ask a program to end, [`style`] knows
//! whether there are colours, and [`lines`] how wide lines may be.

use std::fmt::Display;
use std::io::Write;

pub mod lines;
pub mod program;
pub mod stop;
pub mod style;

/// Prints a line of a command's answer to standard output. That it cannot be written is no error.
pub fn say(line: impl Display) {
    print(std::io::stdout(), line);
}

/// Prints a line beside the answer to standard error: progress, warnings, errors. That it cannot be written is no error.
pub fn note(line: impl Display) {
    print(std::io::stderr(), line);
}

/// One write for a line, so that those of several processes do not mix.
fn print(mut out: impl Write, line: impl Display) {
    let line = format!("{line}\n");
    drop(out.write_all(line.as_bytes()).and_then(|()| out.flush()));
}

#[cfg(test)]
mod tests {
    use std::io;

    use super::*;

    /// Counts the writes that it refuses.
    struct Full<'a>(&'a mut u32);

    impl Write for Full<'_> {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            *self.0 += 1;
            Err(io::ErrorKind::StorageFull.into())
        }

        fn flush(&mut self) -> io::Result<()> {
            Err(io::ErrorKind::StorageFull.into())
        }
    }

    #[test]
    fn a_line_is_one_write_and_a_full_stream_is_left_alone() {
        let mut written = Vec::new();
        print(&mut written, format_args!("{} of {}", 1, 2));
        assert_eq!(written, b"1 of 2\n");
        let mut refused = 0;
        print(Full(&mut refused), format_args!("{} of {}", 1, 2));
        assert_eq!(refused, 1);
    }
}
