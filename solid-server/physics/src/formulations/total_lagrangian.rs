//! Total-Lagrangian SPH: deformation gradient and nominal stress in the reference configuration.

use sph::kernel::CubicSpline;
use sph::lanes::Arithmetic;
use sph::laws::artificial_viscosity::ArtificialViscosity;
use sph::setup::{ElasticParameters, TotalLagrangian};
use sph::space::geometry::{Geometry, Open, Periodic};
use sph::space::tensors::{SpaceSymmetric, SpaceTensor, SpaceVector};
use sph::tasks::for_each_task;

use crate::boundary::supports::Support;
use crate::formulations::bond_forces::{Bonds, ForcePass, TOTAL_LAGRANGIAN_LAMBDA, Viscosity};
use crate::formulations::formulation::{
    AngularImpulse, BodyConstants, BodyFormulation, BodyStep, StateLimits,
};
use crate::formulations::pair_law::PairSums;
use crate::formulations::reference_forces::ForceUnits;
use crate::materials::hyperelastic::Hyperelastic;
use crate::neighbours::lists::{Rows, TASK};
use crate::neighbours::reference::{Reference, ReferencePair};
use crate::neighbours::stencil::MomentPass;
use crate::particles::fields::{StressView, StressViewMut};
use crate::particles::variables::{ParticleView, ParticleViewMut, RigidState};
use crate::space::SolidSpace;

/// A hyperelastic body whose neighbours are those of the undeformed body.
///
/// Rigid motion is met exactly, forces derive from an energy, and neither tensile instability nor list builds occur.
pub struct TotalLagrangianBody<S: SolidSpace> {
    material: ElasticParameters,
    law: Hyperelastic,
    reference: Reference<S>,
    /// Those of pair forces; the hourglass modulus is ζE over the lattice moment of the stencil.
    units: ForceUnits,
    viscosity: Option<Viscosity>,
    arithmetic: Arithmetic,
    /// Largest angular frequency at rest \[rad/s\].
    pub largest_frequency: f64,
}

impl<S: SolidSpace> TotalLagrangianBody<S> {
    /// A body of `material` whose particles are at `position` \[m\] when undeformed, on a lattice of `spacing` \[m\].
    pub fn new(
        constants: &TotalLagrangian,
        material: &ElasticParameters,
        body: &BodyConstants<'_, S>,
        position: &[S::Vector],
        spacing: f64,
        arithmetic: Arithmetic,
    ) -> Self {
        let smoothing_length = constants.smoothing_length(spacing);
        let kernel = CubicSpline::new(smoothing_length);
        let volume = body.mass.iter().map(|mass| mass / material.density).collect();
        let mut anchored = vec![false; position.len()];
        let lasting = |support: &&Support<S>| support.holds_fully() && support.release_time == f64::INFINITY;
        for held in body.supports.iter().filter(lasting).flat_map(|support| &support.particles) {
            anchored[held.particle] = true;
        }
        let reference = Reference::new(body.domain, position, volume, anchored, &kernel);
        let law = Hyperelastic::new(constants.law, material);
        let units = ForceUnits::new(
            constants.hourglass * material.young_modulus() / kernel.lattice_moment(spacing),
            material.young_modulus(),
        );
        let largest_frequency =
            reference.largest_frequency(body.mass, &units, |gradient| law.linear::<S>(gradient));
        let viscous = constants.viscosity_a > 0.0 || constants.viscosity_b > 0.0;
        let viscosity = viscous.then(|| Viscosity {
            law: ArtificialViscosity::new(
                smoothing_length,
                constants.viscosity_a * material.longitudinal_speed(),
                constants.viscosity_b,
                TOTAL_LAGRANGIAN_LAMBDA,
            ),
            density: material.density,
        });
        Self { material: *material, law, reference, units, viscosity, arithmetic, largest_frequency }
    }

