//! The energy budget of a run: the accounts of both sides, their balance, and the scale by which it is judged.

use serde::{Deserialize, Serialize};
use sph::coupling::ledger::{EnergyAccount, EnergyEntry, EnergyKind, EnergyReport, SignRule};
use sph::coupling::solver::Role;
use sph::setup::ParticipantSetup;

use crate::case::Case;

/// A side whose energy is recorded, with the accounts that its case can have.
#[derive(Clone, Debug, PartialEq)]
pub struct LedgerSide {
    /// Which side.
    pub role: Role,
    /// Number of dimensions of the run.
    pub dimensions: usize,
    /// Its accounts.
    pub accounts: Vec<EnergyAccount>,
}

impl LedgerSide {
    /// Those of `roles` in `case`.
    pub fn of(case: &Case, roles: &[Role]) -> Vec<Self> {
        let setup = |role: &Role| match role {
            Role::Fluid => case.fluid_setup().map(ParticipantSetup::Fluid),
            Role::Solid => case.solid_setup().map(ParticipantSetup::Solid),
        };
        let accounts = |role| setup(role).map_or_else(Vec::new, |setup| EnergyAccount::of(&setup));
        let dimensions = case.dimensions();
        roles.iter().map(|role| Self { role: *role, dimensions, accounts: accounts(role) }).collect()
    }
}

/// Energy of one side as last reported, and the scale of its balance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SideEnergy {
    report: EnergyReport,
    /// Largest [`EnergyReport::scale`] so far \[J/m\].
    scale: f64,
    /// Largest |residual| so far \[J/m\].
    largest_residual: f64,
    /// Largest [`gain_of`] so far \[J/m\].
    largest_gain: f64,
}

impl SideEnergy {
    /// Takes the report of a step.
    pub fn take(&mut self, report: &EnergyReport) {
        self.report = *report;
        self.scale = self.scale.max(report.scale());
        self.largest_gain = self.largest_gain.max(gain_of(report));
        if let Some(residual) = report.residual() {
            let size = residual.abs();
            // NaN stays.
            if size > self.largest_residual || size.is_nan() {
                self.largest_residual = size;
            }
        }
    }

    /// The largest |residual| over the scale of the budget \[-\]; `None` from a solver that reports stores alone, or where
    /// nothing was there to be spent.
    pub fn residual_share(&self) -> Option<f64> {
        let counts = self.report.has_flows() && self.scale > 0.0;
        counts.then(|| self.largest_residual / self.scale)
    }

    /// The largest gain from time scheme and contact, over the scale of the budget \[-\]; `None` as for
    /// [`Self::residual_share`].
    pub fn gain_share(&self) -> Option<f64> {
        let counts = self.report.has_flows() && self.scale > 0.0;
        counts.then(|| self.largest_gain / self.scale)
    }

    /// The last report.
    pub fn report(&self) -> &EnergyReport {
        &self.report
    }
}

/// Energy that time scheme and contact together have given \[J/m\]: minus the sum of their accounts.
fn gain_of(report: &EnergyReport) -> f64 {
    -(report.value(EnergyAccount::TimeScheme) + report.value(EnergyAccount::Contact))
}

/// Energy budget of the run, from its start to the last completed step.
#[derive(Clone, Debug, Default, Serialize)]
pub struct EnergySummary {
    /// The fluid; absent without one, or from a solver that reports no energy.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fluid: Option<SideSummary>,
    /// The solids; likewise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub solid: Option<SideSummary>,
    /// Loss between the sides \[J/m\], minus the sum of the work that both received over the interface: artificial
    /// viscosity and repulsion between them, and pressures that are not those of a particle. Either sign.
    pub interface_slip_j_per_m: Option<f64>,
    /// Sum of the residuals of both sides \[J/m\]; `null` where one reports no works and losses.
    pub residual_j_per_m: Option<f64>,
    /// That over the larger scale of the sides \[-\].
    pub residual_share: Option<f64>,
}

