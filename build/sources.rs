//! Tells builds of a solver apart: a digest of all that decides the bits of its results. Shared by build scripts.

use std::path::{Path, PathBuf};
use std::{env, fs};

use sha2::{Digest, Sha256};

/// Settings of the compiler, in addition to the sources.
const SETTINGS: [&str; 6] = [
    "PROFILE",
    "OPT_LEVEL",
    "TARGET",
    "CARGO_CFG_TARGET_FEATURE",
    "CARGO_ENCODED_RUSTFLAGS",
    "CARGO_PKG_VERSION",
];

/// Digests the files in `folders` and single `files`; the crate finds the result as `env!("TIDELOCK_BUILD")`.
pub fn emit(folders: &[&str], files: &[&str]) {
    let mut paths: Vec<PathBuf> = files.iter().map(PathBuf::from).collect();
    for folder in folders {
        println!("cargo:rerun-if-changed={folder}");
        collect(Path::new(folder), &mut paths);
    }
    paths.sort();
    let mut hash = Sha256::new();
    for path in paths {
        println!("cargo:rerun-if-changed={}", path.display());
        hash.update(path.to_string_lossy().as_bytes());
        hash.update(fs::read(&path).unwrap_or_default());
    }
    for name in SETTINGS {
        hash.update(env::var(name).unwrap_or_default());
    }
    let compiler = env::var("RUSTC")
        .ok()
        .and_then(|rustc| std::process::Command::new(rustc).arg("--version").output().ok());
    hash.update(compiler.map(|output| output.stdout).unwrap_or_default());
    let digest: String = hash.finalize().iter().take(8).map(|byte| format!("{byte:02x}")).collect();
    println!("cargo:rustc-env=TIDELOCK_BUILD={digest}");
}

fn collect(folder: &Path, paths: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            collect(&path, paths);
        } else {
            paths.push(path);
        }
    }
}
