//! Stress from the deformation gradient, in plane strain.

use sph::setup::{ElasticParameters, HyperelasticLaw};
use sph::space::{SymmetricTensor, Tensor};

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
pub struct Stress {
    /// First Piola-Kirchhoff stress P: force per reference area \[Pa\].
    pub nominal: Tensor,
    /// Cauchy stress in the plane \[Pa\].
    pub cauchy: SymmetricTensor,
    /// Cauchy stress across the plane σ_zz \[Pa\].
    pub across: f64,
}

impl Stress {
    /// Pressure p = −tr(σ)/3 \[Pa\].
    #[inline]
    pub fn pressure(&self) -> f64 {
        -(self.cauchy.xx + self.cauchy.yy + self.across) / 3.0
    }
}

impl Hyperelastic {
    /// `material` under `law`.
    pub fn new(law: HyperelasticLaw, material: &ElasticParameters) -> Self {
        Self { law, lambda: material.first_lame_constant(), shear_modulus: material.shear_modulus }
    }

    /// Stress at the deformation gradient `f` \[-\]; F_zz = 1.
    ///
    /// ```text
    /// St Venant-Kirchhoff:  S = λ tr(E) I + 2G E,  P = F S,  σ = F S Fᵀ/J,  σ_zz = λ tr(E)/J
    /// neo-Hookean:          σ = (G (F Fᵀ − I) + λ ln J I)/J,  P = J σ F⁻ᵀ,  σ_zz = λ ln J/J
    /// ```
    #[inline]
    pub fn stress(&self, f: &Tensor) -> Stress {
        let (lambda, g) = (self.lambda, self.shear_modulus);
        let jacobian = f.determinant();
        match self.law {
            HyperelasticLaw::StVenantKirchhoff => {
                let strain = (f.transpose() * f - Tensor::identity()) * 0.5;
                let pressure_like = lambda * strain.trace();
                let second = strain * (2.0 * g) + Tensor::identity() * pressure_like;
                let nominal = f * second;
                Stress {
                    nominal,
                    cauchy: symmetric(&(nominal * f.transpose() / jacobian)),
                    across: pressure_like / jacobian,
                }
            }
            HyperelasticLaw::NeoHookean => {
                let volumetric = lambda * jacobian.ln();
                let cofactor = cofactor(f);
                Stress {
                    nominal: f * g + cofactor * ((volumetric - g) / jacobian),
                    cauchy: symmetric(
                        &((f * f.transpose() * g + Tensor::identity() * (volumetric - g)) / jacobian),
                    ),
                    across: volumetric / jacobian,
                }
            }
        }
    }

    /// Strain energy per reference volume at the deformation gradient `f` \[J/m³\].
    ///
    /// ```text
    /// St Venant-Kirchhoff:  ψ = ½λ tr(E)² + G E:E
    /// neo-Hookean:          ψ = ½G (tr(FᵀF) − 2 − 2 ln J) + ½λ ln²J
    /// ```
    pub fn energy_density(&self, f: &Tensor) -> f64 {
        let (lambda, g) = (self.lambda, self.shear_modulus);
        match self.law {
            HyperelasticLaw::StVenantKirchhoff => {
                let strain = (f.transpose() * f - Tensor::identity()) * 0.5;
                0.5 * lambda * strain.trace() * strain.trace() + g * strain.norm_squared()
            }
            HyperelasticLaw::NeoHookean => {
                // tr(FᵀF) − 2J + 2(J − 1 − ln J): no cancellation at small strains.
                let (stretch, shear) = (f[(0, 0)] - f[(1, 1)], f[(0, 1)] + f[(1, 0)]);
                let growth = f.determinant() - 1.0;
                let log = growth.ln_1p();
                0.5 * g * (stretch * stretch + shear * shear + 2.0 * (growth - log))
                    + 0.5 * lambda * log * log
            }
        }
    }

    /// Stress of an infinitesimal displacement gradient \[Pa\]: Hooke's law, which both laws tend to.
    #[inline]
    pub fn linear(&self, gradient: &Tensor) -> Tensor {
        (gradient + gradient.transpose()) * self.shear_modulus
            + Tensor::identity() * (self.lambda * gradient.trace())
    }

