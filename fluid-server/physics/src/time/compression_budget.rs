//! What a stage does to the energy of compression, by cause.

use std::ops::AddAssign;

use sph::lanes::Lanes;

/// Changes of the energy of compression \[J/m\], summed over particles, and what the acoustic relaxation loses.
#[derive(Clone, Copy, Debug, Default)]
pub struct CompressionBudget {
    /// By continuity, Eq. (17).
    pub continuity: f64,
    /// By density diffusion, Eq. (18).
    pub diffusion: f64,
    /// By the volume correction.
    pub volume: f64,
    /// Lost in the acoustic relaxation.
    pub relaxation_loss: f64,
}

impl AddAssign for CompressionBudget {
    fn add_assign(&mut self, other: Self) {
        self.continuity += other.continuity;
        self.diffusion += other.diffusion;
        self.volume += other.volume;
        self.relaxation_loss += other.relaxation_loss;
    }
}

/// Change of the density of four particles by cause \[kg/m³\].
#[derive(Clone, Copy)]
pub struct DensityChange<L> {
    /// Continuity.
    pub continuity: L,
    /// Density diffusion.
    pub diffusion: L,
    /// Volume correction.
    pub volume: L,
}

impl<L: Lanes> DensityChange<L> {
    /// In the predictor of leapfrog: by continuity, and by the half of diffusion and volume correction of the step
    /// before that acts after its end, see [`super::lane_rates::LaneRates::change_to_boundary`].
    #[inline(always)]
    pub fn after_boundary(continuity: L, correction: L) -> Self {
        Self { continuity, diffusion: correction, volume: L::zero() }
    }
}

/// [`CompressionBudget`] in lanes.
#[derive(Clone, Copy)]
pub struct LaneCompressionBudget<L> {
    continuity: L,
    diffusion: L,
    volume: L,
    relaxation_loss: L,
}

impl<L: Lanes> LaneCompressionBudget<L> {
    /// Of no particle.
    #[inline(always)]
    pub fn none() -> Self {
        let zero = L::zero();
        Self { continuity: zero, diffusion: zero, volume: zero, relaxation_loss: zero }
    }

    /// Adds particles of `mass` per depth \[kg/m\] whose density changes by `change` between two `states` of density
    /// \[kg/m³\] and pressure by Eq. (3) \[Pa\].
    ///
    /// ```text
    /// m ½ (p₀/ρ₀² + p₁/ρ₁²) Δρ
    /// ```
    /// This is the change of the stored energy to third order in Δρ/ρ, a change of 1e-3 in a half-step being much.
    #[inline(always)]
    pub fn compresses(&mut self, mass: L, states: [(L, L); 2], change: &DensityChange<L>) {
        let [start, end] = states.map(|(density, pressure)| pressure / (density * density));
        let scale = L::splat(0.5) * mass * (start + end);
        self.continuity = self.continuity + scale * change.continuity;
        self.diffusion = self.diffusion + scale * change.diffusion;
        self.volume = self.volume + scale * change.volume;
    }

    /// Adds a loss of the acoustic relaxation \[J/m\].
    #[inline(always)]
    pub fn relaxes(&mut self, loss: L) {
        self.relaxation_loss = self.relaxation_loss + loss;
    }

    /// Over all lanes.
    #[inline(always)]
    pub fn total(&self) -> CompressionBudget {
        let [continuity, diffusion, volume, relaxation_loss] =
            L::sums([self.continuity, self.diffusion, self.volume, self.relaxation_loss]);
        CompressionBudget { continuity, diffusion, volume, relaxation_loss }
    }
}
