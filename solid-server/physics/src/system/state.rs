//! State at a step boundary: all that a checkpoint holds.

use sph::coupling::ledger::EnergyTally;
use sph::sums::ordered_sum;

use crate::contact::friction::TangentialSprings;
use crate::particles::forces::ParticleForces;
use crate::particles::variables::{Particles, RigidState};
use crate::space::SolidSpace;

/// All that evolves, at a step boundary.
#[derive(Clone, Debug, PartialEq)]
pub struct SolidState<S: SolidSpace> {
    /// φⁿ.
    pub particles: Particles<S>,
    /// Motion of each body that is rigid; the others' entries stay as they are.
    pub rigid: Vec<RigidState<S>>,
    /// Whole periods by which each particle has been wrapped, by axis.
    pub image_counts: Vec<S::Of<i32>>,
    /// Best-fit rotation of each body from its reference, in the plane an angle continuous over turns \[rad\].
    pub rotations: Vec<S::Rotation>,
    /// Elastic springs of the contacts under friction.
    pub springs: TangentialSprings<S>,
    /// Energy at the start, and works and losses since.
    pub energy: EnergyTally,
    /// Results of the last corrector.
    pub last: LastStage<S>,
}

/// Contact of one body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyContact<S: SolidSpace> {
    /// Force of other bodies in the last stage \[N/m\].
    pub bodies: S::Vector,
    /// Force of walls in the last stage \[N/m\].
    pub walls: S::Vector,
    /// Deepest that its particles have been in others, or theirs in it, so far \[m\].
    pub deepest: f64,
    /// Sum over particles and time of the magnitudes of contact forces so far \[N s/m\].
    pub impulse: f64,
}

impl<S: SolidSpace> BodyContact<S> {
    /// Contact of all bodies together.
    pub fn all(contacts: &[Self]) -> Self {
        contacts.iter().fold(Self::default(), |sum, contact| Self {
            bodies: sum.bodies + contact.bodies,
            walls: sum.walls + contact.walls,
            deepest: sum.deepest.max(contact.deepest),
            impulse: sum.impulse + contact.impulse,
        })
    }

    /// Adds the forces on the body's particles in a stage of `duration` \[s\].
    pub fn follow(&mut self, forces: &[ParticleForces<S>], duration: f64) {
        let n = forces.len();
        self.bodies = ordered_sum(n, |i| forces[i].contact - forces[i].film[0]);
        self.walls = ordered_sum(n, |i| forces[i].walls - forces[i].film[1]);
        self.impulse += duration * ordered_sum::<f64, _>(n, |i| forces[i].contact_gross);
        self.deepest = forces.iter().map(|forces| forces.contact_depth).fold(self.deepest, f64::max);
    }
}

/// Maxima over the particles in a stage, which limit the next step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StageMaxima {
    /// Largest acceleration of a particle \[m/s²\].
    pub largest_acceleration: f64,
    /// Largest frequency of a particle on its contacts \[rad/s\].
    pub contact_frequency: f64,
    /// Largest ratio of a particle's tangent stiffness to that at rest \[-\].
    pub tangent_stiffness_ratio: f64,
}

/// Results of the last accepted stage, for reports and for the limit of the next step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LastStage<S: SolidSpace> {
    /// Force of the fluid on each body, that of the water in gaps included \[N/m\].
    pub fluid_force: Vec<S::Vector>,
    /// Reaction of each support on its body, by body \[N/m\].
    pub reactions: Vec<Vec<S::Vector>>,
    /// Contact of each body.
    pub contacts: Vec<BodyContact<S>>,
    pub maxima: StageMaxima,
    /// Particles outside the domain.
    pub outside: u64,
    /// Sub-steps so far, see [`sph::coupling::solver::Counts`].
    pub substeps: u64,
}
