//! Total-Lagrangian SPH: deformation gradient and nominal stress in the reference configuration.

use rayon::prelude::*;

use sph::kernel::CubicSpline;
use sph::setup::{ElasticMaterial, TotalLagrangian};
use sph::vector::{SymmetricTensor, Tensor, Vector};

use super::formulation::{
    BodyConstants, BodyFormulation, BodyStep, DerivedView, Limits, RateViewMut, StressView, StressViewMut,
};
use super::hyperelastic::Hyperelastic;
use super::lists::{Rows, TASK};
use super::pair_law::{PairSums, SumLaw};
use super::particles::{ParticleView, ParticleViewMut, RigidState};
use super::reference::{Reference, ReferencePair};
use super::supports::Support;
use super::updated_lagrangian::courant_limit;

/// λ of Eq. (24) in the optional artificial viscosity \[-\].
const LAMBDA: f64 = 0.01;

/// Part of 2/ω to which velocity Verlet is used; the power iteration may miss some per cent of ω.
const VERLET_FRACTION: f64 = 0.9;

/// Largest c_L Δt/h of the stage rule for A = 1, with h = 1.3 Δx.
///
/// Measured on a cantilever with a stencil of h = 0.8 Δx: stable at 0.4, not at 0.59.
const STAGE_RULE_COURANT: f64 = 0.4;

/// A hyperelastic body whose neighbours are those of the undeformed body.
///
/// Rigid motion is met exactly, forces derive from an energy, and neither tensile instability nor list builds occur.
pub(super) struct TotalLagrangianBody {
    material: ElasticMaterial,
    law: Hyperelastic,
    reference: Reference,
    constants: TotalLagrangian,
    spacing: f64,
    /// ζE over the lattice moment of the stencil \[Pa\].
    hourglass_modulus: f64,
    /// Largest angular frequency at rest \[rad/s\].
    largest_frequency: f64,
}

impl TotalLagrangianBody {
    /// A body of `material` whose particles are at `position` \[m\] when undeformed, on a lattice of `spacing` \[m\].
    pub fn new(
        constants: &TotalLagrangian,
        material: &ElasticMaterial,
        body: &BodyConstants<'_>,
        position: &[Vector],
        spacing: f64,
    ) -> Self {
        let kernel = CubicSpline::new(constants.smoothing_length);
        let volume = body.mass.iter().map(|mass| mass / material.density).collect();
        let mut anchored = vec![false; position.len()];
        let lasting = |support: &&Support| support.holds_fully() && support.release_time == f64::INFINITY;
        for held in body.supports.iter().filter(lasting).flat_map(|support| &support.particles) {
            anchored[held.particle] = true;
        }
        let reference = Reference::new(body.domain, position, volume, anchored, &kernel);
        let law = Hyperelastic::new(constants.law, material);
        let hourglass_modulus =
            constants.hourglass * material.young_modulus() / kernel.lattice_moment(spacing);
        let largest_frequency =
            reference.largest_frequency(body.mass, hourglass_modulus, |gradient| law.linear(gradient));
        Self {
            material: *material,
            law,
            reference,
            constants: *constants,
            spacing,
            hourglass_modulus,
            largest_frequency,
        }
    }

    /// Deformation gradient of particle `i` \[-\].
    #[inline]
    fn deformation_gradient(&self, body: &BodyConstants<'_>, position: &[Vector], i: usize) -> Tensor {
        self.reference
            .deformation_gradient(i, |pair| self.reference.separation(body.domain, position, i, pair))
    }

    /// Artificial viscosity on particle `i` \[N/m\], Eq. (23)-(24) with the reference stencil.
    ///
    /// ```text
    /// f_i = Σ_j a_ij ρ₀ (−A c_L θ + B θ²) x_ij,  θ = h v_ij·x_ij/(x_ij² + λh²) < 0
    /// ```
    fn viscous_force(&self, body: &BodyConstants<'_>, state: &ParticleView<'_>, i: usize) -> Vector {
        let h = self.constants.smoothing_length;
        let sound_speed = self.material.longitudinal_speed();
        let mut force = Vector::zeros();
        for pair in self.reference.of(i) {
            let j = pair.neighbour as usize;
            let x_ij = body.domain.separation(&state.position[i], &state.position[j]);
            let approach = (state.velocity[i] - state.velocity[j]).dot(&x_ij);
            if approach < 0.0 {
                let theta = h * approach / (x_ij.norm_squared() + LAMBDA * h * h);
                let damping =
                    (self.constants.viscosity_b * theta - self.constants.viscosity_a * sound_speed) * theta;
                force += x_ij * (pair.weight * self.material.density * damping);
            }
        }
        force
    }

    fn is_viscous(&self) -> bool {
        self.constants.viscosity_a > 0.0 || self.constants.viscosity_b > 0.0
    }
}

