//! Sums and extremes of the interface ledger.

use serde::{Deserialize, Serialize};
use sph::coupling::driver::StepReport;
use sph::coupling::ledger::{Account, Accounts, LedgerVector, StageBudget};
use sph::coupling::stage::StepStage;

use super::energy::SideEnergy;

/// The largest value of a check and the half-step where it occurred; NaN is larger than everything.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Largest {
    /// The value \[-\].
    pub value: f64,
    /// Where; `None` when every value was zero.
    pub at: Option<StepStage>,
}

impl Largest {
    /// Takes `value` when it is larger.
    pub fn take(&mut self, value: f64, at: StepStage) {
        if value > self.value || (value.is_nan() && !self.value.is_nan()) {
            *self = Self { value, at: Some(at) };
        }
    }
}

/// Largest relative imbalances and residuals of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Extremes {
    /// Force, check (a).
    pub force: Largest,
    /// Torque, check (a).
    pub torque: Largest,
    /// Momentum of the fluid and of the solid, check (b).
    pub momentum: [Largest; 2],
    /// Angular momentum of the fluid and of the solid, check (b); `None` for a side that reports no budget.
    pub angular: [Option<Largest>; 2],
}

/// Energy that crossed the interface since the start \[J/m\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Work {
    /// Work that the fluid and the solid received.
    pub received: [f64; 2],
    /// Sum of |power| over time of the side where it is larger, without cancellation of opposite signs.
    pub passed: f64,
}

impl Work {
    /// What one side gave and the other did not receive, the compression of the water by solids included.
    pub fn drift(&self) -> f64 {
        self.received[0] + self.received[1]
    }
}

/// Sums of one side over the accepted corrector passes.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct SideSums {
    pub(super) impulse: LedgerVector,
    pub(super) work: f64,
    /// Sum of |power| over time.
    pub(super) passed: f64,
    pub(super) momentum_change: LedgerVector,
    /// Impulse and angular impulse of each account; the latter NaN without an angular budget.
    pub(super) accounts: Accounts,
    /// Worst residual since the last row.
    pub(super) residual: Largest,
    pub(super) angular: AngularSums,
    pub(super) energy: SideEnergy,
}

/// Sums of the angular momentum of one side; NaN where it has no budget.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct AngularSums {
    pub(super) impulse: LedgerVector,
    pub(super) change: LedgerVector,
    /// Worst residual since the last row.
    pub(super) residual: Largest,
}

impl SideSums {
    /// Adds an accepted corrector pass.
    pub(super) fn add(&mut self, stage: &StageBudget) {
        let duration = stage.duration;
        self.impulse += duration * stage.interface.force;
        let work = duration * stage.interface.power;
        self.work += work;
        self.passed += work.abs();
        self.momentum_change += stage.momentum_change;
        let unknown = LedgerVector::repeat(f64::NAN);
        match &stage.angular {
            Some(angular) => {
                self.angular.impulse += duration * stage.interface.torque;
                self.angular.change += angular.change;
            }
            None => (self.angular.impulse, self.angular.change) = (unknown, unknown),
        }
        for account in Account::ALL {
            let entry = stage.accounts.get(account);
            let torque = stage.angular.map_or(unknown, |_| duration * entry.torque);
            self.accounts.add_force(account, duration * entry.force);
            self.accounts.add_torque(account, torque);
        }
    }
}

/// What the ledger has summed up, for a checkpoint.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct LedgerSums {
    pub(super) sides: [SideSums; 2],
    /// Worst imbalances since the last row: force, torque.
    pub(super) since_row: [Largest; 2],
    /// Most iterations of a half-step since the last row.
    pub(super) most_iterations: u32,
    pub(super) extremes: Extremes,
    /// Reports of the last step, not yet in a row.
    pub(super) pending: Option<[Option<StepReport>; 2]>,
}
