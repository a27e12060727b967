//! The energy budget of one side: its accounts, and their values since the start of a run.
//!
//! ```text
//! residual = Σ stores (now − start) − Σ works + Σ losses
//! ```
//! Works and losses are summed from forces and rates, stores from the state. No account is what the others leave over.

use std::ops::AddAssign;

use serde::{Deserialize, Serialize};

use crate::coupling::saved::{RestoreError, SavedState};
use crate::setup::{Choice, choices};

choices! {
    /// An account of the energy of one side.
    #[derive(PartialOrd, Ord, Hash, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum EnergyAccount {
        /// Kinetic energy of particles and of rigid bodies.
        Kinetic = "kinetic",
        /// Potential energy in steady gravity; of a fluid without directions in which the domain is periodic.
        Potential = "potential",
        /// Compression of the fluid by the equation of state.
        Compression = "compression",
        /// What the acoustic relaxation stores.
        Relaxation = "relaxation",
        /// Strain of deformable bodies, with that of hourglass control.
        Strain = "strain",
        /// Work of body forces other than steady gravity.
        BodyForce = "body_force",
        /// Work of moving walls: their forces on fluid or bodies times the velocity of the wall.
        Walls = "walls",
        /// Work of supports.
        Supports = "supports",
        /// Work of loads on bodies: pressure, traction and the acceleration of one body.
        Loads = "loads",
        /// Work that this side received from the other: force times own velocity; of a fluid also the compression by the
        /// approach of solids.
        Interface = "interface",
        /// Work of the water in gaps that are too thin for its particles, on bodies.
        Film = "film",
        /// Artificial viscosity of fluid and bodies.
        ArtificialViscosity = "artificial_viscosity",
        /// Physical viscosity.
        Viscosity = "viscosity",
        /// Linear damping.
        Damping = "damping",
        /// The acoustic damper.
        AcousticDamper = "acoustic_damper",
        /// What the acoustic relaxation absorbs.
        AcousticRelaxation = "acoustic_relaxation",
        /// Change of compression by density diffusion.
        DensityDiffusion = "density_diffusion",
        /// Change of compression by the volume correction.
        VolumeCorrection = "volume_correction",
        /// Shifting: shifted particles move in gravity and take the velocity of the fluid at their new place.
        Shifting = "shifting",
        /// Tensile control.
        TensileControl = "tensile_control",
        /// Artificial pressure of the fluid, artificial stress of updated-Lagrangian bodies.
        ArtificialPressure = "artificial_pressure",
        /// Work of pressure or stress in the momentum equation that compression or strain does not receive: gradients
        /// that are not adjoint, and the time scheme between them.
        CorrectedGradients = "corrected_gradients",
        /// The time scheme: work of conservative forces along the path against the change of what they store.
        TimeScheme = "time_scheme",
        /// Contact of bodies with each other and with walls along the normal: dashpot, and what the contacts that are
        /// closed store.
        Contact = "contact",
        /// Friction of bodies, with what its springs store.
        Friction = "friction",
        /// Repulsion of fluid by wall faces: dashpot, and what it stores for the moment.
        Repulsion = "repulsion",
        /// Energy of particles that left.
        Removed = "removed",
    }
}

/// What an account does in the balance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum EnergyKind {
    /// Energy that the side holds.
    Store,
    /// Work from outside, positive where the side gains.
    Work,
    /// Energy that leaves the stores, positive where the side loses.
    Loss,
}

/// What sign an account may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SignRule {
    /// A loss that is never negative beyond round-off and the order of the time scheme.
    NeverNegative,
    /// Either sign.
    Either,
}

impl EnergyAccount {
    /// Number of accounts.
    pub const COUNT: usize = Self::NAMES.len();

    /// All accounts: stores, works, losses.
    pub fn all() -> impl Iterator<Item = Self> {
        Self::NAMES.iter().map(|(_, account)| *account)
    }

