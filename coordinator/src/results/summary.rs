//! `summary.json`: verdict and figures of a run, for programs.

use std::collections::BTreeMap;
use std::io::{self, Read, Write};
use std::path::Path;

use serde::{Deserialize, Serialize};
use sph::coupling::solver::Counts;
use sph::coupling::stage::StepStage;

use crate::case::overrides::Override;

use super::energy::EnergySummary;
use super::error::OutputError;
use super::files::open_regular;
use super::files::write_file;
use super::ledger_sums::{Extremes, Largest, Work};
use super::process::Process;
use super::quality::QualityFigure;

/// Version of the layout of `summary.json`; keys are only ever added within a version.
pub const FORMAT: u32 = 1;

/// Longest summary that is read \[bytes\].
const LONGEST: u64 = 16 << 20;

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The end time was reached.
    Completed,
    /// Stopped from outside at a step boundary; outputs are complete up to there.
    Stopped,
    /// Ended by a fault; outputs hold all that was known then.
    Failed,
}

impl std::fmt::Display for Verdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Verdict::Completed => "completed",
            Verdict::Stopped => "stopped",
            Verdict::Failed => "failed",
        })
    }
}

/// Everything that `summary.json` holds.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Layout of this file, [`FORMAT`].
    pub format: u32,
    /// Title or name of the case.
    pub case: String,
    /// Name of the run.
    pub run_id: String,
    /// Number of dimensions. In three, quantities under keys that end in `_per_m` are the quantity itself, not per metre.
    pub dimensions: usize,
    /// How the run ended.
    pub verdict: Verdict,
    /// What speaks against trusting the answer, in words; empty where nothing is known to.
    pub reservations: Vec<String>,
    /// Figures of the run that judge its answer.
    pub quality: Vec<QualityFigure>,
    /// Why, in a sentence; names step, stage, particle and quantity of a fault.
    pub reason: String,
    /// Completed steps.
    pub steps: u64,
    /// Simulated time from the start to the last completed step.
    pub simulated: Span,
    /// Wall-clock time from the first grant to the last report \[s\].
    pub wall_seconds: f64,
    /// Smallest and largest size of a step; `None` when no step was completed.
    pub time_step: Option<StepSizes>,
    /// Particle-stages per second of wall-clock time, both sides together, walls not counted.
    pub particle_stages_per_second: Option<f64>,
    /// Interface ledger.
    pub ledger: LedgerSummary,
    /// Energy budget by mechanism.
    pub energy: EnergySummary,
    /// Iterated half-steps, where the case has them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub iterations: Option<IterationSummary>,
    /// The fluid side, where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fluid: Option<Participant>,
    /// The solid side, where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub solid: Option<Participant>,
    /// The coordinator's own process.
    pub coordinator: Process,
    /// Checkpoints that were taken.
    pub checkpoints: Checkpoints,
    /// Times that a lost server was started again, with the reason of each.
    pub restarts: Vec<String>,
    /// Whether all ran in one process.
    pub in_process: bool,
    /// SHA-256, as hex, of the resolved case.
    pub case_digest: String,
    /// Values that were set over the case file, in their order; empty where the case is as its file.
    pub set: Vec<Override>,
    /// Every parameter of fluid, bodies and contact by name, such as `fluid.artificial_viscosity_a`.
    pub parameters: BTreeMap<String, serde_json::Value>,
    /// Thresholds of the laws that no case sets, by name.
    pub constants: BTreeMap<String, f64>,
    /// Versions of programs and protocol by name.
    pub versions: BTreeMap<String, String>,
    /// Things that the user should know of.
    pub warnings: Vec<String>,
}

/// Checkpoints of a run, as far as this process took them.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Checkpoints {
    /// Checkpoints written.
    pub taken: u64,
    /// Bytes of the largest.
    pub largest_bytes: u64,
    /// Wall time for which solvers waited for them, sum \[s\].
    pub held_seconds: f64,
    /// Wall time until they were on the disk, sum \[s\]; the solvers continue meanwhile.
    pub written_seconds: f64,
    /// Completed steps of the last one.
    pub last_step: Option<u64>,
    /// Completed steps from which this process went on.
    pub resumed_from: Option<u64>,
}

/// A span of simulated time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Span {
    /// Start \[s\].
    pub start_s: f64,
    /// End \[s\].
    pub end_s: f64,
}

/// Smallest and largest step of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StepSizes {
    /// Smallest \[s\].
    pub smallest_s: f64,
    /// Largest \[s\].
    pub largest_s: f64,
}

impl StepSizes {
    /// `sizes` widened to hold a step of `size` \[s\].
    pub fn with(sizes: Option<Self>, size: f64) -> Self {
        match sizes {
            Some(s) => Self { smallest_s: s.smallest_s.min(size), largest_s: s.largest_s.max(size) },
            None => Self { smallest_s: size, largest_s: size },
        }
    }
}

/// Iterations of implicitly coupled half-steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct IterationSummary {
    /// Mean over all steps; `None` when no step was completed.
    pub mean: Option<f64>,
    /// Most in a step.
    pub largest: u32,
    /// Steps that reached the limit before they had converged.
    pub unsettled_steps: u64,
}

/// Results of the ledger's checks.
#[derive(Clone, Debug, Default, Serialize)]
pub struct LedgerSummary {
    /// Half-step checks that failed.
    pub breaches: u64,
    /// The first failed checks in words.
    pub first_breaches: Vec<String>,
    /// Check (a), force: |F_fluid + F_solid| over gross.
    pub largest_force_imbalance: Worst,
    /// Check (a), torque.
    pub largest_torque_imbalance: Worst,
    /// Check (b) of the fluid.
    pub largest_fluid_momentum_residual: Worst,
    /// Check (b) of the solid.
    pub largest_solid_momentum_residual: Worst,
    /// Check (b) of the fluid's angular momentum; `null` when it reported no budget, as in a periodic domain.
    pub largest_fluid_angular_momentum_residual: Option<Worst>,
    /// Check (b) of the solid's angular momentum; likewise.
    pub largest_solid_angular_momentum_residual: Option<Worst>,
    /// Energy that crossed the interface.
    pub interface_energy: InterfaceEnergy,
}

