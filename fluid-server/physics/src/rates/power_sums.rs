//! Sums of the powers of the forces on the fluid, four particles at a time.

use sph::lanes::{Lanes, WIDTH};
use sph::space::Space;

use super::energy::ForcePowers;
use crate::equations::pair::PairParts;
use crate::equations::terms::PairTerms;
use crate::system::packed_particle::FluidSpace;

/// Particles whose forces are kept until their powers are summed: few enough to stay in the cache. The sums then have a
/// loop of their own, since in that over pairs there is no register left for them.
pub const BLOCK: usize = 16 * WIDTH;

/// What acts on a particle.
#[derive(Clone, Copy, Debug, Default)]
pub struct ActingForces<S: Space> {
    /// Acceleration, without that by solids \[m/s²\].
    pub acceleration: S::Vector,
    /// The part by fluid and walls \[m/s²\].
    pub forces: S::Vector,
    /// Parts of it, as stress divergences \[Pa/m\].
    pub parts: PairParts<S>,
    /// The part by the repulsion of wall faces \[m/s²\].
    pub repulsion: S::Vector,
    /// The part by body forces \[m/s²\].
    pub body: S::Vector,
    /// The part by the particle regularisation \[m/s²\].
    pub regularisation: S::Vector,
    /// The part of that by the shift \[m/s²\].
    pub advection: S::Vector,
    /// Velocity of the shift \[m/s\].
    pub shift: S::Vector,
}

/// The powers that a pass has; the others are zero and cost nothing.
#[derive(Clone, Copy, Debug)]
pub struct ActivePowers {
    /// Artificial pressure.
    pub clumping: bool,
    /// Repulsion by wall faces.
    pub repulsion: bool,
    /// Body forces other than gravity with a potential.
    pub body_force: bool,
    /// Linear damping.
    pub damping: bool,
    /// Shifting and tensile control.
    pub regularisation: bool,
    /// Positions do not move with the mean velocity.
    pub scheme: bool,
}

/// The motion of four particles; those beyond the last have no mass.
#[derive(Clone, Copy, Debug)]
pub struct MovingParticles<S: Space, L: Lanes> {
    /// Mass per depth \[kg/m\].
    pub mass: L,
    /// Density \[kg/m³\].
    pub density: L,
    /// v̄ \[m/s\].
    pub mean_velocity: S::Of<L>,
    /// Velocity of the stage; zero where neither damping nor scheme reads it \[m/s\].
    pub velocity: S::Of<L>,
}

/// Powers on the fluid \[W/m\] in lanes. No product is fused with a sum.
#[derive(Clone, Copy, Debug)]
pub struct PowerSums<L: Lanes> {
    forces: L,
    artificial: L,
    drag: L,
    clumping: L,
    repulsion: L,
    body: L,
    damping: L,
    regularisation: L,
    advection: L,
    shifted: L,
    scheme: L,
}

impl<L: Lanes> PowerSums<L> {
    /// Of no force.
    #[inline(always)]
    pub fn none() -> Self {
        let zero = L::zero();
        Self {
            forces: zero,
            artificial: zero,
            drag: zero,
            clumping: zero,
            repulsion: zero,
            body: zero,
            damping: zero,
            regularisation: zero,
            advection: zero,
            shifted: zero,
            scheme: zero,
        }
    }

    /// Adds those on four particles, with `damping` the rate of the linear damping \[1/s\] and `falling` the part of
    /// gravity that has a potential \[m/s²\].
    #[inline(always)]
    pub fn add<S: FluidSpace, T: PairTerms>(
        &mut self,
        [a, b, c, d]: &[ActingForces<S>; WIDTH],
        particles: &MovingParticles<S, L>,
        (damping, falling): (f64, &S::Vector),
        active: &ActivePowers,
    ) {
        let MovingParticles { mass, density, mean_velocity, velocity } = *particles;
        let falling = S::splat_vector(falling);
        let momentum = S::scaled(mean_velocity, mass);
        // −1/ρ makes an acceleration of a stress divergence.
        let flow = S::scaled(mean_velocity, mass / density);
        let product = |vectors, b| S::rounded_dot(S::lanes::<L>(vectors), b);
        self.forces = self.forces + product([&a.forces, &b.forces, &c.forces, &d.forces], momentum);
        let [p, q, r, s] = [&a.parts, &b.parts, &c.parts, &d.parts];
        let artificial = [&p.artificial, &q.artificial, &r.artificial, &s.artificial];
        self.artificial = self.artificial - product(artificial, flow);
        if T::VISCOUS {
            self.drag = self.drag - product([&p.drag, &q.drag, &r.drag, &s.drag], flow);
        }
        if active.clumping {
            let clumping = [&p.clumping, &q.clumping, &r.clumping, &s.clumping];
            self.clumping = self.clumping - product(clumping, flow);
        }
        if active.repulsion {
            let repulsion = [&a.repulsion, &b.repulsion, &c.repulsion, &d.repulsion];
            self.repulsion = self.repulsion + product(repulsion, momentum);
        }
        if active.body_force {
            let excess = S::minus(S::lanes([&a.body, &b.body, &c.body, &d.body]), falling);
            self.body = self.body + S::rounded_dot(excess, momentum);
        }
        if active.damping {
            self.damping = self.damping - L::splat(damping) * S::rounded_dot(velocity, momentum);
        }
        if active.regularisation {
            let regularisation = [&a.regularisation, &b.regularisation, &c.regularisation, &d.regularisation];
            self.regularisation = self.regularisation + product(regularisation, momentum);
            let advection = [&a.advection, &b.advection, &c.advection, &d.advection];
            self.advection = self.advection + product(advection, momentum);
            let shift = S::lanes([&a.shift, &b.shift, &c.shift, &d.shift]);
            self.shifted = self.shifted + mass * S::rounded_dot(falling, shift);
        }
        if active.scheme {
            let beyond = S::minus(mean_velocity, velocity);
            self.scheme = self.scheme + mass * S::rounded_dot(falling, beyond);
        }
    }

    /// Over all lanes.
    pub fn total(&self) -> ForcePowers {
        let [forces, artificial_viscosity, drag, clumping] =
            L::sums([self.forces, self.artificial, self.drag, self.clumping]);
        let [repulsion, body_force, damping, regularisation] =
            L::sums([self.repulsion, self.body, self.damping, self.regularisation]);
        let [advection, shifted, scheme, _] = L::sums([self.advection, self.shifted, self.scheme, L::zero()]);
        ForcePowers {
            pressure: forces - repulsion - artificial_viscosity - drag - clumping,
            artificial_viscosity,
            drag,
            clumping,
            repulsion,
            body_force,
            damping,
            tension: regularisation - advection,
            advection,
            shifted,
            scheme,
            ..ForcePowers::default()
        }
    }
}
