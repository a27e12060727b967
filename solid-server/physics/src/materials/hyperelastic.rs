//! Stress from the deformation gradient; axes that the space leaves out are not strained.

use sph::setup::{ElasticParameters, HyperelasticLaw};
use sph::space::tensors::{SpaceSymmetric, SpaceTensor};

use crate::space::SolidSpace;

/// A hyperelastic material.
#[derive(Clone, Copy, Debug)]
pub struct Hyperelastic {
    law: HyperelasticLaw,
    /// First Lamé constant λ \[Pa\].
    lambda: f64,
    /// Shear modulus G \[Pa\].
    shear_modulus: f64,
}

/// Stress of one particle.
#[derive(Clone, Copy, Debug)]
pub struct Stress<S: SolidSpace> {
    /// First Piola-Kirchhoff stress P: force per reference area \[Pa\].
    pub nominal: S::Tensor,
    /// Cauchy stress σ \[Pa\].
    pub cauchy: S::SymmetricTensor,
    /// Sum of the normal stresses along the implied axes \[Pa\]: σ_zz in the plane.
    pub implied: f64,
}

impl<S: SolidSpace> Stress<S> {
    /// Pressure p = −tr(σ)/3 \[Pa\].
    #[inline]
    pub fn pressure(&self) -> f64 {
        -(S::symmetric_trace(S::symmetric_components(&self.cauchy)) + self.implied) / 3.0
    }
}

impl Hyperelastic {
    /// `material` under `law`.
    pub fn new(law: HyperelasticLaw, material: &ElasticParameters) -> Self {
        Self { law, lambda: material.first_lame_constant(), shear_modulus: material.shear_modulus }
    }

    /// Stress at the deformation gradient `f` \[-\]; F_zz = 1 in the plane.
    ///
    /// ```text
    /// St Venant-Kirchhoff:  S = λ tr(E) I + 2G E,  P = F S,  σ = F S Fᵀ/J,  σ_zz = λ tr(E)/J
    /// neo-Hookean:          σ = (G (F Fᵀ − I) + λ ln J I)/J,  P = J σ F⁻ᵀ,  σ_zz = λ ln J/J
    /// ```
    #[inline]
    pub fn stress<S: SolidSpace>(&self, f: &S::Tensor) -> Stress<S> {
        let (lambda, g) = (self.lambda, self.shear_modulus);
        let jacobian = f.determinant();
        let identity = S::Tensor::identity();
        match self.law {
            HyperelasticLaw::StVenantKirchhoff => {
                let strain = green_strain::<S>(f);
                let pressure_like = lambda * strain.trace();
                let second = strain * (2.0 * g) + identity * pressure_like;
                let nominal = *f * second;
                Stress {
                    nominal,
                    cauchy: S::SymmetricTensor::of(&(nominal * f.transpose() / jacobian)),
                    implied: S::IMPLIED_AXES * (pressure_like / jacobian),
                }
            }
            HyperelasticLaw::NeoHookean => {
                let volumetric = lambda * jacobian.ln();
                let cauchy = (*f * f.transpose() * g + identity * (volumetric - g)) / jacobian;
                Stress {
                    nominal: *f * g + f.cofactor() * ((volumetric - g) / jacobian),
                    cauchy: S::SymmetricTensor::of(&cauchy),
                    implied: S::IMPLIED_AXES * (volumetric / jacobian),
                }
            }
        }
    }

    /// Strain energy per reference volume at the deformation gradient `f` \[J/m³\].
    ///
    /// ```text
    /// St Venant-Kirchhoff:  ψ = ½λ tr(E)² + G E:E
    /// neo-Hookean:          ψ = ½G (tr(FᵀF) − D − 2 ln J) + ½λ ln²J,  D the number of dimensions
    /// ```
    pub fn energy_density<S: SolidSpace>(&self, f: &S::Tensor) -> f64 {
        let (lambda, g) = (self.lambda, self.shear_modulus);
        match self.law {
            HyperelasticLaw::StVenantKirchhoff => {
                let strain = green_strain::<S>(f);
                0.5 * lambda * strain.trace() * strain.trace() + g * strain.norm_squared()
            }
            HyperelasticLaw::NeoHookean => {
                let log = (f.determinant() - 1.0).ln_1p();
                0.5 * g * S::shear_measure(f) + 0.5 * lambda * log * log
            }
        }
    }

    /// Stress of an infinitesimal displacement gradient \[Pa\]: Hooke's law, which both laws tend to.
    #[inline]
    pub fn linear<S: SolidSpace>(&self, gradient: &S::Tensor) -> S::Tensor {
        (*gradient + gradient.transpose()) * self.shear_modulus
            + S::Tensor::identity() * (self.lambda * gradient.trace())
    }

