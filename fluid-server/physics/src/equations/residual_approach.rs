//! The part of the approach of two particles that a smooth field of velocity does not explain.

use sph::lanes::Real;
use sph::space::Space;

use crate::system::model::FluidModel;
use crate::system::packed_particle::FluidSpace;

/// Distances \[m\] between which a smooth field begins to explain an approach; none in the form `plain`.
#[derive(Clone, Copy, Debug)]
pub struct ResidualApproach<R> {
    /// 1/(b² − a²) \[1/m²\] and a²/(b² − a²) \[-\] of the distances a < b.
    onset: Option<(R, R)>,
}

impl<R: Real> ResidualApproach<R> {
    /// That of `model`.
    #[inline(always)]
    pub fn new<S: FluidSpace>(model: &FluidModel<S>) -> Self {
        let [a, b] = [S::PLAIN_DISTANCE, S::RESIDUAL_DISTANCE];
        let scale = 1.0 / (b * b - a * a);
        let per_square = scale / model.constants.particle_spacing.powi(2);
        let onset = (R::splat(per_square), R::splat(scale * a * a));
        Self { onset: model.has_strain_rates().then_some(onset) }
    }

    /// Whether it differs from the approach itself.
    #[inline(always)]
    pub fn acts(&self) -> bool {
        self.onset.is_some()
    }

    /// v_ij·x_ij − s ½ x_ij·(D_i + D_j)·x_ij \[m²/s\], but at least v_ij·x_ij: of `approach` = v_ij·x_ij, the sum of
    /// both rates of `strain` D \[1/s\], x_ij \[m\] and its `square` \[m²\].
    ///
    /// The share s goes from 0 to 1 between the distances: full viscosity keeps particles apart. The law takes negative values
    /// only, so that viscosity takes energy from each pair; by the bound from below it takes no more than the form `plain`
    /// with the same A.
    #[inline(always)]
    pub fn of<S: Space>(&self, approach: R, strain: S::Symmetric<R>, x: S::Of<R>, square: R) -> R {
        let Some((per_square, shift)) = self.onset else { return approach };
        let share = R::splat(0.5) * R::splat(1.0).min(R::zero().max(square * per_square - shift));
        let explained = S::dot(S::symmetric_times(strain, x), x);
        // In this order an approach that is not a number stays one.
        (approach - share * explained).max(approach)
    }
}

#[cfg(test)]
mod tests {
    use sph::space::Plane;

    use super::*;

    /// Between 0.6 m and 0.8 m.
    const ONSET: ResidualApproach<f64> = ResidualApproach { onset: Some((1.0 / 0.28, 0.36 / 0.28)) };

    /// Of a pair along x at `distance` \[m\] that approaches at `speed` \[m/s\] in a flow of ∂u/∂x = `gradient`.
    fn residual(distance: f64, speed: f64, gradient: f64) -> f64 {
        let strain = [2.0 * gradient, 0.0, 0.0];
        ONSET.of::<Plane>(-speed * distance, strain, [distance, 0.0], distance * distance)
    }

    #[test]
    fn a_smooth_field_explains_its_part_of_an_approach_and_no_more() {
        // A contraction of 0.25/s brings the pair together at 0.25 m/s.
        assert_eq!(residual(1.0, 0.25, -0.25), 0.0);
        assert_eq!(residual(1.0, 1.0, -0.25), -0.75);
        // What it would explain beyond the approach is none, and a stretching field adds nothing to it.
        assert!(residual(1.0, 0.25, -1.0) > 0.0);
        assert_eq!(residual(1.0, 0.25, 1.0), -0.25);
        // Particles that part are not held.
        assert!(residual(1.0, -0.25, 1.0) > 0.0);
    }

    #[test]
    fn it_explains_nothing_of_pairs_that_are_near() {
        // Round-off of the share.
        assert!((residual(0.6, 1.0, -1.0) + 0.6).abs() < 1e-15);
        assert_eq!(residual(0.3, 1.0, -1.0), -0.3);
        // Half of it at r² = (0.36 + 0.64)/2.
        let half = residual(0.5f64.sqrt(), 1.0, -1.0);
        assert!((half + (1.0 - 0.5 * 0.5f64.sqrt()) * 0.5f64.sqrt()).abs() < 1e-15, "{half}");
    }
}
