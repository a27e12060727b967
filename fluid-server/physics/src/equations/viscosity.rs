//! The viscous pair force, Σ_j V_j 2μ (dW/dr)/r v_ij (Morris et al. 1997), and the moment that it is divided by.

use sph::lanes::Lanes;
use sph::space::Space;

use crate::system::thresholds::Thresholds;

/// μ of each particle over its mean moment, the mean of the diagonal of its moment matrix, within limits \[Pa s\].
///
/// On a lattice the kernel sums give a quadratic profile M times its curvature, and between other neighbours some
/// percent more or less: the mean of the diagonal of Σ V_j (x_j − x_i) ⊗ ∇W measures it.
pub fn corrected<S: Thresholds>(viscosity: f64, mean_moment: f64) -> f64 {
    viscosity / mean_moment.clamp(S::SMALLEST_MEAN_MOMENT, S::LARGEST_MEAN_MOMENT)
}

/// Part of Σ V_j [...]·∇W \[Pa/m\] by the viscosity of neighbours: −(μ_i + μ_j) V_j (dW/dr)/r v_ij.
///
/// `weight` = V_j (dW/dr)/r \[1/m²\], `relative_velocity` the part of v_ij that viscosity resists.
#[inline(always)]
pub fn drag<S: Space, L: Lanes>(viscosity: L, weight: L, relative_velocity: S::Of<L>) -> S::Of<L> {
    S::minus(S::splat(L::zero()), S::scaled(relative_velocity, viscosity * weight))
}
