//! Case files that are made to hurt, each through `check` in a process of its own: it must accept or refuse them soon and
//! with little memory. Those that it accepts may be run for a while and must end in order, too.

mod made;
mod values;

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use coordinator::results::process::Process;
use tempfile::TempDir;

/// Exit codes of `check`: accepted, or refused as a mistake of the case.
const CHECKED: [i32; 2] = [0, 2];
/// Exit codes of a run that ends in order: also a server that refuses, physics that breaks down, a failed balance.
const RUN: [i32; 5] = [0, 2, 4, 5, 6];
/// A process that takes longer is ended.
const HANGS: Duration = Duration::from_secs(30);
/// A run that takes longer is ended, and in order as far as it came.
const LONG_ENOUGH: Duration = Duration::from_secs(3);
/// Time between looks at a process.
const LOOK: Duration = Duration::from_millis(1);

/// What every case is held to.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Longest time of a check.
    pub time: Duration,
    /// Largest address space \[bytes\]; more cannot be allocated.
    pub memory: u64,
}

/// A case file to be checked.
#[derive(Clone, Debug)]
pub struct Mutant {
    /// What was done to it.
    pub name: String,
    /// Its text.
    pub text: Vec<u8>,
}

/// What a process did.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The case.
    pub name: String,
    /// Exit code; nothing when it was ended by a signal.
    pub code: Option<i32>,
    /// Whether it was ended since it took too long.
    pub ended: bool,
    /// How long it took.
    pub time: Duration,
    /// Most memory that was seen \[bytes\].
    pub memory: u64,
    /// Whether what it printed acts on a terminal.
    pub acts: bool,
    /// Bytes that it printed.
    pub printed: u64,
}

/// What was found about all cases.
#[derive(Clone, Debug, Default)]
pub struct Findings {
    /// Checks of all cases, slowest first.
    pub checks: Vec<Outcome>,
    /// Runs of accepted cases.
    pub runs: Vec<Outcome>,
    /// What did not end as it must, in words.
    pub faults: Vec<String>,
}

impl Findings {
    /// The check that took most memory.
    pub fn largest(&self) -> Option<&Outcome> {
        self.checks.iter().max_by_key(|check| check.memory)
    }

    /// Number of cases that `check` accepts.
    pub fn accepted(&self) -> usize {
        self.checks.iter().filter(|check| check.code == Some(0)).count()
    }
}

/// All cases in the folder of this value, and the program under test.
#[derive(Debug)]
pub struct Mutants {
    folder: TempDir,
    program: PathBuf,
    mutants: Vec<Mutant>,
}

