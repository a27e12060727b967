//! The trait of the formulations: discretisation of one body by itself.

use std::ops::AddAssign;

use sph::coupling::stage::StageTime;
use sph::space::domain::Domain;

use crate::boundary::supports::Support;
use crate::formulations::pair_law::{PairSums, SumLaw};
use crate::neighbours::lists::Rows;
use crate::particles::fields::{RateView, RateViewMut, StressView, StressViewMut};
use crate::particles::forces::ParticleForces;
use crate::particles::variables::{ParticleView, ParticleViewMut, RigidState};
use crate::space::SolidSpace;

/// Constants of a body's particles.
#[derive(Clone, Copy)]
pub struct BodyConstants<'a, S: SolidSpace> {
    pub domain: &'a Domain<S>,
    /// Mass per depth \[kg/m\].
    pub mass: &'a [f64],
    /// Supports of the body.
    pub supports: &'a [Support<S>],
}

/// Input of [`BodyFormulation::advance`].
#[derive(Clone, Copy)]
pub struct BodyStep<'a, S: SolidSpace> {
    pub constants: BodyConstants<'a, S>,
    pub time: &'a StageTime,
    /// φⁿ.
    pub base: ParticleView<'a, S>,
    /// State whose rates these are.
    pub stage: ParticleView<'a, S>,
    pub base_rigid: &'a RigidState<S>,
    pub stage_rigid: &'a RigidState<S>,
    /// Whole periods by which particles have been wrapped.
    pub image_counts: &'a [S::Of<i32>],
    /// Force on each particle of whatever origin \[N/m\].
    pub force: &'a [S::Vector],
    pub rates: RateView<'a, S>,
}

/// Input of [`BodyFormulation::kick`].
#[derive(Clone, Copy)]
pub struct BodyKick<'a, S: SolidSpace> {
    pub constants: BodyConstants<'a, S>,
    pub time: &'a StageTime,
    /// Duration of the kick \[s\].
    pub duration: f64,
    /// Time at which the new velocities hold \[s\].
    pub target: f64,
    /// Force on each particle of whatever origin \[N/m\].
    pub force: &'a [S::Vector],
    /// Motion at the start of the step.
    pub base_rigid: &'a RigidState<S>,
    pub image_counts: &'a [S::Of<i32>],
}

/// Input of [`BodyFormulation::drift`].
#[derive(Clone, Copy)]
pub struct BodyDrift<'a, S: SolidSpace> {
    pub constants: BodyConstants<'a, S>,
    pub time: &'a StageTime,
    /// Duration of the drift \[s\].
    pub duration: f64,
    /// Time at which the new positions hold \[s\].
    pub target: f64,
    /// Own-body and foreign sums in the middle of the drift; empty where [`BodyFormulation::evolves`] is false.
    pub sums: &'a [PairSums<S>],
    /// Motion at the start of the step.
    pub base_rigid: &'a RigidState<S>,
    pub image_counts: &'a [S::Of<i32>],
}

/// How the strain of a body comes about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StrainRule {
    /// It follows from the positions, and the forces are the derivatives of its energy; or there is none.
    OfPositions,
    /// Density and stress evolve with the velocity gradient.
    Evolves,
}

/// Change of a body's angular momentum by other causes than its forces, about the domain's torque origin
/// \[kg m/s\], and the work of the supports of a rigid body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AngularImpulse<S: SolidSpace> {
    /// Supports.
    pub supports: S::Spin,
    /// The time scheme, [`sph::coupling::ledger::scheme_moment`].
    pub scheme: S::Spin,
    /// Work of the supports of a rigid body \[J/m\].
    pub work: f64,
}

impl<S: SolidSpace> AddAssign for AngularImpulse<S> {
    fn add_assign(&mut self, other: Self) {
        self.supports += other.supports;
        self.scheme += other.scheme;
        self.work += other.work;
    }
}

/// Moment of inertia of a rigid body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidInertia<S: SolidSpace> {
    /// Moment of inertia about the centre of mass per depth \[kg m\].
    pub total: S::Inertia,
    /// The part of the cells about their own centres \[kg m\].
    pub cells: S::Inertia,
}

/// Bounds outside which a body's state has no meaning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StateLimits {
    /// Smallest and largest ρ/ρ₀ \[-\].
    pub density_ratios: (f64, f64),
    /// Largest equivalent elastic shear strain √(s:s)/(2G) \[-\].
    pub largest_shear: f64,
}

sph::constants! {
    const LINEAR_DENSITY: f64 = 2.0, "solid.updated_lagrangian.largest_density",
        "largest density of a valid state over that at rest, and largest ratio of the two in tension [-]";
    const LINEAR_SHEAR: f64 = 1.0, "solid.updated_lagrangian.largest_shear",
        "largest equivalent elastic shear strain sqrt(s:s)/(2G) of a valid state [-]";
    const HYPERELASTIC_DENSITY: f64 = 10.0, "solid.total_lagrangian.largest_density",
        "largest density of a valid state over that at rest, and largest ratio of the two in tension [-]";
}

impl StateLimits {
    /// Of Eq. (5)-(8), which are linear in density and strain.
    pub const LINEAR: Self =
        Self { density_ratios: (1.0 / LINEAR_DENSITY, LINEAR_DENSITY), largest_shear: LINEAR_SHEAR };

