//! Budgets, facts and faults: numbers of a report may be anything, so that a breakdown can be reported.

use sph::coupling::ledger::MomentumReport;
use sph::coupling::ledger::{
    Account, Accounts, AngularBudget, Breach, Check, Energies, InterfaceSums, StageBooks, TorqueAccount,
    Torques,
};
use sph::coupling::solver::{Counts, Divergence, Fault};
use sph::coupling::stage::StepStage;
use sph::space::Vector;

use super::{Choice, Convert, Path, WireError, any_number, any_vector, choice, optional, required, text};
use crate::wire;

impl Choice for Check {
    const ALL: &'static [Self] = &[Check::Force, Check::Torque, Check::Momentum, Check::AngularMomentum];

    fn code(self) -> i32 {
        let wire = match self {
            Check::Force => wire::Check::Force,
            Check::Torque => wire::Check::Torque,
            Check::Momentum => wire::Check::Momentum,
            Check::AngularMomentum => wire::Check::AngularMomentum,
        };
        wire.into()
    }
}

impl Convert for StepStage {
    type Wire = wire::StepStage;

    fn to_wire(&self) -> wire::StepStage {
        wire::StepStage { step: self.step, stage: self.stage.code() }
    }

    fn from_wire(wire: &wire::StepStage, at: &Path<'_>) -> Result<Self, WireError> {
        Ok(Self { step: wire.step, stage: choice(wire.stage, &at.field("stage"))? })
    }
}

impl Convert for InterfaceSums {
    type Wire = wire::InterfaceSums;

    fn to_wire(&self) -> wire::InterfaceSums {
        wire::InterfaceSums {
            force_n_per_m: Some(self.force.to_wire()),
            gross_force_n_per_m: Some(self.gross_force),
            torque_n: Some(self.torque),
            gross_torque_n: Some(self.gross_torque),
            couple_n: Some(self.couple),
            power_w_per_m: Some(self.power),
            pairs: self.pairs,
        }
    }

    fn from_wire(wire: &wire::InterfaceSums, _at: &Path<'_>) -> Result<Self, WireError> {
        Ok(Self {
            force: any_vector(&wire.force_n_per_m),
            gross_force: any_number(wire.gross_force_n_per_m),
            torque: any_number(wire.torque_n),
            gross_torque: any_number(wire.gross_torque_n),
            couple: any_number(wire.couple_n),
            power: any_number(wire.power_w_per_m),
            pairs: wire.pairs,
        })
    }
}

impl Convert for Accounts {
    type Wire = wire::Accounts;

    fn to_wire(&self) -> wire::Accounts {
        let force = |account| Some(self.get(account).to_wire());
        wire::Accounts {
            body_force_n_per_m: force(Account::BodyForce),
            walls_n_per_m: force(Account::Walls),
            supports_n_per_m: force(Account::Supports),
            wall_contact_n_per_m: force(Account::WallContact),
            damping_n_per_m: force(Account::Damping),
            stabilisers_n_per_m: force(Account::Stabilisers),
            removed_n_per_m: force(Account::Removed),
        }
    }

    fn from_wire(wire: &wire::Accounts, _at: &Path<'_>) -> Result<Self, WireError> {
        let forces: [Vector; Account::ALL.len()] = Account::ALL.map(|account| {
            any_vector(match account {
                Account::BodyForce => &wire.body_force_n_per_m,
                Account::Walls => &wire.walls_n_per_m,
                Account::Supports => &wire.supports_n_per_m,
                Account::WallContact => &wire.wall_contact_n_per_m,
                Account::Damping => &wire.damping_n_per_m,
                Account::Stabilisers => &wire.stabilisers_n_per_m,
                Account::Removed => &wire.removed_n_per_m,
            })
        });
        Ok(Self::from(forces))
    }
}

impl Convert for StageBooks {
    type Wire = wire::StageBooks;

    fn to_wire(&self) -> wire::StageBooks {
        wire::StageBooks {
            interface: Some(self.interface.to_wire()),
            accounts: Some(self.accounts.to_wire()),
            duration_s: Some(self.duration),
            momentum_change_kg_per_s: Some(self.momentum_change.to_wire()),
            gross_momentum_kg_per_s: Some(self.gross_momentum),
            angular: self.angular.as_ref().map(Convert::to_wire),
        }
    }

    fn from_wire(wire: &wire::StageBooks, at: &Path<'_>) -> Result<Self, WireError> {
        Ok(Self {
            interface: required(&wire.interface, &at.field("interface"))?,
            accounts: required(&wire.accounts, &at.field("accounts"))?,
            duration: any_number(wire.duration_s),
            momentum_change: any_vector(&wire.momentum_change_kg_per_s),
            gross_momentum: any_number(wire.gross_momentum_kg_per_s),
            angular: optional(&wire.angular, &at.field("angular"))?,
        })
    }
}

impl Convert for AngularBudget {
    type Wire = wire::AngularBudget;

    fn to_wire(&self) -> wire::AngularBudget {
        wire::AngularBudget {
            torques: Some(self.torques.to_wire()),
            angular_momentum_change_kg_m_per_s: Some(self.change),
            gross_angular_momentum_kg_m_per_s: Some(self.gross),
        }
    }