/// Energy that crossed the interface from the start to the last completed step.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct InterfaceEnergy {
    /// Work that the fluid received \[J/m\].
    pub fluid_received_j_per_m: f64,
    /// Work that the solid received \[J/m\].
    pub solid_received_j_per_m: f64,
    /// Sum of both \[J/m\]; holds the compression of the water by solids, so that it is no loss: see
    /// [`EnergySummary::interface_slip_j_per_m`].
    pub drift_j_per_m: f64,
    /// Drift over the larger of both sides' sums of |power| over time \[-\]; `null` when nothing crossed.
    pub drift_share: Option<f64>,
}

impl From<Work> for InterfaceEnergy {
    fn from(work: Work) -> Self {
        let [fluid, solid] = work.received;
        Self {
            fluid_received_j_per_m: fluid,
            solid_received_j_per_m: solid,
            drift_j_per_m: work.drift(),
            drift_share: (work.passed > 0.0).then(|| work.drift() / work.passed),
        }
    }
}

impl LedgerSummary {
    /// Failed checks, first those to quote, and the extremes and the energy that the ledger kept.
    pub fn new(breaches: u64, first_breaches: Vec<String>, extremes: &Extremes, work: Work) -> Self {
        Self {
            breaches,
            first_breaches,
            largest_force_imbalance: extremes.force.into(),
            largest_torque_imbalance: extremes.torque.into(),
            largest_fluid_momentum_residual: extremes.momentum[0].into(),
            largest_solid_momentum_residual: extremes.momentum[1].into(),
            largest_fluid_angular_momentum_residual: extremes.angular[0].map(Worst::from),
            largest_solid_angular_momentum_residual: extremes.angular[1].map(Worst::from),
            interface_energy: work.into(),
        }
    }
}

/// Worst value of a check relative to gross \[-\], and where it occurred.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Worst {
    /// The value; `null` when it is no finite number.
    pub value: Option<f64>,
    /// Half-step; `null` when every value was zero.
    pub at: Option<StepStage>,
}

impl From<Largest> for Worst {
    fn from(largest: Largest) -> Self {
        Self { value: Some(largest.value).filter(|value| value.is_finite()), at: largest.at }
    }
}

/// One side of the run.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Participant {
    /// Name and version that the solver gives itself.
    pub solver: String,
    /// Where it was reached; `in-process` where it was no process of its own.
    pub address: String,
    /// Facts that the solver counted: particles, walls, list builds, lost, outflow.
    pub counts: Counts,
    /// Sum of the wall time of its steps \[s\].
    pub step_seconds: f64,
    /// Part of it spent waiting for the partner's frames \[s\].
    pub waited_seconds: f64,
    /// `waited_seconds` over `step_seconds` \[-\].
    pub waited_share: Option<f64>,
    /// Its process, where it is known.
    pub process: Process,
    /// Peak memory of the process over its particles and wall particles \[bytes\]; the program itself counts too.
    pub peak_memory_bytes_per_particle: Option<f64>,
    /// SHA-256, as hex, of all particles at the end.
    pub state_digest: String,
}

impl Participant {
    /// Fills the counts and what follows from them.
    pub fn set_counts(&mut self, counts: Counts) {
        let particles = counts.particles + counts.wall_particles;
        // Both far below 2^53.
        let share = |bytes: u64| (particles > 0).then(|| bytes as f64 / particles as f64);
        self.peak_memory_bytes_per_particle = self.process.peak_memory_bytes.and_then(share);
        self.counts = counts;
    }

    /// Fills both waits and the share.
    pub fn set_waits(&mut self, step_seconds: f64, waited_seconds: f64) {
        self.step_seconds = step_seconds;
        self.waited_seconds = waited_seconds;
        self.waited_share = (step_seconds > 0.0).then_some(waited_seconds / step_seconds);
    }
}

impl Summary {
    /// The verdict in words; "completed, with reservations" where there are.
    pub fn verdict_text(&self) -> String {
        match self.reservations.is_empty() {
            true => self.verdict.to_string(),
            false => format!("{}, with reservations", self.verdict),
        }
    }

    /// Writes the summary to `path`.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), OutputError> {
        write_file(path, |file| {
            serde_json::to_writer_pretty(&mut *file, self).map_err(io::Error::from)?;
            file.write_all(b"\n")
        })
    }
}

/// What every summary holds, whatever the build that wrote it.
#[derive(Deserialize)]
struct Head {
    format: u32,
    #[serde(rename = "run_id")]
    _run_id: String,
    #[serde(rename = "verdict")]
    _verdict: Verdict,
    #[serde(rename = "steps")]
    _steps: u64,
    case_digest: String,
}

/// Whether a run wrote the file at `path`.
pub(super) fn is_of_a_run(path: &Path) -> bool {
    let read = || -> io::Result<Vec<u8>> {
        let mut text = Vec::new();
        open_regular(path)?.0.take(LONGEST).read_to_end(&mut text)?;
        Ok(text)
    };
    let head: Option<Head> = read().ok().and_then(|text| serde_json::from_slice(&text).ok());
    head.is_some_and(|head| {
        let digest = head.case_digest;
        head.format > 0 && digest.len() == 64 && digest.bytes().all(|byte| byte.is_ascii_hexdigit())
    })
}

#[cfg(test)]
mod tests;
