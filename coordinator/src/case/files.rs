//! Reading small text files that a case names.

use std::path::{Path, PathBuf};

use crate::quote;

/// Largest text file that is read \[bytes\].
pub const LARGEST_FILE: u64 = 4 << 20;

/// `name` as seen from `directory`.
pub fn resolved(directory: &Path, name: &str) -> PathBuf {
    directory.join(name)
}

/// The whole of a regular UTF-8 text file of at most [`LARGEST_FILE`] bytes.
///
/// # Errors
/// What is wrong, in words that name the file.
pub fn read_text(path: &Path) -> Result<String, String> {
    let quoted = quote::path(path);
    let facts = std::fs::metadata(path).map_err(|error| match error.kind() {
        std::io::ErrorKind::NotFound => format!("no such file: {quoted}"),
        _ => format!("cannot read {quoted}: {error}"),
    })?;
    // A device or pipe may have no end.
    if !facts.is_file() {
        return Err(format!("{quoted} is not a regular file"));
    }
    if facts.len() > LARGEST_FILE {
        return Err(format!("{quoted} has {} bytes; at most {LARGEST_FILE} are read", facts.len()));
    }
    std::fs::read_to_string(path).map_err(|error| match error.kind() {
        std::io::ErrorKind::InvalidData => format!("{quoted} is not UTF-8 text"),
        _ => format!("cannot read {quoted}: {error}"),
    })
}
