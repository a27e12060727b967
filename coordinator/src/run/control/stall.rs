//! Finds solvers that give signs of life but complete no step.

use std::cmp::Ordering;
use std::time::{Duration, Instant};

use proto::Phase;
use sph::coupling::driver::Command;
use sph::coupling::solver::Role;
use sph::coupling::stage::{Stage, StepStage};

use super::Control;
use crate::failure::{Failure, Kind};
use crate::results::matched_step::MatchedStep;
use crate::run::participants::Participants;

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

    /// No step is due now: the time starts again.
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
    /// Treats solvers as lost that complete no step within the deadline, whatever signs of life they give.
    pub(super) fn find_stalled(&mut self, participants: &Participants) {
        let aborting = self.failure.is_some() || !self.faults.is_empty();
        let due = self.lockstep.completed() < self.granted && self.paused_at.len() < self.running.len();
        if aborting || !due || self.taking.is_some() {
            self.steps.rest();
            return;
        }
        let Some(limit) = self.steps.overdue(Instant::now()) else { return };
        let waits = |role: &Role| {
            participants.latest_beat(*role).is_some_and(|beat| beat.phase == Phase::WaitingForPartner)
        };
        let stalled: Vec<Role> = self.running.iter().copied().filter(|role| !waits(role)).collect();
        if stalled.is_empty() {
            let completed = self.lockstep.completed();
            // Signs of life may be late as well.
            let awaited = |role| {
                let awaited = participants.latest_beat(role).and_then(|beat| beat.awaited);
                awaited.filter(|at| at.step >= completed)
            };
            return self.separated(missing([Role::Fluid, Role::Solid].map(awaited)), limit, participants);
        }
        for role in stalled {
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

    /// Treats both solvers as lost: each waits for the other, and `missing` says for what.
    fn separated(&mut self, missing: String, limit: Duration, participants: &Participants) {
        self.lost.append(&mut self.running);
        self.fail(Failure::new(
            Kind::Lost,
            format!(
                "the solvers lost each other after {} completed steps: each has waited for the other for {:.0} s, the \
                 deadline by the steps before; {missing}; `[deadlines] step_s` sets the least deadline",
                self.lockstep.completed(),
                limit.as_secs_f64()
            ),
        ));
        participants.command_all(Command::Abort);
    }
}

/// Which frame has not arrived, by the half-steps of the frames that fluid and solid await, as far as known.
///
/// Who waits for the later half-step has sent the frame of the earlier one, to continue.
fn missing(awaited: [Option<StepStage>; 2]) -> String {
    let order = |at: StepStage| (at.step, at.stage == Stage::Corrector);
    let lacks = |receiver: Role, at: StepStage| {
        format!("the {receiver} has not got the {}'s frame of {at}", receiver.partner())
    };
    match awaited {
        [Some(by_fluid), Some(by_solid)] => match order(by_fluid).cmp(&order(by_solid)) {
            Ordering::Less => lacks(Role::Fluid, by_fluid),
            Ordering::Greater => lacks(Role::Solid, by_solid),
            Ordering::Equal => format!("neither has got the other's frame of {by_fluid}"),
        },
        [Some(at), None] => lacks(Role::Fluid, at),
        [None, Some(at)] => lacks(Role::Solid, at),
        [None, None] => "which frame is missing is not known".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_frame_that_went_astray_is_the_earlier_one_that_is_awaited() {
        let at = |step, stage| Some(StepStage { step, stage });
        let (late, early) = (at(8, Stage::Predictor), at(7, Stage::Corrector));
        assert_eq!(missing([late, early]), "the solid has not got the fluid's frame of step 7 corrector");
        assert_eq!(missing([early, late]), "the fluid has not got the solid's frame of step 7 corrector");
        assert_eq!(missing([late, late]), "neither has got the other's frame of step 8 predictor");
        assert_eq!(missing([None, late]), "the solid has not got the fluid's frame of step 8 predictor");
        assert_eq!(missing([None; 2]), "which frame is missing is not known");
    }

    #[test]
    fn the_deadline_grows_with_the_longest_step_and_starts_again_after_a_rest() {
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
