//! Results of a stage for each particle, and for each task.

use std::ops::AddAssign;

use sph::coupling::stage::Stage;
use sph::space::{Plane, Space};
use sph::sums::{Numbers, each_of};

use super::energy::ForcePowers;
use crate::system::model::FluidModel;

/// The part of the rates that a stage computes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StagePart {
    /// All, Eq. (30)-(31).
    #[default]
    Whole,
    /// The predictor of leapfrog: Eq. (17).
    Density,
    /// The corrector of leapfrog: Eq. (22), the diffusion of Eq. (18) and the particle regularisation.
    Momentum,
}

impl StagePart {
    /// The part that `stage` computes for `model`.
    pub fn of<S: Space>(model: &FluidModel<S>, stage: Stage) -> Self {
        match (model.is_leapfrog(), stage) {
            (false, _) => Self::Whole,
            (true, Stage::Predictor) => Self::Density,
            (true, Stage::Corrector) => Self::Momentum,
        }
    }
}

/// Rates of one particle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rates<S: Space = Plane> {
    /// Acceleration \[m/s²\].
    pub acceleration: S::Vector,
    /// Velocity of the shift, in addition to the particle's \[m/s\].
    pub shift: S::Vector,
    /// Density rate \[kg/(m³ s)\].
    pub density: f64,
    /// Part of it by the volume correction \[kg/(m³ s)\].
    pub volume: f64,
}

/// Sums over the particles of one task: forces \[N/m\], and torques about the domain's torque origin \[N\].
#[derive(Clone, Copy, Debug, Default)]
pub struct ExternalForces<S: Space = Plane> {
    /// Body force.
    pub body: Wrench<S>,
    /// Force by walls.
    pub walls: Wrench<S>,
    /// Force by stabilisers that are not antisymmetric.
    pub stabilisers: Wrench<S>,
    /// Torque of the fluid's forces on itself, which do not all act along the line between two particles.
    pub own_torque: S::Spin,
    /// Powers of all forces, in a corrector.
    pub powers: ForcePowers,
}

impl<S: Space> Numbers for ExternalForces<S> {
    fn each(&mut self, visit: &mut dyn FnMut(&mut f64)) {
        let Self { body, walls, stabilisers, own_torque, powers } = self;
        for Wrench { force, torque } in [body, walls, stabilisers] {
            each_of(force, visit);
            each_of(torque, visit);
        }
        each_of(own_torque, visit);
        powers.each(visit);
    }
}

/// A force \[N/m\] and its torque \[N\].
#[derive(Clone, Copy, Debug, Default)]
pub struct Wrench<S: Space> {
    /// Force.
    pub force: S::Vector,
    /// Torque.
    pub torque: S::Spin,
}

impl<S: Space> Wrench<S> {
    /// `force` that acts at `arm` \[m\] from the torque origin.
    #[inline(always)]
    pub fn at(arm: &S::Vector, force: S::Vector) -> Self {
        Self { force, torque: S::cross(arm, &force) }
    }
}

impl<S: Space> AddAssign for Wrench<S> {
    fn add_assign(&mut self, other: Self) {
        self.force += other.force;
        self.torque += other.torque;
    }
}
