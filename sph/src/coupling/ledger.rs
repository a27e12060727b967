//! The audit of what crosses the interface: sums per half-step and side, and the checks on them.

use std::ops::AddAssign;

use serde::{Deserialize, Serialize};

use crate::coupling::stage::StepStage;
use crate::setup::{CouplingKind, InterfaceLaw, LedgerPolicy, RunSetup};
use crate::space::{Space, Vector};

/// Sums over the pair forces that one side received from the other in one half-step, per metre of depth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct InterfaceSums {
    /// Σ f_ij \[N/m\].
    pub force: Vector,
    /// Σ |f_ij| \[N/m\]: the scale of the balance.
    pub gross_force: f64,
    /// Σ (x_i − x₀) × f_ij \[N\], about the domain's torque origin.
    pub torque: f64,
    /// Σ |x_i − x₀| |f_ij| \[N\].
    pub gross_torque: f64,
    /// ½ Σ (x_i − x_j) × f_ij \[N\]: what a non-central law leaves; both sides report the same value.
    pub couple: f64,
    /// Σ f_ij · v_i \[W/m\].
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

/// A named change of one side's momentum that is not a pair force between owners.
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
}

impl Account {
    /// All accounts in the order of [`Accounts`].
    pub const ALL: [Account; 7] = [
        Account::BodyForce,
        Account::Walls,
        Account::Supports,
        Account::WallContact,
        Account::Damping,
        Account::Stabilisers,
        Account::Removed,
    ];

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
        }
    }
}

/// Force of each account on one side \[N/m\].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Accounts([Vector; Account::ALL.len()]);

impl From<[Vector; Account::ALL.len()]> for Accounts {
    /// Accounts of these forces \[N/m\], in the order of [`Account::ALL`].
    fn from(forces: [Vector; Account::ALL.len()]) -> Self {
        Self(forces)
    }
}

impl Accounts {
    /// Force of `account` \[N/m\].
    pub fn get(&self, account: Account) -> Vector {
        self.0[account as usize]
    }

    /// Adds `force` \[N/m\] to `account`.
    pub fn add(&mut self, account: Account, force: Vector) {
        self.0[account as usize] += force;
    }

    /// Sum over all accounts \[N/m\].
    pub fn total(&self) -> Vector {
        self.0.iter().sum()
    }
}

/// A named change of one side's angular momentum that is not a pair force between owners.
///
/// The first seven are the torques of the forces of [`Account`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TorqueAccount {
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
    /// Contact of solids with each other: friction acts across the line between two particles.
    BodyContact,
    /// Forces between own particles where they do not act along the line between them: corrected gradients, viscous
    /// stress, stress of a solid, hourglass control.
    OwnForces,
    /// Shifting, which carries the momentum of a particle to another place.
    Shifting,
    /// The time scheme, see [`scheme_moment`].
    TimeScheme,
}

impl TorqueAccount {
    /// All accounts in the order of [`Torques`].
    pub const ALL: [TorqueAccount; 11] = [
        TorqueAccount::BodyForce,
        TorqueAccount::Walls,
        TorqueAccount::Supports,
        TorqueAccount::WallContact,
        TorqueAccount::Damping,
        TorqueAccount::Stabilisers,
        TorqueAccount::Removed,
        TorqueAccount::BodyContact,
        TorqueAccount::OwnForces,
        TorqueAccount::Shifting,
        TorqueAccount::TimeScheme,
    ];

    /// Name in outputs.
    pub fn name(self) -> &'static str {
        match self {
            TorqueAccount::BodyForce => "body_force",
            TorqueAccount::Walls => "walls",
            TorqueAccount::Supports => "supports",
            TorqueAccount::WallContact => "wall_contact",
            TorqueAccount::Damping => "damping",
            TorqueAccount::Stabilisers => "stabilisers",
            TorqueAccount::Removed => "removed",
            TorqueAccount::BodyContact => "body_contact",
            TorqueAccount::OwnForces => "own_forces",
            TorqueAccount::Shifting => "shifting",
            TorqueAccount::TimeScheme => "time_scheme",
        }
    }
}

/// Torque of each account on one side \[N\], about the domain's torque origin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Torques([f64; TorqueAccount::ALL.len()]);

impl From<[f64; TorqueAccount::ALL.len()]> for Torques {
    /// Accounts of these torques \[N\], in the order of [`TorqueAccount::ALL`].
    fn from(torques: [f64; TorqueAccount::ALL.len()]) -> Self {
        Self(torques)
    }
}

