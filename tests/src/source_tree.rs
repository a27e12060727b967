//! Files of the source tree.

use std::path::{Path, PathBuf};

/// The root of the repository.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().map(Path::to_owned).unwrap_or_default()
}

/// Files of the source tree that end in `.extension`, in the order of their paths; without what is built or downloaded.
///
/// # Panics
/// When a folder cannot be read.
pub fn files(extension: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open = vec![root()];
    while let Some(path) = open.pop() {
        if path.is_dir() {
            let entries = std::fs::read_dir(&path).and_then(Iterator::collect::<Result<Vec<_>, _>>);
            let entries = entries.unwrap_or_else(|e| panic!("cannot read `{}`: {e}", path.display()));
            let skipped = |name: &str| name.starts_with('.') || matches!(name, "target" | "results");
            let kept = entries.into_iter().filter(|entry| !skipped(&entry.file_name().to_string_lossy()));
            open.extend(kept.map(|entry| entry.path()));
        } else if path.extension().is_some_and(|found| found == extension) {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// All shipped case files, in the order of their paths.
///
/// # Panics
/// When a folder cannot be read.
pub fn case_files() -> Vec<PathBuf> {
    let cases = root().join("cases");
    files("toml").into_iter().filter(|path| path.starts_with(&cases)).collect()
}
