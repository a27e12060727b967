//! What a body does by itself, whichever way it is discretised.

use sph::domain::Domain;
use sph::stage::StageTime;
use sph::vector::{SymmetricTensor, Vector};

use super::lists::Rows;
use super::pair_law::{PairSums, SumLaw};
use super::particles::{ParticleView, ParticleViewMut, RigidState};
use super::supports::Support;

/// Constants of a body's particles.
#[derive(Clone, Copy)]
pub(super) struct BodyConstants<'a> {
    pub domain: &'a Domain,
    /// Mass per depth \[kg/m\].
    pub mass: &'a [f64],
    /// Supports of the body.
    pub supports: &'a [Support],
}

/// Stress of a body's particles at one stage.
#[derive(Clone, Copy)]
pub(super) struct StressView<'a> {
    /// Cauchy stress \[Pa\].
    pub cauchy: &'a [SymmetricTensor],
    /// Artificial stress R_i of Eq. (25) \[m⁵/(kg s²)\].
    pub artificial: &'a [SymmetricTensor],
}

/// As [`StressView`], to be written.
pub(super) struct StressViewMut<'a> {
    /// Pressure \[Pa\].
    pub pressure: &'a mut [f64],
    pub cauchy: &'a mut [SymmetricTensor],
    pub artificial: &'a mut [SymmetricTensor],
}

/// Rates of a body's own variables.
#[derive(Clone, Copy)]
pub(super) struct RateView<'a> {
    /// dρ/dt \[kg/(m³ s)\].
    pub density: &'a [f64],
    /// ds/dt \[Pa/s\].
    pub deviatoric_stress: &'a [SymmetricTensor],
}

/// As [`RateView`], to be written.
pub(super) struct RateViewMut<'a> {
    pub density: &'a mut [f64],
    pub deviatoric_stress: &'a mut [SymmetricTensor],
}

/// What moves a body from the start of the step by one stage.
#[derive(Clone, Copy)]
pub(super) struct BodyStep<'a> {
    pub constants: BodyConstants<'a>,
    pub time: &'a StageTime,
    /// φⁿ.
    pub base: ParticleView<'a>,
    /// State whose rates these are.
    pub stage: ParticleView<'a>,
    pub base_rigid: &'a RigidState,
    pub stage_rigid: &'a RigidState,
    /// Whole periods by which particles have been wrapped.
    pub windings: &'a [[i32; 2]],
    /// Force on each particle of whatever origin \[N/m\].
    pub force: &'a [Vector],
    pub rates: RateView<'a>,
}

/// How one body turns its state into stress, internal forces and rates.
///
/// Slices hold the particles of the body alone. A formulation is constant: what evolves is in the state, what is
/// disposable in the workspace. Forces between owners, contact, walls and supports are added by the solver.
pub(super) trait BodyFormulation: Send + Sync {
    /// Pressure and stress of a state.
    fn update_stress(&self, state: &ParticleView<'_>, stress: StressViewMut<'_>);

    /// Radius \[m\] of the own-body neighbour lists in the current configuration; `None` when it needs none.
    fn list_radius(&self) -> Option<f64>;

    /// Sums over own-body pairs.
    fn evaluate(
        &self,
        constants: &BodyConstants<'_>,
        stage: &ParticleView<'_>,
        stress: &StressView<'_>,
        neighbours: &Rows,
        sums: &mut [PairSums],
    );

    /// Rates of own variables, once the sums hold all pairs that belong in them.
    fn complete(&self, stage: &ParticleView<'_>, sums: &[PairSums], rates: RateViewMut<'_>);

    /// Moves the body from φⁿ by the stage's duration, Eq. (30) or (31).
    fn advance(&self, step: &BodyStep<'_>, next: ParticleViewMut<'_>, next_rigid: &mut RigidState);

    /// Whether internal constraints of the body, not its particles one by one, carry what supports hold.
    fn is_rigid(&self) -> bool;

    /// Law by which its particles take part in sums with those of other bodies, walls or the fluid.
    fn sum_law(&self) -> Option<&SumLaw>;

    /// Largest stable step by the waves inside the body \[s\].
    fn time_step_limit(&self) -> f64;

    /// Strain energy per metre of depth of particle `i` of mass `mass` \[kg/m\] \[J/m\].
    fn strain_energy(&self, state: &ParticleView<'_>, mass: f64, i: usize) -> f64;
}
