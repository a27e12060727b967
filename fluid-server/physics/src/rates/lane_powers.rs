//! Powers of the forces on the fluid, four particles at a time.

use sph::lanes::{Lanes, WIDTH};
use sph::space::Space;

use super::energy::ForcePowers;
use crate::system::packed_particle::FluidSpace;

/// What acts on each of four particles. Entries of the last four that no particle has written have no weight.
#[derive(Clone, Copy, Debug)]
pub struct ForceBatch<S: FluidSpace> {
    /// Acceleration by fluid and walls \[m/s²\].
    pub forces: [S::Vector; WIDTH],
    /// Part of the stress divergence by artificial viscosity \[Pa/m\].
    pub artificial: [S::Vector; WIDTH],
    /// The same by the viscous pair force \[Pa/m\].
    pub drag: [S::Vector; WIDTH],
    /// The same by artificial pressure \[Pa/m\].
    pub clumping: [S::Vector; WIDTH],
    /// Acceleration by the repulsion of wall faces, a part of `forces` \[m/s²\].
    pub repulsion: [S::Vector; WIDTH],
    /// Acceleration by body forces \[m/s²\].
    pub body: [S::Vector; WIDTH],
    /// Acceleration by the particle regularisation \[m/s²\].
    pub regularisation: [S::Vector; WIDTH],
    /// The part of it by the shift \[m/s²\].
    pub advection: [S::Vector; WIDTH],
    /// Whether walls are near one of them.
    pub near_walls: bool,
}

impl<S: FluidSpace> Default for ForceBatch<S> {
    fn default() -> Self {
        let none = [S::Vector::default(); WIDTH];
        Self {
            forces: none,
            artificial: none,
            drag: none,
            clumping: none,
            repulsion: none,
            body: none,
            regularisation: none,
            advection: none,
            near_walls: false,
        }
    }
}

/// The powers that a pass has; the others are zero and cost nothing.
#[derive(Clone, Copy, Debug)]
pub struct ActivePowers {
    /// The viscous pair force.
    pub drag: bool,
    /// Artificial pressure.
    pub clumping: bool,
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
    /// Velocity of the stage \[m/s\].
    pub velocity: S::Of<L>,
    /// Velocity of the shift \[m/s\].
    pub shift: S::Of<L>,
}

/// Powers on the fluid \[W/m\] in lanes. No product is fused with a sum.
#[derive(Clone, Copy, Debug)]
pub struct LanePowers<L: Lanes> {
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

/// Scalar product of `b` with each of the four vectors `a`.
#[inline(always)]
fn product<S: FluidSpace, L: Lanes>(a: &[S::Vector; WIDTH], b: S::Of<L>) -> L {
    S::rounded_dot(S::lanes(a.each_ref()), b)
}

impl<L: Lanes> LanePowers<L> {
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
    pub fn add<S: FluidSpace>(
        &mut self,
        batch: &ForceBatch<S>,
        particles: &MovingParticles<S, L>,
        (damping, falling): (f64, &S::Vector),
        active: &ActivePowers,
    ) {
        let MovingParticles { mass, density, mean_velocity, velocity, shift } = *particles;
        let momentum = S::scaled(mean_velocity, mass);
        // −1/ρ makes an acceleration of a stress divergence.
        let flow = S::scaled(mean_velocity, mass / density);
        self.forces = self.forces + product::<S, L>(&batch.forces, momentum);
        self.artificial = self.artificial - product::<S, L>(&batch.artificial, flow);
        if active.drag {
            self.drag = self.drag - product::<S, L>(&batch.drag, flow);
        }
        if active.clumping {
            self.clumping = self.clumping - product::<S, L>(&batch.clumping, flow);
        }
        if batch.near_walls {
            self.repulsion = self.repulsion + product::<S, L>(&batch.repulsion, momentum);
        }
        if active.body_force {
            let excess = S::minus(S::lanes(batch.body.each_ref()), S::splat_vector(falling));
            self.body = self.body + S::rounded_dot(excess, momentum);
        }
        if active.damping {
            self.damping = self.damping - L::splat(damping) * S::rounded_dot(velocity, momentum);
        }
        if active.regularisation {
            self.regularisation = self.regularisation + product::<S, L>(&batch.regularisation, momentum);
            self.advection = self.advection + product::<S, L>(&batch.advection, momentum);
            self.shifted = self.shifted + mass * S::rounded_dot(S::splat_vector(falling), shift);
        }
        if active.scheme {
            let beyond = S::minus(mean_velocity, velocity);
            self.scheme = self.scheme + mass * S::rounded_dot(S::splat_vector(falling), beyond);
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
