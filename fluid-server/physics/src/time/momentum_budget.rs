//! The momentum budget of a stage: sums over the particles that it has moved.

use sph::coupling::ledger::Energies;
use sph::lanes::Lanes;
use sph::space::Space;
use sph::sums::{Numbers, each_of};

use super::compression_budget::CompressionBudget;
use crate::system::lane_arrays::largest;

/// Forces of a stage and the change of momentum by them, summed over particles.
#[derive(Clone, Copy, Debug, Default)]
pub struct MomentumBudget<S: Space> {
    /// Force of the damping \[N/m\].
    pub damping: S::Vector,
    /// Σ m |a| + |p| V/h, the scale of round-off of the forces \[N/m\].
    pub gross: f64,
    /// Largest acceleration \[m/s²\], which is no part of sums.
    pub largest_acceleration: f64,
    /// Σ m (v − vⁿ) \[kg/s\].
    pub momentum: S::Vector,
    /// Σ m |v| + m |vⁿ| \[kg/s\].
    pub gross_momentum: f64,
    /// Angular momentum, about the domain's torque origin.
    pub angular: AngularBudgetSums<S>,
    /// Of the state that ends a step \[J/m\].
    pub energies: Energies,
    /// What the stage did to the compression of the fluid.
    pub compression: CompressionBudget,
}

impl<S: Space> Numbers for MomentumBudget<S> {
    fn each(&mut self, visit: &mut dyn FnMut(&mut f64)) {
        let Self { damping, gross, momentum, gross_momentum, angular, energies, compression, .. } = self;
        let AngularBudgetSums { change, gross_change, gross_torque, damping: torque, shifting, scheme } =
            angular;
        let Energies { kinetic, potential, internal, relaxation } = energies;
        let CompressionBudget { continuity, diffusion, volume, relaxation_loss } = compression;
        [damping, momentum].into_iter().for_each(|vector| each_of(vector, visit));
        [change, torque, shifting, scheme].into_iter().for_each(|spin| each_of(spin, visit));
        [gross, gross_momentum, gross_change, gross_torque].into_iter().for_each(&mut *visit);
        [kinetic, potential, internal, relaxation].into_iter().for_each(&mut *visit);
        [continuity, diffusion, volume, relaxation_loss].into_iter().for_each(&mut *visit);
    }
}

/// Change of angular momentum in a stage, and its causes other than the rates, summed over particles.
#[derive(Clone, Copy, Debug, Default)]
pub struct AngularBudgetSums<S: Space> {
    /// Σ m [(x − x₀) × v − (xⁿ − x₀) × vⁿ] \[kg m/s\].
    pub change: S::Spin,
    /// Σ m |x − x₀| (|v| + |vⁿ|) \[kg m/s\].
    pub gross_change: f64,
    /// Σ |x − x₀| (m |a| + |p| V/h) \[N\].
    pub gross_torque: f64,
    /// Torque of the damping \[N\].
    pub damping: S::Spin,
    /// Part of shifting, Σ m δx × v \[kg m/s\].
    pub shifting: S::Spin,
    /// Part of the time scheme, [`sph::coupling::ledger::scheme_moment`] \[kg m/s\].
    pub scheme: S::Spin,
}

/// [`AngularBudgetSums`] in lanes.
#[derive(Clone, Copy, Debug)]
pub struct LaneAngularBudget<S: Space, L: Lanes> {
    /// Change \[kg m/s\].
    pub change: S::SpinOf<L>,
    /// Its gross \[kg m/s\].
    pub gross_change: L,
    /// Gross of the torques \[N\].
    pub gross_torque: L,
    /// Torque of the damping \[N\].
    pub damping: S::SpinOf<L>,
    /// Part of shifting \[kg m/s\].
    pub shifting: S::SpinOf<L>,
    /// Part of the time scheme \[kg m/s\].
    pub scheme: S::SpinOf<L>,
}

impl<S: Space, L: Lanes> LaneAngularBudget<S, L> {
    #[inline(always)]
    fn none() -> Self {
        let (zero, none) = (L::zero(), S::zero_spin());
        Self {
            change: none,
            gross_change: zero,
            gross_torque: zero,
            damping: none,
            shifting: none,
            scheme: none,
        }
    }

    #[inline(always)]
    fn total(&self) -> AngularBudgetSums<S> {
        let [gross_change, gross_torque, ..] =
            L::sums([self.gross_change, self.gross_torque, L::zero(), L::zero()]);
        AngularBudgetSums {
            change: S::spin_sum(self.change),
            gross_change,
            gross_torque,
            damping: S::spin_sum(self.damping),
            shifting: S::spin_sum(self.shifting),
            scheme: S::spin_sum(self.scheme),
        }
    }
}

/// [`MomentumBudget`] in lanes.
#[derive(Clone, Copy, Debug)]
pub struct LaneMomentumBudget<S: Space, L: Lanes> {
    /// Force of the damping \[N/m\].
    pub damping: S::Of<L>,
    /// Scale of round-off of the forces \[N/m\].
    pub gross: L,
    /// Largest acceleration \[m/s²\].
    pub largest_acceleration: L,
    /// Change of momentum \[kg/s\].
    pub momentum: S::Of<L>,
    /// Its gross \[kg/s\].
    pub gross_momentum: L,
    /// Angular momentum.
    pub angular: LaneAngularBudget<S, L>,
    /// Kinetic energy \[J/m\].
    pub kinetic: L,
    /// Potential energy \[J/m\].
    pub potential: L,
    /// Energy of compression \[J/m\].
    pub internal: L,
    /// What the acoustic relaxation stores \[J/m\].
    pub relaxation: L,
}

impl<S: Space, L: Lanes> LaneMomentumBudget<S, L> {
    /// Over no particle.
    #[inline(always)]
    pub fn none() -> Self {
        let zero = L::zero();
        Self {
            damping: S::splat(zero),
            gross: zero,
            largest_acceleration: zero,
            momentum: S::splat(zero),
            gross_momentum: zero,
            angular: LaneAngularBudget::none(),
            kinetic: zero,
            potential: zero,
            internal: zero,
            relaxation: zero,
        }
    }

    /// Over all lanes; `compression` is kept apart.
    #[inline(always)]
    pub fn total(&self, compression: CompressionBudget) -> MomentumBudget<S> {
        let [damping, momentum] = S::vector_sums(self.damping, self.momentum);
        let [gross, gross_momentum, kinetic, potential] =
            L::sums([self.gross, self.gross_momentum, self.kinetic, self.potential]);
        let [internal, relaxation, ..] = L::sums([self.internal, self.relaxation, L::zero(), L::zero()]);
        MomentumBudget {
            damping: S::vector(damping),
            gross,
            largest_acceleration: largest(self.largest_acceleration),
            momentum: S::vector(momentum),
            gross_momentum,
            angular: self.angular.total(),
            energies: Energies { kinetic, potential, internal, relaxation },
            compression,
        }
    }
}
