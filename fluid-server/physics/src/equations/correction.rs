//! The gradient correction L_i of Eq. (21) in the momentum equation, and where it is trusted.

use super::tensors::{IDENTITY, Symmetric};
use crate::system::model::FluidModel;

/// Below this determinant of the moment matrix the density gradient counts as zero: too few neighbours define it.
pub const SMALLEST_GRADIENT_DETERMINANT: f64 = 1e-3;

/// Below this determinant L_i is the unit matrix: at spray a large L_i does more harm than the error it cures.
pub const SMALLEST_CORRECTION_DETERMINANT: f64 = 0.3;

/// Determinants between which L_i fades into Eq. (22). At a surface it belongs to few neighbours on one side: pressure
/// forces by it tear splashes apart, and raise the frequency of sound above what steps allow that are stable elsewhere.
const MOMENTUM_DETERMINANTS: (f64, f64) = (0.4, 0.7);

/// Largest share of L_i in Eq. (22). The rest, the plain sum, restores the order of the particles under pressure: with
/// L_i alone no arrangement is better than another, and still water goes on creeping and draws together.
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