    /// Name in outputs and messages.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize].0
    }

    /// What it holds, in words.
    pub fn meaning(self) -> &'static str {
        Self::MEANINGS[self as usize].1.trim()
    }

    /// The account of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::NAMES.iter().find(|(known, _)| *known == name).map(|(_, account)| *account)
    }

    /// What it does in the balance.
    pub fn kind(self) -> EnergyKind {
        use EnergyAccount as A;
        match self {
            A::Kinetic | A::Potential | A::Compression | A::Relaxation | A::Strain => EnergyKind::Store,
            A::BodyForce | A::Walls | A::Supports | A::Loads | A::Interface | A::Film => EnergyKind::Work,
            _ => EnergyKind::Loss,
        }
    }

    /// What sign it may have.
    pub fn sign_rule(self) -> SignRule {
        use EnergyAccount as A;
        match self {
            A::Kinetic
            | A::ArtificialViscosity
            | A::Viscosity
            | A::Damping
            | A::AcousticDamper
            | A::AcousticRelaxation => SignRule::NeverNegative,
            _ => SignRule::Either,
        }
    }
}

/// A number for each account \[J\].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EnergyValues([f64; EnergyAccount::COUNT]);

impl EnergyValues {
    /// The number of `account`.
    pub fn get(&self, account: EnergyAccount) -> f64 {
        self.0[account as usize]
    }

    /// Adds `energy` \[J\] to `account`.
    pub fn add(&mut self, account: EnergyAccount, energy: f64) {
        self.0[account as usize] += energy;
    }

    /// All numbers in the order of [`EnergyAccount::all`].
    pub fn as_slice(&self) -> &[f64] {
        &self.0
    }

    /// The values whose numbers these are; `None` for another count.
    pub fn of_slice(numbers: &[f64]) -> Option<Self> {
        numbers.try_into().ok().map(Self)
    }
}

impl AddAssign for EnergyValues {
    fn add_assign(&mut self, other: Self) {
        self.0.iter_mut().zip(other.0).for_each(|(sum, value)| *sum += value);
    }
}

/// What a solver keeps of its energy in its state.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EnergyTally {
    /// Stores at the start of the run \[J\].
    pub start: EnergyValues,
    /// Works and losses since then \[J\].
    pub flows: EnergyValues,
}

impl EnergyTally {
    /// Saves it as the array `name`.
    pub fn save(&self, name: &str, saved: &mut SavedState) {
        saved.put_f64(name, self.start.0.into_iter().chain(self.flows.0));
    }

    /// The tally that was saved as `name`.
    ///
    /// # Errors
    /// When the array is missing or has another length.
    pub fn restored(name: &str, saved: &SavedState) -> Result<Self, RestoreError> {
        let numbers = saved.f64s(name, Some(2 * EnergyAccount::COUNT))?;
        let (start, flows) = numbers.split_at(EnergyAccount::COUNT);
        let values = |numbers: &[f64]| EnergyValues::of_slice(numbers).unwrap_or_default();
        Ok(Self { start: values(start), flows: values(flows) })
    }
}

/// One account of a report.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EnergyEntry {
    /// A store now; a work or loss since the start \[J\].
    pub value: f64,
    /// A store at the start of the run \[J\]; zero for works and losses.
    pub start: f64,
}

/// What one side reports of its energy at a step boundary: the accounts that its case can have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EnergyReport([Option<EnergyEntry>; EnergyAccount::COUNT]);

impl EnergyReport {
    /// The report of the `listed` accounts, from the stores at the start and now and the works and losses since the start.
    pub fn new(
        listed: &[EnergyAccount],
        start: &EnergyValues,
        now: &EnergyValues,
        flows: &EnergyValues,
    ) -> Self {
        let mut report = Self::default();
        for account in listed {
            let entry = match account.kind() {
                EnergyKind::Store => EnergyEntry { value: now.get(*account), start: start.get(*account) },
                EnergyKind::Work | EnergyKind::Loss => EnergyEntry { value: flows.get(*account), start: 0.0 },
            };
            report.set(*account, entry);
        }
        report
    }

    /// The entry of `account`, where it was reported.
    pub fn get(&self, account: EnergyAccount) -> Option<EnergyEntry> {
        self.0[account as usize]
    }

