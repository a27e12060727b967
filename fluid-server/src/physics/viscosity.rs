//! The viscous pair force, Σ_j V_j 2μ (dW/dr)/r v_ij (Morris et al. 1997), and the moment that it is divided by.

use rayon::prelude::*;

use super::gradients::{Gradients, MomentSums};
use super::lanes::Lanes;
use super::model::FluidModel;
use super::rates::TASK;

/// Moments below and above this count as this: at a free surface half of the neighbours are missing by right.
const MOMENT_RANGE: (f64, f64) = (0.9, 1.1);

/// μ of each particle over half the trace of its moment matrix, within limits \[Pa s\].
///
/// On a lattice the kernel sums give a quadratic profile M times its curvature, and between other neighbours some
/// percent more or less: half the trace of Σ V_j (x_j − x_i) ⊗ ∇W tells how much.
fn corrected(viscosity: f64, sums: &MomentSums) -> f64 {
    viscosity / sums.mean_moment().clamp(MOMENT_RANGE.0, MOMENT_RANGE.1)
}

impl Gradients {
    /// Viscosity of each particle for the pair force; nothing where the case has none.
    pub fn finish_viscosity(&mut self, model: &FluidModel) {
        if !model.passes.pair_viscosity {
            return;
        }
        self.viscosity.resize(self.sums.len(), 0.0);
        let viscosity = model.constants.dynamic_viscosity;
        self.viscosity.par_iter_mut().zip(&self.sums).with_min_len(TASK).for_each(|(own, sums)| {
            *own = corrected(viscosity, sums);
        });
    }
}

/// Part of Σ V_j [...]·∇W \[Pa/m\] by the viscosity of neighbours: −(μ_i + μ_j) V_j (dW/dr)/r v_ij.
///
/// `weight` = V_j (dW/dr)/r \[1/m²\], `slip` the part of v_ij that viscosity resists.
#[inline(always)]
pub fn drag(viscosity: Lanes, weight: Lanes, slip: [Lanes; 2]) -> [Lanes; 2] {
    slip.map(|v| -1.0 * (viscosity * weight * v))
}