    fn from_wire(wire: &wire::AngularBudget, at: &Path<'_>) -> Result<Self, WireError> {
        Ok(Self {
            torques: required(&wire.torques, &at.field("torques"))?,
            change: any_number(wire.angular_momentum_change_kg_m_per_s),
            gross: any_number(wire.gross_angular_momentum_kg_m_per_s),
        })
    }
}

impl Convert for Torques {
    type Wire = wire::Torques;

    fn to_wire(&self) -> wire::Torques {
        let torque = |account| Some(self.get(account));
        wire::Torques {
            body_force_n: torque(TorqueAccount::BodyForce),
            walls_n: torque(TorqueAccount::Walls),
            supports_n: torque(TorqueAccount::Supports),
            wall_contact_n: torque(TorqueAccount::WallContact),
            damping_n: torque(TorqueAccount::Damping),
            stabilisers_n: torque(TorqueAccount::Stabilisers),
            removed_n: torque(TorqueAccount::Removed),
            body_contact_n: torque(TorqueAccount::BodyContact),
            own_forces_n: torque(TorqueAccount::OwnForces),
            shifting_n: torque(TorqueAccount::Shifting),
            time_scheme_n: torque(TorqueAccount::TimeScheme),
        }
    }

    fn from_wire(wire: &wire::Torques, _at: &Path<'_>) -> Result<Self, WireError> {
        Ok(Self::from(TorqueAccount::ALL.map(|account| {
            any_number(match account {
                TorqueAccount::BodyForce => wire.body_force_n,
                TorqueAccount::Walls => wire.walls_n,
                TorqueAccount::Supports => wire.supports_n,
                TorqueAccount::WallContact => wire.wall_contact_n,
                TorqueAccount::Damping => wire.damping_n,
                TorqueAccount::Stabilisers => wire.stabilisers_n,
                TorqueAccount::Removed => wire.removed_n,
                TorqueAccount::BodyContact => wire.body_contact_n,
                TorqueAccount::OwnForces => wire.own_forces_n,
                TorqueAccount::Shifting => wire.shifting_n,
                TorqueAccount::TimeScheme => wire.time_scheme_n,
            })
        })))
    }
}

impl Convert for MomentumReport {
    type Wire = wire::MomentumReport;

    fn to_wire(&self) -> wire::MomentumReport {
        wire::MomentumReport {
            change_kg_per_s: Some(self.change.to_wire()),
            gross_kg_per_s: Some(self.gross),
            angular_change_kg_m_per_s: self.angular.map(|[change, _]| change),
            gross_angular_kg_m_per_s: self.angular.map(|[_, gross]| gross),
        }
    }

    fn from_wire(wire: &wire::MomentumReport, _at: &Path<'_>) -> Result<Self, WireError> {
        let angular = wire.angular_change_kg_m_per_s;
        Ok(Self {
            change: any_vector(&wire.change_kg_per_s),
            gross: any_number(wire.gross_kg_per_s),
            angular: angular.map(|change| [change, any_number(wire.gross_angular_kg_m_per_s)]),
        })
    }
}

impl Convert for Energies {
    type Wire = wire::Energies;

    fn to_wire(&self) -> wire::Energies {
        wire::Energies {
            kinetic_j_per_m: Some(self.kinetic),
            potential_j_per_m: Some(self.potential),
            internal_j_per_m: Some(self.internal),
        }
    }

    fn from_wire(wire: &wire::Energies, _at: &Path<'_>) -> Result<Self, WireError> {
        Ok(Self {
            kinetic: any_number(wire.kinetic_j_per_m),
            potential: any_number(wire.potential_j_per_m),
            internal: any_number(wire.internal_j_per_m),
        })
    }
}

impl Convert for Counts {
    type Wire = wire::Counts;

    fn to_wire(&self) -> wire::Counts {
        wire::Counts {
            particles: self.particles,
            wall_particles: self.wall_particles,
            list_builds: self.list_builds,
            lost: self.lost,
            outflow: self.outflow,
            largest_interface: self.largest_interface,
            deepest_contact_m: self.deepest_contact_m,
            contact_impulse_n_s_per_m: self.contact_impulse_n_s_per_m,
            substeps: self.substeps,
        }
    }

    fn from_wire(wire: &wire::Counts, _at: &Path<'_>) -> Result<Self, WireError> {
        Ok(Self {
            particles: wire.particles,
            wall_particles: wire.wall_particles,
            list_builds: wire.list_builds,
            lost: wire.lost,
            outflow: wire.outflow,
            largest_interface: wire.largest_interface,
            deepest_contact_m: wire.deepest_contact_m,
            contact_impulse_n_s_per_m: wire.contact_impulse_n_s_per_m,
            substeps: wire.substeps,
        })
    }
}

impl Convert for Divergence {
    type Wire = wire::Divergence;

    fn to_wire(&self) -> wire::Divergence {
        wire::Divergence {
            at: Some(self.at.to_wire()),
            particle: self.particle,
            position_m: self.position.map(|[x, y]| wire::Vector { x: Some(x), y: Some(y) }),
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
            position: wire
                .position_m
                .as_ref()
                .map(|position| [any_number(position.x), any_number(position.y)]),
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
