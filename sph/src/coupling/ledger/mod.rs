//! The ledger: what each side reports of its momentum in a half-step and of its energy, and the checks on it.
//!
//! Vectors have three components whatever the space: in the plane, forces have no z and torques nothing else. Extensive
//! quantities of the plane are per metre of depth: a force \[N\] is one per metre.

mod accounts;
mod balance;
mod budget;
mod energy;
mod energy_listing;

use nalgebra::Vector3;

pub use accounts::{Account, AccountEntry, Accounts, scheme_moment};
pub(crate) use balance::exceeds;
pub use balance::{Breach, Check, Imbalance, TorqueCheck, balance_breaches, budget_breaches, imbalance};
pub use budget::{AngularBudget, Energies, InterfaceSums, MomentumReport, StageBudget};
pub use energy::{EnergyAccount, EnergyEntry, EnergyKind, EnergyReport, EnergyTally, EnergyValues, SignRule};
pub use energy_listing::potential_gravity;

use crate::space::components::Components;

/// A vector of the ledger, (x, y, z).
pub type LedgerVector = Vector3<f64>;

/// `vector` with zeros for the components that its space lacks.
#[inline]
pub fn lifted<V: Components>(vector: &V) -> LedgerVector {
    let row = vector.row();
    LedgerVector::from_fn(|k, _| if k < V::COUNT { row.as_ref()[k] } else { 0.0 })
}

/// A torque or angular momentum: of the plane, about z.
#[inline]
pub fn axial<T: Components>(spin: T) -> LedgerVector {
    let (row, missing) = (spin.row(), 3 - T::COUNT);
    LedgerVector::from_fn(|k, _| if k < missing { 0.0 } else { row.as_ref()[k - missing] })
}
