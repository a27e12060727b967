//! Whether two folders of results are the same.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::Path;

/// Whether two folders of results hold the same tables, frames and final states, byte for byte.
///
/// # Errors
/// The first difference.
pub fn same_results(expected: &Path, found: &Path) -> Result<(), String> {
    let mut names: Vec<String> = ["probes.csv", "ledger.csv"].map(String::from).to_vec();
    for folder in ["snapshots", "final"] {
        same_names(&files_in(expected, folder)?, &files_in(found, folder)?)?;
        names.extend(files_in(expected, folder)?);
    }
    for name in names {
        let read = |root: &Path| std::fs::read(root.join(&name)).map_err(|e| format!("{name}: {e}"));
        let (a, b) = (read(expected)?, read(found)?);
        if let Some(place) = (0..a.len().max(b.len())).find(|k| a.get(*k) != b.get(*k)) {
            return Err(format!("{name} differs from byte {place} on ({} and {} bytes)", a.len(), b.len()));
        }
    }
    Ok(())
}

/// Whether two folders of results hold files of the same names, logs apart: nothing is missing and nothing is left over.
///
/// # Errors
/// All differences.
pub fn same_files(expected: &Path, found: &Path) -> Result<(), String> {
    let without_logs = |root: &Path| -> Result<BTreeSet<String>, String> {
        Ok(files_in(root, "")?.into_iter().filter(|name| !name.starts_with("logs/")).collect())
    };
    same_names(&without_logs(expected)?, &without_logs(found)?)
}

fn same_names(expected: &BTreeSet<String>, found: &BTreeSet<String>) -> Result<(), String> {
    let mut text = String::new();
    for name in expected.difference(found) {
        let _ = write!(text, " -{name}");
    }
    for name in found.difference(expected) {
        let _ = write!(text, " +{name}");
    }
    if text.is_empty() { Ok(()) } else { Err(format!("other files:{text}")) }
}

/// Paths below `root` of all files in its folder `folder` and the folders in that.
fn files_in(root: &Path, folder: &str) -> Result<BTreeSet<String>, String> {
    let mut names = BTreeSet::new();
    for entry in std::fs::read_dir(root.join(folder)).map_err(|e| format!("{folder}: {e}"))? {
        let entry = entry.map_err(|e| format!("{folder}: {e}"))?;
        let name = Path::new(folder).join(entry.file_name()).to_string_lossy().into_owned();
        if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            names.extend(files_in(root, &name)?);
        } else {
            names.insert(name);
        }
    }
    Ok(names)
}
