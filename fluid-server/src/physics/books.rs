//! Sums over the particles that a stage has moved.

use std::ops::AddAssign;

use sph::lanes::Lanes;
use sph::ledger::Energies;
use sph::vector::Vector;

use super::four::largest;

/// Sums over particles of the forces of a stage and of what they did to the momentum.
#[derive(Clone, Copy, Debug, Default)]
pub struct Books {
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
    /// Of the state that ends a step \[J/m\].
    pub energies: Energies,
}

impl AddAssign for Books {
    fn add_assign(&mut self, other: Self) {
        self.damping += other.damping;
        self.gross += other.gross;
        self.largest_acceleration = self.largest_acceleration.max(other.largest_acceleration);
        self.momentum += other.momentum;
        self.gross_momentum += other.gross_momentum;
        self.energies += other.energies;
    }
}

/// [`Books`] in lanes.
#[derive(Clone, Copy, Debug)]
pub struct LaneBooks<L> {
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
    /// Kinetic energy \[J/m\].
    pub kinetic: L,
    /// Potential energy \[J/m\].
    pub potential: L,
    /// Energy of compression \[J/m\].
    pub internal: L,
}

impl<L: Lanes> LaneBooks<L> {
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
            kinetic: zero,
            potential: zero,
            internal: zero,
        }
    }

    /// Over all lanes.
    #[inline(always)]
    pub fn total(&self) -> Books {
        let ([damped_x, damped_y], [x, y]) = (self.damping, self.momentum);
        let [damped_x, damped_y, x, y] = L::sums([damped_x, damped_y, x, y]);
        let [gross, gross_momentum, kinetic, potential] =
            L::sums([self.gross, self.gross_momentum, self.kinetic, self.potential]);
        let [internal, ..] = L::sums([self.internal, L::zero(), L::zero(), L::zero()]);
        Books {
            damping: Vector::new(damped_x, damped_y),
            gross,
            largest_acceleration: largest(self.largest_acceleration),
            momentum: Vector::new(x, y),
            gross_momentum,
            energies: Energies { kinetic, potential, internal },
        }
    }
}
