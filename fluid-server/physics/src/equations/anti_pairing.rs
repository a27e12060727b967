//! The anti-pairing factor R (W/W(Δx))ⁿ of shifting (Monaghan 2000).

use sph::kernel::shape::Spline;
use sph::lanes::Real;

use crate::system::model::FluidModel;
use crate::system::packed_particle::FluidSpace;

/// The kernel ratio W/W(Δx) over s = r/h.
#[derive(Clone, Copy, Debug)]
pub struct Ratio<R>(Spline<R>);

impl<R: Real> Ratio<R> {
    /// The ratio of `model`'s kernel.
    #[inline(always)]
    pub fn new<S: FluidSpace>(model: &FluidModel<S>) -> Self {
        let c = &model.constants;
        let at_spacing = Spline::scaled(1.0).at(c.particle_spacing / c.smoothing_length());
        Self(Spline::scaled(1.0 / at_spacing))
    }

    /// R (W(r)/W(Δx))⁴, R = `factor`.
    #[inline(always)]
    pub fn pairing(&self, factor: f64, s: R) -> R {
        let ratio = self.0.at(s);
        let square = ratio * ratio;
        R::splat(factor) * (square * square)
    }
}
