//! Powers of the forces on the fluid, by mechanism.
//!
//! With v̄ the mean of a particle's velocities at both ends of the step, a force f does the work Δt f·v̄: summed over all
//! forces this is the change of kinetic energy, exactly. [`super::power_sums`] sums them.

use std::ops::AddAssign;

use sph::coupling::ledger::{EnergyAccount, EnergyValues};
use sph::prescribed::motion::MotionState;
use sph::space::tensors::SpaceVector;
use sph::sums::Numbers;

use crate::equations::pair::PairParts;
use crate::system::packed_particle::FluidSpace;

/// What the rates of a corrector need for the energy budget.
#[derive(Clone, Copy)]
pub struct EnergyInput<'a, S: FluidSpace> {
    /// Velocities at the start of the step \[m/s\].
    pub start_velocity: &'a [S::Vector],
    /// Half the step \[s\].
    pub half: f64,
    /// Acceleration of each particle by solids \[m/s²\]; empty without them.
    pub by_solids: &'a [S::Vector],
    /// The part of gravity that has a potential \[m/s²\].
    pub falling: S::Vector,
    /// Motion of each wall, `None` for one at rest; empty where no wall moves.
    pub motions: &'a [Option<MotionState<S>>],
}

/// Powers on the fluid \[W/m\], summed over particles.
#[derive(Clone, Copy, Debug, Default)]
pub struct ForcePowers {
    /// Pressure and viscous stress.
    pub pressure: f64,
    /// Artificial viscosity.
    pub artificial_viscosity: f64,
    /// The viscous pair force.
    pub drag: f64,
    /// Artificial pressure.
    pub clumping: f64,
    /// Repulsion by wall faces.
    pub repulsion: f64,
    /// Body forces without the part of gravity that has a potential.
    pub body_force: f64,
    /// Linear damping.
    pub damping: f64,
    /// Tensile control.
    pub tension: f64,
    /// The velocity of the fluid where a shift has taken the particle.
    pub advection: f64,
    /// Of gravity on the velocity of the shift.
    pub shifted: f64,
    /// Of gravity on v̄ beyond that on the velocity of the path.
    pub scheme: f64,
    /// Of moving walls by their motion.
    pub walls: f64,
    /// Lost to the acoustic damper.
    pub damper: f64,
    /// Lost to the viscous stress.
    pub stress: f64,
}

impl AddAssign for ForcePowers {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        self.pressure += other.pressure;
        self.artificial_viscosity += other.artificial_viscosity;
        self.drag += other.drag;
        self.clumping += other.clumping;
        self.repulsion += other.repulsion;
        self.body_force += other.body_force;
        self.damping += other.damping;
        self.tension += other.tension;
        self.advection += other.advection;
        self.shifted += other.shifted;
        self.scheme += other.scheme;
        self.walls += other.walls;
        self.damper += other.damper;
        self.stress += other.stress;
    }
}

impl Numbers for ForcePowers {
    fn each(&mut self, visit: &mut dyn FnMut(&mut f64)) {
        let Self {
            pressure,
            artificial_viscosity,
            drag,
            clumping,
            repulsion,
            body_force,
            damping,
            tension,
            advection,
            shifted,
            scheme,
            walls,
            damper,
            stress,
        } = self;
        [pressure, artificial_viscosity, drag, clumping, repulsion, body_force, damping]
            .into_iter()
            .for_each(&mut *visit);
        [tension, advection, shifted, scheme, walls, damper, stress].into_iter().for_each(&mut *visit);
    }
}

impl ForcePowers {
    /// Moves to the account of walls what the force of one that moves with `velocity` \[m/s\] does by that, for an
    /// acceleration by `pairs` and by `repulsion` \[m/s²\], and `parts` of the pairs' stress divergence \[Pa/m\], on a
    /// particle of `mass` \[kg/m\] and `volume` \[m²\] per depth.
    pub fn credit_wall<S: FluidSpace>(
        &mut self,
        (mass, volume): (f64, f64),
        velocity: &S::Vector,
        pairs: &S::Vector,
        parts: &PairParts<S>,
        repulsion: &S::Vector,
    ) {
        let (momentum, flow) = (*velocity * mass, *velocity * -volume);
        let [artificial, drag, clumping] =
            [parts.artificial, parts.drag, parts.clumping].map(|part| part.dot(&flow));
        let (pairs, repulsion) = (pairs.dot(&momentum), repulsion.dot(&momentum));
        self.pressure -= pairs - artificial - drag - clumping;
        self.artificial_viscosity -= artificial;
        self.drag -= drag;
        self.clumping -= clumping;
        self.repulsion -= repulsion;
        self.walls += pairs + repulsion;
    }

    /// Enters the work in `duration` \[s\]. The pressure's is a gain that the account of corrected gradients gives.
    pub fn enter(&self, flows: &mut EnergyValues, duration: f64) {
        use EnergyAccount as A;
        // The work of the viscous stress is part of the pressure's; what it loses is known by itself.
        for (account, power) in [
            (A::BodyForce, self.body_force),
            (A::Walls, self.walls),
            (A::CorrectedGradients, -self.pressure - self.damper - self.stress),
            (A::ArtificialViscosity, -self.artificial_viscosity),
            (A::Viscosity, self.stress - self.drag),
            (A::AcousticDamper, self.damper),
            (A::ArtificialPressure, -self.clumping),
            (A::Repulsion, -self.repulsion),
            (A::Damping, -self.damping),
            (A::TensileControl, -self.tension),
            (A::Shifting, self.shifted - self.advection),
            (A::TimeScheme, -self.scheme),
        ] {
            flows.add(account, duration * power);
        }
    }
}
