//! Steps, stages and the one rule that both sides use for step size, end and outputs, Eq. (30)-(31).

use serde::{Deserialize, Serialize};

use crate::setup::{OutputPlan, StepPolicy, TimePlan};

/// Stage of the predictor-corrector scheme.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Stage {
    /// φⁿ⁺¹ᐟ² = φⁿ + Δt/2 F(φⁿ), Eq. (30).
    Predictor,
    /// φⁿ⁺¹ = φⁿ + Δt F(φⁿ⁺¹ᐟ²), Eq. (31).
    Corrector,
}

impl Stage {
    /// Both stages in order.
    pub const BOTH: [Stage; 2] = [Stage::Predictor, Stage::Corrector];

    /// Fraction of Δt by which this stage advances from φⁿ.
    pub fn step_fraction(self) -> f64 {
        match self {
            Stage::Predictor => 0.5,
            Stage::Corrector => 1.0,
        }
    }

    /// Where in the step the stage state lies, as a fraction of Δt.
    pub fn state_offset(self) -> f64 {
        match self {
            Stage::Predictor => 0.0,
            Stage::Corrector => 0.5,
        }
    }
}

impl std::fmt::Display for Stage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Stage::Predictor => "predictor",
            Stage::Corrector => "corrector",
        })
    }
}

/// A half-step: which step, which stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct StepStage {
    /// Number of completed steps before this one.
    pub step: u64,
    /// Stage within the step.
    pub stage: Stage,
}

impl StepStage {
    /// The first half-step of a run.
    pub const FIRST: StepStage = StepStage { step: 0, stage: Stage::Predictor };

    /// The half-step after this one.
    pub fn next(self) -> Self {
        match self.stage {
            Stage::Predictor => Self { stage: Stage::Corrector, ..self },
            Stage::Corrector => Self { step: self.step + 1, stage: Stage::Predictor },
        }
    }
}

impl std::fmt::Display for StepStage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "step {} {}", self.step, self.stage)
    }
}

/// A half-step with its times.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StageTime {
    /// Which half-step.
    pub at: StepStage,
    /// tⁿ \[s\], start of the step.
    pub step_start: f64,
    /// Δt of the step \[s\].
    pub time_step: f64,
}

impl StageTime {
    /// Time of the state at which this stage evaluates \[s\]: tⁿ or tⁿ⁺¹ᐟ².
    pub fn state_time(&self) -> f64 {
        self.step_start + self.at.stage.state_offset() * self.time_step
    }

    /// Time of the state that this stage makes \[s\]: tⁿ⁺¹ᐟ² or tⁿ⁺¹.
    pub fn target_time(&self) -> f64 {
        self.step_start + self.duration()
    }

    /// Time by which this stage advances from φⁿ \[s\]: Δt/2 or Δt.
    pub fn duration(&self) -> f64 {
        self.at.stage.step_fraction() * self.time_step
    }
}

/// Which outputs are due at a step boundary.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OutputsDue {
    /// A snapshot.
    pub snapshot: bool,
    /// A probe row.
    pub probes: bool,
}

/// Exact times of probes are met where their interval is at least this many steps.
pub const STEPS_PER_EXACT_PROBE: f64 = 5.0;

/// Part of a step that absorbs the round-off of n·Δt against a decimal time.
const TIME_SLACK: f64 = 1e-6;

/// Time and step of a run, advanced by the same arithmetic on both sides.
#[derive(Clone, Debug, PartialEq)]
pub struct Clock {
    plan: TimePlan,
    outputs: OutputPlan,
    state: ClockState,
}

/// A clock at a boundary, for a checkpoint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClockState {
    /// Completed steps.
    pub step: u64,
    /// Time tⁿ \[s\].
    pub time: f64,
    /// Δt of the step to come \[s\].
    pub time_step: f64,
    /// Δt of the step to come as the solvers' limits allow it, not shortened to meet an exact time \[s\].
    pub allowed_step: f64,
    /// What counted as elapsed at the boundary before this one \[s\]: each output is due exactly once.
    pub elapsed_before: f64,
}

