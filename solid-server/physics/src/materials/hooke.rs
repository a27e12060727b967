//! The elastic law, Eq. (5)-(8), and the artificial stress of Gray, Monaghan & Swift 2001.

use sph::setup::ElasticParameters;
use sph::space::tensors::{SpaceSymmetric, SpaceTensor};

use crate::space::SolidSpace;

/// Pressure \[Pa\] at `density` \[kg/m³\].
///
/// ```text
/// p = K β (ρ/ρ₀ − 1)                                               Eq. (5)
/// ```
///
/// ρ is the density at undeformed thickness, β [`ElasticParameters::volume_share`]: 1 in plane strain, Eq. (5) itself.
#[inline]
pub fn pressure(material: &ElasticParameters, density: f64) -> f64 {
    material.bulk_modulus * material.volume_share() * (density / material.density - 1.0)
}

/// Density \[kg/m³\] at `pressure` \[Pa\]: Eq. (5) solved for ρ.
#[inline]
pub fn density(material: &ElasticParameters, pressure: f64) -> f64 {
    material.density * (1.0 + pressure / (material.bulk_modulus * material.volume_share()))
}

/// Cauchy stress σ = −p I + s \[Pa\], Eq. (6).
#[inline]
pub fn cauchy_stress<S: SolidSpace>(pressure: f64, deviatoric: &S::SymmetricTensor) -> S::SymmetricTensor {
    S::SymmetricTensor::isotropic(-pressure).plus(deviatoric)
}

/// Deviatoric stress s = σ + p I \[Pa\].
#[inline]
pub fn deviatoric_stress<S: SolidSpace>(pressure: f64, cauchy: &S::SymmetricTensor) -> S::SymmetricTensor {
    cauchy.plus(&S::SymmetricTensor::isotropic(pressure))
}

/// Jaumann rate of the deviatoric stress s \[Pa/s\] under `velocity_gradient` L_ab = ∂_b v_a \[1/s\].
///
/// ```text
/// ṡ = 2G (D − ⅓ β tr(D) I) + s·ωᵀ + ω·s                            Eq. (7)
/// D_ab = ½(∂_b v_a + ∂_a v_b),  ω_ab = ½(∂_b v_a − ∂_a v_b)        Eq. (8)
/// ```
///
/// The third belongs to plane strain too: s_zz = −(s_xx + s_yy) is implied and not stored. In plane stress D_zz is
/// (β − 1) tr(D), β [`ElasticParameters::volume_share`], so that σ_zz stays zero.
#[inline]
pub fn deviatoric_stress_rate<S: SolidSpace>(
    material: &ElasticParameters,
    s: &S::SymmetricTensor,
    velocity_gradient: &S::Tensor,
) -> S::SymmetricTensor {
    let third = velocity_gradient.trace() * material.volume_share() / 3.0;
    S::SymmetricTensor::of(velocity_gradient)
        .plus(&S::SymmetricTensor::isotropic(-third))
        .scaled(2.0 * material.shear_modulus)
        .plus(&S::corotation(velocity_gradient, s))
}

/// Strain energy per volume \[J/m³\]: p²/(2K) + s:s/(4G).
#[inline]
pub fn strain_energy_density<S: SolidSpace>(
    material: &ElasticParameters,
    pressure: f64,
    s: &S::SymmetricTensor,
) -> f64 {
    pressure * pressure / (2.0 * material.bulk_modulus)
        + S::squared_deviator(s) / (4.0 * material.shear_modulus)
}

/// Von Mises stress √(3/2 s:s) \[Pa\].
#[inline]
pub fn von_mises_stress<S: SolidSpace>(s: &S::SymmetricTensor) -> f64 {
    (1.5 * S::squared_deviator(s)).sqrt()
}

