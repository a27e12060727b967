//! Finds solvers that give signs of life but complete no step.

use std::time::{Duration, Instant};

use proto::Phase;
use sph::solver::Role;

use super::Control;
use crate::failure::{Failure, Kind};
use crate::lockstep::MatchedStep;
use crate::participants::Participants;

/// A step may take this many times the longest one so far: list builds, other programs and snapshots fit in.
const FACTOR: u32 = 100;
/// Before the first step nothing is measured: it may take this many times the least deadline.
const FIRST_FACTOR: u32 = 5;

/// Clock of the steps of a run.
#[derive(Clone, Copy, Debug)]
pub(super) struct StepWatch {
    least: Duration,
    longest: Option<Duration>,
    last: Instant,
}

impl StepWatch {
    /// A clock with a deadline of at least `least`.
    pub(super) fn new(least: Duration) -> Self {
        Self { least, longest: None, last: Instant::now() }
    }

    /// A step was completed by all.
    pub(super) fn completed(&mut self, step: &MatchedStep) {
        let took = [&step.fluid, &step.solid].into_iter().flatten().map(|report| report.elapsed);
        let took = Duration::try_from_secs_f64(took.fold(0.0, f64::max)).unwrap_or_default();
        self.longest = Some(self.longest.map_or(took, |longest| longest.max(took)));
        self.last = Instant::now();
    }

    /// No step is due now: the time starts anew.
    pub(super) fn rest(&mut self) {
        self.last = Instant::now();
    }

    /// The deadline, by the steps measured so far.
    fn limit(&self) -> Duration {
        match self.longest {
            Some(longest) => self.least.max(longest.saturating_mul(FACTOR)),
            None => self.least.saturating_mul(FIRST_FACTOR),
        }
    }

    /// The deadline, when it has passed at `now`.
    pub(super) fn overdue(&self, now: Instant) -> Option<Duration> {
        let limit = self.limit();
        (now.saturating_duration_since(self.last) > limit).then_some(limit)
    }
}

impl Control {
    /// Takes solvers for lost that complete no step within the deadline, whatever signs of life they give.
    pub(super) fn find_stalled(&mut self, participants: &Participants) {
        let given_up = self.failure.is_some() || !self.faults.is_empty();
        let due = self.lockstep.completed() < self.granted && self.held.len() < self.running.len();
        if given_up || !due || self.taking.is_some() {
            self.steps.rest();
            return;
        }
        let Some(limit) = self.steps.overdue(Instant::now()) else { return };
        let waits = |role: &Role| {
            participants.latest_beat(*role).is_some_and(|beat| beat.phase == Phase::WaitingForPartner)
        };
        let (waiting, mut guilty): (Vec<Role>, Vec<Role>) = self.running.iter().copied().partition(waits);
        if guilty.is_empty() {
            // Each waits for the other: the way between them is stuck.
            guilty = waiting;
        }
        for role in guilty {
            let doing =
                participants.latest_beat(role).map_or_else(String::new, |beat| format!("; it was {beat}"));
            let text = format!(
                "it has completed no step for {:.0} s, the deadline by the steps before, though it may give signs of \
                 life{doing}; `[deadlines] step_s` sets the least deadline",
                limit.as_secs_f64()
            );
            self.lost(role, Failure::new(Kind::Lost, text), participants);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_deadline_grows_with_the_longest_step_and_starts_anew_after_a_rest() {
        let second = Duration::from_secs(1);
        let mut watch = StepWatch::new(10 * second);
        let start = watch.last;
        assert_eq!(watch.overdue(start + 49 * second), None, "nothing is measured before the first step");
        assert_eq!(watch.overdue(start + 51 * second), Some(50 * second));
        watch.longest = Some(second / 100);
        assert_eq!(watch.overdue(start + 11 * second), Some(10 * second), "short steps: the least deadline");
        watch.longest = Some(second);
        assert_eq!(watch.overdue(start + 99 * second), None, "a slow solver is not taken for one that hangs");
        assert_eq!(watch.overdue(start + 101 * second), Some(100 * second));
        watch.rest();
        assert_eq!(watch.overdue(watch.last + 99 * second), None);
    }
}
