//! What one side sends and receives in a half-step, by the kind of coupling.

use crate::coupling::exchange::FrameContent;
use crate::coupling::fixed_point::FixedPoint;
use crate::coupling::solver::Role;
use crate::setup::{CouplingKind, ParticipantSetup, RunPlan};

impl ParticipantSetup {
    /// Side that the participant plays.
    pub fn role(&self) -> Role {
        match self {
            Self::Fluid(_) => Role::Fluid,
            Self::Solid(_) => Role::Solid,
        }
    }
}

/// What one side exchanges with its partner in a half-step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CouplingRole {
    /// There is no partner.
    Alone,
    /// Both send states and evaluate the pair law.
    States,
    /// The fluid awaits coupling points and returns the force on each.
    GivesLoads,
    /// The solid sends coupling points and awaits the force on each.
    TakesLoads,
}

impl CouplingRole {
    /// What the solver of `role` exchanges, where it is `coupled` to a partner.
    pub(crate) fn of(role: Role, coupled: bool, setup: &RunPlan) -> Self {
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
            Self::TakesLoads => FrameContent::CouplingPoints,
        }
    }

    /// The fixed point that a solid seeks with implicit coupling.
    pub(crate) fn fixed_point(self, setup: &RunPlan) -> Option<FixedPoint> {
        let plan = setup.coupling.and_then(|coupling| coupling.implicit)?;
        (self == Self::TakesLoads).then(|| FixedPoint::new(plan))
    }
}
