//! One trial: a run is hit, resumed as often as need be, and judged at its end.

use std::path::Path;
use std::process::Child;
use std::time::{Duration, Instant};

use crate::random::RandomNumbers;

use super::{Aim, Hit, LOOK, Moment, Trials, Victim, kill, same_files, same_results, wait};
use crate::bench::{children_of, kept, runs, soon};

/// Most times that a run is resumed.
const MOST_RESUMES: u32 = 6;
/// A file that has not come by then, while the run lasts, does not come.
const COMES: Duration = Duration::from_secs(120);

/// What came of a trial.
pub(super) struct Made {
    /// Kills that hit.
    pub kills: u32,
    /// Whether it was killed before the first checkpoint, so that the run was repeated.
    pub repeated: bool,
    /// What is wrong with the results.
    pub outcome: Result<(), String>,
}

/// A trial under way.
struct Trial<'a> {
    trials: &'a Trials,
    run: Child,
    /// Servers and guards that were seen.
    processes: Vec<u32>,
    kills: u32,
}

impl Trials {
    /// Makes a trial; `None` when the run had ended before its first kill.
    pub(super) fn make(&self, moment: &Moment, victim: Victim, random: &mut RandomNumbers) -> Option<Made> {
        let out = self.bench.path("killed");
        // No old file may be taken for a new one.
        drop(std::fs::remove_dir_all(&out));
        let frames = self.bench.path("frames");
        drop(std::fs::remove_file(&frames));
        let record = moment.record.then_some(frames.as_path());
        let mut trial =
            Trial { trials: self, run: self.start("killed", record), processes: Vec::new(), kills: 0 };
        let mut hits = moment.hits.iter();
        let first = hits.next()?;
        if !trial.hit(*first, victim, &out, random) {
            wait(&mut trial.run);
            return None;
        }
        for hit in hits {
            trial.continue_if_killed();
            trial.hit(*hit, victim, &out, random);
        }
        let (repeated, mut outcome) = trial.see_through(&out);
        trial.no_process_is_left();
        outcome = outcome.and_then(|()| same_results(&self.bench.path("whole"), &out));
        outcome = outcome.and_then(|()| same_files(&self.bench.path("whole"), &out));
        Some(Made { kills: trial.kills, repeated, outcome })
    }
}

impl Trial<'_> {
    /// Waits for the moment of `hit` and kills; whether there was anybody left to be killed.
    fn hit(&mut self, hit: Hit, victim: Victim, out: &Path, random: &mut RandomNumbers) -> bool {
        let victim = hit.victim.unwrap_or(victim);
        if !self.wait_for(hit.aim, out, random) {
            return false;
        }
        self.processes.extend(children_of(self.run.id()));
        let targets = victim.processes(self.run.id());
        let hits = self.run.try_wait().unwrap().is_none() && kill(&targets);
        self.kills += u32::from(hits);
        hits
    }

    /// Waits for the moment of `aim`; whether the run lasts until then.
    fn wait_for(&mut self, aim: Aim, out: &Path, random: &mut RandomNumbers) -> bool {
        match aim {
            Aim::Part(percent) => {
                let frame = out.join("snapshots/fluid_00000000.vtp");
                let there = self.wait_until(LOOK, || frame.exists());
                std::thread::sleep(
                    self.trials.duration.mul_f64(f64::from(percent) / 100.0 * random.fraction()),
                );
                there
            }
            Aim::Within(most) => {
                std::thread::sleep(Duration::from_millis(u64::from(most)).mul_f64(random.fraction()));
                true
            }
            Aim::HalfCheckpoint => {
                // One of the first ten.
                for _ in 0..=(10.0 * random.fraction()) as u32 {
                    let half = || {
                        let names =
                            std::fs::read_dir(out.join("checkpoints")).into_iter().flatten().flatten();
                        names.into_iter().any(|entry| {
                            let name = entry.file_name();
                            name.to_str()
                                .is_some_and(|name| name.starts_with("step_") && name.ends_with(".partial"))
                        })
                    };
                    if !(self.wait_until(Duration::ZERO, || !half()) && self.wait_until(Duration::ZERO, half))
                    {
                        return false;
                    }
                }
                true
            }
            Aim::Begun(name) | Aim::Complete(name) => {
                let width = if name.starts_with("checkpoints") { 12 } else { 8 };
                let name = name.replace("LAST", &format!("{:0width$}", self.trials.last_step));
                let (whole, half) = (out.join(&name), out.join(format!("{name}.partial")));
                let begun = || matches!(aim, Aim::Begun(_)) && half.exists();
                let there = self.wait_until(Duration::ZERO, || begun() || whole.exists());
                // Somewhere in what comes with it.
                std::thread::sleep(Duration::from_millis(3).mul_f64(random.fraction()));
                there
            }
        }
    }

    /// Looks at every `look` until `reached` or the run has ended; whether it was reached.
    fn wait_until(&mut self, look: Duration, mut reached: impl FnMut() -> bool) -> bool {
        let started = Instant::now();
        loop {
            if reached() {
                return true;
            }
            if self.run.try_wait().unwrap().is_some() || started.elapsed() > COMES {
                return false;
            }
            std::thread::sleep(look);
        }
    }

    /// Resumes the run if its coordinator is dead.
    fn continue_if_killed(&mut self) {
        // A signal that was sent takes its moment.
        let started = Instant::now();
        while started.elapsed() < Duration::from_millis(20) {
            if self.run.try_wait().unwrap().is_some() {
                self.run = self.trials.resume("killed");
                return;
            }
            std::thread::sleep(LOOK);
        }
    }

    /// Sees the run to its end; whether it had to be repeated, and what went wrong.
    fn see_through(&mut self, out: &Path) -> (bool, Result<(), String>) {
        let mut repeated = false;
        for _ in 0..MOST_RESUMES {
            let status = wait(&mut self.run);
            let said = self.run.stderr.take().map(|from| std::io::read_to_string(from).unwrap_or_default());
            let said = said.unwrap_or_default();
            let complete = |name: &String| !name.ends_with(".partial");
            let any = out.join("checkpoints").is_dir() && kept(out).iter().any(complete);
            match status {
                Some(0) => return (repeated, Ok(())),
                // Killed, or servers were lost while they were being started.
                None => self.run = self.trials.resume("killed"),
                Some(4 | 7) if any && said.contains("error") => self.run = self.trials.resume("killed"),
                Some(2..=4 | 7) if !any && is_clear(&said) && !repeated => {
                    repeated = true;
                    self.run = self.trials.start("killed", None);
                }
                other => return (repeated, Err(format!("ended with {other:?}: {said}"))),
            }
        }
        (repeated, Err("is not over after so many resumes".into()))
    }

    /// That all servers have ended that were seen.
    fn no_process_is_left(&self) {
        for process in &self.processes {
            soon(&format!("the end of process {process}"), || !runs(*process));
        }
    }
}

/// Whether what was said of a run that was killed before its first checkpoint names what happened and what to do.
fn is_clear(said: &str) -> bool {
    let nothing_to_resume = said.contains("no good checkpoint") && said.contains("run --force")
        || said.contains("has no folder `checkpoints`")
        || said.contains("give the output folder of a run");
    let lost_at_the_start =
        ["the fluid", "the solid", "fluid server", "solid server"].iter().any(|who| said.contains(who))
            && said.contains("error");
    nothing_to_resume || lost_at_the_start
}
