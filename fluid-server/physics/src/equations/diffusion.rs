//! Density diffusion, Eq. (18)-(19): ψ_ij·x_ij, by which V_j (dW/dr)/r is multiplied in Eq. (18).
//!
//! ```text
//! ψ_ij = 2 (ρ_i − ρ_j) x_ij/(x_ij² + λh²) − (∇ρ_i + ∇ρ_j)                          Eq. (19)
//! ```

use sph::lanes::Real;
use sph::space::Space;

/// The first term of Eq. (19) \[kg/m³\] for 2ρ_i, ρ_j \[kg/m³\] and x_ij²/(x_ij² + λh²) = `share` \[-\] (Molteni & Colagrossi
/// 2009).
#[inline(always)]
pub fn plain<R: Real>(twice_density: R, other_density: R, share: R) -> R {
    twice_density.minus_product(R::splat(2.0), other_density) * share
}

/// `psi` with the second term of Eq. (19), for ∇ρ_i + ∇ρ_j = `gradients` \[kg/m⁴\] (Antuono et al. 2010).
#[inline(always)]
pub fn bracketed<S: Space, R: Real>(psi: R, gradients: S::Of<R>, x: S::Of<R>) -> R {
    S::minus_dot(psi, gradients, x)
}

#[cfg(test)]
mod tests {
    use sph::space::Plane;

    use super::*;

    #[test]
    fn a_linear_density_does_not_diffuse() {
        // ρ = 1000 + 30 x − 20 y at x_ij = (0.2, −0.1), without regularisation.
        let (rho_i, gradient, x) = (1010.0, [30.0, -20.0], [0.2, -0.1]);
        let rho_j = rho_i - (gradient[0] * x[0] + gradient[1] * x[1]);
        let psi = plain(2.0 * rho_i, rho_j, 1.0);
        assert!((psi - 16.0).abs() < 1e-12);
        // Round-off of 2ρ.
        assert!(bracketed::<Plane, _>(psi, gradient.map(|g| 2.0 * g), x).abs() < 1e-12);
    }
}