impl BodyFormulation for TotalLagrangianBody {
    fn update_stress(&self, body: &BodyConstants<'_>, state: &ParticleView<'_>, stress: StressViewMut<'_>) {
        stress
            .pressure
            .par_iter_mut()
            .zip(stress.cauchy)
            .zip(stress.deformation)
            .zip(stress.nominal)
            .with_min_len(TASK)
            .enumerate()
            .for_each(|(i, (((p, cauchy), deformation), nominal))| {
                *deformation = self.deformation_gradient(body, state.position, i);
                let found = self.law.stress(deformation);
                *nominal = self.reference.pair_stress(i, &found.nominal);
                *cauchy = found.cauchy;
                *p = found.pressure();
            });
        stress.artificial.fill(SymmetricTensor::default());
    }

    /// ρ = ρ₀/J and s = σ + p I.
    fn derive(&self, stress: &StressView<'_>, derived: DerivedView<'_>) {
        for (i, (rho, s)) in derived.density.iter_mut().zip(derived.deviatoric_stress).enumerate() {
            *rho = self.material.density / stress.deformation[i].determinant();
            *s = stress.cauchy[i].plus(&SymmetricTensor::isotropic(stress.pressure[i]));
        }
    }

    /// The virtual work of a force at x_i + F_i X is that of the force on i and of its moment on F_i.
    fn load_stress(&self, i: usize, moment: &Tensor) -> Tensor {
        self.reference.moment_stress(i, moment) * -1.0
    }

    fn list_radius(&self) -> Option<f64> {
        None
    }

    fn evaluate(
        &self,
        body: &BodyConstants<'_>,
        stage: &ParticleView<'_>,
        stress: &StressView<'_>,
        _neighbours: &Rows,
        sums: &mut [PairSums],
    ) {
        sums.par_iter_mut().with_min_len(TASK).enumerate().for_each(|(i, sums)| {
            let x_ij = |pair: &ReferencePair| self.reference.separation(body.domain, stage.position, i, pair);
            *sums = PairSums::default();
            sums.force =
                self.reference.force(i, stress.nominal, stress.deformation, self.hourglass_modulus, x_ij);
            if self.is_viscous() {
                sums.force += self.viscous_force(body, stage, i);
            }
        });
    }

    fn complete(&self, _stage: &ParticleView<'_>, _sums: &[PairSums], rates: RateViewMut<'_>) {
        rates.density.fill(0.0);
        rates.deviatoric_stress.fill(SymmetricTensor::default());
    }

    fn advance(&self, step: &BodyStep<'_>, next: ParticleViewMut<'_>, _next_rigid: &mut RigidState) {
        let duration = step.time.duration();
        for i in 0..step.base.position.len() {
            next.position[i] = step.base.position[i] + step.stage.velocity[i] * duration;
            next.velocity[i] = step.base.velocity[i] + step.force[i] * (duration / step.constants.mass[i]);
        }
        let position: &[Vector] = next.position;
        for i in 0..position.len() {
            let deformation = self.deformation_gradient(&step.constants, position, i);
            let stress = self.law.stress(&deformation);
            next.density[i] = self.material.density / deformation.determinant();
            next.deviatoric_stress[i] = stress.cauchy.plus(&SymmetricTensor::isotropic(stress.pressure()));
        }
    }

    fn is_rigid(&self) -> bool {
        false
    }

    fn sum_law(&self) -> Option<&SumLaw> {
        None
    }

    fn stage_rule_limit(&self) -> f64 {
        let courant = STAGE_RULE_COURANT * courant_limit(self.constants.viscosity_a);
        courant * 1.3 * self.spacing / self.material.longitudinal_speed()
    }

    /// 2/ω of velocity Verlet; viscosity, explicit, narrows it.
    fn substep_limit(&self) -> f64 {
        let viscous = 1.0 + self.constants.viscosity_a;
        if self.largest_frequency > 0.0 {
            VERLET_FRACTION * 2.0 / (self.largest_frequency * viscous)
        } else {
            f64::INFINITY
        }
    }

    fn stiffening(&self, stress: &StressView<'_>, i: usize) -> f64 {
        self.law.stiffening(&stress.deformation[i])
    }

    fn limits(&self) -> Limits {
        Limits { density_ratios: (0.1, 10.0), largest_shear: f64::INFINITY }
    }

    fn strain_energy(&self, body: &BodyConstants<'_>, state: &ParticleView<'_>, i: usize) -> f64 {
        if self.reference.is_anchored(i) {
            return 0.0;
        }
        let x_ij = |pair: &ReferencePair| self.reference.separation(body.domain, state.position, i, pair);
        let deformation = self.reference.deformation_gradient(i, x_ij);
        self.reference.volume[i] * self.law.energy_density(&deformation)
            + self.reference.hourglass_energy(i, &deformation, self.hourglass_modulus, x_ij)
    }
}