impl Torques {
    /// Torque of `account` \[N\].
    pub fn get(&self, account: TorqueAccount) -> f64 {
        self.0[account as usize]
    }

    /// Adds `torque` \[N\] to `account`.
    pub fn add(&mut self, account: TorqueAccount, torque: f64) {
        self.0[account as usize] += torque;
    }

    /// Sum over all accounts \[N\].
    pub fn total(&self) -> f64 {
        self.0.iter().sum()
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

/// Change of one side's angular momentum in one half-step, about the domain's torque origin.
///
/// The angular momentum is Σ m (x − x₀) × v over all own particles, plus I_c ω for each rigid body, with the
/// moment of inertia I_c = Σ m V/6 of its cells about their own centres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct AngularBudget {
    /// Torques of all origins but the interface.
    pub torques: Torques,
    /// Angular momentum after the stage minus that at the start of the step, summed over all particles \[kg m/s\].
    pub change: f64,
    /// Σ m |x − x₀| |v| at both ends plus duration · Σ |x − x₀| |f| \[kg m/s\]: the scale of round-off.
    pub gross: f64,
}

/// The books of one side for one half-step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StageBooks {
    /// Interface sums.
    pub interface: InterfaceSums,
    /// Forces of all other origins.
    pub accounts: Accounts,
    /// Time by which the stage advanced from the start of the step \[s\]; 0 where it moved no momentum, as in the predictor
    /// of the fluid's leapfrog, whose interface forces only serve the partner.
    pub duration: f64,
    /// Σ m v after the stage minus Σ m v at the start of the step, summed over all particles \[kg/s\].
    pub momentum_change: Vector,
    /// Σ m |v| at both ends plus duration · Σ m |a| \[kg/s\]: the scale of round-off in the momentum check.
    pub gross_momentum: f64,
    /// Budget of the angular momentum; `None` in a periodic domain, where torque has no meaning, and from solvers that
    /// report none.
    pub angular: Option<AngularBudget>,
}

/// What a solid reports of its momentum in one half-step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MomentumReport {
    /// Momentum after the stage minus that at the start of the step \[kg/s\].
    pub change: Vector,
    /// Scale of its round-off \[kg/s\].
    pub gross: f64,
    /// The same of the angular momentum, and its scale \[kg m/s\]; `None` without a budget.
    pub angular: Option<[f64; 2]>,
}

impl From<&StageBooks> for MomentumReport {
    fn from(books: &StageBooks) -> Self {
        Self {
            change: books.momentum_change,
            gross: books.gross_momentum,
            angular: books.angular.map(|angular| [angular.change, angular.gross]),
        }
    }
}

impl StageBooks {
    /// |ΔP − duration·(interface + accounts)| over the gross momentum \[-\]: check (b).
    pub fn momentum_residual(&self) -> f64 {
        let expected = self.duration * (self.interface.force + self.accounts.total());
        relative((self.momentum_change - expected).norm(), self.gross_momentum)
    }

    /// |ΔL − duration·(interface + accounts)| over the gross angular momentum \[-\]: check (b) for torques; 0 without
    /// a budget.
    pub fn angular_residual(&self) -> f64 {
        self.angular.map_or(0.0, |angular| {
            let expected = self.duration * (self.interface.torque + angular.torques.total());
            relative((angular.change - expected).abs(), angular.gross)
        })
    }
}

/// Energies of one side at a step boundary \[J/m\].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Energies {
    /// Kinetic.
    pub kinetic: f64,
    /// Potential, in constant gravity.
    pub potential: f64,
    /// Compression energy of a fluid, strain energy of a solid.
    pub internal: f64,
}

impl AddAssign for Energies {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        self.kinetic += other.kinetic;
        self.potential += other.potential;
        self.internal += other.internal;
    }
}

/// Imbalance of one half-step, relative to gross: check (a).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Imbalance {
    /// |F_fluid + F_solid| / gross force \[-\].
    pub force: f64,
    /// |T_fluid + T_solid − couple| / gross torque \[-\].
    pub torque: f64,
}

/// How the torque of an interface law is checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TorqueCheck {
    /// Pair forces act along x_ij: torques cancel.
    Central,
    /// They do not: torques cancel up to the couple Σ (x_i − x_j) × f_ij, which both sides report.
    WithCouple,
    /// They do not, and the partner receives loads, so that the fluid alone knows the couple: it counts for both.
    WithFluidCouple,
    /// A periodic direction leaves torque without meaning.
    Skipped,
}

