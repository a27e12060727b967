//! Checks of the ledger: action against reaction, and the momentum budget of each side.

use serde::{Deserialize, Serialize};

use super::budget::{InterfaceSums, StageBudget, relative};
use crate::coupling::stage::StepStage;
use crate::setup::{CouplingKind, InterfaceLaw, LedgerPolicy, RunPlan};

/// Imbalance of one half-step, relative to gross: check (a).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Imbalance {
    /// |F_fluid + F_solid| / gross force \[-\].
    pub force: f64,
    /// |T_fluid + T_solid − couple| / gross torque \[-\].
    pub torque: f64,
}

/// How the torque of an interface law is checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TorqueCheck {
    /// Pair forces act along x_ij: torques cancel.
    Central,
    /// They do not: torques cancel up to the couple Σ (x_i − x_j) × f_ij, which both sides report.
    WithCouple,
    /// They do not, and the partner receives loads, so that the fluid alone knows the couple: it counts for both.
    WithFluidCouple,
    /// A periodic direction leaves torque without meaning.
    Skipped,
}

impl TorqueCheck {
    /// The check that fits the interface law and the domain of a run.
    pub fn of(run: &RunPlan) -> Self {
        let Some(coupling) = &run.coupling else { return Self::Central };
        match (coupling.law, coupling.kind) {
            _ if run.domain.is_periodic() => Self::Skipped,
            (InterfaceLaw::Wall, _) => Self::Central,
            (_, CouplingKind::States) => Self::WithCouple,
            (_, CouplingKind::Loads) => Self::WithFluidCouple,
        }
    }
}

/// Compares both sides' sums of one half-step.
pub fn imbalance(ours: &InterfaceSums, theirs: &InterfaceSums, torque: TorqueCheck) -> Imbalance {
    let gross = ours.gross_force.max(theirs.gross_force);
    let gross_torque = ours.gross_torque.max(theirs.gross_torque);
    let net_torque = ours.torque + theirs.torque;
    let torque = match torque {
        TorqueCheck::Central => relative(net_torque.norm(), gross_torque),
        TorqueCheck::WithCouple => relative((net_torque - ours.couple - theirs.couple).norm(), gross_torque),
        // The solid reports none.
        TorqueCheck::WithFluidCouple => {
            relative((net_torque - 2.0 * (ours.couple + theirs.couple)).norm(), gross_torque)
        }
        TorqueCheck::Skipped => 0.0,
    };
    Imbalance { force: relative((ours.force + theirs.force).norm(), gross), torque }
}

/// A failed check of the ledger.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Breach {
    /// Half-step whose check failed.
    pub at: StepStage,
    /// Which balance failed.
    pub check: Check,
    /// Residual relative to gross \[-\].
    pub residual: f64,
    /// Allowed residual \[-\].
    pub tolerance: f64,
}

/// A balance that the ledger checks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Check {
    /// Action equals reaction: force.
    Force,
    /// Action equals reaction: torque.
    Torque,
    /// One side's momentum change equals the impulse of its forces.
    Momentum,
    /// One side's change of angular momentum equals the angular impulse of its forces.
    AngularMomentum,
}

impl Check {
    /// Name in outputs and messages.
    pub fn name(self) -> &'static str {
        match self {
            Check::Force => "action = reaction (force)",
            Check::Torque => "action = reaction (torque)",
            Check::Momentum => "momentum change = impulse of the forces",
            Check::AngularMomentum => "angular momentum change = angular impulse of the forces",
        }
    }
}

impl std::fmt::Display for Breach {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "ledger breach at {}: {} is off by {:.2e} of gross, allowed {:.0e}",
            self.at,
            self.check.name(),
            self.residual,
            self.tolerance
        )?;
        // Round-off stays below 1e-11; a wrong law is of order one. In between, sides used different states.
        if matches!(self.check, Check::Force | Check::Torque) && (1e-9..1e-1).contains(&self.residual) {
            f.write_str("; a residual of this size is the mark of stale data: one side used an older state")?;
        }
        Ok(())
    }
}

/// Breaches of checks (a) in one half-step, force before torque.
pub fn balance_breaches(at: StepStage, imbalance: &Imbalance, policy: &LedgerPolicy) -> Vec<Breach> {
    [(Check::Force, imbalance.force), (Check::Torque, imbalance.torque)]
        .into_iter()
        .filter(|(_, residual)| exceeds(*residual, policy.balance_tolerance))
        .map(|(check, residual)| Breach { at, check, residual, tolerance: policy.balance_tolerance })
        .collect()
}

/// Breaches of check (b) in one half-step of one side, momentum before angular momentum.
pub fn budget_breaches(at: StepStage, budget: &StageBudget, policy: &LedgerPolicy) -> Vec<Breach> {
    let tolerance = policy.momentum_tolerance;
    [(Check::Momentum, budget.momentum_residual()), (Check::AngularMomentum, budget.angular_residual())]
        .into_iter()
        .filter(|(_, residual)| exceeds(*residual, tolerance))
        .map(|(check, residual)| Breach { at, check, residual, tolerance })
        .collect()
}

/// NaN exceeds everything.
pub(crate) fn exceeds(value: f64, tolerance: f64) -> bool {
    value.is_nan() || value > tolerance
}
