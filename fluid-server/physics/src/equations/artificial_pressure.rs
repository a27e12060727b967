//! Artificial pressure (Monaghan 2000): a pair force against the clumping of particles under tension.

use sph::lanes::Real;

use super::anti_pairing::Ratio;
use crate::system::model::FluidModel;
use crate::system::packed_particle::FluidSpace;

/// The pressure that a pair adds to p_i + p_j.
///
/// ```text
/// ε (W(r)/W(Δx))⁴ ([−p_i]₊ + [−p_j]₊)           Monaghan 2000, with pressures in place of p/ρ²
/// ```
/// It is central and symmetric in i and j.
#[derive(Clone, Copy, Debug)]
pub struct ArtificialPressure<R> {
    coefficient: f64,
    ratio: Ratio<R>,
}

impl<R: Real> ArtificialPressure<R> {
    /// That of `model`.
    #[inline(always)]
    pub fn new<S: FluidSpace>(model: &FluidModel<S>) -> Self {
        Self { coefficient: model.constants.artificial_pressure, ratio: Ratio::new(model) }
    }

    /// Whether it acts.
    #[inline(always)]
    pub fn acts(&self) -> bool {
        self.coefficient > 0.0
    }

    /// Its value \[Pa\] for pressures `own` and `other` at a distance of `s` = r/h.
    #[inline(always)]
    pub fn at(&self, s: R, own: R, other: R) -> R {
        let tension = (R::zero() - own).max(R::zero()) + (R::zero() - other).max(R::zero());
        self.ratio.pairing(self.coefficient, s) * tension
    }
}
