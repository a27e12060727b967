//! One body: its particles, material, formulation, supports and loads.

use std::ops::Range;

use sph::coupling::stage::StageTime;
use sph::prescribed::body_force::BodyForceField;
use sph::setup::ElasticParameters;

use crate::boundary::loads::Load;
use crate::boundary::supports::Support;
use crate::formulations::formulation::BodyFormulation;
use crate::space::SolidSpace;

/// Largest stable steps by the elastic waves inside an undeformed body; infinite for a rigid one.
#[derive(Clone, Copy, Debug)]
pub struct WaveLimits {
    /// Step of Eq. (30)-(31) \[s\].
    pub stage_rule: f64,
    /// Sub-step of velocity Verlet \[s\].
    pub substep: f64,
}

impl WaveLimits {
    /// Of a rigid body.
    pub const NONE: Self = Self { stage_rule: f64::INFINITY, substep: f64::INFINITY };
}

/// One body.
pub struct Body<S: SolidSpace> {
    pub name: String,
    /// Its particles.
    pub range: Range<usize>,
    /// Largest mass of a particle \[kg/m\], in space \[kg\].
    pub largest_mass: f64,
    pub material: ElasticParameters,
    pub formulation: Box<dyn BodyFormulation<S>>,
    pub wave_limits: WaveLimits,
    pub supports: Vec<Support<S>>,
    /// Acceleration of this body alone.
    pub acceleration: Option<BodyForceField<S>>,
    pub loads: Vec<Load<S>>,
    /// Time \[s\] until which contact with each wall particle is left out; empty without supports.
    pub wall_exemption: Vec<f64>,
    /// Whether parts of it that are far apart when undeformed may be in contact.
    pub self_contact: bool,
    /// Whether a probe reads the body's rotation.
    pub tracks_rotation: bool,
}

impl<S: SolidSpace> Body<S> {
    /// Whether it is rigid, and no support holds all of it in the step of `time`.
    pub fn is_free_and_rigid(&self, time: &StageTime) -> bool {
        let clamps =
            |support: &Support<S>| support.pivot.is_none() && support.holds_fully() && support.acts(time);
        self.formulation.is_rigid() && !self.supports.iter().any(clamps)
    }
}
