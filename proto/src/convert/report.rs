//! Budgets, facts and faults: numbers of a report may be anything, so that a breakdown can be reported.

use sph::coupling::ledger::{
    Account, Accounts, AngularBudget, Breach, Check, EnergyAccount, EnergyEntry, EnergyKind, EnergyReport,
    InterfaceSums, LedgerVector, MomentumReport, StageBudget,
};
use sph::coupling::solver::{Counts, Divergence, Fault, PartCount, PartCounts};
use sph::coupling::stage::StepStage;

use super::{
    Choice, Convert, Path, WireError, any_number, choice, components, components_to_wire, optional, required,
    text,
};
use crate::wire;

choices!(Check = wire::Check { Force, Torque, Momentum, AngularMomentum });

impl Convert for StepStage {
    type Wire = wire::StepStage;

    fn to_wire(&self) -> wire::StepStage {
        wire::StepStage { step: self.step, stage: self.stage.code() }
    }

    fn from_wire(wire: &wire::StepStage, at: &Path<'_>) -> Result<Self, WireError> {
        Ok(Self { step: wire.step, stage: choice(wire.stage, &at.field("stage"))? })
    }
}

/// A vector of a report, which may be anything; an absent one is zero.
fn any_vector(wire: &Option<wire::Vector>, at: &Path<'_>, name: &str) -> Result<LedgerVector, WireError> {
    match wire {
        Some(vector) => Ok(components(&vector.components, &at.field(name))?.into()),
        None => Ok(LedgerVector::zeros()),
    }
}

fn vector_to_wire(vector: &LedgerVector) -> Option<wire::Vector> {
    components_to_wire(vector.as_slice())
}

impl Convert for InterfaceSums {
    type Wire = wire::InterfaceSums;

    fn to_wire(&self) -> wire::InterfaceSums {
        wire::InterfaceSums {
            force_n: vector_to_wire(&self.force),
            gross_force_n: Some(self.gross_force),
            torque_n_m: vector_to_wire(&self.torque),
            gross_torque_n_m: Some(self.gross_torque),
            couple_n_m: vector_to_wire(&self.couple),
            power_w: Some(self.power),
            pairs: self.pairs,
        }
    }

    fn from_wire(wire: &wire::InterfaceSums, at: &Path<'_>) -> Result<Self, WireError> {
        Ok(Self {
            force: any_vector(&wire.force_n, at, "force_n")?,
            gross_force: any_number(wire.gross_force_n),
            torque: any_vector(&wire.torque_n_m, at, "torque_n_m")?,
            gross_torque: any_number(wire.gross_torque_n_m),
            couple: any_vector(&wire.couple_n_m, at, "couple_n_m")?,
            power: any_number(wire.power_w),
            pairs: wire.pairs,
        })
    }
}

choices!(
    Account = wire::Account {
        BodyForce,
        Walls,
        Supports,
        WallContact,
        Damping,
        Stabilisers,
        Removed,
        BodyContact,
        OwnForces,
        Shifting,
        TimeScheme
    }
);

fn accounts_to_wire(accounts: &Accounts) -> Vec<wire::AccountEntry> {
    let entry = |account| {
        let entry = accounts.get(account);
        wire::AccountEntry {
            account: account.code(),
            force_n: vector_to_wire(&entry.force),
            torque_n_m: vector_to_wire(&entry.torque),
        }
    };
    Account::ALL.map(entry).into()
}

fn accounts_from_wire(wire: &[wire::AccountEntry], at: &Path<'_>) -> Result<Accounts, WireError> {
    let mut accounts = Accounts::default();
    let mut listed = Vec::with_capacity(Account::ALL.len());
    for (k, entry) in wire.iter().enumerate() {
        let at = at.item("accounts", k);
        let account: Account = choice(entry.account, &at.field("account"))?;
        if listed.contains(&account) {
            return Err(at.field("account").error(format!("repeats {}", account.name())));
        }
        listed.push(account);
        accounts.add_force(account, any_vector(&entry.force_n, &at, "force_n")?);
        accounts.add_torque(account, any_vector(&entry.torque_n_m, &at, "torque_n_m")?);
    }
    Ok(accounts)
}

