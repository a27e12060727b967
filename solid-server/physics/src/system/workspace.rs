//! What a checkpoint holds, and what can be thrown away.

use std::ops::{AddAssign, Range};

use sph::ledger::InterfaceSums;
use sph::sums::ordered_sum;
use sph::vector::{SymmetricTensor, Tensor, Vector, cross};

use crate::boundary::walls::WallState;
use crate::contact::friction::Slips;
use crate::contact::repulsion::{ContactSums, Touch};
use crate::formulations::formulation::{AngularImpulse, RateView, RateViewMut, StressView, StressViewMut};
use crate::formulations::pair_law::PairSums;
use crate::interface::fluid_link::FluidLink;
use crate::neighbours::lists::{ContactLists, OwnLists};
use crate::particles::variables::{Particles, RigidState};

/// All that evolves, at a step boundary.
#[derive(Clone, Debug, PartialEq)]
pub struct SolidState {
    /// φⁿ.
    pub particles: Particles,
    /// Motion of each body that is rigid; the others' entries stay as they are.
    pub rigid: Vec<RigidState>,
    /// Whole periods by which each particle has been wrapped, by axis.
    pub windings: Vec<[i32; 2]>,
    /// Best-fit angle of each body relative to its reference, continuous over turns \[rad\].
    pub angles: Vec<f64>,
    /// Elastic slips of the contacts under friction.
    pub slips: Slips,
    /// What the last corrector left to report.
    pub last: LastStage,
}

/// Contact of one body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyContact {
    /// Force of other bodies in the last stage \[N/m\].
    pub bodies: Vector,
    /// Force of walls in the last stage \[N/m\].
    pub walls: Vector,
    /// Deepest that its particles have been in others, or theirs in it, so far \[m\].
    pub deepest: f64,
    /// Sum over particles and time of the magnitudes of contact forces so far \[N s/m\].
    pub impulse: f64,
}

impl BodyContact {
    /// Contact of all bodies together.
    pub fn all(contacts: &[Self]) -> Self {
        contacts.iter().fold(Self::default(), |sum, contact| Self {
            bodies: sum.bodies + contact.bodies,
            walls: sum.walls + contact.walls,
            deepest: sum.deepest.max(contact.deepest),
            impulse: sum.impulse + contact.impulse,
        })
    }

    /// Takes in the forces on the body's particles in a stage of `duration` \[s\].
    pub fn follow(&mut self, forces: &[ParticleForces], duration: f64) {
        let n = forces.len();
        self.bodies = ordered_sum(n, |i| forces[i].contact);
        self.walls = ordered_sum(n, |i| forces[i].walls);
        self.impulse += duration * ordered_sum::<f64, _>(n, |i| forces[i].contact_gross);
        self.deepest = forces.iter().map(|forces| forces.contact_depth).fold(self.deepest, f64::max);
    }
}

/// What the last accepted stage left to report and to judge the next step by.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LastStage {
    /// Force of the fluid on each body \[N/m\].
    pub fluid_force: Vec<Vector>,
    /// Reaction of each support on its body, by body \[N/m\].
    pub reactions: Vec<Vec<Vector>>,
    /// Contact of each body.
    pub contacts: Vec<BodyContact>,
    /// Largest acceleration of a particle \[m/s²\].
    pub largest_acceleration: f64,
    /// Largest frequency of a particle on its contacts \[rad/s\].
    pub contact_frequency: f64,
    /// Largest ratio of a particle's tangent stiffness to that at rest \[-\].
    pub stiffening: f64,
    /// Particles outside the domain.
    pub outside: u64,
    /// Sub-steps so far, see [`sph::solver::Counts`].
    pub substeps: u64,
}

/// Stress of all particles.
#[derive(Debug, Default)]
pub struct StressFields {
    /// Pressure \[Pa\].
    pub pressure: Vec<f64>,
    /// Cauchy stress \[Pa\].
    pub cauchy: Vec<SymmetricTensor>,
    /// Artificial stress R_i of Eq. (25) \[m⁵/(kg s²)\].
    pub artificial: Vec<SymmetricTensor>,
    /// Deformation gradient \[-\]; of total-Lagrangian bodies.
    pub deformation: Vec<Tensor>,
    /// What pair forces read of each particle \[-\]; likewise.
    pub shown: Vec<Tensor>,
}

