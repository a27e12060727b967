//! A step that all participants have completed: what the ledger records.

use sph::coupling::driver::StepReport;
use sph::coupling::ledger::{Breach, Imbalance, LedgerVector};
use sph::coupling::solver::Role;

/// A step that every participant has completed, with its checks.
#[derive(Clone, Debug)]
pub struct MatchedStep {
    /// Report of the fluid, where there is one.
    pub fluid: Option<StepReport>,
    /// Report of the solid, where there is one.
    pub solid: Option<StepReport>,
    /// Imbalance of predictor and corrector; zero without a partner.
    pub imbalance: [Imbalance; 2],
    /// Residual of the momentum check, the worst of both sides and stages \[-\].
    pub momentum_residual: f64,
    /// Failed checks.
    pub breaches: Vec<(Option<Role>, Breach)>,
    /// Impulse that crossed the interface so far, on the fluid and on the solid \[N s/m\]; corrector passes only.
    pub impulse: [LedgerVector; 2],
}

impl MatchedStep {
    /// The report of either side; sides agree on step and time.
    pub fn any(&self) -> &StepReport {
        match (&self.fluid, &self.solid) {
            (Some(report), _) | (None, Some(report)) => report,
            (None, None) => unreachable!("a matched step has at least one report"),
        }
    }

    /// The report of `role`.
    pub fn of(&self, role: Role) -> Option<&StepReport> {
        match role {
            Role::Fluid => self.fluid.as_ref(),
            Role::Solid => self.solid.as_ref(),
        }
    }
}
