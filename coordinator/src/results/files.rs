//! Files of a run: how one becomes complete, and how one that may be anything is opened.

use std::fs::{self, File};
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

use super::error::OutputError;
use super::names::PARTIAL;

/// `path` with [`PARTIAL`] appended to its name.
pub(super) fn with_suffix(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_os_string();
    name.push(PARTIAL);
    PathBuf::from(name)
}

/// Removes the file at `path`, if there is one; of a link the link itself.
///
/// # Errors
/// When the system refuses, or it is a folder.
pub fn remove_if_there(path: &Path) -> io::Result<()> {
    match fs::remove_file(path) {
        Err(e) if e.kind() != io::ErrorKind::NotFound => Err(e),
        _ => Ok(()),
    }
}

/// A new, empty file at `path`. What is there is removed first, so that nothing behind a link is written.
///
/// # Errors
/// When the system refuses, or a folder is there.
pub fn fresh(path: &Path) -> io::Result<File> {
    remove_if_there(path)?;
    File::create_new(path)
}

/// Opens the regular file at `path`, which may be a link to one, for reading; with its length \[bytes\].
///
/// # Errors
/// When it cannot be opened, or is a pipe, device or folder, which could block a reader.
pub fn open_regular(path: &Path) -> io::Result<(File, u64)> {
    let regular = |facts: fs::Metadata| match facts.is_file() {
        true => Ok(facts.len()),
        false => Err(io::Error::new(io::ErrorKind::InvalidInput, "it is no regular file")),
    };
    // To open a pipe waits for its writer.
    regular(fs::metadata(path)?)?;
    let file = File::open(path)?;
    let length = regular(file.metadata()?)?;
    Ok((file, length))
}

/// Writes `path` under a name with [`PARTIAL`] and renames it when its content is on the disk.
///
/// # Errors
/// When the file cannot be written; its place is then as it was before.
pub fn write_file(
    path: &Path,
    content: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<(), OutputError> {
    let partial = with_suffix(path);
    let written = fresh(&partial).and_then(|file| {
        let mut writer = BufWriter::with_capacity(1 << 16, file);
        content(&mut writer)?;
        let file = writer.into_inner().map_err(io::IntoInnerError::into_error)?;
        file.sync_data()?;
        fs::rename(&partial, path)
    });
    written.map_err(|e| {
        // The cause of the failure is what matters; the remains carry a name that says what they are.
        let _ = fs::remove_file(&partial);
        OutputError::file("write", path, e)
    })
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    #[test]
    fn a_failed_write_leaves_the_old_content_and_no_remains() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("table");
        write_file(&path, |w| w.write_all(b"old")).unwrap();
        let failed = write_file(&path, |w| {
            w.write_all(b"half")?;
            Err(io::Error::from(io::ErrorKind::StorageFull))
        });
        assert!(failed.unwrap_err().to_string().contains("free some space"));
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(fs::read_dir(root.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_link_at_the_partial_name_is_not_followed() {
        let root = tempfile::tempdir().unwrap();
        let (mine, path) = (root.path().join("mine"), root.path().join("report.html"));
        fs::write(&mine, "mine").unwrap();
        for target in [&mine, &root.path().join("absent")] {
            std::os::unix::fs::symlink(target, with_suffix(&path)).unwrap();
            write_file(&path, |w| w.write_all(b"new")).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), "new");
            assert_eq!(fs::read_to_string(&mine).unwrap(), "mine");
            assert!(!root.path().join("absent").exists());
        }
    }

    #[test]
    fn a_pipe_is_refused_at_once() {
        let root = tempfile::tempdir().unwrap();
        let pipe = root.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        assert!(open_regular(&pipe).unwrap_err().to_string().contains("no regular file"));
        assert!(open_regular(root.path()).is_err());
    }
}