impl Mutants {
    /// Every case for `program`, of the replaced values every `stride`-th one.
    pub fn new(program: &Path, stride: usize) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let mut mutants = made::all(folder.path());
        mutants.extend(values::replaced().into_iter().step_by(stride.max(1)));
        Self { folder, program: program.canonicalize().unwrap(), mutants }
    }

    /// Number of cases.
    pub fn count(&self) -> usize {
        self.mutants.len()
    }

    /// Checks all cases by `workers` at a time, and runs those that are accepted if `running`.
    pub fn judge(&self, limits: Limits, workers: usize, running: bool) -> Findings {
        let next = AtomicUsize::new(0);
        let found = Mutex::new(Findings::default());
        std::thread::scope(|scope| {
            for _ in 0..workers.max(1) {
                scope.spawn(|| {
                    while let Some(k) =
                        Some(next.fetch_add(1, Ordering::Relaxed)).filter(|k| *k < self.count())
                    {
                        let (check, run) = self.judge_one(k, limits, running);
                        let mut found = found.lock().unwrap();
                        found.faults.extend(faults(&check, limits, "check", &CHECKED));
                        let unlimited = Limits { time: HANGS, ..limits };
                        found.faults.extend(run.iter().filter_map(|run| faults(run, unlimited, "run", &RUN)));
                        found.checks.push(check);
                        found.runs.extend(run);
                    }
                });
            }
        });
        let mut found = found.into_inner().unwrap();
        found.checks.sort_by_key(|check| std::cmp::Reverse(check.time));
        found
    }

    fn judge_one(&self, k: usize, limits: Limits, running: bool) -> (Outcome, Option<Outcome>) {
        let mutant = &self.mutants[k];
        let case = self.folder.path().join(format!("mutant_{k}.toml"));
        std::fs::write(&case, &mutant.text).unwrap();
        let case = case.to_str().unwrap();
        let check = self.process(k, &mutant.name, &["check", case], limits.memory, HANGS);
        let run = (running && check.code == Some(0)).then(|| {
            let out = self.folder.path().join(format!("out_{k}"));
            let words =
                ["run", case, "--in-process", "--threads", "1", "--quiet", "--out", out.to_str().unwrap()];
            // Results of a case may be large; its memory is no concern of checking.
            let run = self.process(k, &mutant.name, &words, 8 << 30, LONG_ENOUGH);
            drop(std::fs::remove_dir_all(out));
            run
        });
        drop(std::fs::remove_file(case));
        (check, run)
    }

    /// The program with `words`, in an address space of `memory` bytes, ended after `longest`.
    fn process(&self, k: usize, name: &str, words: &[&str], memory: u64, longest: Duration) -> Outcome {
        let output = self.folder.path().join(format!("output_{k}"));
        let file = File::create(&output).unwrap();
        let limited = format!("ulimit -v {}; exec \"$@\"", memory >> 10);
        let mut command = Command::new("sh");
        command.args(["-c", &limited, "sh"]).arg(&self.program).args(words);
        // Each thread reserves address space; two do the work of any number.
        command.env("RAYON_NUM_THREADS", "2").env_remove("CLICOLOR_FORCE");
        command.stdin(Stdio::null()).stdout(file.try_clone().unwrap()).stderr(file);
        let start = Instant::now();
        let mut child = command.spawn().unwrap();
        let id = child.id();
        let is_running = || {
            let running = std::fs::read_link(format!("/proc/{id}/exe"));
            running.is_ok_and(|running| running == self.program)
        };
        let (mut memory, mut ended) = (0, false);
        let status = loop {
            if let Some(status) = child.try_wait().unwrap() {
                break status;
            }
            // Before its `exec`, a child shares the memory of this process, which other tests fill.
            if is_running() {
                memory = memory.max(Process::of(id).peak_memory_bytes.unwrap_or(0));
            }
            if !ended && start.elapsed() > longest {
                ended = true;
                child.kill().unwrap();
            }
            std::thread::sleep(LOOK);
        };
        let time = start.elapsed();
        let printed = std::fs::read(&output).unwrap();
        drop(std::fs::remove_file(output));
        let acts = |c: char| c.is_control() && c != '\n';
        Outcome {
            name: name.to_owned(),
            code: status.code(),
            ended,
            time,
            memory,
            acts: String::from_utf8_lossy(&printed).contains(acts),
            printed: printed.len() as u64,
        }
    }
}

/// What is wrong with an outcome, if anything.
fn faults(outcome: &Outcome, limits: Limits, what: &str, codes: &[i32]) -> Option<String> {
    // A list of mistakes with their lines, or of a few thousand bodies.
    const MOST_PRINTED: u64 = 4 << 20;
    let Outcome { name, code, time, memory, acts, printed, ended } = outcome;
    let in_order = code.is_some_and(|code| codes.contains(&code)) || (*ended && what == "run");
    let fault = if !in_order {
        format!("ends with {code:?}{}", if *ended { ", too late" } else { "" })
    } else if *time > limits.time {
        format!("takes {:.1} s", time.as_secs_f64())
    } else if what == "check" && *memory > limits.memory {
        format!("takes {} MiB", memory >> 20)
    } else if *acts {
        "prints control characters".into()
    } else if *printed > MOST_PRINTED {
        format!("prints {printed} bytes")
    } else {
        return None;
    };
    Some(format!("{what} of {name}: {fault}"))
}
