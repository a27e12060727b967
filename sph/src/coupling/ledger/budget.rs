//! Sums of one side over one half-step: what crossed the interface, and its momentum budget.

use std::ops::AddAssign;

use serde::{Deserialize, Serialize};

use super::LedgerVector;
use super::accounts::Accounts;

/// Sums over the pair forces that one side received from the other in one half-step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct InterfaceSums {
    /// Σ f_ij \[N\].
    pub force: LedgerVector,
    /// Σ |f_ij| \[N\]: the scale of the balance.
    pub gross_force: f64,
    /// Σ (x_i − x₀) × f_ij \[N m\], about the domain's torque origin.
    pub torque: LedgerVector,
    /// Σ |x_i − x₀| |f_ij| \[N m\].
    pub gross_torque: f64,
    /// ½ Σ (x_i − x_j) × f_ij \[N m\]: what a non-central law leaves; both sides report the same value.
    pub couple: LedgerVector,
    /// Σ f_ij · v_i \[W\].
    pub power: f64,
    /// Number of pairs.
    pub pairs: u64,
}

impl std::ops::AddAssign for InterfaceSums {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        self.force += other.force;
        self.gross_force += other.gross_force;
        self.torque += other.torque;
        self.gross_torque += other.gross_torque;
        self.couple += other.couple;
        self.power += other.power;
        self.pairs += other.pairs;
    }
}

/// Change of one side's angular momentum in one half-step, about the domain's torque origin.
///
/// The angular momentum is Σ m (x − x₀) × v over all own particles, plus I_c ω for each rigid body, with the
/// moment of inertia I_c = Σ m V/6 of its cells about their own centres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct AngularBudget {
    /// Angular momentum after the stage minus that at the start of the step, summed over all particles \[kg m²/s\].
    pub change: LedgerVector,
    /// Σ m |x − x₀| |v| at both ends plus duration · Σ |x − x₀| |f| \[kg m²/s\]: the scale of round-off.
    pub gross: f64,
}

/// Momentum budget of one side for one half-step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StageBudget {
    /// Interface sums.
    pub interface: InterfaceSums,
    /// Forces and torques of all other origins.
    pub accounts: Accounts,
    /// Time by which the stage advanced from the start of the step \[s\]; 0 where it moved no momentum, as in the predictor
    /// of the fluid's leapfrog, whose interface forces only serve the partner.
    pub duration: f64,
    /// Σ m v after the stage minus Σ m v at the start of the step, summed over all particles \[kg m/s\].
    pub momentum_change: LedgerVector,
    /// Σ m |v| at both ends plus duration · Σ m |a| \[kg m/s\]: the scale of round-off in the momentum check.
    pub gross_momentum: f64,
    /// Budget of the angular momentum; `None` in a periodic domain, where torque has no meaning, and from solvers that
    /// report none.
    pub angular: Option<AngularBudget>,
}

/// What a solid reports of its momentum in one half-step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MomentumReport {
    /// Momentum after the stage minus that at the start of the step \[kg m/s\].
    pub change: LedgerVector,
    /// Scale of its round-off \[kg m/s\].
    pub gross: f64,
    /// The same of the angular momentum; `None` without a budget.
    pub angular: Option<AngularBudget>,
}

impl From<&StageBudget> for MomentumReport {
    fn from(budget: &StageBudget) -> Self {
        Self { change: budget.momentum_change, gross: budget.gross_momentum, angular: budget.angular }
    }
}

impl StageBudget {
    /// |ΔP − duration·(interface + accounts)| over the gross momentum \[-\]: check (b).
    pub fn momentum_residual(&self) -> f64 {
        let expected = self.duration * (self.interface.force + self.accounts.total_force());
        relative((self.momentum_change - expected).norm(), self.gross_momentum)
    }

    /// |ΔL − duration·(interface + accounts)| over the gross angular momentum \[-\]: check (b) for torques; 0 without
    /// a budget.
    pub fn angular_residual(&self) -> f64 {
        self.angular.map_or(0.0, |angular| {
            let expected = self.duration * (self.interface.torque + self.accounts.total_torque());
            relative((angular.change - expected).norm(), angular.gross)
        })
    }
}

/// Energies of one side at a step boundary \[J\].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Energies {
    /// Kinetic.
    pub kinetic: f64,
    /// Potential, in constant gravity.
    pub potential: f64,
    /// Compression energy of a fluid, strain energy of a solid.
    pub internal: f64,
    /// What the acoustic relaxation of a fluid stores.
    pub relaxation: f64,
}

impl AddAssign for Energies {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        self.kinetic += other.kinetic;
        self.potential += other.potential;
        self.internal += other.internal;
        self.relaxation += other.relaxation;
    }
}

/// `residual / gross`; a residual without any gross is infinitely wrong.
pub(super) fn relative(residual: f64, gross: f64) -> f64 {
    if residual == 0.0 { 0.0 } else { residual / gross }
}
