//! Viscous stress, Eq. (4), and the tensor T = (p I − τ)·L of the momentum equation.

use sph::space::Space;
use sph::space::tensors::SpaceTensor;

/// τ of Eq. (4) \[Pa\] from the velocity gradient ∂v_a/∂x_b \[1/s\].
///
/// ```text
/// τ = μ [∇v + (∇v)ᵀ − ⅔ (∇·v) I]
/// ```
pub fn viscous_stress<S: Space>(viscosity: f64, gradient: S::Matrix<f64>) -> S::Matrix<f64> {
    let twice_rate = S::matrix_plus(gradient, S::transposed(gradient));
    let third = 2.0 / 3.0 * S::trace(gradient);
    S::matrix_scaled(S::matrix_plus_isotropic(twice_rate, -third), viscosity)
}

/// The viscous stress \[Pa\] less that of the pair force, from the velocity gradient ∂v_a/∂x_b \[1/s\].
///
/// ```text
/// μ [(∇v)ᵀ − (∇·v) I]
/// ```
/// It has no divergence, but it pulls at a free surface: the pair force alone leaves ∂v/∂n = 0 there instead of no
/// traction, and so half of the dissipation of a wave (Colagrossi et al. 2011).
pub fn transposed_stress<S: Space>(viscosity: f64, gradient: S::Matrix<f64>) -> S::Matrix<f64> {
    S::matrix_scaled(S::transposed_less_trace(gradient), viscosity)
}

/// Dissipation τ:∇v \[W/m³\] of a viscous `stress` τ \[Pa\] in the velocity gradient ∂v_a/∂x_b \[1/s\].
pub fn dissipation<S: Space>(stress: S::Matrix<f64>, gradient: S::Matrix<f64>) -> f64 {
    // τ:∇v = tr(τᵀ·∇v), row by row.
    let (stress, gradient) = (S::tensor(stress), S::tensor(gradient));
    (SpaceTensor::transpose(&stress) * gradient).trace()
}

/// T = (p I − τ)·L \[Pa\].
#[inline(always)]
pub fn momentum_tensor<S: Space>(
    pressure: f64,
    stress: S::Matrix<f64>,
    correction: S::Symmetric<f64>,
) -> S::Matrix<f64> {
    let minus_stress = S::matrix_scaled(stress, -1.0);
    S::matrix_times_symmetric(S::matrix_plus_isotropic(minus_stress, pressure), correction)
}

/// `stress` mirrored at a plane of unit `normal`; unchanged for a zero normal.
///
/// The mirror image at a slip wall carries no shear; a wall that reverses the velocity keeps the stress.
pub fn mirrored_stress<S: Space>(stress: S::Matrix<f64>, normal: S::Of<f64>) -> S::Matrix<f64> {
    // R·τ·R = (Rᵀ·(R·τ)ᵀ)ᵀ with R = I − 2 n nᵀ.
    let mirror = S::symmetric_minus_outer(S::identity(), S::scaled(normal, 2.0), normal);
    let half = S::transposed(S::matrix_times_symmetric(S::transposed(stress), mirror));
    S::matrix_times_symmetric(half, mirror)
}

#[cfg(test)]
mod tests {
    use sph::space::Plane;

    use super::*;

    #[test]
    fn a_slip_wall_mirrors_shear_away() {
        // Mirrored at a plane of normal y, the shear changes sign; along 45° the axes swap.
        assert_eq!(mirrored_stress::<Plane>([1.0, 2.0, 4.0, 3.0], [0.0, 1.0]), [1.0, -2.0, -4.0, 3.0]);
        let n = std::f64::consts::FRAC_1_SQRT_2;
        let swapped = mirrored_stress::<Plane>([1.0, 2.0, 4.0, 3.0], [n, n]);
        for (found, expected) in swapped.iter().zip([3.0, 4.0, 2.0, 1.0]) {
            // Round-off of n² = 1/2.
            assert!((found - expected).abs() < 1e-14);
        }
        assert_eq!(mirrored_stress::<Plane>([1.0, 2.0, 4.0, 3.0], [0.0, 0.0]), [1.0, 2.0, 4.0, 3.0]);
    }

    #[test]
    fn viscous_stress_of_expansion_and_shear() {
        // Simple shear ∂v_x/∂y = 5: τ_xy = μ·5, no normal stress.
        assert_eq!(viscous_stress::<Plane>(2.0, [0.0, 5.0, 0.0, 0.0]), [0.0, 10.0, 10.0, 0.0]);
        // Expansion ∂v_x/∂x = ∂v_y/∂y = 3: 2μ·3 − ⅔μ·6 = μ·2.
        let [xx, xy, _, yy] = viscous_stress::<Plane>(2.0, [3.0, 0.0, 0.0, 3.0]);
        assert!((xx - 4.0).abs() < 1e-14 && xy == 0.0 && (yy - 4.0).abs() < 1e-14);
        assert_eq!(viscous_stress::<Plane>(2.0, [0.0, 4.0, -4.0, 0.0]), [0.0; 4]);
    }

    #[test]
    fn pair_force_and_transposed_stress_make_up_the_viscous_stress() {
        // Of the pair force the stress is μ ∇v. Together they are that of Eq. (4) where ∇·v = 0.
        let gradient = [3.0, 5.0, -2.0, -3.0];
        let rest = transposed_stress::<Plane>(2.0, gradient);
        let whole: Vec<f64> = gradient.iter().zip(rest).map(|(g, rest)| 2.0 * g + rest).collect();
        assert_eq!(whole, viscous_stress::<Plane>(2.0, gradient));
    }
}
