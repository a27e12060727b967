//! Which of several faults is the cause.

use sph::coupling::solver::Fault;

use crate::failure::Kind;

/// From this rank on a fault is what another failure left behind.
pub(super) const RANK_CONSEQUENCE: u8 = 5;

/// Causes before consequences: when one side diverges, the other only sees its partner go.
pub(super) fn rank(fault: &Fault) -> u8 {
    match fault {
        Fault::Diverged(_) => 0,
        Fault::StaleFrame { .. } => 1,
        Fault::Ledger(_) => 2,
        Fault::Coverage { .. } => 3,
        Fault::Clock { .. } => 4,
        Fault::Contradiction { .. } => 2,
        Fault::Peer { .. } => RANK_CONSEQUENCE,
        Fault::Aborted { .. } => RANK_CONSEQUENCE + 1,
    }
}

/// Kind of failure that a fault is.
pub(super) fn kind_of(fault: &Fault) -> Kind {
    match fault {
        Fault::Diverged(_) => Kind::Diverged,
        Fault::StaleFrame { .. } | Fault::Ledger(_) | Fault::Contradiction { .. } => Kind::Ledger,
        Fault::Coverage { .. } | Fault::Clock { .. } | Fault::Peer { .. } => Kind::Lost,
        Fault::Aborted { .. } => Kind::Stopped,
    }
}