    /// Upper estimate of the largest tangent modulus at the deformation gradient `f` over that at rest \[-\].
    ///
    /// ```text
    /// St Venant-Kirchhoff:  (3Λ² − 1)/2,  Λ the largest principal stretch: stiffens in tension
    /// neo-Hookean:          (G + (G + λ(1 − ln J))/Λ²)/(λ + 2G),  Λ the smallest: stiffens in compression
    /// ```
    /// Both are exact for uniaxial strain; the modulus of waves along a stretched fibre grows with Λ² besides.
    pub fn tangent_stiffness_ratio<S: SolidSpace>(&self, f: &S::Tensor) -> f64 {
        let (lambda, g) = (self.lambda, self.shear_modulus);
        let [largest, smallest] = S::squared_stretches(f);
        match self.law {
            HyperelasticLaw::StVenantKirchhoff => (1.5 * largest - 0.5).max(1.0),
            HyperelasticLaw::NeoHookean => {
                let volumetric = lambda * (1.0 - f.determinant().ln());
                ((g + (g + volumetric) / smallest) / (lambda + 2.0 * g)).max(1.0)
            }
        }
    }
}

/// Green-Lagrange strain E = ½(FᵀF − I) \[-\].
#[inline]
fn green_strain<S: SolidSpace>(f: &S::Tensor) -> S::Tensor {
    (f.transpose() * *f - S::Tensor::identity()) * 0.5
}

#[cfg(test)]
mod tests {
    use super::*;
    use sph::space::{Plane, Tensor};

    const RUBBER: ElasticParameters =
        ElasticParameters { density: 1100.0, bulk_modulus: 20e6, shear_modulus: 4.27e6 };
    const LAWS: [HyperelasticLaw; 2] = [HyperelasticLaw::StVenantKirchhoff, HyperelasticLaw::NeoHookean];

    #[test]
    fn nominal_stress_is_the_derivative_of_the_energy() {
        let f = Tensor::new(1.2, 0.3, -0.15, 0.8);
        for law in LAWS {
            let law = Hyperelastic::new(law, &RUBBER);
            let nominal = law.stress::<Plane>(&f).nominal;
            for k in 0..4 {
                let step = 1e-6;
                let mut shifted = [f, f];
                shifted[0][k] += step;
                shifted[1][k] -= step;
                let slope = (law.energy_density::<Plane>(&shifted[0])
                    - law.energy_density::<Plane>(&shifted[1]))
                    / (2.0 * step);
                // Central difference: truncation and round-off near 1e-9 of the modulus.
                assert!((slope - nominal[k]).abs() < 1e-8 * RUBBER.bulk_modulus, "{law:?} {k}");
            }
        }
    }

    #[test]
    fn cauchy_and_nominal_stress_are_one_stress() {
        let f = Tensor::new(1.2, 0.3, -0.15, 0.8);
        for law in LAWS {
            let stress = Hyperelastic::new(law, &RUBBER).stress::<Plane>(&f);
            let cauchy = stress.nominal * f.transpose() / f.determinant();
            let c = stress.cauchy;
            let difference = cauchy - Tensor::new(c.xx, c.xy, c.xy, c.yy);
            assert!(difference.norm() < 1e-9 * cauchy.norm());
        }
    }

    #[test]
    fn small_strains_follow_hooke_s_law_also_across_the_plane() {
        let gradient = Tensor::new(1.0, 0.4, -0.2, 0.5) * 1e-7;
        for law in LAWS {
            let law = Hyperelastic::new(law, &RUBBER);
            let stress = law.stress::<Plane>(&(Tensor::identity() + gradient));
            let expected = law.linear::<Plane>(&gradient);
            // Second-order terms are of relative size strain.
            assert!((stress.nominal - expected).norm() < 1e-6 * expected.norm());
            let across = RUBBER.first_lame_constant() * gradient.trace();
            assert!((stress.implied / across - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn uniform_stretch_has_the_stress_of_the_formula() {
        // F = diag(1.1, 1): E_xx = 0.105; P_xx = 1.1 (λ + 2G) 0.105; neo-Hookean P = G (1.1 − 1/1.1) + λ ln 1.1/1.1.
        let f = Tensor::new(1.1, 0.0, 0.0, 1.0);
        let (lambda, g) = (RUBBER.first_lame_constant(), RUBBER.shear_modulus);
        let expected = [1.1 * (lambda + 2.0 * g) * 0.105, g * (1.1 - 1.0 / 1.1) + lambda * 1.1f64.ln() / 1.1];
        for (law, expected) in LAWS.into_iter().zip(expected) {
            let stress = Hyperelastic::new(law, &RUBBER).stress::<Plane>(&f);
            assert!((stress.nominal[(0, 0)] / expected - 1.0).abs() < 1e-13);
        }
    }

    #[test]
    fn stiffening_is_the_tangent_of_uniaxial_strain() {
        for (law, stretches) in [(LAWS[0], [1.0, 1.2, 1.6]), (LAWS[1], [1.0, 0.8, 0.5])] {
            let law = Hyperelastic::new(law, &RUBBER);
            let along = |stretch: f64| Tensor::new(stretch, 0.0, 0.0, 1.0);
            let slope = |stretch: f64| {
                let p = |x: f64| law.stress::<Plane>(&along(x)).nominal[(0, 0)];
                (p(stretch + 1e-5) - p(stretch - 1e-5)) / 2e-5
            };
            for stretch in stretches {
                let ratio = slope(stretch) / slope(1.0);
                assert!(
                    (law.tangent_stiffness_ratio::<Plane>(&along(stretch)) / ratio - 1.0).abs() < 1e-4,
                    "{law:?} {stretch}"
                );
            }
        }
    }
}
