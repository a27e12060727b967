//! Failures of outputs, each with its remedy.

use std::io;
use std::path::{Path, PathBuf};

use crate::failure::Failure;

/// An output that cannot be written, or must not be.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The file system refused.
    #[error("cannot {action} `{}`: {cause}; {hint}", path.display())]
    File {
        /// What was tried.
        action: &'static str,
        /// On which file or folder.
        path: PathBuf,
        /// Answer of the system.
        cause: io::Error,
        /// What to do about it.
        hint: &'static str,
    },
    /// Writing would destroy something.
    #[error("output folder `{}` {reason}; {hint}", path.display())]
    Refused {
        /// The folder.
        path: PathBuf,
        /// What is in the way.
        reason: String,
        /// What to do about it.
        hint: &'static str,
    },
    /// A file or its content is not as it must be.
    #[error("`{}`: {reason}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
}

impl OutputError {
    /// A refusal of the file system with the remedy that fits its cause.
    pub fn file(action: &'static str, path: &Path, cause: io::Error) -> Self {
        let hint = match cause.kind() {
            io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
                "make it writable or choose another folder with `--out`"
            }
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
                "free some space or choose a folder on another disk with `--out`"
            }
            io::ErrorKind::FileTooLarge => "raise the largest size of a file (`ulimit -f`)",
            io::ErrorKind::NotADirectory => {
                "a part of this path is a file: choose another folder with `--out`"
            }
            io::ErrorKind::NotFound => "check the path",
            _ => "check the disk or choose another folder with `--out`",
        };
        Self::File { action, path: path.to_path_buf(), cause, hint }
    }

    /// A file whose content is not as it must be.
    pub fn content(path: &Path, reason: impl Into<String>) -> Self {
        Self::Content { path: path.to_path_buf(), reason: reason.into() }
    }
}

impl From<OutputError> for Failure {
    fn from(error: OutputError) -> Self {
        Failure::output(error.to_string())
    }
}

pub(super) fn refused<T>(path: &Path, reason: &str, hint: &'static str) -> Result<T, OutputError> {
    Err(OutputError::Refused { path: path.to_path_buf(), reason: reason.to_owned(), hint })
}
