//! Time-step limits of a scene, by the formulas of the solvers, and what to use of them.

use solid::limits::{acceleration_limit, estimated_step};
use sph::setup::{FormulationKind, SolidStepping, SubstepCount};
use sph::space::tensors::SpaceVector;

use super::Case;
use super::file::body::BodyTable;
use super::file::solid::SolidTable;
use super::scene::{Scene, SceneSpace};

sph::constants! {
    /// Speeds and contacts grow after the start.
    pub const RECOMMENDED_FRACTION: f64 = 0.8, "recommended.waves",
        "recommended fraction of a limit by sound or elastic waves [-]";
    /// That limit has a margin of its own.
    const RECOMMENDED_REFERENCE_FRACTION: f64 = 0.9, "recommended.total_lagrangian",
        "recommended fraction of the limit of total-Lagrangian sub-steps [-]";
    const RECOMMENDED_DAMPING_FRACTION: f64 = 0.5, "recommended.damping",
        "recommended fraction of a limit by linear damping [-]";
}

/// A limit of the time step with its origin.
#[derive(Clone, Debug, PartialEq)]
pub struct StepLimit {
    /// What sets it, such as `fluid, acoustic h/(c0 + v)`.
    pub origin: String,
    /// Largest stable step \[s\].
    pub stability: f64,
    /// Largest step to use \[s\].
    pub recommended: f64,
}

/// The smallest by `key`, if there is any.
pub fn governing(limits: &[StepLimit], key: impl Fn(&StepLimit) -> f64) -> Option<&StepLimit> {
    limits.iter().min_by(|a, b| key(a).total_cmp(&key(b)))
}

impl Case {
    /// Limits of the time step of everything in the scene at the start.
    pub(super) fn step_limits(&self) -> Vec<StepLimit> {
        sph::in_space!(&self.scene, scene => self.step_limits_in(scene))
    }

    fn step_limits_in<S: SceneSpace>(&self, scene: &Scene<S>) -> Vec<StepLimit> {
        let mut found = Vec::new();
        let limit = |origin: &str, stability: f64, fraction: f64| StepLimit {
            origin: origin.to_owned(),
            stability,
            recommended: fraction * stability,
        };
        if let Some(fluid) = &self.file.fluid {
            let constants = fluid.parameters.values();
            let speed = scene.fluid.velocity.iter().map(|v| v.norm()).fold(0.0, f64::max);
            found.push(limit(
                "fluid, acoustic h/(c0 + v)",
                constants.acoustic_limit(speed),
                RECOMMENDED_FRACTION,
            ));
            if constants.dynamic_viscosity > 0.0 {
                found.push(limit("fluid, viscous h²/(8 ν)", fluid::viscous_limit::<S>(&constants), 1.0));
            }
            if let Some(damping) = &fluid.damping {
                found.push(limit(
                    "fluid, damping 1/k",
                    1.0 / damping.rate_per_s,
                    RECOMMENDED_DAMPING_FRACTION,
                ));
            }
        }
        if let Some(solid) = &self.file.solid {
            found.extend(solid.bodies.iter().filter_map(|body| body_limit::<S>(solid, body)));
            let gravity = self.file.body_force.gravity_m_s2.to::<S>().norm();
            if gravity > 0.0 && !solid.bodies.is_empty() {
                let stability = acceleration_limit::<S>(solid.particle_spacing_m.value, gravity);
                found.push(limit("solid, acceleration ¼ √(Δx/g)", stability, 1.0));
            }
            if let Some(damping) = &solid.damping {
                found.push(limit(
                    "solid, damping 1/k",
                    1.0 / damping.rate_per_s,
                    RECOMMENDED_DAMPING_FRACTION,
                ));
            }
        }
        found
    }
}

/// What limits the step by the waves of `body`, by the formulas of the solver.
fn body_limit<S: SceneSpace>(solid: &SolidTable, body: &BodyTable) -> Option<StepLimit> {
    let formulation = body.formulation.to_setup();
    let (stepping, spacing) = (solid.substeps.to_setup(), solid.particle_spacing_m.value);
    let stability = estimated_step::<S>(stepping, &formulation, &body.material.parameters.values(), spacing)?;
    let length = match formulation.kind() {
        FormulationKind::TotalLagrangian => "Δx/c_L",
        FormulationKind::UpdatedLagrangian | FormulationKind::Rigid => "h/c_L",
    };
    let origin = match stepping {
        SolidStepping::StageRule => format!("elastic, of {length}"),
        SolidStepping::Substeps(SubstepCount::Fixed(count)) => {
            format!("elastic, {count} sub-steps, each of {length}")
        }
        SolidStepping::Substeps(SubstepCount::Automatic) => {
            format!("elastic, the largest number of sub-steps, each of {length}")
        }
    };
    let has_margin =
        stepping != SolidStepping::StageRule && formulation.kind() == FormulationKind::TotalLagrangian;
    let fraction = if has_margin { RECOMMENDED_REFERENCE_FRACTION } else { RECOMMENDED_FRACTION };
    let origin = format!("body `{}`, {origin}", body.name.value);
    Some(StepLimit { origin, stability, recommended: fraction * stability })
}
