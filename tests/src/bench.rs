//! A folder for one test, cases in it, and the coordinator as a process.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Output, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;
use tempfile::TempDir;

/// A tank 20 cm wide with water, a free block and a clamped plate under water: 400 particles, 1 ms in 25 steps.
const TANK: &str = include_str!("tank.toml");
const TANK_IN_SPACE: &str = include_str!("tank_3d.toml");

/// Wait for something that a healthy process does in a moment.
const SOON: Duration = Duration::from_secs(30);
/// Time between looks.
const LOOK: Duration = Duration::from_millis(5);

/// A folder for one test and the program under test.
#[derive(Debug)]
pub struct Bench {
    folder: TempDir,
    program: PathBuf,
}

impl Bench {
    /// A bench for `program`, which each test knows as `env!("CARGO_BIN_EXE_tidelock-node")`.
    #[must_use]
    pub fn new(program: &str) -> Self {
        Self { folder: tempfile::tempdir().unwrap(), program: program.into() }
    }

    /// Path of `name` in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes `text` to `name`.
    pub fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.path(name);
        std::fs::write(&path, text).unwrap();
        path
    }

    /// The tank's case as `name`, each `from` replaced by its `to`.
    pub fn tank(&self, name: &str, changes: &[(&str, &str)]) -> PathBuf {
        let mut text = TANK.to_owned();
        for (from, to) in changes {
            assert!(text.contains(from), "the tank has no {from:?}");
            text = text.replacen(from, to, 1);
        }
        self.write(name, &text)
    }

    /// The tank's case until `end_time` \[s\], with so many sub-steps of the solids.
    pub fn tank_to(&self, end_time: f64, substeps: Option<u32>) -> PathBuf {
        let end = format!("end_time_s = {end_time}");
        let stepping = substeps.map_or_else(String::new, |count| format!("\nsubsteps = {count}"));
        let solid = format!("[solid]{stepping}");
        self.tank("tank.toml", &[("end_time_s = 0.002", &end), ("[solid]", &solid)])
    }

    /// Water in space with a free rigid ball and a clamped elastic post, until `end_time` \[s\].
    pub fn space_to(&self, end_time: f64) -> PathBuf {
        let text = TANK_IN_SPACE.replacen("end_time_s = 0.03", &format!("end_time_s = {end_time}"), 1);
        self.write(&format!("tank_3d_{end_time}.toml"), &text)
    }

    /// The tank's case until `end_time` \[s\] for [`crate::idle::Idle`] solvers, which show other particles than the case has.
    pub fn tank_for_idle(&self, end_time: f64) -> PathBuf {
        let end = format!("end_time_s = {end_time}");
        let warn = "[ledger]\naction = \"warn\"\n[solid]";
        self.tank("tank.toml", &[("end_time_s = 0.002", &end), ("[solid]", warn)])
    }

    /// The coarse drifting-body case cut to `end_time` \[s\], with lines that start with a key replaced.
    pub fn coarse(&self, end_time: f64, replace: &[(&str, &str)]) -> PathBuf {
        let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../cases/drifting_body_coarse.toml");
        let text = std::fs::read_to_string(shipped).unwrap();
        let mut lines: Vec<String> = Vec::new();
        for line in text.lines() {
            if line.starts_with("end_time_s") {
                lines.push(format!("end_time_s = {end_time}"));
            } else if let Some((_, new)) = replace.iter().find(|(key, _)| line.starts_with(key)) {
                lines.push((*new).to_owned());
            } else if !line.starts_with("picture_times_s") {
                lines.push(line.to_owned());
            }
        }
        self.write("case.toml", &lines.join("\n"))
    }

    /// The shipped case `name`, each `from` replaced by its `to`.
    pub fn shipped(&self, name: &str, changes: &[(&str, &str)]) -> PathBuf {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let mut text = std::fs::read_to_string(root.join(format!("cases/{name}.toml"))).unwrap();
        for (from, to) in changes {
            assert!(text.contains(from), "{name} has no {from:?}");
            text = text.replace(from, to);
        }
        // Words of a command are sought beside the case.
        let solvers = std::fs::canonicalize(root.join("solvers")).unwrap();
        let text = text.replace("../solvers", solvers.to_str().unwrap());
        self.write(&format!("{name}.toml"), &text)
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(&self.program);
        command.args(arguments);
        command
    }

    /// Calls the program and waits for its end.
    pub fn call(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    /// Runs `case` into the folder `name`, which must succeed; returns the summary.
    pub fn run(&self, case: &Path, name: &str, further: &[&str]) -> Value {
        let out = self.path(name);
        let mut arguments = vec!["run", text(case), "--quiet", "--out", text(&out)];
        arguments.extend(further);
        let output = self.call(&arguments);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        self.summary(name)
    }

    /// The summary in the folder `name`.
    pub fn summary(&self, name: &str) -> Value {
        serde_json::from_slice(&std::fs::read(self.path(name).join("summary.json")).unwrap()).unwrap()
    }

    /// Calls the program, which must fail with `code` and a message that holds every one of `words`.
    pub fn refused(&self, arguments: &[&str], code: i32, words: &[&str]) {
        let output = self.call(arguments);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {message}");
        for word in words {
            assert!(message.contains(word), "{arguments:?}: no {word:?} in\n{message}");
        }
    }

    /// Calls `run` on `case`, as [`Bench::refused`]; no results may look complete.
    pub fn run_refused(&self, case: &Path, further: &[&str], code: i32, words: &[&str]) {
        let out = self.path("refused");
        let mut arguments = vec!["run", text(case), "--quiet", "--force", "--out", text(&out)];
        arguments.extend(further);
        self.refused(&arguments, code, words);
        assert!(!out.join("summary.json").exists());
    }

    /// Calls `check` and `run` on `case`: both must call the case wrong with every one of `words`.
    pub fn case_refused(&self, case: &Path, words: &[&str]) {
        self.refused(&["check", text(case)], 2, words);
        self.run_refused(case, &[], 2, words);
        assert!(!self.path("refused").exists(), "a wrong case leaves no results");
    }

    /// Starts a run of `case` into the folder `name` and waits until steps have been taken.
    pub fn start(&self, case: &Path, name: &str) -> Running {
        let out = self.path(name);
        let child = self
            .command(&["run", text(case), "--quiet", "--out", text(&out)])
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut running = Running { child, servers: Vec::new() };
        // Snapshots are written in their order: with the second one some steps are done on both sides.
        let snapshots = out.join("snapshots");
        let of = |side: &str| {
            let names = std::fs::read_dir(&snapshots).into_iter().flatten().flatten();
            let names = names.map(|entry| entry.file_name().to_string_lossy().into_owned());
            names.filter(|name| name.starts_with(side) && name.ends_with(".vtp")).count()
        };
        soon("the second snapshot", || of("fluid") > 1 && of("solid") > 1);
        running.servers = children_of(running.child.id());
        running
    }
}

