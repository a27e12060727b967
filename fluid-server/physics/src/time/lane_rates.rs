//! The rates of four particles.

use sph::lanes::{Lanes, WIDTH};
use sph::space::Space;

use super::compression_budget::DensityChange;
use crate::rates::particle_rates::Rates;

/// [`Rates`] of four particles.
pub struct LaneRates<S: Space, L: Lanes> {
    /// Acceleration \[m/s²\].
    pub acceleration: S::Of<L>,
    /// Velocity of the shift \[m/s\].
    pub shift: S::Of<L>,
    /// Density rate \[kg/(m³ s)\].
    pub density: L,
    /// Part of it by the volume correction \[kg/(m³ s)\].
    pub volume: L,
    /// Acceleration of each particle \[m/s²\].
    pub own_acceleration: [S::Vector; WIDTH],
}

impl<S: Space, L: Lanes> LaneRates<S, L> {
    /// Those of the particles whose rates these are.
    #[inline(always)]
    pub fn of([a, b, c, d]: [Rates<S>; WIDTH]) -> Self {
        let own_acceleration = [a.acceleration, b.acceleration, c.acceleration, d.acceleration];
        Self {
            acceleration: S::lanes(own_acceleration.each_ref()),
            shift: S::lanes([&a.shift, &b.shift, &c.shift, &d.shift]),
            density: L::from_array([a.density, b.density, c.density, d.density]),
            volume: L::from_array([a.volume, b.volume, c.volume, d.volume]),
            own_acceleration,
        }
    }
}

impl<S: Space, L: Lanes> LaneRates<S, L> {
    /// Change of density by `continuity` \[kg/m³\], and by `others`, the part of the density rate without it
    /// \[kg/(m³ s)\], in `duration` \[s\].
    #[inline(always)]
    pub fn change(&self, continuity: L, others: L, duration: f64) -> DensityChange<L> {
        let duration = L::splat(duration);
        let diffusion = (others - self.volume) * duration;
        DensityChange { continuity, diffusion, volume: self.volume * duration }
    }

    /// Change of density in the corrector of leapfrog, of `half` a step \[s\], at a density `rate` of continuity
    /// \[kg/(m³ s)\].
    ///
    /// The half of diffusion and volume correction that acts after the boundary is kept as one number. The volume
    /// correction is therefore charged for the whole step here, and diffusion makes up for it there.
    #[inline(always)]
    pub fn change_to_boundary(&self, rate: L, half: f64) -> DensityChange<L> {
        let half = L::splat(half);
        let volume = self.volume * half;
        let volume = volume + volume;
        DensityChange { continuity: rate * half, diffusion: self.density * half - volume, volume }
    }
}
