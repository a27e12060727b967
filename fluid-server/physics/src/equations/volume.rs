//! The volume correction, which ties the density to the volume that the particles fill.
//!
//! Eq. (17) with L_i follows the flow, not the number of particles: each time that particles change their arrangement a
//! remainder is left, of one sign in shear, and Σ m/ρ parts from the volume that is there. The kernel sum
//!
//! ```text
//! σ_i = Σ_j V_j W_ij / s,  s the same sum on a lattice, j = i included
//! ```
//! reads this from positions and densities alone: where particles surround i, σ − 1 is how much more volume the
//! densities claim than there is.

use crate::equations::neighbour_sums::NeighbourSums;
use crate::system::model::FluidModel;
use crate::system::packed_particle::FluidSpace;

/// σ − 1 of a particle of `volume` \[m²\], within limits \[-\]; zero where the case does not ask for it.
#[inline(always)]
pub fn volume_excess<S: FluidSpace>(model: &FluidModel<S>, sums: &NeighbourSums<S>, volume: f64) -> f64 {
    if !model.corrects_volume() {
        return 0.0;
    }
    let (kernel, spacing) = (&model.kernel, model.constants.particle_spacing);
    let sum = volume * kernel.value(0.0) + sums.volume * kernel.value(spacing);
    (sum / model.lattice_sum - 1.0).clamp(-S::LARGEST_VOLUME_EXCESS, S::LARGEST_VOLUME_EXCESS)
}

/// Rate of the volume correction \[1/s\] for particles that move at U = `speed` \[m/s\] relative to each other, with
/// the smallest `eigenvalue` of the moment matrix \[-\].
///
/// ```text
/// dρ_i/dt gains ρ_i (σ_i − 1) r_i,   r_i = min(k U_i, 0.02 c₀)/h · clamp((λ_i − 0.8)/0.1, 0, 1)
/// ```
/// Disorder arises and is read as fast as particles pass each other: a rate by U leaves an error in equilibrium that
/// does not depend on spacing, flow or c₀, and leaves rigid motion alone.
#[inline(always)]
pub fn volume_rate<S: FluidSpace>(model: &FluidModel<S>, speed: f64, eigenvalue: f64) -> f64 {
    let c = &model.constants;
    let speed = (c.volume_correction * speed).min(S::LARGEST_VOLUME_SPEED * c.sound_speed);
    let (least, full) = (S::LEAST_VOLUME_EIGENVALUE, S::FULL_VOLUME_EIGENVALUE);
    speed / c.smoothing_length() * ((eigenvalue - least) / (full - least)).clamp(0.0, 1.0)
}