/// Energy budget of one side.
#[derive(Clone, Debug, Serialize)]
pub struct SideSummary {
    /// Its accounts: stores, works, losses.
    pub accounts: Vec<AccountSummary>,
    /// Σ stores (now − start) − Σ works + Σ losses \[J/m\]; `null` from a solver that reports stores alone.
    pub residual_j_per_m: Option<f64>,
    /// The largest |residual| at any step \[J/m\]; likewise.
    pub largest_residual_j_per_m: Option<f64>,
    /// The larger of the energy held at the start, potential energy given since, and work, at any time \[J/m\].
    pub scale_j_per_m: f64,
    /// The largest |residual| over the scale \[-\]; `null` also where nothing was there to be spent.
    pub residual_share: Option<f64>,
}

/// One account.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct AccountSummary {
    /// Its name.
    pub account: EnergyAccount,
    /// What it does in the balance.
    pub kind: EnergyKind,
    /// What sign it may have.
    pub sign: SignRule,
    /// A store now; a work or loss since the start \[J/m\].
    pub value_j_per_m: f64,
    /// Change of a store since the start \[J/m\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub change_j_per_m: Option<f64>,
}

impl SideSummary {
    fn new(side: &SideEnergy) -> Option<Self> {
        let account = |(account, entry): (EnergyAccount, EnergyEntry)| AccountSummary {
            account,
            kind: account.kind(),
            sign: account.sign_rule(),
            value_j_per_m: entry.value,
            change_j_per_m: (account.kind() == EnergyKind::Store).then_some(entry.value - entry.start),
        };
        let accounts: Vec<AccountSummary> = side.report.entries().map(account).collect();
        let residual = side.report.residual();
        let largest = residual.map(|_| side.largest_residual);
        (!accounts.is_empty()).then_some(Self {
            accounts,
            residual_j_per_m: residual,
            largest_residual_j_per_m: largest,
            scale_j_per_m: side.scale,
            residual_share: side.residual_share(),
        })
    }

    /// Change of what its stores hold \[J/m\].
    pub fn change(&self) -> f64 {
        self.accounts.iter().filter_map(|account| account.change_j_per_m).sum()
    }

    /// Its works and losses, the largest first.
    pub fn largest_flows(&self) -> Vec<AccountSummary> {
        let mut flows: Vec<AccountSummary> =
            self.accounts.iter().filter(|account| account.kind != EnergyKind::Store).copied().collect();
        flows.sort_by(|a, b| b.value_j_per_m.abs().total_cmp(&a.value_j_per_m.abs()));
        flows
    }
}

impl EnergySummary {
    /// Of both sides.
    pub fn new(sides: &[SideEnergy; 2]) -> Self {
        let [fluid, solid] = sides;
        let work = |side: &SideEnergy| side.report.get(EnergyAccount::Interface).map(|entry| entry.value);
        let slip = work(fluid).zip(work(solid)).map(|(fluid, solid)| -(fluid + solid));
        let [fluid, solid] = [SideSummary::new(fluid), SideSummary::new(solid)];
        let present = || [&fluid, &solid].into_iter().flatten();
        let residuals: Option<Vec<f64>> = present().map(|side| side.residual_j_per_m).collect();
        let residual = residuals.filter(|list| !list.is_empty()).map(|list| list.iter().sum::<f64>());
        let scale = present().map(|side| side.scale_j_per_m).fold(0.0, f64::max);
        Self {
            interface_slip_j_per_m: slip,
            residual_j_per_m: residual,
            residual_share: residual.filter(|_| scale > 0.0).map(|residual| residual.abs() / scale),
            fluid,
            solid,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_time_scheme_and_contact_give_together_is_a_gain_that_stays() {
        let mut side = SideEnergy::default();
        assert_eq!(side.gain_share(), None);
        let report = |scheme: f64, contact: f64| {
            let mut report = EnergyReport::default();
            report.set(EnergyAccount::Kinetic, EnergyEntry { value: 2.0, start: 2.0 });
            report.set(EnergyAccount::TimeScheme, EnergyEntry { value: scheme, start: 0.0 });
            report.set(EnergyAccount::Contact, EnergyEntry { value: contact, start: 0.0 });
            report.set(EnergyAccount::ArtificialPressure, EnergyEntry { value: -3.0, start: 0.0 });
            report
        };
        // What contact takes is not gained; artificial stress has its own account.
        side.take(&report(-0.5, 0.75));
        assert_eq!(side.gain_share(), Some(0.0));
        side.take(&report(-1.0, 0.75));
        side.take(&report(-0.5, 0.75));
        assert_eq!(side.gain_share(), Some(0.125));
    }
}