impl Convert for StageBudget {
    type Wire = wire::StageBudget;

    fn to_wire(&self) -> wire::StageBudget {
        wire::StageBudget {
            interface: Some(self.interface.to_wire()),
            accounts: accounts_to_wire(&self.accounts),
            duration_s: Some(self.duration),
            momentum_change_kg_m_per_s: vector_to_wire(&self.momentum_change),
            gross_momentum_kg_m_per_s: Some(self.gross_momentum),
            angular: self.angular.as_ref().map(Convert::to_wire),
        }
    }

    fn from_wire(wire: &wire::StageBudget, at: &Path<'_>) -> Result<Self, WireError> {
        Ok(Self {
            interface: required(&wire.interface, &at.field("interface"))?,
            accounts: accounts_from_wire(&wire.accounts, at)?,
            duration: any_number(wire.duration_s),
            momentum_change: any_vector(&wire.momentum_change_kg_m_per_s, at, "momentum_change_kg_m_per_s")?,
            gross_momentum: any_number(wire.gross_momentum_kg_m_per_s),
            angular: optional(&wire.angular, &at.field("angular"))?,
        })
    }
}

impl Convert for AngularBudget {
    type Wire = wire::AngularBudget;

    fn to_wire(&self) -> wire::AngularBudget {
        wire::AngularBudget {
            change_kg_m2_per_s: vector_to_wire(&self.change),
            gross_kg_m2_per_s: Some(self.gross),
        }
    }

    fn from_wire(wire: &wire::AngularBudget, at: &Path<'_>) -> Result<Self, WireError> {
        Ok(Self {
            change: any_vector(&wire.change_kg_m2_per_s, at, "change_kg_m2_per_s")?,
            gross: any_number(wire.gross_kg_m2_per_s),
        })
    }
}

impl Convert for MomentumReport {
    type Wire = wire::MomentumReport;

    fn to_wire(&self) -> wire::MomentumReport {
        wire::MomentumReport {
            change_kg_m_per_s: vector_to_wire(&self.change),
            gross_kg_m_per_s: Some(self.gross),
            angular: self.angular.as_ref().map(Convert::to_wire),
        }
    }

    fn from_wire(wire: &wire::MomentumReport, at: &Path<'_>) -> Result<Self, WireError> {
        Ok(Self {
            change: any_vector(&wire.change_kg_m_per_s, at, "change_kg_m_per_s")?,
            gross: any_number(wire.gross_kg_m_per_s),
            angular: optional(&wire.angular, &at.field("angular"))?,
        })
    }
}

/// The stores of an energy budget in short.
pub(super) fn stores_to_wire(report: &EnergyReport) -> wire::Energies {
    use EnergyAccount::{Compression, Kinetic, Potential, Relaxation, Strain};
    let internal = [Compression, Relaxation, Strain].map(|account| report.value(account));
    wire::Energies {
        kinetic_j: Some(report.value(Kinetic)),
        potential_j: Some(report.value(Potential)),
        internal_j: Some(internal.iter().sum()),
    }
}

/// The accounts of an energy budget, by name.
pub(super) fn energies_to_wire(report: &EnergyReport) -> Vec<wire::EnergyEntry> {
    let entry = |(account, entry): (EnergyAccount, EnergyEntry)| wire::EnergyEntry {
        account: account.name().to_owned(),
        value_j: Some(entry.value),
        start_j: (account.kind() == EnergyKind::Store).then_some(entry.start),
    };
    report.entries().map(entry).collect()
}

/// The same back; what is wrong with a name says which there are.
pub(super) fn energies_from_wire(
    wire: &[wire::EnergyEntry],
    at: &Path<'_>,
) -> Result<EnergyReport, WireError> {
    let mut report = EnergyReport::default();
    for (k, entry) in wire.iter().enumerate() {
        let at = at.item("energy_accounts", k);
        let Some(account) = EnergyAccount::named(&entry.account) else {
            let known: Vec<&str> = EnergyAccount::all().map(EnergyAccount::name).collect();
            let problem =
                format!("`{}` is no account of energy; allowed: {}", entry.account, known.join(", "));
            return Err(at.field("account").error(problem));
        };
        if report.get(account).is_some() {
            return Err(at.field("account").error(format!("repeats {}", account.name())));
        }
        let start = match account.kind() {
            EnergyKind::Store => any_number(entry.start_j),
            EnergyKind::Work | EnergyKind::Loss => 0.0,
        };
        report.set(account, EnergyEntry { value: any_number(entry.value_j), start });
    }
    Ok(report)
}