/// Rates of all particles' own variables.
#[derive(Debug, Default)]
pub struct Rates {
    /// dρ/dt \[kg/(m³ s)\].
    pub density: Vec<f64>,
    /// ds/dt \[Pa/s\].
    pub deviatoric_stress: Vec<SymmetricTensor>,
}

/// Forces on one particle by origin \[N/m\], that of the fluid apart.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ParticleForces {
    /// Gravity and other body forces.
    pub body_force: Vector,
    /// Linear damping.
    pub damping: Vector,
    /// Contact with walls.
    pub walls: Vector,
    /// Particles of its own body.
    pub own: Vector,
    /// Sum of all, those of particles of its own and other bodies included.
    pub total: Vector,
    /// Sum of the magnitudes.
    pub gross: f64,
    /// Contact with other bodies, or with distant parts of its own.
    pub contact: Vector,
    /// Sum of the magnitudes of both contact forces.
    pub contact_gross: f64,
    /// Sum of the stiffness of all contacts \[Pa\].
    pub contact_stiffness: f64,
    /// Largest depth in contact \[m\].
    pub contact_depth: f64,
}

impl ParticleForces {
    /// Adds `weight` times `other`; of stiffness and depth the larger stays.
    pub fn add(&mut self, weight: f64, other: &Self) {
        self.body_force += other.body_force * weight;
        self.damping += other.damping * weight;
        self.walls += other.walls * weight;
        self.own += other.own * weight;
        self.total += other.total * weight;
        self.gross += other.gross * weight;
        self.contact += other.contact * weight;
        self.contact_gross += other.contact_gross * weight;
        self.contact_stiffness = self.contact_stiffness.max(other.contact_stiffness);
        self.contact_depth = self.contact_depth.max(other.contact_depth);
    }
}

/// Torques of [`ParticleForces`] about the domain's torque origin \[N\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ParticleTorques {
    /// Of gravity and other body forces.
    pub body_force: f64,
    /// Of linear damping.
    pub damping: f64,
    /// Of contact with walls.
    pub walls: f64,
    /// Of contact with other bodies, or with distant parts of its own.
    pub contact: f64,
    /// Of particles of its own body.
    pub own: f64,
    /// Of the fluid, which acts as in the exchange while the particle moves on: beyond that at its place there.
    pub displaced: f64,
}

impl AddAssign for ParticleTorques {
    fn add_assign(&mut self, other: Self) {
        self.body_force += other.body_force;
        self.damping += other.damping;
        self.walls += other.walls;
        self.contact += other.contact;
        self.own += other.own;
        self.displaced += other.displaced;
    }
}

impl ParticleTorques {
    /// Adds `weight` times the torques of `forces` at `arm` \[m\] from the torque origin.
    pub fn add(&mut self, weight: f64, arm: &Vector, forces: &ParticleForces) {
        self.body_force += weight * cross(arm, &forces.body_force);
        self.damping += weight * cross(arm, &forces.damping);
        self.walls += weight * cross(arm, &forces.walls);
        self.contact += weight * cross(arm, &forces.contact);
        self.own += weight * cross(arm, &forces.own);
    }
}