impl Clock {
    /// A clock that continues from `state`. The end time may be another than in the run that was saved.
    pub fn resumed(plan: TimePlan, outputs: OutputPlan, state: &ClockState) -> Self {
        Self { plan, outputs, state: *state }
    }

    /// What [`Clock::resumed`] needs.
    pub fn state(&self) -> ClockState {
        self.state
    }

    /// A clock at the start; `limit` is the smaller of both solvers' stated limits \[s\] for the first step.
    pub fn new(plan: TimePlan, outputs: OutputPlan, limit: f64) -> Self {
        let allowed_step = match plan.step {
            StepPolicy::Fixed { time_step } => time_step,
            StepPolicy::Adaptive { factor, maximum, .. } => (factor * limit).min(maximum),
        };
        let state = ClockState {
            step: 0,
            time: plan.start_time,
            time_step: allowed_step,
            allowed_step,
            elapsed_before: 0.0,
        };
        let mut clock = Self { plan, outputs, state };
        clock.state.time_step = clock.shortened();
        clock
    }

    /// Completed steps.
    pub fn step(&self) -> u64 {
        self.state.step
    }

    /// Time tⁿ \[s\].
    pub fn time(&self) -> f64 {
        self.state.time
    }

    /// Δt of the step to come \[s\].
    pub fn time_step(&self) -> f64 {
        self.state.time_step
    }

    /// Times of `stage` in the step to come.
    pub fn stage(&self, stage: Stage) -> StageTime {
        StageTime {
            at: StepStage { step: self.state.step, stage },
            step_start: self.state.time,
            time_step: self.state.time_step,
        }
    }

    /// Ends the step; `limit` is the smaller of both solvers' stated limits \[s\] for the next.
    pub fn advance(&mut self, limit: f64) {
        self.state.elapsed_before = self.elapsed();
        self.state.step += 1;
        match self.plan.step {
            // A product has no drift; step counts stay far below 2^53.
            StepPolicy::Fixed { time_step } => {
                self.state.time = self.plan.start_time + self.state.step as f64 * time_step
            }
            StepPolicy::Adaptive { factor, maximum, growth, .. } => {
                let reached = self.state.time + self.state.time_step;
                let mark = self.next_exact_time();
                let met = (mark - reached).abs() <= TIME_SLACK * self.state.time_step;
                self.state.time = if met { mark } else { reached };
                self.state.allowed_step = (factor * limit).min(maximum).min(growth * self.state.allowed_step);
                self.state.time_step = self.shortened();
            }
        }
    }

    /// Δt of the step to come \[s\]: the allowed one, or as much less as makes all steps up to the next exact time alike.
    ///
    /// A few short steps before each exact time would feed the stiffest vibrations of solids: velocity Verlet is unstable
    /// where the step varies in time with them, well below its limit.
    fn shortened(&self) -> f64 {
        let allowed = self.state.allowed_step;
        let left = self.next_exact_time() - self.state.time;
        // Without the slack, a rest of 3.0000000001 steps would become four.
        let steps = (left / allowed - TIME_SLACK).ceil().max(1.0);
        if steps.is_finite() { (left / steps).min(allowed) } else { allowed }
    }

    /// The first exact time after tⁿ \[s\]; infinite where there is none.
    fn next_exact_time(&self) -> f64 {
        let StepPolicy::Adaptive { exact: Some(exact_times), .. } = &self.plan.step else {
            return f64::INFINITY;
        };
        let (start, now) = (self.plan.start_time, self.state.time);
        let after = now + TIME_SLACK * self.state.allowed_step;
        let listed = exact_times.iter().chain(&self.outputs.snapshot_times).copied();
        let multiple = |interval: f64| {
            let count = ((after - start) / interval).floor();
            // The quotient may round to either side of a whole number.
            let candidates = [0.0, 1.0, 2.0].map(|more| start + (count + more) * interval);
            candidates.into_iter().find(|time| *time > after).unwrap_or(f64::INFINITY)
        };
        let probes = self
            .outputs
            .probe_interval
            .filter(|interval| *interval >= STEPS_PER_EXACT_PROBE * self.state.allowed_step);
        let regular = [self.outputs.snapshot_interval, probes].into_iter().flatten().map(multiple);
        listed.filter(|time| *time > after).chain(regular).fold(f64::INFINITY, f64::min)
    }

