//! Pair terms of two solid particles in the sums (17), (21) and (25), over one neighbour or four.

use sph::kernel::shape::Spline;
use sph::kernel::{CubicSpline, PairKernel};
use sph::lanes::Real;
use sph::laws::artificial_viscosity::ArtificialViscosity;
use sph::setup::{ElasticParameters, UpdatedLagrangian};
use sph::space::tensors::SpaceSymmetric;

use crate::space::SolidSpace;

/// One particle as a pair sees it, or one in each lane.
#[derive(Clone, Copy)]
pub struct PairParticle<S: SolidSpace, R: Real = f64> {
    /// Mass per depth \[kg/m\].
    pub mass: R,
    /// Density \[kg/m³\].
    pub density: R,
    /// Velocity \[m/s\].
    pub velocity: S::Of<R>,
    /// Cauchy stress \[Pa\].
    pub stress: S::Symmetric<R>,
    /// Artificial stress R_i \[m⁵/(kg s²)\].
    pub artificial_stress: S::Symmetric<R>,
}

/// What a pair of particles a, b adds to the sums of a.
pub struct PairTerms<S: SolidSpace, R: Real> {
    /// x_ab \[m\].
    pub separation: S::Of<R>,
    /// v_ab \[m/s\].
    pub velocity: S::Of<R>,
    /// (dW/dr)/r \[1/m⁴\].
    pub gradient_factor: R,
    /// V_b (dW/dr)/r \[1/m²\].
    pub weight: R,
    /// 1/(ρ_a ρ_b) \[m⁶/kg²\].
    pub inverse_densities: R,
    /// Π_ab of Eq. (23) \[m⁵/(kg s²)\].
    pub viscosity: R,
    /// Fⁿ of Eq. (26) \[-\]; `None` without artificial stress.
    pub nearness: Option<R>,
}

/// Sums over the pairs of one particle, or over a part of them in each lane.
#[derive(Clone, Copy, Debug)]
pub struct PairSums<S: SolidSpace, R: Real = f64> {
    /// Force per metre of depth \[N/m\].
    pub force: S::Of<R>,
    /// The part of it by artificial viscosity \[N/m\].
    pub viscous: S::Of<R>,
    /// The part of it by artificial stress \[N/m\].
    pub artificial: S::Of<R>,
    /// Σ V_j (v_j − v_i) ⊗ ∇_i W_ij \[1/s\]: the velocity gradient ∂_b v_a before correction.
    pub gradient: S::Matrix<R>,
    /// Σ V_j (x_j − x_i) ⊗ ∇_i W_ij \[-\]: the inverse of L_i, Eq. (21).
    pub moment: S::Symmetric<R>,
}

impl<S: SolidSpace, R: Real> PairSums<S, R> {
    /// Sums over no pairs.
    #[inline(always)]
    pub fn zero() -> Self {
        let none = S::splat(R::zero());
        Self {
            force: none,
            viscous: none,
            artificial: none,
            gradient: S::zero_matrix(),
            moment: S::zero_symmetric(),
        }
    }

    /// Adds a neighbour with V_j (dW/dr)/r = `weight` \[1/m²\], x_ij \[m\] and v_ij \[m/s\] to gradient and moment.
    #[inline(always)]
    pub fn add_gradient(&mut self, weight: R, x_ij: S::Of<R>, v_ij: S::Of<R>) {
        let weighted = S::scaled(x_ij, weight);
        self.gradient = S::minus_outer(self.gradient, v_ij, weighted);
        self.moment = S::symmetric_minus_outer(self.moment, x_ij, weighted);
    }

    /// Adds the gradient and moment of `other`.
    #[inline]
    pub fn add_gradients_of(&mut self, other: &Self) {
        self.gradient = S::matrix_plus(self.gradient, other.gradient);
        self.moment = S::symmetric_plus(self.moment, other.moment);
    }

