//! The file operations of a checkpoint, one by one: what comes after what is what makes it safe.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::Path;

use crate::results::files::fresh;

/// File operations. Implemented by [`Disk`], and in tests by a disk that fails or forgets.
pub trait Files {
    /// Makes a folder.
    ///
    /// # Errors
    /// When the system refuses.
    fn create_folder(&mut self, path: &Path) -> io::Result<()>;

    /// Writes a new file in place of the one there; its content need not be on the disk afterwards.
    ///
    /// # Errors
    /// When the system refuses.
    fn write(&mut self, path: &Path, content: &[u8]) -> io::Result<()>;

    /// Brings a file's content, or a folder's names, to the disk.
    ///
    /// # Errors
    /// When the system refuses.
    fn sync(&mut self, path: &Path) -> io::Result<()>;

    /// Renames a folder.
    ///
    /// # Errors
    /// When the system refuses.
    fn rename(&mut self, from: &Path, to: &Path) -> io::Result<()>;

    /// Removes a file.
    ///
    /// # Errors
    /// When the system refuses.
    fn remove_file(&mut self, path: &Path) -> io::Result<()>;

    /// Removes an empty folder.
    ///
    /// # Errors
    /// When the system refuses.
    fn remove_folder(&mut self, path: &Path) -> io::Result<()>;
}

/// The disk itself.
#[derive(Clone, Copy, Debug, Default)]
pub struct Disk;

impl Files for Disk {
    fn create_folder(&mut self, path: &Path) -> io::Result<()> {
        fs::create_dir(path)
    }

    fn write(&mut self, path: &Path, content: &[u8]) -> io::Result<()> {
        fresh(path)?.write_all(content)
    }

    fn sync(&mut self, path: &Path) -> io::Result<()> {
        File::open(path)?.sync_all()
    }

    fn rename(&mut self, from: &Path, to: &Path) -> io::Result<()> {
        fs::rename(from, to)
    }

    fn remove_file(&mut self, path: &Path) -> io::Result<()> {
        fs::remove_file(path)
    }

    fn remove_folder(&mut self, path: &Path) -> io::Result<()> {
        fs::remove_dir(path)
    }
}
