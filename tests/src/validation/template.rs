//! Case files with values replaced.

use std::path::{Path, PathBuf};

use coordinator::study::template;

/// Folder of the case files.
pub fn folder() -> PathBuf {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR"));
    tests.parent().unwrap_or(tests).join("cases/validation")
}

/// The text of the case file at `path` with the values at the dotted paths replaced or added; comments are lost.
///
/// # Errors
/// When the file is no TOML, or a path leads through something that is no table or list.
pub fn instantiate(path: &Path, changes: &[(String, toml::Value)]) -> Result<String, String> {
    let text =
        std::fs::read_to_string(path).map_err(|e| format!("`{}` cannot be read: {e}", path.display()))?;
    template::instantiate(&text, changes).map_err(|e| format!("`{}`: {e}", path.display()))
}