    /// Whether the end of the run is reached.
    pub fn finished(&self) -> bool {
        self.reached(self.plan.end_time)
    }

    /// Fraction of the simulated time that is done, in [0, 1].
    pub fn progress(&self) -> f64 {
        let span = self.plan.end_time - self.plan.start_time;
        if span > 0.0 { ((self.state.time - self.plan.start_time) / span).clamp(0.0, 1.0) } else { 1.0 }
    }

    /// Outputs due at this boundary; first and last boundary take both.
    pub fn outputs_due(&self) -> OutputsDue {
        let always = self.state.step == 0 || self.finished();
        OutputsDue {
            snapshot: always || self.crossed(self.outputs.snapshot_interval) || self.passed_snapshot_time(),
            probes: always || self.crossed(self.outputs.probe_interval),
        }
    }

    fn reached(&self, time: f64) -> bool {
        self.elapsed() >= time - self.plan.start_time
    }

    /// Time since the start \[s\], with the slack.
    fn elapsed(&self) -> f64 {
        self.state.time - self.plan.start_time + TIME_SLACK * self.state.time_step
    }

    /// Whether a multiple of `interval` after the start lies in (previous boundary, this boundary].
    fn crossed(&self, interval: Option<f64>) -> bool {
        interval.is_some_and(|interval| {
            (self.elapsed() / interval).floor() > (self.state.elapsed_before / interval).floor()
        })
    }

