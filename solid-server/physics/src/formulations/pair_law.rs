//! Pair terms of two solid particles in the sums (17), (21) and (25).

use sph::kernel::shape::Spline;
use sph::kernel::{CubicSpline, PairKernel};
use sph::lanes::Real;
use sph::laws::artificial_viscosity::ArtificialViscosity;
use sph::setup::{ElasticMaterial, UpdatedLagrangian};
use sph::space::tensors::SpaceSymmetric;
use sph::space::{SymmetricTensor, Tensor, Vector};

/// One particle as a pair sees it.
#[derive(Clone, Copy)]
pub struct PairParticle {
    /// Mass per depth \[kg/m\].
    pub mass: f64,
    /// Density \[kg/m³\].
    pub density: f64,
    /// Velocity \[m/s\].
    pub velocity: Vector,
    /// Cauchy stress \[Pa\].
    pub stress: SymmetricTensor,
    /// Artificial stress R_i \[m⁵/(kg s²)\].
    pub artificial_stress: SymmetricTensor,
}

/// Sums over the pairs of one particle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PairSums {
    /// Force per metre of depth \[N/m\].
    pub force: Vector,
    /// Σ V_j (v_j − v_i) ⊗ ∇_i W_ij \[1/s\]: the velocity gradient ∂_b v_a before correction.
    pub gradient: Tensor,
    /// Σ V_j (x_j − x_i) ⊗ ∇_i W_ij \[-\]: the inverse of L_i, Eq. (21).
    pub moment: SymmetricTensor,
}

impl PairSums {
    /// Adds a neighbour of volume V_j \[m²\] to gradient and moment; x_ij, v_ij and (dW/dr)/r as everywhere.
    #[inline]
    pub fn add_gradient(&mut self, volume: f64, x_ij: &Vector, v_ij: &Vector, gradient_factor: f64) {
        let weighted = x_ij * (-volume * gradient_factor);
        self.gradient += v_ij * weighted.transpose();
        self.moment.xx += x_ij.x * weighted.x;
        self.moment.yy += x_ij.y * weighted.y;
        self.moment.xy += x_ij.x * weighted.y;
    }
}

/// Smallest eigenvalue of the moment along which the velocity gradient is corrected \[-\].
///
/// In the bulk it is 1, at the corner of a lattice of h = 1.3 Δx about 0.3. Below this bound too few neighbours lie
/// along that direction, and the gradient along it stays as summed.
pub const SMALLEST_MOMENT: f64 = 0.1;

/// Velocity gradient \[1/s\] corrected by L_i, Eq. (21): G·M⁻¹, exact for linear velocities.
///
/// Fallback: no correction along principal directions of M whose eigenvalue is below [`SMALLEST_MOMENT`].
#[inline]
pub fn corrected_gradient(gradient: &Tensor, moment: &SymmetricTensor) -> Tensor {
    let m = moment;
    let principal = m.principal();
    if principal.minor >= SMALLEST_MOMENT {
        let inverse = 1.0 / (m.xx * m.yy - m.xy * m.xy);
        return gradient * Tensor::new(m.yy * inverse, -m.xy * inverse, -m.xy * inverse, m.xx * inverse);
    }
    let factor = |eigenvalue: f64| if eigenvalue >= SMALLEST_MOMENT { 1.0 / eigenvalue } else { 1.0 };
    gradient * principal.with_values(factor(principal.major), factor(principal.minor)).full()
}

/// Constants of the sum (25) between solid particles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SumLaw {
    /// Kernel, Eq. (10)-(11).
    pub kernel: CubicSpline,
    /// Its gradient for lanes.
    pub pair_kernel: PairKernel,
    /// Sound speed c of Eq. (23) \[m/s\]: the longitudinal wave speed, as for every stiff wave of the solid.
    pub sound_speed: f64,
    /// A of Eq. (23) \[-\].
    pub viscosity_a: f64,
    /// B of Eq. (23) \[-\].
    pub viscosity_b: f64,
    /// λ of Eq. (24) \[-\].
    pub lambda: f64,
    /// ε of the artificial stress \[-\].
    pub artificial_stress: f64,
    /// n of Eq. (26) \[-\].
    pub exponent: f64,
    /// 1/W(d₀) of Eq. (26) \[m²\], d₀ the particle spacing.
    inverse_reference_kernel: f64,
}