    /// Upper estimate of the largest tangent modulus at the deformation gradient `f` over that at rest \[-\].
    ///
    /// ```text
    /// St Venant-Kirchhoff:  (3Λ² − 1)/2,  Λ the largest principal stretch: stiffens in tension
    /// neo-Hookean:          (G + (G + λ(1 − ln J))/Λ²)/(λ + 2G),  Λ the smallest: stiffens in compression
    /// ```
    /// Both are exact for uniaxial strain; the modulus of waves along a stretched fibre grows with Λ² besides.
    pub fn tangent_stiffness_ratio(&self, f: &Tensor) -> f64 {
        let (lambda, g) = (self.lambda, self.shear_modulus);
        let jacobian = f.determinant();
        let sum = f.norm_squared();
        let spread = (sum * sum - 4.0 * jacobian * jacobian).max(0.0).sqrt();
        let largest = 0.5 * (sum + spread);
        match self.law {
            HyperelasticLaw::StVenantKirchhoff => (1.5 * largest - 0.5).max(1.0),
            HyperelasticLaw::NeoHookean => {
                let smallest = jacobian * jacobian / largest;
                ((g + (g + lambda * (1.0 - jacobian.ln())) / smallest) / (lambda + 2.0 * g)).max(1.0)
            }
        }
    }
}

/// Cofactor matrix J F⁻ᵀ.
#[inline]
pub fn cofactor(f: &Tensor) -> Tensor {
    Tensor::new(f[(1, 1)], -f[(1, 0)], -f[(0, 1)], f[(0, 0)])
}

#[inline]
fn symmetric(tensor: &Tensor) -> SymmetricTensor {
    SymmetricTensor { xx: tensor[(0, 0)], yy: tensor[(1, 1)], xy: 0.5 * (tensor[(0, 1)] + tensor[(1, 0)]) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RUBBER: ElasticParameters =
        ElasticParameters { density: 1100.0, bulk_modulus: 20e6, shear_modulus: 4.27e6 };
    const LAWS: [HyperelasticLaw; 2] = [HyperelasticLaw::StVenantKirchhoff, HyperelasticLaw::NeoHookean];

    #[test]
    fn nominal_stress_is_the_derivative_of_the_energy() {
        let f = Tensor::new(1.2, 0.3, -0.15, 0.8);
        for law in LAWS {
            let law = Hyperelastic::new(law, &RUBBER);
            let nominal = law.stress(&f).nominal;
            for k in 0..4 {
                let step = 1e-6;
                let mut shifted = [f, f];
                shifted[0][k] += step;
                shifted[1][k] -= step;
                let slope =
                    (law.energy_density(&shifted[0]) - law.energy_density(&shifted[1])) / (2.0 * step);
                // Central difference: truncation and round-off near 1e-9 of the modulus.
                assert!((slope - nominal[k]).abs() < 1e-8 * RUBBER.bulk_modulus, "{law:?} {k}");
            }
        }
    }

    #[test]
    fn cauchy_and_nominal_stress_are_one_stress() {
        let f = Tensor::new(1.2, 0.3, -0.15, 0.8);
        for law in LAWS {
            let stress = Hyperelastic::new(law, &RUBBER).stress(&f);
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
            let stress = law.stress(&(Tensor::identity() + gradient));
            let expected = law.linear(&gradient);
            // Second-order terms are of relative size strain.
            assert!((stress.nominal - expected).norm() < 1e-6 * expected.norm());
            let across = RUBBER.first_lame_constant() * gradient.trace();
            assert!((stress.across / across - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn uniform_stretch_has_the_stress_of_the_formula() {
        // F = diag(1.1, 1): E_xx = 0.105; P_xx = 1.1 (λ + 2G) 0.105; neo-Hookean P = G (1.1 − 1/1.1) + λ ln 1.1/1.1.
        let f = Tensor::new(1.1, 0.0, 0.0, 1.0);
        let (lambda, g) = (RUBBER.first_lame_constant(), RUBBER.shear_modulus);
        let expected = [1.1 * (lambda + 2.0 * g) * 0.105, g * (1.1 - 1.0 / 1.1) + lambda * 1.1f64.ln() / 1.1];
        for (law, expected) in LAWS.into_iter().zip(expected) {
            let stress = Hyperelastic::new(law, &RUBBER).stress(&f);
            assert!((stress.nominal[(0, 0)] / expected - 1.0).abs() < 1e-13);
        }
    }

    #[test]
    fn stiffening_is_the_tangent_of_uniaxial_strain() {
        for (law, stretches) in [(LAWS[0], [1.0, 1.2, 1.6]), (LAWS[1], [1.0, 0.8, 0.5])] {
            let law = Hyperelastic::new(law, &RUBBER);
            let along = |stretch: f64| Tensor::new(stretch, 0.0, 0.0, 1.0);
            let slope = |stretch: f64| {
                let p = |x: f64| law.stress(&along(x)).nominal[(0, 0)];
                (p(stretch + 1e-5) - p(stretch - 1e-5)) / 2e-5
            };
            for stretch in stretches {
                let ratio = slope(stretch) / slope(1.0);
                assert!(
                    (law.tangent_stiffness_ratio(&along(stretch)) / ratio - 1.0).abs() < 1e-4,
                    "{law:?} {stretch}"
                );
            }
        }
    }
}
