//! The time step of a case and the number of steps: a run must be stable, and it must end.

use sph::coupling::solver::Role;

use super::Case;
use super::errors::{CaseError, ErrorList};
use super::file::run::StepTable;
use super::limits::{self, RECOMMENDED_FRACTION, StepLimit};
use crate::failure::Failure;

/// Most steps of a run: at a millisecond each they take 30 years.
const MOST_STEPS: f64 = 1e12;

/// Shortest step as a fraction of the times of a run: below, adding it to a time is mostly rounding.
const SHORTEST_FRACTION: f64 = 1e-13;

/// How many steps a run takes, and what decides it.
struct Count {
    /// Steps, estimated when adaptive.
    steps: f64,
    /// Their size \[s\].
    size: f64,
    /// The key that decides the size, with its value.
    decided_by: String,
    /// What to change.
    remedy: &'static str,
}

impl Case {
    /// Refuses a fixed step above the stability limit, unless the case overrides it, and more steps than any run can take.
    pub(super) fn check_time_step(&self, errors: &ErrorList) {
        let time = &self.file.time;
        let ready = time.intact
            && self.file.fluid.as_ref().is_none_or(|fluid| fluid.intact)
            && self.file.solid.as_ref().is_none_or(|s| s.intact && s.bodies.iter().all(|body| body.intact));
        if !ready {
            return;
        }
        let limits = self.step_limits();
        if let StepTable::Fixed { time_step_s } = &time.step
            && let Some(limit) = limits::governing(&limits, |limit| limit.stability)
            && time_step_s.value > time.limit_factor.value * limit.stability
        {
            let largest = time.limit_factor.value * limit.stability;
            let error =
                CaseError::new(&time_step_s.place, "above the stability limit").value(time_step_s.value);
            let recommended =
                limits::governing(&limits, |l| l.recommended).map_or(largest, |l| l.recommended);
            errors.add(
                error.allowed(format!("at most {largest:.4e} s ({})", limit.origin)).hint(format!(
                    "use {recommended:.2e} s, or raise `time.limit_factor` to try a larger step"
                )),
            );
        }
        let end = &time.end_time_s;
        let count = self.count_of_steps(&limits, end.value);
        if let Err(problem) = count.check(time.start_time_s, end.value) {
            let error = CaseError::new(&end.place, problem).value(end.value);
            errors.add(error.allowed(allowed()).hint(count.remedy));
        }
    }

    /// Refuses a fixed step above `limit` \[s\], which the solver of `role` states for the start, unless the case overrides
    /// it.
    ///
    /// # Errors
    /// When the step is too long.
    pub fn check_stated_limit(&self, role: Role, limit: f64) -> Result<(), Failure> {
        let time = &self.file.time;
        let StepTable::Fixed { time_step_s } = &time.step else { return Ok(()) };
        let (step, largest) = (time_step_s.value, time.limit_factor.value * limit);
        // The same formula may be rounded in another order here and there.
        if step <= largest * (1.0 + 1e-9) {
            return Ok(());
        }
        Err(Failure::input(format!(
            "`time.step.time_step_s` = {step:e} s: above the stability limit of {largest:.4e} s that the {role} solver \
             states; use {:.2e} s, or raise `time.limit_factor` to try a larger step",
            RECOMMENDED_FRACTION * limit
        )))
    }

    /// Steps of a run that ends at `end` \[s\].
    fn count_of_steps(&self, limits: &[StepLimit], end: f64) -> Count {
        let time = &self.file.time;
        let span = end - time.start_time_s;
        match &time.step {
            StepTable::Fixed { time_step_s } => Count {
                steps: span / time_step_s.value,
                size: time_step_s.value,
                decided_by: format!("`time.step.time_step_s` = {:e} s", time_step_s.value),
                remedy: "lower `time.end_time_s` or raise `time.step.time_step_s`",
            },
            StepTable::Adaptive { factor, maximum_s, .. } => {
                let limit = limits::governing(limits, |limit| limit.stability);
                let stable = limit.map_or(f64::INFINITY, |limit| factor.value * limit.stability);
                match limit.filter(|_| stable < *maximum_s) {
                    Some(limit) => Count {
                        steps: span / stable,
                        size: stable,
                        decided_by: format!(
                            "`time.step.factor` = {:e} of the stable step of {:e} s ({})",
                            factor.value, limit.stability, limit.origin
                        ),
                        remedy: "lower `time.end_time_s`, or change what makes the stable step so short",
                    },
                    None => Count {
                        steps: span / maximum_s,
                        size: *maximum_s,
                        decided_by: format!("`time.step.maximum_s` = {maximum_s:e} s"),
                        remedy: "lower `time.end_time_s` or raise `time.step.maximum_s`",
                    },
                }
            }
        }
    }

    /// Lets the run end at `time` \[s\] instead.
    ///
    /// # Errors
    /// When the time is not finite, lies before the start, or is so late that the run would never get there.
    pub fn set_end_time(&mut self, time: f64) -> Result<(), String> {
        let start = self.file.time.start_time_s;
        if !time.is_finite() || time < start {
            return Err(format!("end time {time:e} s: must be a time of {start:e} s or later"));
        }
        let count = self.count_of_steps(&self.step_limits(), time);
        count
            .check(start, time)
            .map_err(|problem| format!("end time {time:e} s: {problem}; {}", allowed()))?;
        let end = std::mem::replace(&mut self.file.time.end_time_s.value, time);
        // Else the former end would stay a time of a picture.
        if self.file.outputs.has_default_pictures(start, end) {
            self.file.outputs.set_default_pictures(start, time);
            self.outputs.picture_times.clone_from(&self.file.outputs.picture_times_s);
            self.outputs.plan = self.file.outputs.plan();
        }
        Ok(())
    }
}

fn allowed() -> String {
    format!("at most {MOST_STEPS:e} steps, each at least {SHORTEST_FRACTION:e} of the times of the run")
}

impl Count {
    fn check(&self, start: f64, end: f64) -> Result<(), String> {
        let by = &self.decided_by;
        if self.steps.is_nan() || self.steps > MOST_STEPS {
            return Err(format!("with {by} the run takes {:.1e} steps", self.steps));
        }
        if end > start && self.size < SHORTEST_FRACTION * start.abs().max(end.abs()) {
            return Err(format!("with {by} a step is lost in the rounding of times from {start:e} s on"));
        }
        Ok(())
    }
}
