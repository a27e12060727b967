//! Files of the source tree.

use std::path::{Path, PathBuf};

/// The root of the repository.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().map(Path::to_owned).unwrap_or_default()
}

/// All shipped case files, in the order of their names.
///
/// # Panics
/// When a folder of cases cannot be read.
pub fn case_files() -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open = vec![root().join("cases")];
    while let Some(path) = open.pop() {
        if path.is_dir() {
            let entries = std::fs::read_dir(&path).and_then(Iterator::collect::<Result<Vec<_>, _>>);
            let entries = entries.unwrap_or_else(|e| panic!("cannot read `{}`: {e}", path.display()));
            open.extend(entries.into_iter().map(|entry| entry.path()));
        } else if path.extension().is_some_and(|extension| extension == "toml") {
            found.push(path);
        }
    }
    found.sort();
    found
}
