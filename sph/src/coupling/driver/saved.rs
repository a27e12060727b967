//! A run at a step boundary: clock and solver, saved and restored.

use super::messages::Checkpoint;
use crate::coupling::saved::{RestoreError, SavedState};
use crate::coupling::solver::Solver;
use crate::coupling::stage::ClockState;

const CLOCK_STEP: &str = "driver.step";
const CLOCK_TIMES: &str = "driver.times";
const ALLOWED_STEP: &str = "driver.allowed_step";

/// Takes `solver` back to a boundary that was saved by [`Command::Checkpoint`](super::Command::Checkpoint); returns where the run continues.
///
/// # Errors
/// When an array is missing or does not fit the solver's set-up; the solver is then of no further use.
pub fn restore<S: Solver + ?Sized>(solver: &mut S, state: &SavedState) -> Result<ClockState, RestoreError> {
    let [step] = state.u64s(CLOCK_STEP)?;
    let [time, time_step, elapsed_before] = state.numbers(CLOCK_TIMES)?;
    if time_step <= 0.0 {
        return Err(RestoreError::new(CLOCK_TIMES, format!("time step {time_step} s, must be positive")));
    }
    let [allowed_step] = state.numbers(ALLOWED_STEP)?;
    solver.restore(state)?;
    Ok(ClockState { step, time, time_step, allowed_step, elapsed_before })
}

/// Saves what [`restore`] takes.
pub fn save<S: Solver + ?Sized>(solver: &S, clock: &ClockState) -> Checkpoint {
    let ClockState { step, time, time_step, allowed_step, elapsed_before } = *clock;
    let mut state = SavedState::default();
    state.put_u64(CLOCK_STEP, [step]);
    state.put_f64(CLOCK_TIMES, [time, time_step, elapsed_before]);
    state.put_f64(ALLOWED_STEP, [allowed_step]);
    solver.save(&mut state);
    Checkpoint { step, time, time_step, state }
}