    /// Deformation gradients of the particles from `first` on \[-\], for the body at `position` \[m\].
    fn deform<G: Geometry<S>>(
        &self,
        geometry: G,
        body: &BodyConstants<'_, S>,
        position: &[S::Vector],
        first: usize,
        deformation: &mut [S::Tensor],
    ) {
        let stencils = &self.reference.stencils;
        self.arithmetic.run(MomentPass { geometry, stencils, position, first, sums: deformation });
        for (k, deformation) in deformation.iter_mut().enumerate() {
            *deformation = self.reference.completed(body.domain, position, first + k, deformation);
        }
    }

    /// The same in the box of the body.
    fn deform_in_box(
        &self,
        body: &BodyConstants<'_, S>,
        position: &[S::Vector],
        first: usize,
        deformation: &mut [S::Tensor],
    ) {
        if body.domain.is_periodic() {
            self.deform(Periodic::new(body.domain), body, position, first, deformation);
        } else {
            self.deform(Open, body, position, first, deformation);
        }
    }

    /// Forces of all pairs of the body \[N/m\].
    fn pair_forces<G: Geometry<S>>(
        &self,
        geometry: G,
        body: &BodyConstants<'_, S>,
        state: &ParticleView<'_, S>,
        pair_tensor: &[S::Matrix<f64>],
        sums: &mut [PairSums<S>],
    ) {
        let bonds = Bonds {
            geometry,
            stencils: &self.reference.stencils,
            position: state.position,
            velocity: state.velocity,
            pair_tensor,
            units: self.units,
            viscosity: self.viscosity,
        };
        for_each_task(sums.len(), TASK, sums, &|particles, sums| {
            let first = particles.start;
            let mut both = [[S::Vector::zeros(); TASK]; 2];
            let [forces, viscous] = both.each_mut().map(|forces| &mut forces[..sums.len()]);
            self.arithmetic.run(ForcePass { bonds: &bonds, first, forces, viscous });
            for (k, sums) in sums.iter_mut().enumerate() {
                let i = first + k;
                // Anchored material is rigid within.
                let inner = if self.reference.anchored[i] {
                    [S::Vector::zeros(); 2]
                } else {
                    [forces[k], viscous[k]]
                };
                let border = self.border_force(body, state, pair_tensor, i);
                *sums = PairSums {
                    force: S::components(&(inner[0] + border[0])),
                    viscous: S::components(&(inner[1] + border[1])),
                    ..PairSums::zero()
                };
            }
        });
    }

    /// Force on particle `i` of its pairs between anchored and free particles, and the part of it by artificial viscosity
    /// \[N/m\].
    fn border_force(
        &self,
        body: &BodyConstants<'_, S>,
        state: &ParticleView<'_, S>,
        pair_tensor: &[S::Matrix<f64>],
        i: usize,
    ) -> [S::Vector; 2] {
        let x_ij = |pair: &ReferencePair<S>| self.reference.separation(body.domain, state.position, i, pair);
        let mut viscous = S::Vector::zeros();
        let mut force =
            self.reference.force(i, self.reference.across_border(i), pair_tensor, &self.units, x_ij);
        let Some(viscosity) = &self.viscosity else { return [force, viscous] };
        for pair in self.reference.across_border(i) {
            let j = pair.neighbour as usize;
            let x_ij = body.domain.separation(&state.position[i], &state.position[j]);
            let approach = (state.velocity[i] - state.velocity[j]).dot(&x_ij);
            let of_pair = x_ij * (pair.weight * viscosity.pressure(approach, x_ij.norm_squared()));
            force += of_pair;
            viscous += of_pair;
        }
        [force, viscous]
    }
}

