//! Logs of the servers that the coordinator starts: one file for each process, none written over.

use std::fs::{self, File, OpenOptions};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use sph::coupling::solver::Role;

use crate::failure::Failure;

/// Most logs of one side in a folder.
const MOST: u32 = 100_000;

/// A new log of the server of `role` in `folder`: `fluid-server.log`, then `fluid-server-1.log` and so on.
///
/// # Errors
/// When it cannot be made or written; the message names it.
pub fn create(folder: &Path, role: Role) -> Result<(File, PathBuf), Failure> {
    for number in 0..MOST {
        let path = folder.join(name(role, number));
        let failed = |e: std::io::Error| {
            Failure::output(format!(
                "cannot write the log `{}` of the {role} server: {e}; free some space, or give another folder by `--out`",
                path.display()
            ))
        };
        match OpenOptions::new().write(true).create_new(true).open(&path) {
            Ok(mut log) => {
                // A disk without room shows here, not as a server that says nothing.
                writeln!(log, "log of the {role} server").map_err(failed)?;
                return Ok((log, path));
            }
            Err(e) if e.kind() == ErrorKind::AlreadyExists => {}
            Err(e) => return Err(failed(e)),
        }
    }
    Err(Failure::output(format!(
        "`{}` holds {MOST} logs of the {role} server; remove those that you do not need",
        folder.display()
    )))
}

fn name(role: Role, number: u32) -> String {
    let suffix = if number == 0 { String::new() } else { format!("-{number}") };
    format!("{role}-server{suffix}.log")
}

/// Last lines of a log, for a message.
pub fn tail(log: &Path) -> String {
    const LINES: usize = 12;
    let text = fs::read_to_string(log).unwrap_or_default();
    // The first line is the coordinator's.
    let lines: Vec<&str> = text.lines().skip(1).collect();
    if lines.is_empty() {
        return String::new();
    }
    let last = &lines[lines.len().saturating_sub(LINES)..];
    format!("\nlast lines of its log `{}`:\n  {}", log.display(), last.join("\n  "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::failure::Kind;

    #[test]
    fn no_log_is_written_over() {
        let folder = tempfile::tempdir().unwrap();
        for expected in ["fluid-server.log", "fluid-server-1.log", "fluid-server-2.log"] {
            let (mut log, path) = create(folder.path(), Role::Fluid).unwrap();
            assert_eq!(path.file_name().unwrap(), expected);
            writeln!(log, "{expected} says this").unwrap();
        }
        assert!(tail(&folder.path().join("fluid-server-1.log")).ends_with("fluid-server-1.log says this"));
    }

    #[test]
    fn a_log_that_cannot_be_written_is_named_with_the_remedy() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("missing");
        let failure = create(&missing, Role::Solid).unwrap_err();
        assert_eq!(failure.kind, Kind::Output);
        for words in ["solid-server.log", "No such file", "--out"] {
            assert!(failure.message.contains(words), "{failure}");
        }
    }
}
