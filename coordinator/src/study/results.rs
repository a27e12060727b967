//! What a finished run left behind, and what is kept of it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sph::space::Vector;

use super::cost::{PASSES, STEP};
use super::order::{domain_around, surrounded, widest_gap};
use crate::family::figures::Histories;
use crate::results::state;

/// Outputs of a finished run.
pub struct Results {
    folder: PathBuf,
    spacing: f64,
    probes: Histories,
}

impl Results {
    /// Reads the results in `folder` of a run at `spacing` \[m\].
    ///
    /// # Errors
    /// When the probes cannot be read.
    pub fn read(folder: &Path, spacing: f64) -> Result<Self, String> {
        let probes = Histories::read(folder)?;
        Ok(Self { folder: folder.to_owned(), spacing, probes })
    }

    /// Rows of the probes as (time \[s\], value of the column `name`).
    ///
    /// # Errors
    /// When there is no such column.
    pub fn history(&self, name: &str) -> Result<Vec<(f64, f64)>, String> {
        self.probes.of(name)
    }

    /// Diameter of the widest void within the fluid at the end, over the spacing; √2 on a lattice.
    ///
    /// # Errors
    /// When the final state cannot be read.
    pub fn widest_void(&self) -> Result<f64, String> {
        let particles = state::read(&self.folder.join("final/fluid.state"))?;
        let positions = particles.field("position").ok_or("the final state has no positions")?;
        let positions: Vec<Vector> =
            positions.values.chunks_exact(2).map(|x| Vector::new(x[0], x[1])).collect();
        let domain = domain_around(&positions, 2.0 * self.spacing);
        let inside = surrounded(&positions, self.spacing);
        Ok(widest_gap(&domain, &positions, self.spacing, inside) / self.spacing)
    }
}

/// What is kept of a run, beside its case file; a run with such a file is finished.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// Builds of the solvers and arithmetic path that made it.
    pub made_by: String,
    /// Relative error \[-\], if the result is valid.
    pub error: Option<f64>,
    /// Why it is not: the run stopped, or the fluid is torn.
    pub flaw: Option<String>,
    /// CPU time of all steps \[s\].
    pub cpu_seconds: f64,
    /// CPU time of the whole process, outputs included \[s\].
    pub process_cpu_seconds: f64,
    /// CPU time of one evaluation of the kernel in a fixed loop just before \[s\].
    pub kernel_seconds: f64,
    /// Completed steps.
    pub steps: u64,
    /// Particles at the end, walls apart.
    pub particles: u64,
    /// CPU seconds of each pass, and of what else there is in a step.
    pub passes: BTreeMap<String, f64>,
}

/// Name of what is in no pass.
pub const REST: &str = "rest";

impl Measured {
    /// CPU seconds of each pass from sums over spans.
    pub fn passes_of(totals: &BTreeMap<String, f64>) -> (f64, BTreeMap<String, f64>) {
        let of = |name: &str| totals.get(name).copied().unwrap_or_default();
        let mut passes: BTreeMap<String, f64> =
            PASSES.iter().map(|name| ((*name).to_owned(), of(name))).collect();
        let whole = of(STEP);
        passes.insert(REST.to_owned(), (whole - passes.values().sum::<f64>()).max(0.0));
        (whole, passes)
    }

    /// Passes with their shares of the CPU time, the largest first.
    pub fn shares(&self) -> Vec<(&str, f64)> {
        let share = |(name, seconds)| (String::as_str(name), seconds / self.cpu_seconds);
        let mut shares: Vec<(&str, f64)> = self.passes.iter().map(share).collect();
        shares.sort_by(|a, b| b.1.total_cmp(&a.1));
        shares
    }

    /// CPU time per particle and stage \[s\].
    pub fn per_particle_stage(&self) -> f64 {
        // Counts far below 2^53.
        self.cpu_seconds / (2.0 * self.steps as f64 * self.particles as f64)
    }
}
