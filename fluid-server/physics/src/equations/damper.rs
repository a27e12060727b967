//! The acoustic damper.

use super::neighbour_sums::NeighbourSums;
use super::tensors::{IDENTITY, Symmetric};
use crate::system::model::FluidModel;

/// Factor on the share of solids by which the damper fades \[-\].
const SOLID_FADING: f64 = 4.0;

/// Pressure of the acoustic damper \[Pa\], which acts in the momentum equation alone.
///
/// ```text
/// q_i = −α ρ_i c₀ h (∇·v)_i (1 − 4 s_i)₊
/// ```
/// A bulk viscosity: it damps sound and leaves vortices alone, as the term of Sun, Pilloton, Antuono & Colagrossi
/// (2023). s_i is the share of solids in the support; near them the damper fades, since the reaction of a
/// solid particle would need states of this stage that are not exchanged.
///
/// ∇·v is read through `inverse` = L_i: on disordered particles the plain sum does not vanish for a solenoidal field.
pub fn damper(model: &FluidModel, sums: &NeighbourSums, inverse: Option<Symmetric>, density: f64) -> f64 {
    if !model.has_damper() {
        return 0.0;
    }
    let [v_xx, v_xy, v_yx, v_yy] = sums.velocity_gradient();
    let [xx, xy, yy] = inverse.unwrap_or(IDENTITY);
    let divergence = v_xx * xx + (v_xy + v_yx) * xy + v_yy * yy;
    let clear = (1.0 - SOLID_FADING * sums.solid_share).max(0.0);
    -model.acoustic_diffusivity * density * divergence * clear
}