impl TorqueCheck {
    /// The check that fits the interface law and the domain of a run.
    pub fn of(run: &RunSetup) -> Self {
        let Some(coupling) = &run.coupling else { return Self::Central };
        match (coupling.law, coupling.kind) {
            _ if run.domain.is_periodic() => Self::Skipped,
            (InterfaceLaw::Wall, _) => Self::Central,
            (_, CouplingKind::States) => Self::WithCouple,
            (_, CouplingKind::Loads) => Self::WithFluidCouple,
        }
    }
}

/// Compares both sides' sums of one half-step.
pub fn imbalance(ours: &InterfaceSums, theirs: &InterfaceSums, torque: TorqueCheck) -> Imbalance {
    let gross = ours.gross_force.max(theirs.gross_force);
    let gross_torque = ours.gross_torque.max(theirs.gross_torque);
    let net_torque = ours.torque + theirs.torque;
    let torque = match torque {
        TorqueCheck::Central => relative(net_torque.abs(), gross_torque),
        TorqueCheck::WithCouple => relative((net_torque - ours.couple - theirs.couple).abs(), gross_torque),
        // The solid reports none.
        TorqueCheck::WithFluidCouple => {
            relative((net_torque - 2.0 * (ours.couple + theirs.couple)).abs(), gross_torque)
        }
        TorqueCheck::Skipped => 0.0,
    };
    Imbalance { force: relative((ours.force + theirs.force).norm(), gross), torque }
}

/// `residual / gross`; a residual without any gross is infinitely wrong.
fn relative(residual: f64, gross: f64) -> f64 {
    if residual == 0.0 { 0.0 } else { residual / gross }
}

/// A failed check of the ledger.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Breach {
    /// Half-step for which the books do not balance.
    pub at: StepStage,
    /// Which balance failed.
    pub check: Check,
    /// Residual relative to gross \[-\].
    pub residual: f64,
    /// Allowed residual \[-\].
    pub tolerance: f64,
}

/// A balance that the ledger checks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Check {
    /// Action equals reaction: force.
    Force,
    /// Action equals reaction: torque.
    Torque,
    /// One side's momentum change equals the impulse of its forces.
    Momentum,
    /// One side's change of angular momentum equals the angular impulse of its forces.
    AngularMomentum,
}

impl Check {
    /// Name in outputs and messages.
    pub fn name(self) -> &'static str {
        match self {
            Check::Force => "action = reaction (force)",
            Check::Torque => "action = reaction (torque)",
            Check::Momentum => "momentum change = impulse of the forces",
            Check::AngularMomentum => "angular momentum change = angular impulse of the forces",
        }
    }
}

impl std::fmt::Display for Breach {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "ledger breach at {}: {} is off by {:.2e} of gross, allowed {:.0e}",
            self.at,
            self.check.name(),
            self.residual,
            self.tolerance
        )?;
        // Round-off stays below 1e-11; a wrong law is of order one. In between, sides used different states.
        if matches!(self.check, Check::Force | Check::Torque) && (1e-9..1e-1).contains(&self.residual) {
            f.write_str("; a residual of this size is the mark of stale data: one side used an older state")?;
        }
        Ok(())
    }
}

/// Breaches of checks (a) in one half-step, force before torque.
pub fn balance_breaches(at: StepStage, imbalance: &Imbalance, policy: &LedgerPolicy) -> Vec<Breach> {
    [(Check::Force, imbalance.force), (Check::Torque, imbalance.torque)]
        .into_iter()
        .filter(|(_, residual)| exceeds(*residual, policy.balance_tolerance))
        .map(|(check, residual)| Breach { at, check, residual, tolerance: policy.balance_tolerance })
        .collect()
}

/// Breaches of check (b) in one half-step of one side, momentum before angular momentum.
pub fn budget_breaches(at: StepStage, books: &StageBooks, policy: &LedgerPolicy) -> Vec<Breach> {
    let tolerance = policy.momentum_tolerance;
    [(Check::Momentum, books.momentum_residual()), (Check::AngularMomentum, books.angular_residual())]
        .into_iter()
        .filter(|(_, residual)| exceeds(*residual, tolerance))
        .map(|(check, residual)| Breach { at, check, residual, tolerance })
        .collect()
}

/// NaN exceeds everything.
pub(crate) fn exceeds(value: f64, tolerance: f64) -> bool {
    value.is_nan() || value > tolerance
}
