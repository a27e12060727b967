//! Updated-Lagrangian SPH as in the source paper, Eq. (5)-(8), (17), (25)-(26).

use sph::lanes::Arithmetic;
use sph::setup::{ElasticParameters, UpdatedLagrangian};
use sph::space::geometry::{Geometry, Open, Periodic};
use sph::space::tensors::{SpaceSymmetric, SpaceTensor};
use sph::tasks::{for_each, for_each_task};

use crate::formulations::formulation::{AngularImpulse, BodyConstants, BodyDrift, BodyFormulation, BodyStep};
use crate::formulations::pair_lanes::{BodyArrays, PairPass};
use crate::formulations::pair_law::{PairSums, SumLaw};
use crate::materials::hooke::{
    artificial_stress, cauchy_stress, deviatoric_stress_rate, pressure, strain_energy_density,
};
use crate::neighbours::lists::{Rows, TASK};
use crate::particles::fields::{RateViewMut, StressView, StressViewMut};
use crate::particles::variables::{ParticleView, ParticleViewMut, RigidState};
use crate::space::SolidSpace;

/// An elastic body whose density and stress evolve with the velocity gradient.
///
/// The same gradient, corrected by L_i of Eq. (21) or not, enters Eq. (7) and the continuity equation in the form
/// dρ/dt = −ρ tr(∇v), which without correction is Eq. (17). Without correction free surfaces see shear in a rigid
/// rotation, and the body turns as if on a torsion spring.
pub struct UpdatedLagrangianBody<S: SolidSpace> {
    material: ElasticParameters,
    law: SumLaw<S>,
    gradient_correction: bool,
    arithmetic: Arithmetic,
}

impl<S: SolidSpace> UpdatedLagrangianBody<S> {
    /// A body of `material` on a lattice of `particle_spacing` \[m\].
    pub fn new(
        constants: &UpdatedLagrangian,
        material: &ElasticParameters,
        particle_spacing: f64,
        arithmetic: Arithmetic,
    ) -> Self {
        Self {
            material: *material,
            law: SumLaw::new(constants, material, particle_spacing),
            gradient_correction: constants.gradient_correction,
            arithmetic,
        }
    }

    fn sum_pairs<G: Geometry<S>>(
        &self,
        geometry: G,
        members: BodyArrays<'_, S>,
        neighbours: &Rows,
        sums: &mut [PairSums<S>],
    ) {
        let law = &self.law;
        for_each_task(sums.len(), TASK, sums, &|particles, sums| {
            let first = particles.start;
            self.arithmetic.run(PairPass { geometry, law, members, neighbours, first, sums });
        });
    }

    fn velocity_gradient(&self, sums: &PairSums<S>) -> S::Tensor {
        if self.gradient_correction { sums.corrected_gradient() } else { sums.plain_gradient() }
    }
}

impl<S: SolidSpace> BodyFormulation<S> for UpdatedLagrangianBody<S> {
    fn update_stress(
        &self,
        _constants: &BodyConstants<'_, S>,
        state: &ParticleView<'_, S>,
        stress: StressViewMut<'_, S>,
    ) {
        let (material, epsilon) = (&self.material, self.law.artificial_stress);
        let results = ((stress.pressure, stress.cauchy), stress.artificial);
        for_each(results, 8 * TASK, |i, ((p, sigma), artificial)| {
            let rho = state.density[i];
            *p = pressure(material, rho);
            *sigma = cauchy_stress::<S>(*p, &state.deviatoric_stress[i]);
            *artificial = artificial_stress::<S>(epsilon, sigma, rho);
        });
    }

    fn list_radius(&self) -> Option<f64> {
        Some(self.law.kernel.support_radius())
    }

    fn evaluate(
        &self,
        constants: &BodyConstants<'_, S>,
        stage: &ParticleView<'_, S>,
        stress: &StressView<'_, S>,
        neighbours: &Rows,
        sums: &mut [PairSums<S>],
    ) {
        let members = BodyArrays {
            position: stage.position,
            velocity: stage.velocity,
            mass: constants.mass,
            density: stage.density,
            stress: stress.cauchy,
            artificial: stress.artificial,
        };
        if constants.domain.is_periodic() {
            self.sum_pairs(Periodic::new(constants.domain), members, neighbours, sums);
        } else {
            self.sum_pairs(Open, members, neighbours, sums);
        }
    }

    fn complete(&self, stage: &ParticleView<'_, S>, sums: &[PairSums<S>], rates: RateViewMut<'_, S>) {
        for_each((rates.density, rates.deviatoric_stress), 8 * TASK, |i, (rho_dot, s_dot)| {
            let gradient = self.velocity_gradient(&sums[i]);
            *rho_dot = -stage.density[i] * gradient.trace();
            *s_dot = deviatoric_stress_rate::<S>(&self.material, &stage.deviatoric_stress[i], &gradient);
        });
    }

    fn advance(
        &self,
        step: &BodyStep<'_, S>,
        next: ParticleViewMut<'_, S>,
        _next_rigid: &mut RigidState<S>,
    ) -> AngularImpulse<S> {
        let duration = step.time.duration();
        let (base, stage, rates) = (&step.base, &step.stage, &step.rates);
        let next = (((next.position, next.velocity), next.density), next.deviatoric_stress);
        for_each(next, 8 * TASK, |i, (((x, v), rho), s)| {
            *x = base.position[i] + stage.velocity[i] * duration;
            *v = base.velocity[i] + step.force[i] * (duration / step.constants.mass[i]);
            *rho = base.density[i] + rates.density[i] * duration;
            *s = base.deviatoric_stress[i].plus(&rates.deviatoric_stress[i].scaled(duration));
        });
        AngularImpulse::default()
    }

    /// Density and stress follow the gradient in the middle of the drift, both by the midpoint rule.
    fn drift(
        &self,
        drift: &BodyDrift<'_, S>,
        particles: ParticleViewMut<'_, S>,
        _motion: &mut RigidState<S>,
    ) -> AngularImpulse<S> {
        let (duration, half) = (drift.duration, 0.5 * drift.duration);
        let ParticleViewMut { position, velocity, density, deviatoric_stress } = particles;
        let columns = (((position, velocity), density), deviatoric_stress);
        for_each(columns, 8 * TASK, |i, (((x, v), rho), s)| {
            *x += *v * duration;
            let gradient = self.velocity_gradient(&drift.sums[i]);
            let rate = |s| deviatoric_stress_rate::<S>(&self.material, s, &gradient);
            *rho *= (1.0 - half * gradient.trace()) / (1.0 + half * gradient.trace());
            let middle = s.plus(&rate(s).scaled(half));
            *s = s.plus(&rate(&middle).scaled(duration));
        });
        AngularImpulse::default()
    }

    fn evolves(&self) -> bool {
        true
    }

    fn sum_law(&self) -> Option<&SumLaw<S>> {
        Some(&self.law)
    }

    fn strain_energy(&self, constants: &BodyConstants<'_, S>, state: &ParticleView<'_, S>, i: usize) -> f64 {
        let rho = state.density[i];
        let p = pressure(&self.material, rho);
        constants.mass[i] / rho * strain_energy_density::<S>(&self.material, p, &state.deviatoric_stress[i])
    }
}
