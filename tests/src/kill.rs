//! Kills a fluid server, a solid server or the coordinator somewhere in a run, and compares what comes out in the end with
//! the results of an undisturbed run, bit for bit.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::bench::{Bench, children_of, command_line, text, wait_for_first_frame};

/// Steps between checkpoints.
const EVERY_STEPS: &str = "40";
/// Time between looks.
const LOOK: Duration = Duration::from_micros(500);
/// A run that has not ended by then hangs.
const HANGS: Duration = Duration::from_secs(600);

/// Who is killed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Victim {
    /// The fluid server.
    Fluid,
    /// The solid server.
    Solid,
    /// The coordinator; the run goes on by `resume`.
    Coordinator,
}

/// What a number of trials has shown.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// Trials with a kill in the middle of the run.
    pub trials: u32,
    /// Trials that ended with the undisturbed run's bits.
    pub equal: u32,
    /// Trials in which the coordinator was killed before the first checkpoint, so that the run was started anew.
    pub anew: u32,
    /// What went wrong in the others.
    pub problems: Vec<String>,
}

/// A generator of numbers that are random enough for times of death (xorshift64*).
#[derive(Clone, Debug)]
pub struct Dice(u64);

impl Dice {
    /// Dice that fall alike for the same `seed`.
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    /// A number in [0, 1).
    pub fn fraction(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        // The upper 53 bits: a whole number that a double holds exactly.
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / 2f64.powi(53)
    }
}

/// One case and the undisturbed run of it.
#[derive(Debug)]
pub struct Trials {
    bench: Bench,
    program: PathBuf,
    case: PathBuf,
    duration: Duration,
}

impl Trials {
    /// Runs the case that `write` puts on a bench, undisturbed.
    pub fn new(program: &Path, write: impl FnOnce(&Bench) -> PathBuf) -> Self {
        let bench = Bench::new(text(program));
        let case = write(&bench);
        let mut trials = Self { bench, program: program.into(), case, duration: Duration::ZERO };
        let mut run = trials.start("whole");
        wait_for_first_frame(&trials.bench.path("whole"), &mut run, LOOK);
        let started = Instant::now();
        let status = wait(&mut run);
        assert_eq!(status, Some(0), "the undisturbed run");
        trials.duration = started.elapsed();
        trials
    }

    fn start(&self, name: &str) -> Child {
        let out = self.bench.path(name);
        let mut command = Command::new(&self.program);
        command.args(["run", text(&self.case), "--quiet", "--threads", "1", "--force", "--out", text(&out)]);
        command.args(["--checkpoint-every-steps", EVERY_STEPS]);
        command.stderr(Stdio::piped()).spawn().unwrap()
    }

    /// Kills `victim` after a fraction `when` of the undisturbed run's time and sees the run to its end; `None` when it
    /// had ended before.
    fn one(&self, victim: Victim, when: f64, tally: &mut Tally) -> Option<Result<(), String>> {
        // `--force` leaves no old frame that could be taken for a new one.
        drop(std::fs::remove_dir_all(self.bench.path("killed")));
        let mut run = self.start("killed");
        wait_for_first_frame(&self.bench.path("killed"), &mut run, LOOK);
        std::thread::sleep(self.duration.mul_f64(when));
        let target = match victim {
            Victim::Coordinator => Some(run.id()),
            Victim::Fluid => server_of(run.id(), "node-fluid"),
            Victim::Solid => server_of(run.id(), "node-solid"),
        };
        let hit = target.is_some_and(|process| run.try_wait().unwrap().is_none() && kill(process));
        let mut status = wait(&mut run);
        if !hit {
            return None;
        }
        let mut said = std::io::read_to_string(run.stderr.take().unwrap()).unwrap_or_default();
        if victim == Victim::Coordinator && status.is_none() {
            let out = self.bench.path("killed");
            let output =
                self.bench.call(&["resume", text(&out), "--quiet", "--checkpoint-every-steps", EVERY_STEPS]);
            status = output.status.code();
            said = String::from_utf8_lossy(&output.stderr).into_owned();
            if status == Some(2) && said.contains("anew") || said.contains("has no folder") {
                tally.anew += 1;
                status = wait(&mut self.start("killed"));
            }
        }
        if status != Some(0) {
            return Some(Err(format!("ended with {status:?}: {said}")));
        }
        Some(same_results(&self.bench.path("whole"), &self.bench.path("killed")))
    }

    /// Makes `times` trials, each victim in turn.
    pub fn run(&self, times: u32, dice: &mut Dice, tally: &mut Tally) {
        let victims = [Victim::Fluid, Victim::Solid, Victim::Coordinator];
        let mut missed = 0;
        let mut done = 0;
        while done < times {
            let victim = victims[usize::try_from(done % 3).unwrap_or(0)];
            let when = dice.fraction();
            let Some(result) = self.one(victim, when, tally) else {
                missed += 1;
                assert!(missed < 10 * times + 20, "runs end before they can be hit");
                continue;
            };
            done += 1;
            tally.trials += 1;
            match result {
                Ok(()) => tally.equal += 1,
                Err(problem) => tally.problems.push(format!("{victim:?} at {when:.3}: {problem}")),
            }
        }
    }
}

/// Whether two folders of results hold the same tables, frames and final states, byte for byte.
///
/// # Errors
/// The first difference.
pub fn same_results(expected: &Path, found: &Path) -> Result<(), String> {
    let mut names: Vec<String> = ["probes.csv", "ledger.csv"].map(String::from).to_vec();
    for folder in ["snapshots", "final"] {
        let list = |root: &Path| -> Result<Vec<String>, String> {
            let entries = std::fs::read_dir(root.join(folder)).map_err(|e| format!("{folder}: {e}"))?;
            let mut names: Vec<String> =
                entries.flatten().map(|e| format!("{folder}/{}", e.file_name().to_string_lossy())).collect();
            names.sort();
            Ok(names)
        };
        let (a, b) = (list(expected)?, list(found)?);
        if a != b {
            let mut text = format!("other files in {folder}:");
            for name in a.iter().filter(|name| !b.contains(name)) {
                let _ = write!(text, " -{name}");
            }
            for name in b.iter().filter(|name| !a.contains(name)) {
                let _ = write!(text, " +{name}");
            }
            return Err(text);
        }
        names.extend(a);
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

/// The server of a coordinator, by the hidden sub-command that it was started with.
pub fn server_of(coordinator: u32, command: &str) -> Option<u32> {
    children_of(coordinator).into_iter().find(|child| command_line(*child).contains(command))
}

fn kill(process: u32) -> bool {
    Command::new("kill").args(["-KILL", &process.to_string()]).status().is_ok_and(|status| status.success())
}

/// Waits for the end of `run`; its exit code, `None` for one that was killed.
fn wait(run: &mut Child) -> Option<i32> {
    let started = Instant::now();
    loop {
        if let Some(status) = run.try_wait().unwrap() {
            return status.code();
        }
        if started.elapsed() > HANGS {
            drop(run.kill());
            return Some(-1);
        }
        std::thread::sleep(LOOK);
    }
}
