//! Figures of a run so far, for progress and summary.

use serde::{Deserialize, Serialize};
use sph::coupling::solver::{Counts, Role};

use super::matched_step::MatchedStep;
use super::summary::StepSizes;

/// Breaches that the summary quotes.
const QUOTED_BREACHES: usize = 10;

/// What is known of one side of the run.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct SideTally {
    /// Facts that the solver counted.
    pub counts: Counts,
    /// SHA-256 of all particles at the end, as hex.
    pub state_digest: String,
    /// Sum of the wall time of its steps \[s\].
    pub step_seconds: f64,
    /// Part of it spent waiting for the partner \[s\].
    pub waited_seconds: f64,
}

/// Figures of the run so far.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Tally {
    /// Steps that all participants have completed.
    pub steps: u64,
    /// Time at their end \[s\].
    pub time: f64,
    /// Smallest and largest step.
    pub step_sizes: Option<StepSizes>,
    /// Failed checks.
    pub breaches: u64,
    /// The first of them in words.
    pub first_breaches: Vec<String>,
    /// Fluid and solid.
    pub sides: [SideTally; 2],
    /// Iterations of half-steps.
    pub iterations: Iterations,
}

/// Iterations of implicitly coupled half-steps.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Iterations {
    /// Sum over all steps.
    pub sum: u64,
    /// Most in a step.
    pub largest: u32,
    /// Steps that reached the limit before they had converged.
    pub unconverged: u64,
}

impl Tally {
    /// Adds a step that all participants have completed.
    pub fn add(&mut self, step: &MatchedStep) {
        let report = step.any();
        self.steps = report.step + 1;
        self.time = report.end_time;
        self.step_sizes = Some(StepSizes::with(self.step_sizes, report.time_step));
        for role in [Role::Fluid, Role::Solid] {
            if let Some(report) = step.of(role) {
                let side = &mut self.sides[role.index()];
                side.step_seconds += report.elapsed;
                side.waited_seconds += report.waited;
            }
        }
        let iterations = &mut self.iterations;
        iterations.sum += u64::from(report.iterations);
        iterations.largest = iterations.largest.max(report.iterations);
        iterations.unconverged += u64::from(report.unconverged);
        self.breaches += step.breaches.len() as u64;
        for (side, breach) in &step.breaches {
            if self.first_breaches.len() < QUOTED_BREACHES {
                let whose = side.map(|role| format!("{role}: ")).unwrap_or_default();
                self.first_breaches.push(format!("{whose}{breach}"));
            }
        }
    }
}
