//! The file that marks, and locks, the folder of a run that is not complete.

use std::fs::{self, File, TryLockError};
use std::io::{self, Read, Seek, Write};
use std::os::unix::fs::MetadataExt;
use std::path::Path;

use super::error::{OutputError, refused};
use super::files::open_regular;
use super::names::MARKER;

/// Start of the text in a marker.
pub(super) const TEXT: &str = "A run is writing here";
/// Longest marker that is read \[bytes\].
const LONGEST: u64 = 256;

/// Content of the marker at `path`.
///
/// # Errors
/// When there is none, or it is a link, longer than a marker, or no text.
pub(super) fn text(path: &Path) -> io::Result<String> {
    let unfit = || io::Error::new(io::ErrorKind::InvalidInput, "it is no marker of a run");
    if fs::symlink_metadata(path)?.is_symlink() {
        return Err(unfit());
    }
    let (file, length) = open_regular(path)?;
    if length > LONGEST {
        return Err(unfit());
    }
    let mut text = String::new();
    file.take(LONGEST).read_to_string(&mut text)?;
    Ok(text)
}

/// Creates where needed and locks the marker, and says whether it was created; a lock distinguishes a running run from
/// one that was killed.
pub(super) fn take_marker(path: &Path) -> Result<(File, bool), OutputError> {
    let file = path.join(MARKER);
    let failed = |e| OutputError::file("write to output folder", path, e);
    loop {
        let is_new = match fs::symlink_metadata(&file) {
            Ok(facts) if facts.is_file() => false,
            Ok(_) => return no_marker(path),
            Err(e) if e.kind() == io::ErrorKind::NotFound => true,
            Err(e) => return Err(failed(e)),
        };
        let mut marker = match File::options().read(true).write(true).create_new(is_new).open(&file) {
            Err(e) if matches!(e.kind(), io::ErrorKind::NotFound | io::ErrorKind::AlreadyExists) => continue,
            opened => opened.map_err(failed)?,
        };
        // A file system without locks still has the marker.
        if matches!(marker.try_lock(), Err(TryLockError::WouldBlock)) {
            return refused(
                path,
                "is being written by another run",
                "wait for it to end or choose another folder with `--out`",
            );
        }
        // The run before may have removed it meanwhile: a lock on a file without a name keeps no other run off.
        let here = marker.metadata().map_err(failed)?;
        if !fs::symlink_metadata(&file).is_ok_and(|f| (f.dev(), f.ino()) == (here.dev(), here.ino())) {
            continue;
        }
        if let Err(e) = write_marker(&mut marker) {
            if is_new {
                let _ = fs::remove_file(&file);
            }
            return match e.kind() {
                io::ErrorKind::InvalidData => no_marker(path),
                _ => Err(OutputError::file("write to", &file, e)),
            };
        }
        return Ok((marker, is_new));
    }
}

fn no_marker<T>(path: &Path) -> Result<T, OutputError> {
    let reason = format!("holds a `{MARKER}` that no run wrote, so nothing was changed");
    refused(path, &reason, "move that file elsewhere or choose another folder")
}

/// Gives an empty marker its text.
fn write_marker(marker: &mut File) -> io::Result<()> {
    let mut start = Vec::new();
    Read::by_ref(marker).take(TEXT.len() as u64).read_to_end(&mut start)?;
    if start.is_empty() {
        marker.rewind()?;
        return marker
            .write_all(format!("{TEXT}, or was killed before its outputs were complete.\n").as_bytes());
    }
    if start == TEXT.as_bytes() { Ok(()) } else { Err(io::ErrorKind::InvalidData.into()) }
}