impl<S: SolidSpace> BodyFormulation<S> for TotalLagrangianBody<S> {
    fn update_stress(
        &self,
        body: &BodyConstants<'_, S>,
        state: &ParticleView<'_, S>,
        stress: StressViewMut<'_, S>,
    ) {
        let StressViewMut { pressure, cauchy, artificial, deformation, pair_tensor } = stress;
        let (count, results) = (pressure.len(), (((pressure, cauchy), deformation), pair_tensor));
        for_each_task(count, TASK, results, &|particles, results| {
            let (first, (((pressure, cauchy), deformation), pair_tensor)) = (particles.start, results);
            self.deform_in_box(body, state.position, first, deformation);
            for (k, f) in deformation.iter().enumerate() {
                let found = self.law.stress::<S>(f);
                pair_tensor[k] = self.reference.pair_tensor(first + k, f, &found.nominal, &self.units);
                cauchy[k] = found.cauchy;
                pressure[k] = found.pressure();
            }
        });
        artificial.fill(S::SymmetricTensor::default());
    }

    /// ρ = ρ₀/J and s = σ + p I.
    fn derive(&self, stress: &StressView<'_, S>, derived: ParticleViewMut<'_, S>) {
        for (i, (rho, s)) in derived.density.iter_mut().zip(derived.deviatoric_stress).enumerate() {
            *rho = self.material.density / stress.deformation[i].determinant();
            *s = stress.cauchy[i].plus(&S::SymmetricTensor::isotropic(stress.pressure[i]));
        }
    }

    /// The virtual work of a force at x_i + F_i X is that of the force on i and of its moment on F_i.
    fn load_pair_tensor(&self, i: usize, moment: &S::Tensor) -> S::Matrix<f64> {
        self.reference.moment_pair_tensor(i, &-*moment, &self.units)
    }

    fn evaluate(
        &self,
        body: &BodyConstants<'_, S>,
        stage: &ParticleView<'_, S>,
        stress: &StressView<'_, S>,
        _neighbours: &Rows,
        sums: &mut [PairSums<S>],
    ) {
        if body.domain.is_periodic() {
            self.pair_forces(Periodic::new(body.domain), body, stage, stress.pair_tensor, sums);
        } else {
            self.pair_forces(Open, body, stage, stress.pair_tensor, sums);
        }
    }

    fn advance(
        &self,
        step: &BodyStep<'_, S>,
        next: ParticleViewMut<'_, S>,
        _next_rigid: &mut RigidState<S>,
    ) -> AngularImpulse<S> {
        let duration = step.time.duration();
        for i in 0..step.base.position.len() {
            next.position[i] = step.base.position[i] + step.stage.velocity[i] * duration;
            next.velocity[i] = step.base.velocity[i] + step.force[i] * (duration / step.constants.mass[i]);
        }
        let position: &[S::Vector] = next.position;
        let derived = next.density.chunks_mut(TASK).zip(next.deviatoric_stress.chunks_mut(TASK));
        for (task, (density, deviatoric_stress)) in derived.enumerate() {
            let mut deformation = [S::Tensor::zeros(); TASK];
            let deformation = &mut deformation[..density.len()];
            self.deform_in_box(&step.constants, position, task * TASK, deformation);
            for (k, f) in deformation.iter().enumerate() {
                let stress = self.law.stress::<S>(f);
                density[k] = self.material.density / f.determinant();
                deviatoric_stress[k] = stress.cauchy.plus(&S::SymmetricTensor::isotropic(stress.pressure()));
            }
        }
        AngularImpulse::default()
    }

    fn tangent_stiffness_ratio(&self, stress: &StressView<'_, S>, i: usize) -> f64 {
        self.law.tangent_stiffness_ratio::<S>(&stress.deformation[i])
    }

    fn limits(&self) -> StateLimits {
        StateLimits::HYPERELASTIC
    }

    fn strain_energy(&self, body: &BodyConstants<'_, S>, state: &ParticleView<'_, S>, i: usize) -> f64 {
        if self.reference.anchored[i] {
            return 0.0;
        }
        let x_ij = |pair: &ReferencePair<S>| self.reference.separation(body.domain, state.position, i, pair);
        let deformation = self.reference.deformation_gradient(i, x_ij);
        self.reference.volume[i] * self.law.energy_density::<S>(&deformation)
            + self.reference.hourglass_energy(i, &deformation, self.units.hourglass_modulus(), x_ij)
    }
}
