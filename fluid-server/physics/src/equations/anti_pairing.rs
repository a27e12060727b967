//! The anti-pairing factor R (W/W(Δx))ⁿ of shifting (Monaghan 2000).

use sph::lanes::Lanes;

use crate::system::model::FluidModel;

/// R and n of the anti-pairing term R (W/W(Δx))ⁿ (Monaghan 2000).
const PAIRING: f64 = 0.2;

/// The kernel ratio W/W(Δx) in lanes.
#[derive(Clone, Copy, Debug)]
pub struct Ratio<L> {
    /// 1/4 and 1 over (2−s)³/4 − (1−s)³ at s = Δx/h.
    outer: L,
    inner: L,
}

impl<L: Lanes> Ratio<L> {
    /// The ratio of `model`'s kernel.
    #[inline(always)]
    pub fn new(model: &FluidModel) -> Self {
        let c = &model.constants;
        let s = c.particle_spacing / c.smoothing_length;
        let value = 0.25 * (2.0 - s).max(0.0).powi(3) - (1.0 - s).max(0.0).powi(3);
        Self { outer: L::splat(0.25 / value), inner: L::splat(1.0 / value) }
    }

    /// R (W(r)/W(Δx))⁴, and the weight of a neighbour at s = r/h in the largest relative speed.
    #[inline(always)]
    pub fn pairing(&self, s: L) -> (L, L) {
        let outer = (L::splat(2.0) - s).max(L::zero());
        let inner = (L::splat(1.0) - s).max(L::zero());
        let outer_cube = self.outer * outer * (outer * outer);
        let ratio = outer_cube.minus_product(self.inner * inner, inner * inner);
        let square_ratio = ratio * ratio;
        (L::splat(PAIRING) * (square_ratio * square_ratio), outer.min(L::splat(1.0)))
    }
}

/// R (W/W(Δx))⁴ of one pair, where `ratio` is W/W(Δx).
pub fn pairing_of(ratio: f64) -> f64 {
    PAIRING * ratio.powi(4)
}