impl Convert for Counts {
    type Wire = wire::Counts;

    fn to_wire(&self) -> wire::Counts {
        wire::Counts {
            particles: self.particles,
            wall_particles: self.wall_particles,
            list_builds: self.list_builds,
            escaped: self.escaped,
            outflow: self.outflow,
            largest_interface: self.largest_interface,
            deepest_contact_m: Some(self.deepest_contact_m),
            contact_impulse_n_s: Some(self.contact_impulse_n_s),
            substeps: self.substeps,
            parts: self.parts.as_ref().map(PartCounts::to_wire),
        }
    }

    fn from_wire(wire: &wire::Counts, at: &Path<'_>) -> Result<Self, WireError> {
        let parts = wire.parts.as_ref().map(|parts| PartCounts::from_wire(parts, &at.field("parts")));
        Ok(Self {
            particles: wire.particles,
            wall_particles: wire.wall_particles,
            list_builds: wire.list_builds,
            escaped: wire.escaped,
            outflow: wire.outflow,
            largest_interface: wire.largest_interface,
            deepest_contact_m: any_number(wire.deepest_contact_m),
            contact_impulse_n_s: any_number(wire.contact_impulse_n_s),
            substeps: wire.substeps,
            parts: parts.transpose()?,
        })
    }
}

impl Convert for PartCounts {
    type Wire = wire::PartCounts;

    fn to_wire(&self) -> wire::PartCounts {
        wire::PartCounts {
            each: self.each.iter().map(PartCount::to_wire).collect(),
            mean_imbalance: self.mean_imbalance,
            largest_imbalance: self.largest_imbalance,
        }
    }

    fn from_wire(wire: &wire::PartCounts, at: &Path<'_>) -> Result<Self, WireError> {
        let each = wire.each.iter().map(|part| PartCount::from_wire(part, at));
        Ok(Self {
            each: each.collect::<Result<_, _>>()?,
            mean_imbalance: wire.mean_imbalance,
            largest_imbalance: wire.largest_imbalance,
        })
    }
}

impl Convert for PartCount {
    type Wire = wire::PartCount;

    fn to_wire(&self) -> wire::PartCount {
        wire::PartCount {
            particles: self.particles,
            copies: self.copies,
            computing_s: Some(self.computing_seconds),
            waited_for_copies_s: Some(self.waited_for_copies_seconds),
            waited_for_agreement_s: Some(self.waited_for_agreement_seconds),
            copy_messages: self.copy_messages,
            copy_bytes: self.copy_bytes,
            other_messages: self.other_messages,
            other_bytes: self.other_bytes,
        }
    }

    fn from_wire(wire: &wire::PartCount, _at: &Path<'_>) -> Result<Self, WireError> {
        Ok(Self {
            particles: wire.particles,
            copies: wire.copies,
            computing_seconds: any_number(wire.computing_s),
            waited_for_copies_seconds: any_number(wire.waited_for_copies_s),
            waited_for_agreement_seconds: any_number(wire.waited_for_agreement_s),
            copy_messages: wire.copy_messages,
            copy_bytes: wire.copy_bytes,
            other_messages: wire.other_messages,
            other_bytes: wire.other_bytes,
        })
    }
}

impl Convert for Divergence {
    type Wire = wire::Divergence;

    fn to_wire(&self) -> wire::Divergence {
        wire::Divergence {
            at: Some(self.at.to_wire()),
            particle: self.particle,
            position_m: self.position.as_deref().and_then(components_to_wire),
            quantity: self.quantity.clone(),
            value: Some(self.value),
            allowed: self.allowed.clone(),
            hint: self.hint.clone(),
        }
    }

