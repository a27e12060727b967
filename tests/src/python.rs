//! The solvers in Python, for tests that start them.
//!
//! They need `python3` with the packages of `solvers/python/requirements.txt`. Where these are missing a test says that
//! it is skipped; with the environment variable `TIDELOCK_REQUIRE_PYTHON` set, as `.ci/run` does, it fails.

use std::io::BufRead;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

/// How to get what the solvers in Python need, as `.ci/run` does.
const INSTALL: &str = "to run it: `python3 -m venv target/python && target/python/bin/pip install -r \
    solvers/python/requirements.txt`, then put target/python/bin first on the PATH";

/// Whether the solvers in Python can run here; says why not.
#[must_use]
pub fn python_is_there(test: &str) -> bool {
    let output = Command::new("python3").args(["-c", "import grpc, grpc_tools.protoc, numpy"]).output();
    let problem = match output {
        Ok(output) if output.status.success() => return true,
        Ok(output) => String::from_utf8_lossy(&output.stderr).lines().last().unwrap_or_default().to_owned(),
        Err(error) => format!("python3: {error}"),
    };
    let text = format!("SKIPPED {test}: {problem}; {INSTALL}");
    assert!(std::env::var_os("TIDELOCK_REQUIRE_PYTHON").is_none(), "{text}");
    // Past the harness, which keeps the output of tests that pass to itself.
    terminal::note(text);
    false
}

/// The folder of the skin and its solvers.
#[must_use]
pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../solvers/python")
}

/// Lines that let a script elsewhere import the skin.
#[must_use]
pub fn import_path() -> String {
    format!("import sys\nsys.path.insert(0, {:?})\n", folder().to_string_lossy())
}

/// A solver in Python that listens; ended when dropped.
#[derive(Debug)]
pub struct Listening {
    child: Child,
    /// Where it listens, host and port.
    pub address: String,
}

impl Listening {
    /// Starts `script` with `further` options.
    ///
    /// # Panics
    /// When it does not say where it listens.
    #[must_use]
    pub fn start(script: &Path, further: &[&str]) -> Self {
        let child = Command::new("python3")
            .arg(script)
            .args(["--listen", "127.0.0.1:0"])
            .args(further)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn();
        Self::of(child.unwrap())
    }

    /// The solver that `child` is.
    ///
    /// # Panics
    /// When it does not say where it listens.
    #[must_use]
    pub fn of(mut child: Child) -> Self {
        let mut line = String::new();
        std::io::BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let address = line.trim().strip_prefix("LISTEN ").expect("LISTEN and the address").to_owned();
        Self { child, address }
    }
}

impl Drop for Listening {
    fn drop(&mut self) {
        // Closing its input ends it; killing makes sure.
        drop(self.child.stdin.take());
        drop(self.child.kill());
        drop(self.child.wait());
    }
}