    /// Of hyperelastic laws.
    pub const HYPERELASTIC: Self = Self {
        density_ratios: (1.0 / HYPERELASTIC_DENSITY, HYPERELASTIC_DENSITY),
        largest_shear: f64::INFINITY,
    };
}

/// Formulation of one body: from its state to stress, internal forces and rates.
///
/// Slices hold the particles of the body alone. A formulation is constant: variables are in the state, buffers
/// in the workspace. Forces between owners, contact, walls and supports are added by the solver.
pub trait BodyFormulation<S: SolidSpace>: Send + Sync {
    /// Pressure and stress of a state.
    fn update_stress(
        &self,
        constants: &BodyConstants<'_, S>,
        state: &ParticleView<'_, S>,
        stress: StressViewMut<'_, S>,
    );

    /// Overwrites the variables that follow from the stress just updated; none where density and stress are advanced.
    fn derive(&self, _stress: &StressView<'_, S>, _derived: ParticleViewMut<'_, S>) {}

    /// Radius \[m\] of the own-body neighbour lists in the current configuration; `None` when it needs none.
    fn list_radius(&self) -> Option<f64> {
        None
    }

    /// Contribution of a load of `moment` f ⊗ X \[N\] about particle `i` to its pair tensor \[-\].
    fn load_pair_tensor(&self, _i: usize, _moment: &S::Tensor) -> S::Matrix<f64> {
        S::zero_matrix()
    }

    /// Sums over own-body pairs.
    fn evaluate(
        &self,
        constants: &BodyConstants<'_, S>,
        stage: &ParticleView<'_, S>,
        stress: &StressView<'_, S>,
        neighbours: &Rows,
        sums: &mut [PairSums<S>],
    );

    /// Rates of own variables, once the sums hold all pairs that belong in them; zero where they are not advanced.
    fn complete(&self, _stage: &ParticleView<'_, S>, _sums: &[PairSums<S>], rates: RateViewMut<'_, S>) {
        rates.density.fill(0.0);
        rates.deviatoric_stress.fill(S::SymmetricTensor::default());
    }

    /// Moves the body from φⁿ by the stage's duration, Eq. (30) or (31).
    ///
    /// Returns the change of the angular momentum of a rigid body by supports and scheme.
    fn advance(
        &self,
        step: &BodyStep<'_, S>,
        next: ParticleViewMut<'_, S>,
        next_rigid: &mut RigidState<S>,
    ) -> AngularImpulse<S>;

    /// Velocities follow the forces: v ← v + f Δt/m, particle by particle unless the body is rigid; [`AngularImpulse`] as in
    /// [`BodyFormulation::advance`].
    fn kick(
        &self,
        kick: &BodyKick<'_, S>,
        particles: ParticleViewMut<'_, S>,
        _motion: &mut RigidState<S>,
    ) -> AngularImpulse<S> {
        for (i, v) in particles.velocity.iter_mut().enumerate() {
            *v += kick.force[i] * (kick.duration / kick.constants.mass[i]);
        }
        AngularImpulse::default()
    }

    /// Positions follow the velocities: x ← x + v Δt, and density and stress their gradient; [`AngularImpulse`] as in
    /// [`BodyFormulation::advance`].
    fn drift(
        &self,
        drift: &BodyDrift<'_, S>,
        particles: ParticleViewMut<'_, S>,
        _motion: &mut RigidState<S>,
    ) -> AngularImpulse<S> {
        for (x, v) in particles.position.iter_mut().zip(particles.velocity.iter()) {
            *x += *v * drift.duration;
        }
        AngularImpulse::default()
    }

    /// Whether density and stress evolve with the velocity gradient, so that a drift needs sums in its middle.
    fn evolves(&self) -> bool {
        false
    }

    /// How its strain comes about.
    fn strain_rule(&self) -> StrainRule {
        if self.evolves() { StrainRule::Evolves } else { StrainRule::OfPositions }
    }

    /// Whether the body is rigid: supports then act on the whole body, not on single particles.
    fn is_rigid(&self) -> bool {
        self.inertia().is_some()
    }

    /// Moment of inertia of a body that is rigid.
    fn inertia(&self) -> Option<RigidInertia<S>> {
        None
    }

    /// Bound of the squared frequency of a rigid body on its contacts in `forces`, those of its particles \[1/s²\].
    fn contact_rate(&self, _forces: &[ParticleForces<S>]) -> Option<f64> {
        None
    }

    /// Law by which its particles take part in sums with those of other bodies, walls or the fluid.
    fn sum_law(&self) -> Option<&SumLaw<S>> {
        None
    }

    /// Tangent stiffness at particle `i` over that of the undeformed body \[-\].
    fn tangent_stiffness_ratio(&self, _stress: &StressView<'_, S>, _i: usize) -> f64 {
        1.0
    }

    /// Bounds of a meaningful state.
    fn limits(&self) -> StateLimits {
        StateLimits::LINEAR
    }

    /// Strain energy per metre of depth of particle `i` \[J/m\].
    fn strain_energy(&self, constants: &BodyConstants<'_, S>, state: &ParticleView<'_, S>, i: usize) -> f64;
}