    /// Whether a listed time of a snapshot lies in (previous boundary, this boundary].
    fn passed_snapshot_time(&self) -> bool {
        let passed = self.state.elapsed_before..self.elapsed();
        self.outputs.snapshot_times.iter().any(|time| {
            let after = time - self.plan.start_time;
            after > passed.start && after <= passed.end
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clock(step: StepPolicy) -> Clock {
        let plan = TimePlan { start_time: 0.0, end_time: 0.1, step };
        let outputs = OutputPlan {
            snapshot_interval: Some(0.05),
            probe_interval: Some(0.003),
            snapshot_times: vec![0.0, 0.0421],
        };
        Clock::new(plan, outputs, 1e-3)
    }

    /// Limits that wander between 0.3 and 1.7 ms.
    fn wandering(step: u64) -> f64 {
        1e-3 * (1.0 + 0.7 * (0.37 * step as f64).sin())
    }

    fn exact(times: &[f64]) -> StepPolicy {
        StepPolicy::Adaptive { factor: 0.5, maximum: 1.0, growth: 1.2, exact: Some(times.to_vec()) }
    }

    #[test]
    fn fixed_steps_end_exactly_and_take_each_output_once() {
        let mut clock = clock(StepPolicy::Fixed { time_step: 1e-3 });
        let (mut snapshots, mut probes) = (0, 0);
        loop {
            let due = clock.outputs_due();
            snapshots += u32::from(due.snapshot);
            probes += u32::from(due.probes);
            if clock.finished() {
                break;
            }
            clock.advance(f64::INFINITY);
        }
        assert_eq!(clock.step(), 100);
        // 0, 43 ms (the first boundary from 42.1 ms on), 50 ms and the end.
        assert_eq!(snapshots, 4);
        // 0, 33 multiples of 3 ms up to 99 ms, and the end.
        assert_eq!(probes, 35);
    }

    #[test]
    fn adaptive_steps_shrink_at_once_and_grow_slowly() {
        let policy = StepPolicy::Adaptive { factor: 0.5, maximum: 1e-2, growth: 1.1, exact: None };
        let mut clock = clock(policy);
        assert_eq!(clock.time_step(), 5e-4);
        clock.advance(2e-4);
        assert_eq!(clock.time_step(), 1e-4);
        clock.advance(1.0);
        assert!((clock.time_step() - 1.1e-4).abs() < 1e-18);
        assert!((clock.time() - 6e-4).abs() < 1e-18);
    }

    #[test]
    fn adaptive_steps_meet_exact_times_and_are_shortened_alike() {
        let mut clock = clock(exact(&[0.0421, 0.1, 0.07]));
        let mut boundaries = vec![0.0];
        let (mut snapshots, mut probes, mut short) = (Vec::new(), Vec::new(), 0);
        loop {
            let due = clock.outputs_due();
            if due.snapshot {
                snapshots.push(clock.time());
            }
            if due.probes {
                probes.push(clock.time());
            }
            if clock.finished() {
                break;
            }
            let state = clock.state();
            assert!(state.time_step <= state.allowed_step);
            // The shortest: two are made of a little more than one, and the limit grows by 1.2 between them.
            short += u32::from(state.time_step < 0.499 / 1.2 * state.allowed_step);
            clock.advance(wandering(clock.step()));
            boundaries.push(clock.time());
        }
        assert_eq!(snapshots, [0.0, 0.0421, 0.05, 0.1]);
        assert!(boundaries.contains(&0.07), "a time of no output is met");
        // Only where the limit falls below a fifth of the probes' interval shortly before one of their times: at most
        // once in each of its periods of 17 steps.
        assert!(short as usize <= boundaries.len() / 17, "{short} of {} steps", boundaries.len());
        // Where five steps exceed 3 ms, a row comes late, but never twice.
        assert_eq!(probes.len(), 35);
        let met =
            probes.iter().filter(|time| (*time / 0.003 - (*time / 0.003).round()).abs() < 1e-12).count();
        assert!((15..35).contains(&met), "{met}");
    }

    #[test]
    fn steps_of_one_limit_are_alike_up_to_each_exact_time() {
        let mut clock = clock(exact(&[0.1]));
        let mut steps = Vec::new();
        while !clock.finished() {
            steps.push(clock.time_step());
            clock.advance(0.94e-3);
        }
        assert!(steps.iter().skip(1).all(|step| *step <= 0.47e-3));
        // Probes every 3 ms: seven steps each. Others only around the picture at 42.1 ms, the snapshot at 50 ms and the end;
        // with short steps before each of the 33 rows of probes there would be 69 changes.
        let changes = steps.windows(2).filter(|pair| (pair[1] / pair[0] - 1.0).abs() > 1e-6).count();
        assert!(changes <= 10, "{changes} changes in {} steps", steps.len());
    }

    #[test]
    fn what_is_asked_for_from_outside_changes_no_step() {
        let mut whole = clock(exact(&[0.1]));
        let mut shorter = whole.clone();
        shorter.plan.end_time = 0.03337;
        while !shorter.finished() {
            let limit = wandering(shorter.step());
            shorter.advance(limit);
            whole.advance(limit);
            assert_eq!(shorter.state(), whole.state());
        }
        assert!(shorter.time() > 0.03337, "the end from outside is not met exactly");
        let mut resumed = Clock::resumed(whole.plan.clone(), whole.outputs.clone(), &shorter.state());
        while !resumed.finished() {
            let limit = wandering(resumed.step());
            resumed.advance(limit);
            whole.advance(limit);
        }
        assert_eq!(resumed.state(), whole.state());
        assert_eq!(whole.time(), 0.1);
    }

    #[test]
    fn an_interval_below_a_step_shortens_every_step() {
        let plan = TimePlan { start_time: 0.3, end_time: 0.3004, step: exact(&[]) };
        let outputs = OutputPlan { snapshot_interval: Some(1e-4), ..OutputPlan::default() };
        let mut clock = Clock::new(plan, outputs, 1e-3);
        let mut times = vec![clock.time()];
        while !clock.finished() {
            clock.advance(1e-3);
            times.push(clock.time());
        }
        assert_eq!(times, [0.3, 0.3 + 1e-4, 0.3 + 2e-4, 0.3 + 3.0 * 1e-4, 0.3 + 4.0 * 1e-4]);
    }

    #[test]
    fn half_steps_follow_each_other() {
        let second = StepStage::FIRST.next();
        assert_eq!(second, StepStage { step: 0, stage: Stage::Corrector });
        assert_eq!(second.next(), StepStage { step: 1, stage: Stage::Predictor });
    }
}