impl SumLaw {
    /// The law of a body of `material` on a lattice of `particle_spacing` \[m\].
    pub fn new(constants: &UpdatedLagrangian, material: &ElasticMaterial, particle_spacing: f64) -> Self {
        let kernel = CubicSpline::new(constants.smoothing_length);
        Self {
            kernel,
            pair_kernel: PairKernel::new(&kernel, 1.0),
            sound_speed: material.longitudinal_speed(),
            viscosity_a: constants.viscosity_a,
            viscosity_b: constants.viscosity_b,
            lambda: constants.lambda,
            artificial_stress: constants.artificial_stress,
            exponent: constants.artificial_stress_exponent,
            inverse_reference_kernel: 1.0 / kernel.value(particle_spacing),
        }
    }

    /// The law between particles of two bodies of equal kernel: means of both bodies' constants.
    pub fn between(&self, other: &Self) -> Self {
        let mean = |a: f64, b: f64| 0.5 * (a + b);
        Self {
            sound_speed: mean(self.sound_speed, other.sound_speed),
            viscosity_a: mean(self.viscosity_a, other.viscosity_a),
            viscosity_b: mean(self.viscosity_b, other.viscosity_b),
            lambda: mean(self.lambda, other.lambda),
            ..*self
        }
    }

    /// Adds neighbour `b` of `a` to the sums of `a`, if it lies within support.
    ///
    /// ```text
    /// f_ab = m_a m_b ((σ_a + σ_b)/(ρ_a ρ_b) − Π_ab I + (R_a + R_b) Fⁿ)·∇_a W_ab        Eq. (25)
    /// ```
    #[inline]
    pub fn add_pair(&self, sums: &mut PairSums, a: &PairParticle, b: &PairParticle, x_ab: &Vector) {
        let square = x_ab.norm_squared();
        let support = self.kernel.support_radius();
        if square >= support * support {
            return;
        }
        let distance = square.sqrt();
        let gradient_factor = self.kernel.gradient_factor(distance);
        let v_ab = a.velocity - b.velocity;
        sums.add_gradient(b.mass / b.density, x_ab, &v_ab, gradient_factor);

        let mean_density = 0.5 * (a.density + b.density);
        let viscosity = self.artificial_viscosity().pressure(v_ab.dot(x_ab), square) / mean_density;
        let mut law = a.stress.plus(&b.stress).scaled(1.0 / (a.density * b.density));
        law.xx -= viscosity;
        law.yy -= viscosity;
        let artificial = a.artificial_stress.plus(&b.artificial_stress);
        if artificial != SymmetricTensor::default() {
            law = law.plus(&artificial.scaled(self.power_of_nearness(distance)));
        }
        sums.force += law.dot(x_ab) * (a.mass * b.mass * gradient_factor);
    }

    /// The artificial viscosity, Eq. (23)-(24).
    pub fn artificial_viscosity(&self) -> ArtificialViscosity {
        let linear = self.viscosity_a * self.sound_speed;
        ArtificialViscosity::new(self.kernel.smoothing_length(), linear, self.viscosity_b, self.lambda)
    }

    /// F of Eq. (26) over s = r/h \[-\].
    pub fn nearness<R: Real>(&self) -> Spline<R> {
        Spline::scaled(self.kernel.value(0.0) * self.inverse_reference_kernel)
    }

    /// Fⁿ of Eq. (26) \[-\] at `distance` \[m\].
    #[inline]
    fn power_of_nearness(&self, distance: f64) -> f64 {
        let ratio = self.nearness().at(distance / self.kernel.smoothing_length());
        if self.exponent == 4.0 { fourth_power(ratio) } else { ratio.powf(self.exponent) }
    }
}