    /// Adds neighbour `b` of `a`.
    ///
    /// ```text
    /// f_ab = m_a m_b ((σ_a + σ_b)/(ρ_a ρ_b) − Π_ab I + (R_a + R_b) Fⁿ)·∇_a W_ab        Eq. (25)
    /// ```
    #[inline(always)]
    pub fn add_pair(&mut self, a: &PairParticle<S, R>, b: &PairParticle<S, R>, pair: &PairTerms<S, R>) {
        self.add_gradient(pair.weight, pair.separation, pair.velocity);
        let stress = S::symmetric_scaled(S::symmetric_plus(a.stress, b.stress), pair.inverse_densities);
        let mut law = S::symmetric_plus_isotropic(stress, R::zero() - pair.viscosity);
        let factor = a.mass * b.mass * pair.gradient_factor;
        if let Some(nearness) = pair.nearness {
            let artificial = S::symmetric_plus(a.artificial_stress, b.artificial_stress);
            law = S::symmetric_plus_product(law, artificial, nearness);
            let force = S::symmetric_times(artificial, pair.separation);
            self.artificial = S::plus_product(self.artificial, factor * nearness, force);
        }
        self.viscous = S::minus_product(self.viscous, factor * pair.viscosity, pair.separation);
        self.force = S::plus_product(self.force, factor, S::symmetric_times(law, pair.separation));
    }
}

impl<S: SolidSpace> PairSums<S> {
    /// The velocity gradient as summed \[1/s\].
    #[inline]
    pub fn plain_gradient(&self) -> S::Tensor {
        S::tensor(self.gradient)
    }

    /// Velocity gradient \[1/s\] corrected by L_i, Eq. (21): G·M⁻¹, exact for linear velocities.
    ///
    /// Fallback: no correction along principal directions of M whose eigenvalue is below [`crate::thresholds::Thresholds::SMALLEST_MOMENT`].
    #[inline]
    pub fn corrected_gradient(&self) -> S::Tensor {
        let moment = S::symmetric_tensor(self.moment);
        let [_, smallest] = moment.extremes();
        let inverse = if smallest >= S::SMALLEST_MOMENT {
            S::symmetric_tensor(S::symmetric_inverse(self.moment, S::symmetric_determinant(self.moment)))
        } else {
            moment.map_principal(|value| if value >= S::SMALLEST_MOMENT { 1.0 / value } else { 1.0 })
        };
        self.plain_gradient() * inverse.full()
    }
}

/// Constants of the sum (25) between solid particles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SumLaw<S: SolidSpace> {
    /// Kernel, Eq. (10)-(11).
    pub kernel: CubicSpline<S>,
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