    /// The value of `account` \[J\]; zero where it was not reported.
    pub fn value(&self, account: EnergyAccount) -> f64 {
        self.get(account).map_or(0.0, |entry| entry.value)
    }

    /// Enters `account`.
    pub fn set(&mut self, account: EnergyAccount, entry: EnergyEntry) {
        self.0[account as usize] = Some(entry);
    }

    /// The accounts that were reported, with their entries.
    pub fn entries(&self) -> impl Iterator<Item = (EnergyAccount, EnergyEntry)> + '_ {
        EnergyAccount::all().filter_map(|account| self.get(account).map(|entry| (account, entry)))
    }

    /// Whether works or losses were reported: stores alone do not balance.
    pub fn has_flows(&self) -> bool {
        self.entries().any(|(account, _)| account.kind() != EnergyKind::Store)
    }

    /// Σ stores (now − start) − Σ works + Σ losses \[J\]; `None` from a solver that reports stores alone.
    ///
    /// ```
    /// use sph::coupling::ledger::{EnergyAccount, EnergyEntry, EnergyReport};
    /// // A block of 2 J that lost 0.5 J to friction.
    /// let mut report = EnergyReport::default();
    /// report.set(EnergyAccount::Kinetic, EnergyEntry { value: 1.5, start: 2.0 });
    /// assert_eq!(report.residual(), None);
    /// report.set(EnergyAccount::Friction, EnergyEntry { value: 0.5, start: 0.0 });
    /// assert_eq!(report.residual(), Some(0.0));
    /// ```
    pub fn residual(&self) -> Option<f64> {
        self.has_flows().then(|| {
            self.entries()
                .map(|(account, entry)| match account.kind() {
                    EnergyKind::Store => entry.value - entry.start,
                    EnergyKind::Work => -entry.value,
                    EnergyKind::Loss => entry.value,
                })
                .sum()
        })
    }

    /// Energy that was there to be spent \[J\]: the largest of what stores other than the potential held at the start, the
    /// potential energy that has been given or taken since, and the work from outside.
    pub fn scale(&self) -> f64 {
        let (mut held, mut fallen, mut work) = (0.0, 0.0, 0.0);
        for (account, EnergyEntry { value, start }) in self.entries() {
            match (account.kind(), account) {
                (EnergyKind::Store, EnergyAccount::Potential) => fallen += (value - start).abs(),
                (EnergyKind::Store, _) => held += start.abs(),
                (EnergyKind::Work, _) => work += value.abs(),
                (EnergyKind::Loss, _) => {}
            }
        }
        f64::max(held, f64::max(fallen, work))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_find_their_account_and_kinds_come_in_order() {
        let mut last = EnergyKind::Store as usize;
        for (k, account) in EnergyAccount::all().enumerate() {
            assert_eq!((account as usize, EnergyAccount::named(account.name())), (k, Some(account)));
            assert!(account.kind() as usize >= last, "{}", account.name());
            last = account.kind() as usize;
        }
        assert_eq!(EnergyAccount::named("heat"), None);
    }

    #[test]
    fn works_raise_the_stores_and_losses_lower_them() {
        let (mut start, mut now, mut flows) =
            (EnergyValues::default(), EnergyValues::default(), EnergyValues::default());
        start.add(EnergyAccount::Potential, -7.0);
        now.add(EnergyAccount::Potential, -6.0);
        now.add(EnergyAccount::Kinetic, 2.0);
        flows.add(EnergyAccount::Walls, 4.0);
        flows.add(EnergyAccount::Viscosity, 1.0);
        let all: Vec<EnergyAccount> = EnergyAccount::all().collect();
        assert_eq!(EnergyReport::new(&all, &start, &now, &flows).residual(), Some(0.0));
        let listed = [EnergyAccount::Kinetic, EnergyAccount::Viscosity];
        let partial = EnergyReport::new(&listed, &start, &now, &flows);
        assert_eq!(partial.entries().count(), 2);
        assert_eq!(partial.residual(), Some(3.0));
    }
}