/// `x`⁴, the power of Eq. (26) in the source paper.
#[inline(always)]
pub fn fourth_power<R: Real>(x: R) -> R {
    (x * x) * (x * x)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn law() -> SumLaw {
        let constants = UpdatedLagrangian {
            smoothing_length: 1.3,
            gradient_correction: true,
            viscosity_a: 1.0,
            viscosity_b: 0.5,
            lambda: 0.01,
            artificial_stress: 0.3,
            artificial_stress_exponent: 4.0,
        };
        let material = ElasticMaterial { density: 2.0, bulk_modulus: 5.0, shear_modulus: 3.0 };
        SumLaw::new(&constants, &material, 1.0)
    }

    fn particle(k: f64) -> PairParticle {
        PairParticle {
            mass: 1.0 + 0.2 * k,
            density: 2.0 - 0.1 * k,
            velocity: Vector::new(0.3 - k, 0.2 * k),
            stress: SymmetricTensor { xx: 1.0 + k, yy: -0.5, xy: 0.4 * k },
            artificial_stress: SymmetricTensor { xx: -0.1, yy: -0.2 * k, xy: 0.05 },
        }
    }

    #[test]
    fn pair_force_is_antisymmetric() {
        let (a, b) = (particle(0.0), particle(1.0));
        let x_ab = Vector::new(0.7, -0.4);
        let (mut on_a, mut on_b) = (PairSums::default(), PairSums::default());
        law().add_pair(&mut on_a, &a, &b, &x_ab);
        law().add_pair(&mut on_b, &b, &a, &-x_ab);
        assert!(on_a.force.norm() > 0.1);
        assert_eq!(on_a.force, -on_b.force);
    }

    #[test]
    fn nearness_is_one_at_the_initial_spacing() {
        assert!((law().power_of_nearness(1.0) - 1.0).abs() < 1e-15);
        let ratio = law().kernel.value(1.4) / law().kernel.value(1.0);
        assert!((law().power_of_nearness(1.4) - ratio.powi(4)).abs() < 1e-15);
    }

    /// Sums at the corner particle of a lattice quadrant, a free edge or the bulk, for a linear velocity.
    fn lattice_sums(columns: std::ops::RangeInclusive<i32>, rows: std::ops::RangeInclusive<i32>) -> PairSums {
        let law = law();
        let velocity = |x: &Vector| Tensor::new(0.3, -1.0, 0.8, -0.2) * x;
        let mut sums = PairSums::default();
        for column in columns {
            for row in rows.clone() {
                let x_j = Vector::new(f64::from(column), f64::from(row));
                let r = x_j.norm();
                sums.add_gradient(1.0, &-x_j, &-velocity(&x_j), law.kernel.gradient_factor(r));
            }
        }
        sums
    }

    #[test]
    fn corrected_gradient_is_exact_for_linear_velocities_up_to_the_corner() {
        let expected = Tensor::new(0.3, -1.0, 0.8, -0.2);
        for (columns, rows) in [(-3..=3, -3..=3), (0..=3, -3..=3), (0..=3, 0..=3), (0..=1, 0..=3)] {
            let sums = lattice_sums(columns, rows);
            let corrected = corrected_gradient(&sums.gradient, &sums.moment);
            assert!((corrected - expected).norm() < 1e-13);
        }
        // Without correction a free edge sees shear in a rigid rotation.
        let sums = lattice_sums(0..=3, -3..=3);
        assert!((sums.gradient - expected).norm() > 0.1);
    }

    #[test]
    fn correction_falls_back_along_directions_without_neighbours() {
        let sums = lattice_sums(-3..=3, 0..=0);
        let corrected = corrected_gradient(&sums.gradient, &sums.moment);
        // Along the row both components are exact; across it nothing is known.
        assert!((corrected[(0, 0)] - 0.3).abs() < 1e-14);
        assert!((corrected[(1, 0)] - 0.8).abs() < 1e-14);
        assert_eq!((corrected[(0, 1)], corrected[(1, 1)]), (0.0, 0.0));
        let alone = corrected_gradient(&Tensor::zeros(), &SymmetricTensor::default());
        assert_eq!(alone, Tensor::zeros());
    }
}
