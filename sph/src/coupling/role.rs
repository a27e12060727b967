//! The two kinds of coupling as the half-step driver sees them.

use crate::coupling::exchange::FrameContent;
use crate::coupling::fixed_point::Iteration;
use crate::coupling::solver::Role;
use crate::setup::{CouplingKind, RunSetup};

/// How one side meets its partner in a half-step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Meeting {
    /// There is no partner.
    Alone,
    /// Both send states and evaluate the pair law.
    States,
    /// The fluid awaits samples and returns the force on each.
    GivesLoads,
    /// The solid sends samples and awaits the force on each.
    TakesLoads,
}

impl Meeting {
    /// How the solver of `role` meets a partner, where it is `coupled` to one.
    pub(crate) fn of(role: Role, coupled: bool, setup: &RunSetup) -> Self {
        let kind = setup.coupling.map(|coupling| coupling.kind).unwrap_or_default();
        match (coupled, kind, role) {
            (false, ..) => Self::Alone,
            (true, CouplingKind::States, _) => Self::States,
            (true, CouplingKind::Loads, Role::Fluid) => Self::GivesLoads,
            (true, CouplingKind::Loads, Role::Solid) => Self::TakesLoads,
        }
    }

    /// What the own frames carry.
    pub(crate) fn content(self) -> FrameContent {
        match self {
            Self::Alone | Self::States => FrameContent::States,
            Self::GivesLoads => FrameContent::Forces,
            Self::TakesLoads => FrameContent::Samples,
        }
    }

    /// The iterations of a solid whose half-steps are iterated.
    pub(crate) fn iteration(self, setup: &RunSetup) -> Option<Iteration> {
        let plan = setup.coupling.and_then(|coupling| coupling.iterate)?;
        (self == Self::TakesLoads).then(|| Iteration::new(plan))
    }
}