/// Artificial stress R_i of one particle \[m⁵/(kg s²)\], to be added for both particles of a pair in Eq. (25).
///
/// ```text
/// R' = −ε σ'/ρ²  for a principal stress σ' > 0, else 0;  R = Q R' Qᵀ
/// ```
///
/// Principal axes are those of the full stress (Gray, Monaghan & Swift 2001).
#[inline]
pub fn artificial_stress<S: SolidSpace>(
    epsilon: f64,
    stress: &S::SymmetricTensor,
    density: f64,
) -> S::SymmetricTensor {
    let factor = -epsilon / (density * density);
    stress.map_principal(|value| factor * value.max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use sph::space::{Plane, SymmetricTensor, Tensor};

    const RUBBER: ElasticParameters = ElasticParameters {
        density: 1100.0,
        bulk_modulus: 20e6,
        shear_modulus: 4.27e6,
        plane: sph::setup::PlaneState::Strain,
    };

    /// Integrates Eq. (7) and (17) under a constant velocity gradient by the midpoint rule.
    fn strained(gradient: Tensor, time: f64, steps: u32, s_start: SymmetricTensor) -> (f64, SymmetricTensor) {
        let dt = time / f64::from(steps);
        let (mut rho, mut s) = (RUBBER.density, s_start);
        let rates = |rho: f64, s: &SymmetricTensor| {
            (-rho * gradient.trace(), deviatoric_stress_rate::<Plane>(&RUBBER, s, &gradient))
        };
        for _ in 0..steps {
            let (rho_dot, s_dot) = rates(rho, &s);
            let (rho_half, s_half) = (rho + 0.5 * dt * rho_dot, s.plus(&s_dot.scaled(0.5 * dt)));
            let (rho_dot, s_dot) = rates(rho_half, &s_half);
            (rho, s) = (rho + dt * rho_dot, s.plus(&s_dot.scaled(dt)));
        }
        (pressure(&RUBBER, rho), s)
    }

    #[test]
    fn uniaxial_strain_slope_is_the_longitudinal_modulus() {
        let strain = 1e-6;
        let (p, s) = strained(Tensor::new(1.0, 0.0, 0.0, 0.0), strain, 10, SymmetricTensor::default());
        let slope = cauchy_stress::<Plane>(p, &s).xx / strain;
        let modulus = RUBBER.bulk_modulus + 4.0 / 3.0 * RUBBER.shear_modulus;
        // Second-order terms are of relative size strain.
        assert!((slope / modulus - 1.0).abs() < 2e-6);
    }

    #[test]
    fn stress_free_sides_give_the_plane_strain_modulus() {
        // E/(1 − ν²) = 4G (K + G/3)/(K + 4G/3); lateral strain −(K − 2G/3)/(K + 4G/3).
        let (k, g) = (RUBBER.bulk_modulus, RUBBER.shear_modulus);
        let lateral = -(k - 2.0 / 3.0 * g) / (k + 4.0 / 3.0 * g);
        let strain = 1e-6;
        let (p, s) = strained(Tensor::new(1.0, 0.0, 0.0, lateral), strain, 10, SymmetricTensor::default());
        let stress = cauchy_stress::<Plane>(p, &s);
        let modulus = 4.0 * g * (k + g / 3.0) / (k + 4.0 / 3.0 * g);
        assert!((stress.xx / strain / modulus - 1.0).abs() < 2e-6);
        assert!(stress.yy.abs() < 1e-5 * stress.xx);
    }

    #[test]
    fn a_sheet_in_tension_has_young_s_modulus_and_no_stress_across() {
        let sheet = ElasticParameters { plane: sph::setup::PlaneState::Stress, ..RUBBER };
        let young = RUBBER.young_modulus();
        let nu = 0.5 * young / RUBBER.shear_modulus - 1.0;
        let strain = 1e-6;
        let gradient = Tensor::new(strain, 0.0, 0.0, -nu * strain);
        let rho = RUBBER.density * (1.0 - gradient.trace());
        let p = pressure(&sheet, rho);
        let s = deviatoric_stress_rate::<Plane>(&sheet, &SymmetricTensor::default(), &gradient);
        let stress = cauchy_stress::<Plane>(p, &s);
        // Round-off of the density, whose change is a millionth.
        assert!((stress.xx / (young * strain) - 1.0).abs() < 1e-8, "{}", stress.xx / (young * strain));
        assert!(stress.yy.abs() < 1e-8 * stress.xx);
        let across = -p - (s.xx + s.yy);
        assert!(across.abs() < 1e-8 * stress.xx, "{across}");
        assert!((von_mises_stress::<Plane>(&s) / stress.xx - 1.0).abs() < 1e-8);
        let energy = strain_energy_density::<Plane>(&sheet, p, &s);
        assert!((energy / (0.5 * young * strain * strain) - 1.0).abs() < 1e-8);
    }

    #[test]
    fn simple_shear_slope_is_the_shear_modulus() {
        let strain = 1e-6;
        let (p, s) = strained(Tensor::new(0.0, 1.0, 0.0, 0.0), strain, 10, SymmetricTensor::default());
        assert!((cauchy_stress::<Plane>(p, &s).xy / strain / RUBBER.shear_modulus - 1.0).abs() < 1e-9);
    }

    #[test]
    fn rigid_spin_only_rotates_the_stress() {
        // v = Ω × x with Ω = 1: L = [[0, −1], [1, 0]]; after the angle a the tensor is Q s Qᵀ.
        let start = SymmetricTensor { xx: 2e5, yy: -0.5e5, xy: 0.3e5 };
        let angle: f64 = 0.7;
        let (p, s) = strained(Tensor::new(0.0, -1.0, 1.0, 0.0), angle, 2000, start);
        let q = Tensor::new(angle.cos(), -angle.sin(), angle.sin(), angle.cos());
        let rotated = q * Tensor::new(start.xx, start.xy, start.xy, start.yy) * q.transpose();
        assert_eq!(p, 0.0);
        // Midpoint rule: relative error (2Ω dt)²·angle/6 ~ 1e-7.
        let tolerance = 1e-6 * 2e5;
        assert!((s.xx - rotated[(0, 0)]).abs() < tolerance);
        assert!((s.xy - rotated[(0, 1)]).abs() < tolerance);
        assert!((s.yy - rotated[(1, 1)]).abs() < tolerance);
    }

    #[test]
    fn a_spin_in_space_only_rotates_the_stress() {
        use nalgebra::{Matrix3, UnitQuaternion, Vector3};
        use sph::space::{Spatial, SymmetricTensor3};

        let spin = Vector3::new(0.3, -0.5, 0.6);
        let start = SymmetricTensor3 { xx: 2e5, yy: -0.5e5, zz: -1.5e5, xy: 0.3e5, yz: -0.4e5, xz: 0.7e5 };
        let (mut s, steps) = (start, 2000);
        let dt = 1.0 / f64::from(steps);
        let rate = |s: &SymmetricTensor3| deviatoric_stress_rate::<Spatial>(&RUBBER, s, &spin.cross_matrix());
        for _ in 0..steps {
            let middle = s.plus(&rate(&s).scaled(0.5 * dt));
            s = s.plus(&rate(&middle).scaled(dt));
        }
        let q: Matrix3<f64> = UnitQuaternion::from_scaled_axis(spin).to_rotation_matrix().into_inner();
        // Midpoint rule: relative error (2Ω dt)²/6.
        assert!((s.full() - q * start.full() * q.transpose()).norm() < 1e-6 * start.full().norm());
        assert!((von_mises_stress::<Spatial>(&s) / von_mises_stress::<Spatial>(&start) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn stress_is_the_slope_of_the_energy() {
        let energy = |strain: f64| {
            let (p, s) = strained(Tensor::new(1.0, 0.4, 0.0, -0.3), strain, 10, SymmetricTensor::default());
            (strain_energy_density::<Plane>(&RUBBER, p, &s), cauchy_stress::<Plane>(p, &s))
        };
        let (strain, step) = (1e-5, 1e-7);
        let slope = (energy(strain + step).0 - energy(strain - step).0) / (2.0 * step);
        let stress = energy(strain).1;
        let power = stress.xx + 0.4 * stress.xy - 0.3 * stress.yy;
        // The law is rate-based: energy and work agree up to terms of relative size strain.
        assert!((slope / power - 1.0).abs() < 1e-4, "{slope} {power}");
    }

    #[test]
    fn density_inverts_pressure() {
        for rho in [1000.0, 1100.0, 1234.5] {
            assert!((density(&RUBBER, pressure(&RUBBER, rho)) - rho).abs() < 1e-9);
        }
    }

    #[test]
    fn uniaxial_von_mises_is_the_applied_stress() {
        // Plane stress tension T has s = (2, −1, −1) T/3; here s_zz is implied.
        let s = SymmetricTensor { xx: 2.0, yy: -1.0, xy: 0.0 };
        assert!((von_mises_stress::<Plane>(&s) - 3.0).abs() < 1e-12);
    }

    #[test]
    fn artificial_stress_opposes_tension_along_principal_axes_only() {
        let epsilon = 0.3;
        // Principal stresses 3 and −1 at 30 degrees.
        let (major, minor, angle) = (3.0, -1.0, 30f64.to_radians());
        let q = Tensor::new(angle.cos(), -angle.sin(), angle.sin(), angle.cos());
        let full = q * Tensor::new(major, 0.0, 0.0, minor) * q.transpose();
        let stress = SymmetricTensor { xx: full[(0, 0)], yy: full[(1, 1)], xy: full[(0, 1)] };
        let r = artificial_stress::<Plane>(epsilon, &stress, 2.0);
        let expected = q * Tensor::new(-epsilon * major / 4.0, 0.0, 0.0, 0.0) * q.transpose();
        assert!((r.xx - expected[(0, 0)]).abs() < 1e-15);
        assert!((r.yy - expected[(1, 1)]).abs() < 1e-15);
        assert!((r.xy - expected[(0, 1)]).abs() < 1e-15);
        let compressed =
            artificial_stress::<Plane>(epsilon, &SymmetricTensor { xx: -1.0, yy: -2.0, xy: 0.1 }, 2.0);
        assert_eq!(compressed, SymmetricTensor::default());
        let hydrostatic = artificial_stress::<Plane>(epsilon, &SymmetricTensor::isotropic(2.0), 2.0);
        assert_eq!(hydrostatic, SymmetricTensor::isotropic(-0.15));
    }
}