/// A run in progress.
#[derive(Debug)]
pub struct Running {
    child: Child,
    /// Process ids of the servers that it started, and of their guards.
    pub servers: Vec<u32>,
}

/// Sends a signal such as `INT` to a process.
pub fn signal(name: &str, process: u32) {
    let process = process.to_string();
    assert!(Command::new("kill").args([&format!("-{name}"), &process]).status().unwrap().success());
}

impl Running {
    /// Sends a signal such as `INT` to the coordinator.
    pub fn signal(&self, name: &str) {
        signal(name, self.child.id());
    }

    /// Waits for the coordinator's end; returns its status and what it wrote to stderr.
    pub fn end(&mut self) -> (ExitStatus, String) {
        let mut status = None;
        soon("the coordinator's end", || {
            status = self.child.try_wait().unwrap();
            status.is_some()
        });
        let message = std::io::read_to_string(self.child.stderr.take().unwrap()).unwrap();
        (status.unwrap(), message)
    }

    /// Waits until no server is left.
    pub fn servers_end(&self) {
        assert!(!self.servers.is_empty());
        for server in &self.servers {
            soon(&format!("the end of process {server}"), || !runs(*server));
        }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // Ended already in a test that passes.
        drop(self.child.kill());
        drop(self.child.wait());
    }
}

/// Looks at every `look` whether `run` has written its first frame to the results in `out`, or has ended.
pub fn wait_for_first_frame(out: &Path, run: &mut Child, look: Duration) {
    let frame = out.join("snapshots/fluid_00000000.vtp");
    let started = Instant::now();
    while !frame.exists() && run.try_wait().unwrap().is_none() {
        assert!(started.elapsed() < 4 * SOON, "no first frame");
        std::thread::sleep(look);
    }
}

/// Looks whether `out` holds a checkpoint; fails instead of hanging.
pub fn wait_for_checkpoint(out: &Path) {
    soon("a checkpoint", || out.join("checkpoints").exists() && !kept(out).is_empty());
}

/// Checkpoint folders of the results in `out`, oldest first.
pub fn kept(out: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(out.join("checkpoints")).unwrap().flatten();
    let names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
    let mut names: Vec<String> = names.filter(|name| name.starts_with("step_")).collect();
    names.sort();
    names
}

/// `path` as an argument.
pub fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// Waits until `reached`; fails instead of hanging.
pub fn soon(what: &str, mut reached: impl FnMut() -> bool) {
    let started = Instant::now();
    while !reached() {
        assert!(started.elapsed() < SOON, "{what} does not come");
        std::thread::sleep(LOOK);
    }
}

/// State letter and parent of a process, from `/proc`.
fn stat(process: u32) -> Option<(String, u32)> {
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // The name in parentheses may hold anything.
    let mut rest = stat.rsplit_once(')')?.1.split_whitespace();
    Some((rest.next()?.to_owned(), rest.next()?.parse().ok()?))
}

/// Words by which a process was started, from `/proc`; empty for one that is gone.
pub fn command_line(process: u32) -> String {
    let words = std::fs::read(format!("/proc/{process}/cmdline")).unwrap_or_default();
    String::from_utf8_lossy(&words).replace('\0', " ")
}

/// Whether a process runs; one that only waits to be reaped does not.
pub fn runs(process: u32) -> bool {
    stat(process).is_some_and(|(state, _)| state != "Z" && state != "X")
}

/// Child processes of `parent`.
pub fn children_of(parent: u32) -> Vec<u32> {
    let processes = std::fs::read_dir("/proc").unwrap().flatten();
    processes
        .filter_map(|entry| entry.file_name().to_str()?.parse().ok())
        .filter(|process| stat(*process).is_some_and(|(_, of)| of == parent))
        .collect()
}

/// Digests of the final states of fluid and solid; `null` for a side that is not there.
pub fn digests(summary: &Value) -> [Value; 2] {
    ["fluid", "solid"].map(|side| summary[side]["state_digest"].clone())
}

/// Values of the last and the first row of `probes.csv` in `folder` by column.
pub fn probe_rows(folder: &Path) -> [Vec<(String, f64)>; 2] {
    let table = std::fs::read_to_string(folder.join("probes.csv")).unwrap();
    let mut lines = table.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let rows: Vec<&str> = lines.collect();
    [rows[0], rows[rows.len() - 1]].map(|row| {
        let values = row.split(',').map(|value| value.parse().unwrap());
        names.iter().map(|name| (*name).to_owned()).zip(values).collect()
    })
}
