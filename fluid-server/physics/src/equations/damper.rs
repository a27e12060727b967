//! The acoustic damper.

use super::neighbour_sums::NeighbourSums;
use crate::system::model::FluidModel;
use crate::system::packed_particle::FluidSpace;

/// Pressure of the acoustic damper \[Pa\], which acts in the momentum equation alone.
///
/// ```text
/// q_i = −α ρ_i c₀ h (∇·v)_i (1 − k s_i)₊,  k = SOLID_FADING
/// ```
/// A bulk viscosity: it damps sound and leaves vortices alone, as the term of Sun, Pilloton, Antuono & Colagrossi
/// (2023). s_i is the share of solids in the support; near them the damper fades, since the reaction of a
/// solid particle would need states of this stage that are not exchanged.
///
/// ∇·v is read through `inverse` = L_i: on disordered particles the plain sum does not vanish for a solenoidal field.
pub fn damper<S: FluidSpace>(
    model: &FluidModel<S>,
    sums: &NeighbourSums<S>,
    inverse: Option<S::Symmetric<f64>>,
    density: f64,
) -> f64 {
    if !model.has_damper() {
        return 0.0;
    }
    let divergence = S::contracted(sums.velocity_gradient(), inverse.unwrap_or(S::identity()));
    let clear = (1.0 - S::SOLID_FADING * sums.solid_share).max(0.0);
    -model.acoustic_diffusivity * density * divergence * clear
}
