//! Reading small text files that a case names.

use std::path::{Path, PathBuf};

use crate::quote;

/// Largest text file that is read \[bytes\].
pub const LARGEST_FILE: u64 = 4 << 20;

/// `name` as seen from `directory`.
pub fn resolved(directory: &Path, name: &str) -> PathBuf {
    directory.join(name)
}

/// Largest file of a surface that is read \[bytes\]: some two million facets in words, ten in binary form.
pub const LARGEST_SURFACE: u64 = 512 << 20;

/// The whole of a regular file of at most `largest` bytes.
///
/// # Errors
/// What is wrong, in words that name the file.
pub fn read_bytes(path: &Path, largest: u64) -> Result<Vec<u8>, String> {
    let quoted = quote::path(path);
    let facts = std::fs::metadata(path).map_err(|error| match error.kind() {
        std::io::ErrorKind::NotFound => format!("no such file: {quoted}"),
        _ => format!("cannot read {quoted}: {error}"),
    })?;
    // A device or pipe may have no end.
    if !facts.is_file() {
        return Err(format!("{quoted} is not a regular file"));
    }
    if facts.len() > largest {
        return Err(format!("{quoted} has {} bytes; at most {largest} are read", facts.len()));
    }
    std::fs::read(path).map_err(|error| format!("cannot read {quoted}: {error}"))
}

/// The whole of a regular UTF-8 text file of at most [`LARGEST_FILE`] bytes.
///
/// # Errors
/// What is wrong, in words that name the file.
pub fn read_text(path: &Path) -> Result<String, String> {
    let bytes = read_bytes(path, LARGEST_FILE)?;
    String::from_utf8(bytes).map_err(|_| format!("{} is not UTF-8 text", quote::path(path)))
}
