//! Constant facts of a run of solids.

use sph::coupling::ledger::EnergyAccount;
use sph::coupling::stage::StageTime;
use sph::prescribed::body_force::BodyForceField;
use sph::setup::{Damping, SolidProbeKind, SolidStepping};
use sph::space::domain::Domain;
use sph::space::tensors::SpaceVector;

use crate::boundary::supports::{Support, acts};
use crate::boundary::walls::Walls;
use crate::contact::repulsion::Repulsion;
use crate::contact::sums::SumContact;
use crate::formulations::body::Body;
use crate::formulations::formulation::BodyConstants;
use crate::neighbours::lists::PairRadii;
use crate::neighbours::material_point::MaterialPoint;
use crate::particles::constants::ParticleConstants;
use crate::space::SolidSpace;

/// Constant facts of a run.
pub struct SolidModel<S: SolidSpace> {
    pub domain: Domain<S>,
    /// Spacing of the particles Δx \[m\].
    pub spacing: f64,
    pub bodies: Vec<Body<S>>,
    pub particles: ParticleConstants<S>,
    pub contact: ContactModel,
    pub walls: Walls<S>,
    pub body_force: BodyForceField<S>,
    pub damping: Option<Damping>,
    pub stepping: SolidStepping,
    pub probes: Vec<Probe<S>>,
    /// The run stops when more particles than this are outside the domain.
    pub lost_particle_limit: u64,
    /// Accounts of the energy budget that the case can have.
    pub energy_accounts: Vec<EnergyAccount>,
}

/// Law of contact between bodies and with walls.
pub enum ContactModel {
    /// Repulsion by penetration depth.
    Repulsion(Box<Repulsion>),
    /// The sums of the source paper.
    Sums(SumContact),
}

/// A probe: its kind in the set-up, with precomputed weights.
pub enum Probe<S: SolidSpace> {
    /// A material point.
    MaterialPoint(MaterialPoint),
    /// Any other kind, which needs no preparation.
    Plain(SolidProbeKind<S>),
}

impl ContactModel {
    /// Distances within which particles of different owners interact.
    pub fn radii(&self) -> PairRadii {
        match self {
            Self::Repulsion(law) => law.fields.radii(),
            Self::Sums(sums) => PairRadii::both(sums.support_radius),
        }
    }

    /// Undeformed distance \[m\] from which parts of one body can be in contact.
    pub fn self_contact_distance(&self) -> Option<f64> {
        match self {
            Self::Repulsion(law) => law.self_contact_distance,
            Self::Sums(_) => None,
        }
    }

    /// Distance from held particles within which walls are left out of the contact \[m\].
    pub fn clearance<S: SolidSpace>(&self) -> f64 {
        match self {
            Self::Repulsion(law) => S::CLAMP_CLEARANCE * law.fields.walls.distance,
            Self::Sums(sums) => sums.support_radius,
        }
    }
}

impl<S: SolidSpace> SolidModel<S> {
    /// Point about which torques are taken \[m\]; `None` in a periodic domain, where they have no meaning.
    pub fn torque_origin(&self) -> Option<S::Vector> {
        (!self.domain.is_periodic()).then(|| self.domain.torque_origin())
    }

    /// Number of particles.
    pub fn len(&self) -> usize {
        self.particles.len()
    }

    /// Constants of `body` as its formulation needs them.
    pub fn constants<'a>(&'a self, body: &'a Body<S>) -> BodyConstants<'a, S> {
        BodyConstants {
            domain: &self.domain,
            mass: &self.particles.mass[body.range.clone()],
            supports: &body.supports,
        }
    }

    /// The body of particle `i`.
    pub fn body_of(&self, i: usize) -> &Body<S> {
        &self.bodies[self.particles.body[i] as usize]
    }

    /// Whether particles `i` and `j` may be in contact: they belong to different bodies or, with self-contact, are far apart
    /// when undeformed.
    pub fn may_be_in_contact(&self, i: usize, j: usize) -> bool {
        if self.particles.body[i] != self.particles.body[j] {
            return true;
        }
        let reference = &self.particles.reference_position;
        self.contact.self_contact_distance().is_some_and(|distance| {
            self.body_of(i).self_contact
                && self.domain.separation(&reference[i], &reference[j]).norm() > distance
        })
    }

    /// Whether any two particles may be in contact.
    pub fn has_contact(&self) -> bool {
        self.bodies.len() > 1
            || self.contact.self_contact_distance().is_some()
                && self.bodies.iter().any(|body| body.self_contact)
    }

    /// The support that holds particle `i` in the step of `time`.
    pub fn acting_support(&self, i: usize, time: &StageTime) -> Option<&Support<S>> {
        let k = self.particles.support[i];
        (k > 0).then(|| &self.body_of(i).supports[k as usize - 1]).filter(|support| support.acts(time))
    }

    /// Whether contact of particle `i` with wall particle `w` counts in the step of `time`: not while all components of
    /// the particle are held.
    ///
    /// A clamp continues its body into the wall, so the wall beside the clamp is in contact with it from the start. Wall
    /// particles within [`ContactModel::clearance`] of a fully held particle at the start do not act on the body while
    /// that support does.
    pub fn wall_acts_on(&self, i: usize, w: usize, time: &StageTime) -> bool {
        let held = self.acting_support(i, time).is_some_and(Support::holds_fully);
        let exempt = self.body_of(i).wall_exemption.get(w).is_some_and(|until| acts(*until, time));
        !held && !exempt && self.walls.acts(w, time)
    }

    /// Number of supports and walls released before the step of `time`; [`Self::wall_acts_on`] changes with it.
    pub fn released(&self, time: &StageTime) -> usize {
        let supports = self.bodies.iter().flat_map(|body| &body.supports);
        supports.filter(|support| !acts(support.release_time, time)).count() + self.walls.released(time)
    }

    /// Rate of linear damping in the step of `time` \[1/s\].
    pub fn damping_rate(&self, time: &StageTime) -> f64 {
        self.damping.filter(|damping| acts(damping.until, time)).map_or(0.0, |damping| damping.rate)
    }
}
