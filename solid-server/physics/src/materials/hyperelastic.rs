//! Stress from the deformation gradient; axes that the space leaves out are not strained, or bear no stress.

use sph::setup::{ElasticParameters, HyperelasticLaw, PlaneState};
use sph::space::tensors::{SpaceSymmetric, SpaceTensor};

use crate::space::SolidSpace;

/// Newton steps for the stretch across a sheet; four suffice for moderate strains.
const NEWTON_STEPS: u32 = 50;

/// Least square of that stretch.
const THINNEST: f64 = 1e-12;

/// A hyperelastic material.
#[derive(Clone, Copy, Debug)]
pub struct Hyperelastic {
    law: HyperelasticLaw,
    /// First Lamé constant λ \[Pa\].
    lambda: f64,
    /// That within the plane, λ' \[Pa\]: λ in plane strain.
    plane_lambda: f64,
    plane: PlaneState,
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
        Self {
            law,
            lambda: material.first_lame_constant(),
            plane_lambda: material.plane_lame_constant(),
            plane: material.plane,
            shear_modulus: material.shear_modulus,
        }
    }

    /// Logarithm of the square of the stretch across the plane \[-\] of a neo-Hookean sheet that bears no stress there.
    ///
    /// ```text
    /// G (t² − 1) + λ ln(J t) = 0,  J the determinant within the plane
    /// ```
    /// By Newton's method from the small-strain value; the left side is convex in ln t².
    fn sheet_stretch(&self, log_jacobian: f64) -> f64 {
        let (lambda, g) = (self.lambda, self.shear_modulus);
        let mut log = -2.0 * lambda * log_jacobian / (lambda + 2.0 * g);
        for _ in 0..NEWTON_STEPS {
            let value = g * log.exp_m1() + lambda * (log_jacobian + 0.5 * log);
            let step = value / (g * log.exp() + 0.5 * lambda);
            log -= step;
            if step.abs() < f64::EPSILON * (1.0 + log.abs()) {
                break;
            }
        }
        log
    }

    /// Whether the space leaves out an axis that bears no stress.
    fn is_sheet<S: SolidSpace>(&self) -> bool {
        S::IMPLIED_AXES > 0.0 && self.plane == PlaneState::Stress
    }

    /// Stress at the deformation gradient `f` \[-\] within the plane; F_zz = t, 1 in plane strain.
    ///
    /// ```text
    /// St Venant-Kirchhoff:  S = λ' tr(E) I + 2G E,  P = F S,  σ = F S Fᵀ/(J t),  σ_zz = λ tr(E)/J
    ///                       plane stress: σ_zz = 0,  t² = 1 − 2λ tr(E)/(λ + 2G)
    /// neo-Hookean:          σ = (G (F Fᵀ − I) + λ ln(J t) I)/(J t),  P = J t σ F⁻ᵀ,  σ_zz = λ ln J/J
    ///                       plane stress: σ_zz = 0,  t of [`Self::sheet_stretch`]
    /// ```
    /// In plane strain λ' = λ. P is force per undeformed area in plane stress too.
    #[inline]
    pub fn stress<S: SolidSpace>(&self, f: &S::Tensor) -> Stress<S> {
        let (lambda, g) = (self.lambda, self.shear_modulus);
        let jacobian = f.determinant();
        let identity = S::Tensor::identity();
        match self.law {
            HyperelasticLaw::StVenantKirchhoff => {
                let strain = green_strain::<S>(f);
                let pressure_like = self.plane_lambda * strain.trace();
                if self.is_sheet::<S>() {
                    let stretch = 1.0 - 2.0 * lambda * strain.trace() / (lambda + 2.0 * g);
                    let nominal = *f * (strain * (2.0 * g) + identity * pressure_like);
                    // A sheet that has no thickness left is beyond the law; the limits of the state end the run first.
                    let volume = jacobian * stretch.max(THINNEST).sqrt();
                    let cauchy = S::SymmetricTensor::of(&(nominal * f.transpose() / volume));
                    return Stress { nominal, cauchy, implied: 0.0 };
                }
                let second = strain * (2.0 * g) + identity * pressure_like;
                let nominal = *f * second;
                Stress {
                    nominal,
                    cauchy: S::SymmetricTensor::of(&(nominal * f.transpose() / jacobian)),
                    implied: S::IMPLIED_AXES * (pressure_like / jacobian),
                }
            }
            HyperelasticLaw::NeoHookean => {
                if self.is_sheet::<S>() {
                    let log = self.sheet_stretch(jacobian.ln());
                    let volumetric = -g * log.exp_m1();
                    let volume = jacobian * (0.5 * log).exp();
                    let cauchy = (*f * f.transpose() * g + identity * (volumetric - g)) / volume;
                    return Stress {
                        nominal: *f * g + f.cofactor() * ((volumetric - g) / jacobian),
                        cauchy: S::SymmetricTensor::of(&cauchy),
                        implied: 0.0,
                    };
                }
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
    /// In plane stress with λ' in the first, and in the second with the share of the thickness.
    pub fn energy_density<S: SolidSpace>(&self, f: &S::Tensor) -> f64 {
        let (lambda, g) = (self.lambda, self.shear_modulus);
        match self.law {
            HyperelasticLaw::StVenantKirchhoff => {
                let strain = green_strain::<S>(f);
                0.5 * self.plane_lambda * strain.trace() * strain.trace() + g * strain.norm_squared()
            }
            HyperelasticLaw::NeoHookean => {
                let log = (f.determinant() - 1.0).ln_1p();
                if self.is_sheet::<S>() {
                    let across = self.sheet_stretch(log);
                    let volume = log + 0.5 * across;
                    let shear = S::shear_measure(f) + (across.exp_m1() - across);
                    return 0.5 * g * shear + 0.5 * lambda * volume * volume;
                }
                0.5 * g * S::shear_measure(f) + 0.5 * lambda * log * log
            }
        }
    }

    /// Stress of an infinitesimal displacement gradient \[Pa\]: Hooke's law, which both laws tend to.
    #[inline]
    pub fn linear<S: SolidSpace>(&self, gradient: &S::Tensor) -> S::Tensor {
        (*gradient + gradient.transpose()) * self.shear_modulus
            + S::Tensor::identity() * (self.plane_lambda * gradient.trace())
    }

    /// Upper estimate of the largest tangent modulus at the deformation gradient `f` over that at rest \[-\].
    ///
    /// ```text
    /// St Venant-Kirchhoff:  (3Λ² − 1)/2,  Λ the largest principal stretch: stiffens in tension
    /// neo-Hookean:          (G + (G + λ(1 − ln J))/Λ²)/(λ + 2G),  Λ the smallest: stiffens in compression
    ///                       plane stress: (G + (G + λ(β − ln(J t)))/Λ²)/(λ' + 2G),  β = 2G t²/(λ + 2G t²)
    /// ```
    /// Both are exact for uniaxial strain; the modulus of waves along a stretched fibre grows with Λ² besides.
    pub fn tangent_stiffness_ratio<S: SolidSpace>(&self, f: &S::Tensor) -> f64 {
        let (lambda, g) = (self.lambda, self.shear_modulus);
        let [largest, smallest] = S::squared_stretches(f);
        match self.law {
            HyperelasticLaw::StVenantKirchhoff => (1.5 * largest - 0.5).max(1.0),
            HyperelasticLaw::NeoHookean => {
                if self.is_sheet::<S>() {
                    let log_jacobian = f.determinant().ln();
                    let across = self.sheet_stretch(log_jacobian);
                    let yielding = 2.0 * g * across.exp();
                    let share = yielding / (lambda + yielding);
                    let volumetric = lambda * (share - log_jacobian - 0.5 * across);
                    return ((g + (g + volumetric) / smallest) / (self.plane_lambda + 2.0 * g)).max(1.0);
                }
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
mod tests;
