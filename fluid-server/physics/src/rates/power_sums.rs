//! Sums of the powers of the forces on the fluid, four particles at a time.

use std::ops::Range;

use sph::lanes::{LanePass, Lanes, WIDTH};
use sph::space::Space;

use super::energy::{EnergyInput, ForcePowers};
use crate::equations::pair::PairParts;
use crate::system::lane_arrays::{get, numbers, vectors, weight};
use crate::system::packed_particle::{FluidSpace, Packed};
use crate::system::state::FluidState;

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
    /// The viscous pair force.
    pub drag: bool,
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
struct MovingParticles<S: Space, L: Lanes> {
    /// Mass per depth \[kg/m\].
    mass: L,
    /// Density \[kg/m³\].
    density: L,
    /// v̄ \[m/s\].
    mean_velocity: S::Of<L>,
    /// Velocity of the stage; zero where neither damping nor scheme reads it \[m/s\].
    velocity: S::Of<L>,
}

/// Powers on the fluid \[W/m\], each over every fourth particle. No product is fused with a sum.
#[derive(Clone, Copy, Debug, Default)]
pub struct PowerSums<N = [f64; WIDTH]> {
    forces: N,
    artificial: N,
    drag: N,
    clumping: N,
    repulsion: N,
    body: N,
    damping: N,
    regularisation: N,
    advection: N,
    shifted: N,
    scheme: N,
}

/// Adds the powers of the `acting` forces on `particles` to `sums`: a pass of its own, so that it is compiled once for
/// all combinations of terms of the pair sums.
pub struct AddPowers<'a, S: FluidSpace> {
    /// Sums over earlier particles.
    pub sums: &'a mut PowerSums,
    /// Own particles as neighbours read them.
    pub fluid: &'a [S::Particle],
    /// State.
    pub state: &'a FluidState<S>,
    /// What the energy budget needs.
    pub energy: &'a EnergyInput<'a, S>,
    /// The particles, at most [`BLOCK`].
    pub particles: Range<usize>,
    /// What acts on each.
    pub acting: &'a [ActingForces<S>; BLOCK],
    /// Rate of the linear damping \[1/s\].
    pub damping: f64,
    /// The powers that there are.
    pub active: &'a ActivePowers,
}

impl<S: FluidSpace> LanePass for AddPowers<'_, S> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { fluid, state, energy, particles, active, .. } = self;
        let half = L::splat(energy.half);
        let mut sums = self.sums.in_lanes::<L>();
        for (first, acting) in particles.clone().step_by(WIDTH).zip(self.acting.as_chunks::<WIDTH>().0) {
            let [a, b, c, d] = acting;
            let mut acceleration =
                S::lanes::<L>([&a.acceleration, &b.acceleration, &c.acceleration, &d.acceleration]);
            if !energy.by_solids.is_empty() {
                acceleration = S::plus(acceleration, vectors::<S, L>(energy.by_solids, first));
            }
            let start = vectors::<S, L>(energy.start_velocity, first);
            let velocity = if active.damping || active.scheme {
                let velocities = get(fluid, first).map(|particle| particle.velocity());
                S::lanes(velocities.each_ref())
            } else {
                S::splat(L::zero())
            };
            let moving = MovingParticles {
                mass: numbers::<L>(&state.mass, first) * weight(first, particles.end),
                density: numbers(&state.density, first),
                mean_velocity: S::plus(start, S::scaled(acceleration, half)),
                velocity,
            };
            sums.add::<S>(acting, &moving, (self.damping, &energy.falling), active);
        }
        *self.sums = sums.in_memory();
    }
}

/// Each sum as `$convert` gives it.
macro_rules! converted {
    ($sums:expr, $convert:path) => {
        PowerSums {
            forces: $convert($sums.forces),
            artificial: $convert($sums.artificial),
            drag: $convert($sums.drag),
            clumping: $convert($sums.clumping),
            repulsion: $convert($sums.repulsion),
            body: $convert($sums.body),
            damping: $convert($sums.damping),
            regularisation: $convert($sums.regularisation),
            advection: $convert($sums.advection),
            shifted: $convert($sums.shifted),
            scheme: $convert($sums.scheme),
        }
    };
}

impl PowerSums {
    #[inline(always)]
    fn in_lanes<L: Lanes>(&self) -> PowerSums<L> {
        converted!(self, L::from_array)
    }

    /// Over all particles.
    pub fn total(&self) -> ForcePowers {
        let sums = converted!(self, sum);
        ForcePowers {
            pressure: sums.forces - sums.repulsion - sums.artificial - sums.drag - sums.clumping,
            artificial_viscosity: sums.artificial,
            drag: sums.drag,
            clumping: sums.clumping,
            repulsion: sums.repulsion,
            body_force: sums.body,
            damping: sums.damping,
            tension: sums.regularisation - sums.advection,
            advection: sums.advection,
            shifted: sums.shifted,
            scheme: sums.scheme,
            ..ForcePowers::default()
        }
    }
}

/// As [`Lanes::sums`].
fn sum([a, b, c, d]: [f64; WIDTH]) -> f64 {
    (a + b) + (c + d)
}

impl<L: Lanes> PowerSums<L> {
    #[inline(always)]
    fn in_memory(&self) -> PowerSums {
        converted!(self, L::to_array)
    }

    /// Adds those on four particles, with `damping` the rate of the linear damping \[1/s\] and `falling` the part of
    /// gravity that has a potential \[m/s²\].
    #[inline(always)]
    fn add<S: FluidSpace>(
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
        if active.drag {
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
}
