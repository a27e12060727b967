//! Kills servers and coordinators at chosen moments of a run, sees the run to its end, and compares what comes out with the
//! results of an undisturbed run, bit for bit.

mod compare;
mod moments;
mod trial;

use std::fmt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};

use crate::bench::{Bench, children_of, command_line, text, wait_for_first_frame};
use crate::random::RandomNumbers;

pub use compare::{same_files, same_results};
pub use moments::{Aim, Hit, MOMENTS, Moment};

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
    /// The coordinator; the run continues by `resume`.
    Coordinator,
    /// Both servers.
    Both,
    /// Both servers and the coordinator.
    All,
}

impl Victim {
    /// All of them.
    pub const EACH: [Self; 5] = [Self::Fluid, Self::Solid, Self::Coordinator, Self::Both, Self::All];

    /// Those of the run of `coordinator` that are there.
    fn processes(self, coordinator: u32) -> Vec<u32> {
        let (fluid, solid) = (server_of(coordinator, "node-fluid"), server_of(coordinator, "node-solid"));
        let found = match self {
            Self::Fluid => [fluid, None, None],
            Self::Solid => [solid, None, None],
            Self::Coordinator => [Some(coordinator), None, None],
            Self::Both => [fluid, solid, None],
            Self::All => [Some(coordinator), fluid, solid],
        };
        found.into_iter().flatten().collect()
    }
}

/// What became of the trials of one moment.
#[derive(Clone, Debug, Default)]
pub struct Count {
    /// Trials.
    pub trials: u32,
    /// Trials that ended with the undisturbed run's bits and nothing stale.
    pub equal: u32,
    /// Of these, trials killed before the first checkpoint, which was said, so that the run was repeated.
    pub repeated: u32,
    /// Kills in them; one that hits several processes at once counts once.
    pub kills: u32,
}

/// What a number of trials has shown.
#[derive(Clone, Debug)]
pub struct Tally {
    /// By moment, as in [`MOMENTS`].
    pub moments: Vec<Count>,
    /// What went wrong.
    pub problems: Vec<String>,
}

impl Default for Tally {
    fn default() -> Self {
        Self { moments: vec![Count::default(); MOMENTS.len()], problems: Vec::new() }
    }
}

impl Tally {
    /// All moments together.
    pub fn sum(&self) -> Count {
        self.moments.iter().fold(Count::default(), |sum, count| Count {
            trials: sum.trials + count.trials,
            equal: sum.equal + count.equal,
            repeated: sum.repeated + count.repeated,
            kills: sum.kills + count.kills,
        })
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let line = |f: &mut fmt::Formatter<'_>, name: &str, count: &Count| {
            let Count { trials, equal, repeated, kills } = count;
            writeln!(f, "  {name}: {equal} of {trials} equal, {repeated} repeated, {kills} kills")
        };
        for (moment, count) in MOMENTS.iter().zip(&self.moments).filter(|(_, count)| count.trials > 0) {
            line(f, moment.name, count)?;
        }
        line(f, "together", &self.sum())?;
        self.problems.iter().try_for_each(|problem| writeln!(f, "  {problem}"))
    }
}

/// One case and the undisturbed run of it.
#[derive(Debug)]
pub struct Trials {
    bench: Bench,
    program: PathBuf,
    case: PathBuf,
    duration: Duration,
    /// Completed steps at the end.
    last_step: u64,
}

impl Trials {
    /// Runs the case that `write` puts on a bench, undisturbed.
    pub fn new(program: &Path, write: impl FnOnce(&Bench) -> PathBuf) -> Self {
        let bench = Bench::new(text(program));
        let case = write(&bench);
        let mut trials =
            Self { bench, program: program.into(), case, duration: Duration::ZERO, last_step: 0 };
        let mut run = trials.start("whole", None);
        wait_for_first_frame(&trials.bench.path("whole"), &mut run, LOOK);
        let started = Instant::now();
        let status = wait(&mut run);
        assert_eq!(status, Some(0), "the undisturbed run");
        trials.duration = started.elapsed();
        trials.last_step = trials.bench.summary("whole")["steps"].as_u64().unwrap();
        trials
    }

    fn start(&self, name: &str, record: Option<&Path>) -> Child {
        let out = self.bench.path(name);
        let mut command = Command::new(&self.program);
        command.args(["run", text(&self.case), "--quiet", "--threads", "1", "--force", "--out", text(&out)]);
        command.args(["--checkpoint-every-steps", EVERY_STEPS]);
        command.args(record.into_iter().flat_map(|file| ["--record", text(file)]));
        command.stderr(Stdio::piped()).spawn().unwrap()
    }

    fn resume(&self, name: &str) -> Child {
        let out = self.bench.path(name);
        let mut command = Command::new(&self.program);
        command.args(["resume", text(&out), "--quiet", "--threads", "1"]);
        command.args(["--checkpoint-every-steps", EVERY_STEPS]);
        command.stderr(Stdio::piped()).spawn().unwrap()
    }

    /// Makes `times` trials: the moments with `only` in their name in turn, and the victims of each in turn.
    pub fn run(&self, times: u32, only: &str, random: &mut RandomNumbers, tally: &mut Tally) {
        let chosen: Vec<usize> = (0..MOMENTS.len()).filter(|k| MOMENTS[*k].name.contains(only)).collect();
        assert!(!chosen.is_empty(), "no moment has `{only}` in its name");
        let (mut done, mut missed) = (0, 0);
        while done < times {
            let place = chosen[usize::try_from(done).unwrap_or(0) % chosen.len()];
            let moment = &MOMENTS[place];
            let turn = usize::try_from(tally.moments[place].trials).unwrap_or(0);
            let victim = moment.victims[turn % moment.victims.len()];
            let Some(made) = self.make(moment, victim, random) else {
                missed += 1;
                assert!(missed < 10 * times + 20, "runs end before they can be hit");
                continue;
            };
            done += 1;
            let count = &mut tally.moments[place];
            count.trials += 1;
            count.kills += made.kills;
            match made.outcome {
                Ok(()) => {
                    count.equal += 1;
                    count.repeated += u32::from(made.repeated);
                }
                Err(problem) => tally.problems.push(format!("{}, {victim:?}: {problem}", moment.name)),
            }
        }
    }
}

/// The server of a coordinator, by the hidden sub-command that it was started with.
pub fn server_of(coordinator: u32, command: &str) -> Option<u32> {
    children_of(coordinator).into_iter().find(|child| command_line(*child).contains(command))
}

/// Kills all of `processes` at once; whether any was there.
fn kill(processes: &[u32]) -> bool {
    let killed = processes.iter().filter_map(|process| Pid::from_raw(process.cast_signed()));
    // All of them are tried, whatever became of one.
    killed.map(|pid| kill_process(pid, Signal::KILL).is_ok()).fold(false, |any, one| any | one)
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