/// Disposable buffers, reused from stage to stage.
#[derive(Debug)]
pub struct Workspace {
    /// State at which the stage evaluates.
    pub stage: Particles,
    pub stage_rigid: Vec<RigidState>,
    /// State that the stage makes.
    pub next: Particles,
    pub next_rigid: Vec<RigidState>,
    pub stress: StressFields,
    /// Own-body sums, then all that belong in the rates.
    pub sums: Vec<PairSums>,
    pub rates: Rates,
    pub contact: Vec<ContactSums>,
    /// Particles in touch at the latest evaluation.
    pub touches: Vec<Touch>,
    /// Slips at the latest evaluation, and those at the start of the step.
    pub slips: Slips,
    pub start_slips: Slips,
    /// Prescribed loads on each particle; empty where no body has any \[N/m\].
    pub loads: Vec<Vector>,
    /// Forces of the latest evaluation.
    pub forces: Vec<ParticleForces>,
    /// Forces at the start of the step, where each pass of sub-steps starts anew.
    pub start_forces: Vec<ParticleForces>,
    /// Forces that moved the stage, means over its sub-steps.
    pub mean_forces: Vec<ParticleForces>,
    /// Torques of these, at the places where they acted.
    pub mean_torques: Vec<ParticleTorques>,
    /// What else the stage did to the angular momentum.
    pub angular_impulse: AngularImpulse,
    /// Where particles were when the forces of the fluid were exchanged; of sub-steps \[m\].
    pub exchange_position: Vec<Vector>,
    /// Force of the fluid on each particle in this stage \[N/m\].
    pub fluid_force: Vec<Vector>,
    /// Sum of all forces on each particle \[N/m\].
    pub total_force: Vec<Vector>,
    /// Velocity gained in the first half of a sub-step \[m/s\].
    pub velocity_gain: Vec<Vector>,
    /// Lists of each body; empty for formulations that need none.
    pub own_lists: Vec<Option<OwnLists>>,
    pub contact_lists: ContactLists,
    pub walls: WallState,
    /// Pressure of wall particles toward solids \[Pa\].
    pub wall_pressure: Vec<f64>,
    /// Reactions of the stage, by body and support \[N/m\].
    pub reactions: Vec<Vec<Vector>>,
    /// Link to the fluid; `None` when the run has one participant.
    pub fluid: Option<FluidLink>,
    /// Sums over pair forces with the fluid in this stage.
    pub interface_sums: InterfaceSums,
    pub list_builds: u64,
    /// Sub-steps of the stage; none under the stage rule.
    pub substeps: u32,
}

impl StressFields {
    /// Fields of `count` particles.
    pub fn new(count: usize) -> Self {
        Self {
            pressure: vec![0.0; count],
            cauchy: vec![SymmetricTensor::default(); count],
            artificial: vec![SymmetricTensor::default(); count],
            deformation: vec![Tensor::identity(); count],
            shown: vec![Tensor::zeros(); count],
        }
    }

    /// The part of one body.
    pub fn view(&self, range: &Range<usize>) -> StressView<'_> {
        StressView {
            pressure: &self.pressure[range.clone()],
            cauchy: &self.cauchy[range.clone()],
            artificial: &self.artificial[range.clone()],
            deformation: &self.deformation[range.clone()],
            shown: &self.shown[range.clone()],
        }
    }

    /// As [`StressFields::view`], to be written.
    pub fn view_mut(&mut self, range: &Range<usize>) -> StressViewMut<'_> {
        StressViewMut {
            pressure: &mut self.pressure[range.clone()],
            cauchy: &mut self.cauchy[range.clone()],
            artificial: &mut self.artificial[range.clone()],
            deformation: &mut self.deformation[range.clone()],
            shown: &mut self.shown[range.clone()],
        }
    }

    /// Deviator of the stress of particle `i` \[Pa\].
    pub fn deviator(&self, i: usize) -> SymmetricTensor {
        self.cauchy[i].plus(&SymmetricTensor::isotropic(self.pressure[i]))
    }
}

impl Rates {
    /// Rates of `count` particles.
    pub fn new(count: usize) -> Self {
        Self { density: vec![0.0; count], deviatoric_stress: vec![SymmetricTensor::default(); count] }
    }

    /// The part of one body.
    pub fn view(&self, range: &Range<usize>) -> RateView<'_> {
        RateView {
            density: &self.density[range.clone()],
            deviatoric_stress: &self.deviatoric_stress[range.clone()],
        }
    }

    /// As [`Rates::view`], to be written.
    pub fn view_mut(&mut self, range: &Range<usize>) -> RateViewMut<'_> {
        RateViewMut {
            density: &mut self.density[range.clone()],
            deviatoric_stress: &mut self.deviatoric_stress[range.clone()],
        }
    }
}