impl<S: SolidSpace> SumLaw<S> {
    /// The law of a body of `material` on a lattice of `particle_spacing` \[m\].
    pub fn new(constants: &UpdatedLagrangian, material: &ElasticParameters, particle_spacing: f64) -> Self {
        let kernel = CubicSpline::new(constants.smoothing_length(particle_spacing));
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
    #[inline]
    pub fn add_pair(
        &self,
        sums: &mut PairSums<S>,
        a: &PairParticle<S>,
        b: &PairParticle<S>,
        x_ab: &S::Vector,
    ) {
        let separation = S::components(x_ab);
        let square = S::dot(separation, separation);
        let support = self.kernel.support_radius();
        if square >= support * support {
            return;
        }
        let distance = square.sqrt();
        let gradient_factor = self.kernel.gradient_factor(distance);
        let velocity = S::minus(a.velocity, b.velocity);
        let damping = self.artificial_viscosity().pressure(S::dot(velocity, separation), square);
        let pair = PairTerms {
            separation,
            velocity,
            gradient_factor,
            weight: b.mass / b.density * gradient_factor,
            inverse_densities: 1.0 / (a.density * b.density),
            viscosity: damping / (0.5 * (a.density + b.density)),
            nearness: Some(self.power_of_nearness(distance)),
        };
        sums.add_pair(a, b, &pair);
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
    use sph::space::{Plane, Tensor, Vector};

    type Sums = PairSums<Plane>;

    fn law() -> SumLaw<Plane> {
        let constants = UpdatedLagrangian { viscosity_b: 0.5, ..UpdatedLagrangian::default() };
        let material = ElasticParameters {
            density: 2.0,
            bulk_modulus: 5.0,
            shear_modulus: 3.0,
            plane: sph::setup::PlaneState::Strain,
        };
        SumLaw::new(&constants, &material, 1.0)
    }

    fn particle(k: f64) -> PairParticle<Plane> {
        PairParticle {
            mass: 1.0 + 0.2 * k,
            density: 2.0 - 0.1 * k,
            velocity: [0.3 - k, 0.2 * k],
            stress: [1.0 + k, 0.4 * k, -0.5],
            artificial_stress: [-0.1, 0.05, -0.2 * k],
        }
    }

    #[test]
    fn pair_force_is_antisymmetric() {
        let (a, b) = (particle(0.0), particle(1.0));
        let x_ab = Vector::new(0.7, -0.4);
        let (mut on_a, mut on_b) = (Sums::zero(), Sums::zero());
        law().add_pair(&mut on_a, &a, &b, &x_ab);
        law().add_pair(&mut on_b, &b, &a, &-x_ab);
        assert!(on_a.force[0].hypot(on_a.force[1]) > 0.1);
        assert_eq!(on_a.force, on_b.force.map(|component| -component));
    }

    #[test]
    fn nearness_is_one_at_the_initial_spacing() {
        assert!((law().power_of_nearness(1.0) - 1.0).abs() < 1e-15);
        let ratio = law().kernel.value(1.4) / law().kernel.value(1.0);
        assert!((law().power_of_nearness(1.4) - ratio.powi(4)).abs() < 1e-15);
    }

    /// Sums at the corner particle of a lattice quadrant, a free edge or the bulk, for a linear velocity.
    fn lattice_sums(columns: std::ops::RangeInclusive<i32>, rows: std::ops::RangeInclusive<i32>) -> Sums {
        let law = law();
        let velocity = |x: &Vector| Tensor::new(0.3, -1.0, 0.8, -0.2) * x;
        let mut sums = Sums::zero();
        for column in columns {
            for row in rows.clone() {
                let x_j = Vector::new(f64::from(column), f64::from(row));
                let r = x_j.norm();
                sums.add_gradient(law.kernel.gradient_factor(r), (-x_j).into(), (-velocity(&x_j)).into());
            }
        }
        sums
    }

    #[test]
    fn corrected_gradient_is_exact_for_linear_velocities_up_to_the_corner() {
        let expected = Tensor::new(0.3, -1.0, 0.8, -0.2);
        for (columns, rows) in [(-3..=3, -3..=3), (0..=3, -3..=3), (0..=3, 0..=3), (0..=1, 0..=3)] {
            let sums = lattice_sums(columns, rows);
            let corrected = sums.corrected_gradient();
            assert!((corrected - expected).norm() < 1e-13);
        }
        // Without correction a free edge sees shear in a rigid rotation.
        let sums = lattice_sums(0..=3, -3..=3);
        assert!((sums.plain_gradient() - expected).norm() > 0.1);
    }

    #[test]
    fn correction_falls_back_along_directions_without_neighbours() {
        let sums = lattice_sums(-3..=3, 0..=0);
        let corrected = sums.corrected_gradient();
        // Along the row both components are exact; across it nothing is known.
        assert!((corrected[(0, 0)] - 0.3).abs() < 1e-14);
        assert!((corrected[(1, 0)] - 0.8).abs() < 1e-14);
        assert_eq!((corrected[(0, 1)], corrected[(1, 1)]), (0.0, 0.0));
        let alone = Sums::zero().corrected_gradient();
        assert_eq!(alone, Tensor::zeros());
    }
}