    fn from_wire(wire: &wire::Divergence, at: &Path<'_>) -> Result<Self, WireError> {
        Ok(Self {
            at: required(&wire.at, &at.field("at"))?,
            particle: wire.particle,
            position: wire.position_m.as_ref().map(|position| position.components.clone()),
            quantity: text(&wire.quantity, &at.field("quantity"))?,
            value: any_number(wire.value),
            allowed: text(&wire.allowed, &at.field("allowed"))?,
            hint: text(&wire.hint, &at.field("hint"))?,
        })
    }
}

impl Convert for Breach {
    type Wire = wire::Breach;

    fn to_wire(&self) -> wire::Breach {
        wire::Breach {
            at: Some(self.at.to_wire()),
            check: self.check.code(),
            residual: Some(self.residual),
            tolerance: Some(self.tolerance),
        }
    }

    fn from_wire(wire: &wire::Breach, at: &Path<'_>) -> Result<Self, WireError> {
        Ok(Self {
            at: required(&wire.at, &at.field("at"))?,
            check: choice(wire.check, &at.field("check"))?,
            residual: any_number(wire.residual),
            tolerance: any_number(wire.tolerance),
        })
    }
}

impl Convert for Fault {
    type Wire = wire::Fault;

    fn to_wire(&self) -> wire::Fault {
        use wire::fault::Kind;
        let kind = match self {
            Fault::Diverged(divergence) => Kind::Diverged(divergence.to_wire()),
            Fault::Ledger(breach) => Kind::Ledger(breach.to_wire()),
            Fault::StaleFrame { at, sent, used } => {
                Kind::StaleFrame(wire::StaleFrame { at: Some(at.to_wire()), sent: *sent, used: *used })
            }
            Fault::Coverage { at, shortfall } => {
                Kind::Coverage(wire::CoverageGap { at: Some(at.to_wire()), shortfall_m: Some(*shortfall) })
            }
            Fault::Clock { at, difference } => {
                Kind::Clock(wire::ClockDifference { at: Some(at.to_wire()), difference: difference.clone() })
            }
            Fault::Peer { at, message } => {
                Kind::Peer(wire::PeerFault { at: Some(at.to_wire()), message: message.clone() })
            }
            Fault::Contradiction { at, message } => {
                Kind::Contradiction(wire::Contradiction { at: Some(at.to_wire()), message: message.clone() })
            }
            Fault::Aborted { at } => Kind::Aborted(wire::Aborted { at: Some(at.to_wire()) }),
        };
        wire::Fault { kind: Some(kind) }
    }

    fn from_wire(wire: &wire::Fault, at: &Path<'_>) -> Result<Self, WireError> {
        use wire::fault::Kind;
        let when = |stage: &Option<wire::StepStage>| required(stage, &at.field("at"));
        Ok(match &wire.kind {
            Some(Kind::Diverged(divergence)) => {
                Fault::Diverged(Divergence::from_wire(divergence, &at.field("diverged"))?)
            }
            Some(Kind::Ledger(breach)) => Fault::Ledger(Breach::from_wire(breach, &at.field("ledger"))?),
            Some(Kind::StaleFrame(stale)) => {
                Fault::StaleFrame { at: when(&stale.at)?, sent: stale.sent, used: stale.used }
            }
            Some(Kind::Coverage(gap)) => {
                Fault::Coverage { at: when(&gap.at)?, shortfall: any_number(gap.shortfall_m) }
            }
            Some(Kind::Clock(clock)) => Fault::Clock {
                at: when(&clock.at)?,
                difference: text(&clock.difference, &at.field("difference"))?,
            },
            Some(Kind::Peer(peer)) => {
                Fault::Peer { at: when(&peer.at)?, message: text(&peer.message, &at.field("message"))? }
            }
            Some(Kind::Contradiction(found)) => Fault::Contradiction {
                at: when(&found.at)?,
                message: text(&found.message, &at.field("message"))?,
            },
            Some(Kind::Aborted(aborted)) => Fault::Aborted { at: when(&aborted.at)? },
            None => return Err(at.field("kind").error("is missing or of a later version of the protocol")),
        })
    }
}
