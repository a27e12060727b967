//! The gradient correction L_i of Eq. (21) in the momentum equation, and where it is trusted.

use super::tensors::{IDENTITY, Symmetric};
use crate::system::model::FluidModel;

/// Determinant of the moment matrix below which the density gradient counts as zero: too few neighbours define it
/// \[-\].
pub const SMALLEST_GRADIENT_DETERMINANT: f64 = 1e-3;

/// Determinant of the moment matrix below which L_i is the unit matrix: in spray a large L_i does more harm than good
/// \[-\].
pub const SMALLEST_CORRECTION_DETERMINANT: f64 = 0.3;

/// Determinants between which L_i fades into Eq. (22). At a surface few neighbours on one side define it: pressure
/// forces with it tear splashes apart, and raise the frequency of sound above the stability limit of the time step.
const MOMENTUM_DETERMINANTS: (f64, f64) = (0.4, 0.7);

/// Largest share of L_i in Eq. (22) \[-\]. The rest, the plain sum, keeps the particles evenly spaced under pressure:
/// with L_i alone no arrangement is preferred, and fluid at rest keeps creeping and contracts.
const LARGEST_SHARE: f64 = 0.8;

/// L_i as Eq. (22) takes it: most of it where the neighbours surround the particle, none of it at a surface; the unit
/// matrix where the case does not correct momentum.
///
/// The rest is that of the plain sum, 1/M I.
#[inline(always)]
pub fn in_momentum(model: &FluidModel, correction: &Symmetric) -> Symmetric {
    if !model.corrects_momentum() {
        return IDENTITY;
    }
    let [xx, xy, yy] = *correction;
    let determinant = 1.0 / (xx * yy - xy * xy);
    let (least, enough) = MOMENTUM_DETERMINANTS;
    let share = LARGEST_SHARE * ((determinant - least) / (enough - least)).clamp(0.0, 1.0);
    let rest = (1.0 - share) * model.cross_gradient_scale;
    [share * xx + rest, share * xy, share * yy + rest]
}
