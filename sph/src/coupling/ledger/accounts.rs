//! Named accounts: every change of one side's momentum that is not a pair force across the interface.

use serde::{Deserialize, Serialize};

use super::LedgerVector;
use crate::space::Space;

/// A named change of one side's momentum or angular momentum that is not a pair force between owners.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Account {
    /// Gravity, other body forces and surface loads.
    BodyForce,
    /// Fixed and moving walls of the fluid.
    Walls,
    /// Supports of solids.
    Supports,
    /// Contact of solids with walls.
    WallContact,
    /// Linear damping.
    Damping,
    /// Stabilisers that are not antisymmetric.
    Stabilisers,
    /// Particles that left.
    Removed,
    /// Contact of solids with each other, torque only: friction acts across the line between two particles.
    BodyContact,
    /// Forces between own particles where they do not act along the line between them, torque only: corrected
    /// gradients, viscous stress, stress of a solid, hourglass control.
    OwnForces,
    /// Shifting, which carries the momentum of a particle to another place; torque only.
    Shifting,
    /// The time scheme, see [`scheme_moment`]; torque only.
    TimeScheme,
}

impl Account {
    /// All accounts.
    pub const ALL: [Account; 11] = [
        Account::BodyForce,
        Account::Walls,
        Account::Supports,
        Account::WallContact,
        Account::Damping,
        Account::Stabilisers,
        Account::Removed,
        Account::BodyContact,
        Account::OwnForces,
        Account::Shifting,
        Account::TimeScheme,
    ];

    /// The accounts whose force may differ from zero: the first of [`Account::ALL`].
    pub fn with_force() -> impl Iterator<Item = Account> {
        Self::ALL.into_iter().take_while(|account| *account != Account::BodyContact)
    }

    /// Name in outputs.
    pub fn name(self) -> &'static str {
        match self {
            Account::BodyForce => "body_force",
            Account::Walls => "walls",
            Account::Supports => "supports",
            Account::WallContact => "wall_contact",
            Account::Damping => "damping",
            Account::Stabilisers => "stabilisers",
            Account::Removed => "removed",
            Account::BodyContact => "body_contact",
            Account::OwnForces => "own_forces",
            Account::Shifting => "shifting",
            Account::TimeScheme => "time_scheme",
        }
    }
}

/// Force and torque of one account, means over the stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct AccountEntry {
    /// Force \[N\].
    pub force: LedgerVector,
    /// Torque about the domain's torque origin \[N m\]; zero without an angular budget.
    pub torque: LedgerVector,
}

/// Force and torque of each account of one side.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Accounts([AccountEntry; Account::ALL.len()]);

impl Accounts {
    /// Entry of `account`.
    pub fn get(&self, account: Account) -> AccountEntry {
        self.0[account as usize]
    }

    /// Adds `force` \[N\] to `account`.
    pub fn add_force(&mut self, account: Account, force: LedgerVector) {
        self.0[account as usize].force += force;
    }

    /// Adds `torque` \[N m\] to `account`.
    pub fn add_torque(&mut self, account: Account, torque: LedgerVector) {
        self.0[account as usize].torque += torque;
    }

    /// Sum of all forces \[N\].
    pub fn total_force(&self) -> LedgerVector {
        self.0.iter().map(|entry| entry.force).sum()
    }

    /// Sum of all torques \[N m\].
    pub fn total_torque(&self) -> LedgerVector {
        self.0.iter().map(|entry| entry.torque).sum()
    }
}

/// What a time scheme by itself does to the angular momentum of unit mass that moves from `start` over `stage`, where
/// its forces were evaluated, to `end`, each a place about the torque origin \[m\] and a velocity \[m/s\], in m²/s:
///
/// ```text
/// x₁ × v₁ − x₀ × v₀ = x_s × (v₁ − v₀) + [(x₁ − x_s) × v₁ + (x_s − x₀) × v₀]
/// ```
/// The first term is the moment of the forces at the places where they were evaluated, the second is returned. It
/// vanishes where positions move along the velocities beside them, as in leapfrog.
#[inline]
pub fn scheme_moment<S: Space>(
    start: (&S::Vector, &S::Vector),
    stage: &S::Vector,
    end: (&S::Vector, &S::Vector),
) -> S::Spin {
    S::cross(&(*end.0 - *stage), end.1) + S::cross(&(*stage - *start.0), start.1)
}
