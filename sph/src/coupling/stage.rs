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
#[derive(Clone, Copy, Debug, PartialEq)]
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

/// Time and step of a run, advanced by the same arithmetic on both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    plan: TimePlan,
    outputs: OutputPlan,
    step: u64,
    time: f64,
    time_step: f64,
    /// What counted as elapsed at the boundary before this one \[s\]: each output is due exactly once.
    elapsed_before: f64,
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
    /// What counted as elapsed at the boundary before this one \[s\], which decides what outputs are due.
    pub elapsed_before: f64,
}

impl Clock {
    /// A clock that continues from `state`. The end time may be another than in the run that was saved.
    pub fn resumed(plan: TimePlan, outputs: OutputPlan, state: &ClockState) -> Self {
        let ClockState { step, time, time_step, elapsed_before } = *state;
        Self { plan, outputs, step, time, time_step, elapsed_before }
    }

    /// What [`Clock::resumed`] needs.
    pub fn state(&self) -> ClockState {
        let Self { step, time, time_step, elapsed_before, .. } = *self;
        ClockState { step, time, time_step, elapsed_before }
    }

    /// A clock at the start; `limit` is the smaller of both solvers' stated limits \[s\] for the first step.
    pub fn new(plan: TimePlan, outputs: OutputPlan, limit: f64) -> Self {
        let time_step = match plan.step {
            StepPolicy::Fixed { time_step } => time_step,
            StepPolicy::Adaptive { factor, maximum, .. } => (factor * limit).min(maximum),
        };
        Self { plan, outputs, step: 0, time: plan.start_time, time_step, elapsed_before: 0.0 }
    }

    /// Completed steps.
    pub fn step(&self) -> u64 {
        self.step
    }

    /// Time tⁿ \[s\].
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Δt of the step to come \[s\].
    pub fn time_step(&self) -> f64 {
        self.time_step
    }

    /// Times of `stage` in the step to come.
    pub fn stage(&self, stage: Stage) -> StageTime {
        StageTime {
            at: StepStage { step: self.step, stage },
            step_start: self.time,
            time_step: self.time_step,
        }
    }

    /// Ends the step; `limit` is the smaller of both solvers' stated limits \[s\] for the next.
    pub fn advance(&mut self, limit: f64) {
        self.elapsed_before = self.elapsed();
        self.step += 1;
        match self.plan.step {
            // A product has no drift; step counts stay far below 2^53.
            StepPolicy::Fixed { time_step } => {
                self.time = self.plan.start_time + self.step as f64 * time_step
            }
            StepPolicy::Adaptive { factor, maximum, growth } => {
                self.time += self.time_step;
                self.time_step = (factor * limit).min(maximum).min(growth * self.time_step);
            }
        }
    }

    /// Whether the end of the run is reached.
    pub fn finished(&self) -> bool {
        self.reached(self.plan.end_time)
    }

    /// Fraction of the simulated time that is done, in [0, 1].
    pub fn progress(&self) -> f64 {
        let span = self.plan.end_time - self.plan.start_time;
        if span > 0.0 { ((self.time - self.plan.start_time) / span).clamp(0.0, 1.0) } else { 1.0 }
    }

    /// Outputs due at this boundary; first and last boundary take both.
    pub fn outputs_due(&self) -> OutputsDue {
        let always = self.step == 0 || self.finished();
        OutputsDue {
            snapshot: always || self.crossed(self.outputs.snapshot_interval),
            probes: always || self.crossed(self.outputs.probe_interval),
        }
    }

    fn reached(&self, time: f64) -> bool {
        self.elapsed() >= time - self.plan.start_time
    }

    /// Time since the start \[s\]; a millionth of a step absorbs the round-off of n·Δt against a decimal time.
    fn elapsed(&self) -> f64 {
        self.time - self.plan.start_time + 1e-6 * self.time_step
    }

    /// Whether a multiple of `interval` after the start lies in (previous boundary, this boundary].
    fn crossed(&self, interval: Option<f64>) -> bool {
        interval.is_some_and(|interval| {
            (self.elapsed() / interval).floor() > (self.elapsed_before / interval).floor()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clock(step: StepPolicy) -> Clock {
        let plan = TimePlan { start_time: 0.0, end_time: 0.1, step };
        let outputs = OutputPlan { snapshot_interval: Some(0.05), probe_interval: Some(0.003) };
        Clock::new(plan, outputs, 1e-3)
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
        assert_eq!(snapshots, 3);
        // 0, 33 multiples of 3 ms up to 99 ms, and the end.
        assert_eq!(probes, 35);
    }

    #[test]
    fn adaptive_steps_shrink_at_once_and_grow_slowly() {
        let policy = StepPolicy::Adaptive { factor: 0.5, maximum: 1e-2, growth: 1.1 };
        let mut clock = clock(policy);
        assert_eq!(clock.time_step(), 5e-4);
        clock.advance(2e-4);
        assert_eq!(clock.time_step(), 1e-4);
        clock.advance(1.0);
        assert!((clock.time_step() - 1.1e-4).abs() < 1e-18);
        assert!((clock.time() - 6e-4).abs() < 1e-18);
    }

    #[test]
    fn half_steps_follow_each_other() {
        let second = StepStage::FIRST.next();
        assert_eq!(second, StepStage { step: 0, stage: Stage::Corrector });
        assert_eq!(second.next(), StepStage { step: 1, stage: Stage::Predictor });
    }
}
