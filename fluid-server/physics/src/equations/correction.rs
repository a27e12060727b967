//! The gradient correction L_i of Eq. (21) in the momentum equation, and where it is trusted.

use crate::system::model::FluidModel;
use crate::system::packed_particle::FluidSpace;

/// L_i as Eq. (22) takes it: most of it where the neighbours surround the particle, none of it at a surface; the unit
/// matrix where the case does not correct momentum.
///
/// The rest is that of the plain sum, 1/M I.
#[inline(always)]
pub fn in_momentum<S: FluidSpace>(model: &FluidModel<S>, correction: S::Symmetric<f64>) -> S::Symmetric<f64> {
    if !model.corrects_momentum() {
        return S::identity();
    }
    let determinant = 1.0 / S::symmetric_determinant(correction);
    let (least, full) = (S::LEAST_MOMENTUM_DETERMINANT, S::FULL_MOMENTUM_DETERMINANT);
    let share = model.constants.correction_share * ((determinant - least) / (full - least)).clamp(0.0, 1.0);
    let rest = (1.0 - share) * model.cross_gradient_scale;
    S::symmetric_plus_isotropic(S::symmetric_scaled(correction, share), rest)
}
