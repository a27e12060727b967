//! The momentum budget of a stage: sums over the particles that it has moved.

use std::ops::AddAssign;

use sph::coupling::ledger::Energies;
use sph::lanes::Lanes;
use sph::space::Vector;

use crate::system::lane_arrays::largest;

/// Forces of a stage and the change of momentum by them, summed over particles.
#[derive(Clone, Copy, Debug, Default)]
pub struct MomentumBudget {
    /// Force of the damping \[N/m\].
    pub damping: Vector,
    /// Σ m |a| + |p| V/h, the scale of round-off of the forces \[N/m\].
    pub gross: f64,
    /// Largest acceleration \[m/s²\].
    pub largest_acceleration: f64,
    /// Σ m (v − vⁿ) \[kg/s\].
    pub momentum: Vector,
    /// Σ m |v| + m |vⁿ| \[kg/s\].
    pub gross_momentum: f64,
    /// Angular momentum, about the domain's torque origin.
    pub angular: AngularBudgetSums,
    /// Of the state that ends a step \[J/m\].
    pub energies: Energies,
}

impl AddAssign for MomentumBudget {
    fn add_assign(&mut self, other: Self) {
        self.damping += other.damping;
        self.gross += other.gross;
        self.largest_acceleration = self.largest_acceleration.max(other.largest_acceleration);
        self.momentum += other.momentum;
        self.gross_momentum += other.gross_momentum;
        self.angular += other.angular;
        self.energies += other.energies;
    }
}

/// Change of angular momentum in a stage, and its causes other than the rates, summed over particles.
#[derive(Clone, Copy, Debug, Default)]
pub struct AngularBudgetSums {
    /// Σ m [(x − x₀) × v − (xⁿ − x₀) × vⁿ] \[kg m/s\].
    pub change: f64,
    /// Σ m |x − x₀| (|v| + |vⁿ|) \[kg m/s\].
    pub gross_change: f64,
    /// Σ |x − x₀| (m |a| + |p| V/h) \[N\].
    pub gross_torque: f64,
    /// Torque of the damping \[N\].
    pub damping: f64,
    /// Part of shifting, Σ m δx × v \[kg m/s\].
    pub shifting: f64,
    /// Part of the time scheme, [`sph::coupling::ledger::scheme_moment`] \[kg m/s\].
    pub scheme: f64,
}

impl AddAssign for AngularBudgetSums {
    fn add_assign(&mut self, other: Self) {
        self.change += other.change;
        self.gross_change += other.gross_change;
        self.gross_torque += other.gross_torque;
        self.damping += other.damping;
        self.shifting += other.shifting;
        self.scheme += other.scheme;
    }
}

/// [`AngularBudgetSums`] in lanes.
#[derive(Clone, Copy, Debug)]
pub struct LaneAngularBudget<L> {
    /// Change \[kg m/s\].
    pub change: L,
    /// Its gross \[kg m/s\].
    pub gross_change: L,
    /// Gross of the torques \[N\].
    pub gross_torque: L,
    /// Torque of the damping \[N\].
    pub damping: L,
    /// Part of shifting \[kg m/s\].
    pub shifting: L,
    /// Part of the time scheme \[kg m/s\].
    pub scheme: L,
}

impl<L: Lanes> LaneAngularBudget<L> {
    #[inline(always)]
    fn none() -> Self {
        let zero = L::zero();
        Self {
            change: zero,
            gross_change: zero,
            gross_torque: zero,
            damping: zero,
            shifting: zero,
            scheme: zero,
        }
    }

    #[inline(always)]
    fn total(&self) -> AngularBudgetSums {
        let [change, gross_change, gross_torque, damping] =
            L::sums([self.change, self.gross_change, self.gross_torque, self.damping]);
        let [shifting, scheme, ..] = L::sums([self.shifting, self.scheme, L::zero(), L::zero()]);
        AngularBudgetSums { change, gross_change, gross_torque, damping, shifting, scheme }
    }
}

/// [`MomentumBudget`] in lanes.
#[derive(Clone, Copy, Debug)]
pub struct LaneMomentumBudget<L> {
    /// Force of the damping \[N/m\].
    pub damping: [L; 2],
    /// Scale of round-off of the forces \[N/m\].
    pub gross: L,
    /// Largest acceleration \[m/s²\].
    pub largest_acceleration: L,
    /// Change of momentum \[kg/s\].
    pub momentum: [L; 2],
    /// Its gross \[kg/s\].
    pub gross_momentum: L,
    /// Angular momentum.
    pub angular: LaneAngularBudget<L>,
    /// Kinetic energy \[J/m\].
    pub kinetic: L,
    /// Potential energy \[J/m\].
    pub potential: L,
    /// Energy of compression \[J/m\].
    pub internal: L,
}

impl<L: Lanes> LaneMomentumBudget<L> {
    /// Over no particle.
    #[inline(always)]
    pub fn none() -> Self {
        let zero = L::zero();
        Self {
            damping: [zero; 2],
            gross: zero,
            largest_acceleration: zero,
            momentum: [zero; 2],
            gross_momentum: zero,
            angular: LaneAngularBudget::none(),
            kinetic: zero,
            potential: zero,
            internal: zero,
        }
    }

    /// Over all lanes.
    #[inline(always)]
    pub fn total(&self) -> MomentumBudget {
        let ([damped_x, damped_y], [x, y]) = (self.damping, self.momentum);
        let [damped_x, damped_y, x, y] = L::sums([damped_x, damped_y, x, y]);
        let [gross, gross_momentum, kinetic, potential] =
            L::sums([self.gross, self.gross_momentum, self.kinetic, self.potential]);
        let [internal, ..] = L::sums([self.internal, L::zero(), L::zero(), L::zero()]);
        MomentumBudget {
            damping: Vector::new(damped_x, damped_y),
            gross,
            largest_acceleration: largest(self.largest_acceleration),
            momentum: Vector::new(x, y),
            gross_momentum,
            angular: self.angular.total(),
            energies: Energies { kinetic, potential, internal },
        }
    }
}
