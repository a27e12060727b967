//! Commands and events between coordinator and participant during a run.

use serde::{Deserialize, Serialize};

use crate::coupling::ledger::{EnergyReport, StageBudget};
use crate::coupling::saved::SavedState;
use crate::coupling::solver::{Counts, Fault, ParticleFields};

/// A command of the coordinator to a participant during a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Step until this many steps are completed; never lowers an earlier grant.
    GrantThrough(u64),
    /// Finish at the end of the granted steps, with outputs complete.
    Stop,
    /// Abort at once.
    Abort,
    /// Save the state at the boundary where the participant waits; changes nothing.
    Checkpoint,
    /// At the end time wait for [`Command::Stop`], so that a checkpoint can be taken there.
    Pause,
}

/// An event that a participant reports to the coordinator during a run.
// A step's report is the most frequent event by far, and a steady step allocates nothing.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// A step is complete.
    Step(StepReport),
    /// Probe values at a step boundary.
    Probes(ProbeValues),
    /// Particle fields at a step boundary.
    Snapshot(ParticleFields),
    /// The answer to [`Command::Checkpoint`].
    Checkpoint(Box<Checkpoint>),
    /// No further step is taken until [`Command::Stop`] arrives: at the end time after [`Command::Pause`], or
    /// after a breach under [`BreachAction::StopAndCheckpoint`](crate::setup::BreachAction::StopAndCheckpoint).
    Paused(Paused),
    /// The run ended in order; the last event.
    Finished(FinalReport),
    /// The run ended out of order; the last event.
    Failed(FailureReport),
}

/// Where a participant waits for [`Command::Stop`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Paused {
    /// Completed steps.
    pub step: u64,
    /// Time \[s\].
    pub time: f64,
}

/// The complete state of one side at a step boundary, before the outputs that are due there.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint {
    /// Completed steps.
    pub step: u64,
    /// Time \[s\].
    pub time: f64,
    /// Size of the next step \[s\].
    pub time_step: f64,
    /// Clock and solver.
    pub state: SavedState,
}

/// Probe values at a step boundary, in the order of the set-up.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ProbeValues {
    /// Completed steps.
    pub step: u64,
    /// Time \[s\].
    pub time: f64,
    /// Values.
    pub values: Vec<f64>,
}

/// One completed step of one side.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StepReport {
    /// Completed steps before this one.
    pub step: u64,
    /// Time at its end \[s\].
    pub end_time: f64,
    /// Its size \[s\].
    pub time_step: f64,
    /// Momentum budgets of predictor and corrector.
    pub budgets: [StageBudget; 2],
    /// Energy budget at its end, since the start of the run.
    pub energies: EnergyReport,
    /// Own and partner particles in the last frames.
    pub interface_particles: [u64; 2],
    /// Wall time of the step \[s\].
    pub elapsed: f64,
    /// Part of it spent waiting for the partner \[s\].
    pub waited: f64,
    /// Breaches that the policy lets pass.
    pub breaches: u64,
    /// Updates of the coupling points in its corrector; none with explicit coupling.
    pub iterations: u32,
    /// Whether that reached its limit before convergence.
    pub unconverged: bool,
}

/// How a run ended in order.
#[derive(Clone, Debug, PartialEq)]
pub struct FinalReport {
    /// Completed steps.
    pub step: u64,
    /// Time \[s\].
    pub time: f64,
    /// Whether the end time was reached; otherwise the run was stopped from outside.
    pub reached_end: bool,
    /// Facts of the run.
    pub counts: Counts,
    /// All particles with full precision.
    pub state: ParticleFields,
}

/// How a run ended out of order.
#[derive(Clone, Debug, PartialEq)]
pub struct FailureReport {
    /// Why.
    pub fault: Fault,
    /// Completed steps.
    pub step: u64,
    /// Time \[s\].
    pub time: f64,
    /// Facts of the run.
    pub counts: Counts,
    /// All particles as they were when it happened.
    pub state: ParticleFields,
}
