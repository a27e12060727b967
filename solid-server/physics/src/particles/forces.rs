//! Forces on the particles by origin, and their torques.

use std::ops::AddAssign;

use crate::space::SolidSpace;

/// Contact forces on one particle in a stage.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactForces<S: SolidSpace> {
    /// Force from other bodies, or from distant parts of its own \[N/m\].
    pub bodies: S::Vector,
    /// Force from walls \[N/m\].
    pub walls: S::Vector,
    /// Bound of the stiffness of all its contacts \[Pa\].
    pub stiffness: f64,
    /// Largest penetration depth of the particle, or of another particle near it \[m\].
    pub depth: f64,
    /// The part of both forces by friction \[N/m\].
    pub friction: S::Vector,
    /// Power of the forces from walls by the motion of these, Σ f·v_w, and the part of it by friction \[W/m\].
    pub wall_power: f64,
    /// See there.
    pub wall_friction_power: f64,
}

/// Parts of the forces on one particle that the energy budget tells apart.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ForceParts<S: SolidSpace> {
    /// Whether there are body forces other than gravity, loads, damping or artificial stress.
    pub varies: bool,
    /// Prescribed loads, in the body force \[N/m\].
    pub load: S::Vector,
    /// Artificial viscosity, in the force of its own body \[N/m\].
    pub viscous: S::Vector,
    /// Artificial stress, likewise.
    pub artificial: S::Vector,
    /// Friction, in both contact forces \[N/m\].
    pub friction: S::Vector,
    /// As in [`ContactForces`] \[W/m\].
    pub wall_power: f64,
    /// As in [`ContactForces`] \[W/m\].
    pub wall_friction_power: f64,
}

/// Forces on one particle by origin \[N/m\], that of the fluid apart.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ParticleForces<S: SolidSpace> {
    /// Gravity and other body forces.
    pub body_force: S::Vector,
    /// Linear damping.
    pub damping: S::Vector,
    /// Contact with walls.
    pub walls: S::Vector,
    /// Particles of its own body.
    pub own: S::Vector,
    /// Sum of all, those of particles of its own and other bodies included.
    pub total: S::Vector,
    /// Sum of the magnitudes.
    pub gross: f64,
    /// Contact with other bodies, or with distant parts of its own.
    pub contact: S::Vector,
    /// Water in gaps toward bodies and toward walls, in the two forces of contact.
    pub film: [S::Vector; 2],
    /// Power of the water in gaps by the motion of walls, Σ f·v_w \[W/m\]; not in means.
    pub film_wall_power: f64,
    /// Sum of the magnitudes of both contact forces.
    pub contact_gross: f64,
    /// Sum of the stiffness of all contacts \[Pa\].
    pub contact_stiffness: f64,
    /// Largest depth in contact \[m\].
    pub contact_depth: f64,
    /// Parts of the forces; not in means.
    pub parts: ForceParts<S>,
}

impl<S: SolidSpace> ParticleForces<S> {
    /// Adds `weight` times `other`; of stiffness and depth the larger stays.
    pub fn add(&mut self, weight: f64, other: &Self) {
        self.body_force += other.body_force * weight;
        self.damping += other.damping * weight;
        self.walls += other.walls * weight;
        self.own += other.own * weight;
        self.total += other.total * weight;
        self.gross += other.gross * weight;
        self.contact += other.contact * weight;
        for (film, other) in self.film.iter_mut().zip(other.film) {
            *film += other * weight;
        }
        self.contact_gross += other.contact_gross * weight;
        self.contact_stiffness = self.contact_stiffness.max(other.contact_stiffness);
        self.contact_depth = self.contact_depth.max(other.contact_depth);
    }
}

/// Torques of [`ParticleForces`] about the domain's torque origin \[N\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ParticleTorques<S: SolidSpace> {
    /// Of gravity and other body forces.
    pub body_force: S::Spin,
    /// Of linear damping.
    pub damping: S::Spin,
    /// Of contact with walls.
    pub walls: S::Spin,
    /// Of contact with other bodies, or with distant parts of its own.
    pub contact: S::Spin,
    /// Of particles of its own body.
    pub own: S::Spin,
    /// Of the fluid, whose force acts at the moving particle: the torque in excess of that at the position of the exchange.
    pub displaced: S::Spin,
}

impl<S: SolidSpace> AddAssign for ParticleTorques<S> {
    fn add_assign(&mut self, other: Self) {
        self.body_force += other.body_force;
        self.damping += other.damping;
        self.walls += other.walls;
        self.contact += other.contact;
        self.own += other.own;
        self.displaced += other.displaced;
    }
}

impl<S: SolidSpace> ParticleTorques<S> {
    /// Adds `weight` times the torques of `forces` at `arm` \[m\] from the torque origin.
    pub fn add(&mut self, weight: f64, arm: &S::Vector, forces: &ParticleForces<S>) {
        self.body_force += S::cross(arm, &forces.body_force) * weight;
        self.damping += S::cross(arm, &forces.damping) * weight;
        self.walls += S::cross(arm, &forces.walls) * weight;
        self.contact += S::cross(arm, &forces.contact) * weight;
        self.own += S::cross(arm, &forces.own) * weight;
    }
}
