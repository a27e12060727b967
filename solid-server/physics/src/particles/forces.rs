//! Forces on the particles by origin, and their torques.

use std::ops::AddAssign;

use sph::space::{Vector, cross};

/// Contact forces on one particle in a stage.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactForces {
    /// Force from other bodies, or from distant parts of its own \[N/m\].
    pub bodies: Vector,
    /// Force from walls \[N/m\].
    pub walls: Vector,
    /// Bound of the stiffness of all its contacts \[Pa\].
    pub stiffness: f64,
    /// Largest penetration depth of the particle, or of another particle near it \[m\].
    pub depth: f64,
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
    /// Of the fluid, whose force acts at the moving particle: the torque in excess of that at the position of the exchange.
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
