//! Continuity, Eq. (1) and (17).

use sph::lanes::Real;

/// Density rate \[kg/(m³ s)\] of a particle of `density` ρ \[kg/m³\] where the velocity diverges by `divergence` \[1/s\].
///
/// ```text
/// dρ_i/dt = −ρ_i ∇·v = ρ_i Σ_j V_j (v_i − v_j)·∇_i W_ij                            Eq. (17)
/// ```
#[inline(always)]
pub fn density_rate<R: Real>(density: R, divergence: R) -> R {
    R::zero() - density * divergence
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn expansion_thins_the_fluid() {
        // A doubling of the area per second.
        assert_eq!(density_rate(1000.0, 1.0), -1000.0);
        assert_eq!(density_rate(1000.0, -0.5), 500.0);
    }
}
