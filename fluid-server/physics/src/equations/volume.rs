//! The volume correction, which ties the density to the volume that the particles fill.
//!
//! Eq. (17) with L_i follows the flow, not the number of particles: each time that particles change their arrangement a
//! remainder is left, of one sign in shear, and Σ m/ρ parts from the volume that is there.
//! [`crate::rates::volume_reading`] reads by how much, from positions and densities alone.

use crate::system::model::FluidModel;
use crate::system::packed_particle::FluidSpace;

/// Rate of the volume correction \[1/s\] for particles that move at U = `speed` \[m/s\] relative to each other, with
/// the smallest `eigenvalue` of the moment matrix \[-\].
///
/// ```text
/// dρ_i/dt gains ρ_i ε_i r_i,   r_i = min(k U_i, 0.2 c₀)/h · clamp((λ_i − 0.87)/0.06, 0, 1)
/// ```
/// Disorder arises as fast as particles pass each other: a rate by U leaves an error in equilibrium that does not depend
/// on spacing, flow or c₀, and leaves rigid motion alone.
#[inline(always)]
pub fn volume_rate<S: FluidSpace>(model: &FluidModel<S>, speed: f64, eigenvalue: f64) -> f64 {
    let c = &model.constants;
    let speed = (c.volume_correction * speed).min(S::LARGEST_VOLUME_SPEED * c.sound_speed);
    let (least, full) = (S::LEAST_VOLUME_EIGENVALUE, S::FULL_VOLUME_EIGENVALUE);
    speed / c.smoothing_length() * ((eigenvalue - least) / (full - least)).clamp(0.0, 1.0)
}
