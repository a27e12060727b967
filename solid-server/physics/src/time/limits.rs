//! Limits of the time step of solids: all formulas and coefficients.
//!
//! The first functions need the material, the spacing and the coefficients of a body only, so that a case can be judged
//! before its bodies exist.

use sph::coupling::stage::StageTime;
use sph::setup::{ElasticParameters, Formulation, SolidStepping, SubstepCount};
use sph::space::tensors::SpaceVector;

use crate::boundary::walls::WallState;
use crate::formulations::body::Body;
use crate::particles::forces::ParticleForces;
use crate::space::SolidSpace;
use crate::system::model::SolidModel;
use crate::system::state::SolidState;
use crate::system::workspace::Workspace;
use crate::thresholds::Thresholds;

sph::constants! {
    /// Corners of bodies that spin may be somewhat faster than their waves; beyond, a step or a speed is wrong.
    pub const LARGEST_SPEED: f64 = 2.0, "solid.largest_speed",
        "largest speed of a particle of a solid, over the longitudinal wave speed [-]";
    /// That of the source paper, whatever the stencil.
    const REFERENCE_KERNEL_RATIO: f64 = 1.3, "solid.stage_rule.kernel_ratio",
        "h/dx that the Courant number of the stage rule of a total-Lagrangian body refers to [-]";
    /// The midpoint rule of Eq. (30)-(31) lets an oscillation grow by (ω Δt)⁴/8 per step, and nothing damps a rigid body.
    const RIGID_STAGE_RULE: f64 = 0.5, "solid.stage_rule.rigid_contact",
        "step of the stage rule times the frequency of a rigid body on its contacts [-]";
    /// Two bodies approach by half a spacing in a step at most, less than the distance over which contact is foreseen,
    /// [`IMMINENT`](crate::contact::density_field::IMMINENT).
    const TRAVEL: f64 = 0.25, "solid.rigid.travel",
        "largest way of a particle of a rigid body in a step, in particle spacings [-]";
    const STANDING_CUBE: f64 = 16.0, "solid.rigid.standing_cube",
        "estimate of the squared frequency of a rigid cube on its contact, over that of its outer row on the contact of one side [-]";
    /// Contact may stiffen within a step.
    const AUTOMATIC_FRACTION: f64 = 0.8, "solid.substeps.automatic_fraction",
        "part of the stable sub-step that an automatic number of sub-steps takes [-]";
    const MOST_SUBSTEPS: f64 = 10_000.0, "solid.substeps.most",
        "most sub-steps per step that an automatic number reaches [-]";
}

/// Largest c_L Δt/h \[-\] of the stage rule, Eq. (30)-(31), for artificial viscosity A.
///
/// ```text
/// C₁ A^⅓ for C₁ A^⅓ > 0.1 and A < 1,  0.1 below,  C₁/A above;  C₁ = 1, in space 0.65
/// ```
///
/// The midpoint rule lets an undamped oscillation grow by (ω Δt)⁴/8 per step; viscous damping of rate ∝ A ω outweighs
/// it up to ω Δt ∝ A^⅓. Measured on a cantilever: A = 1 stable to 1.2, not at 1.5; A = 0.1 stable at 0.5, not at
/// 0.85. Above A = 1 the viscous term itself limits the step. In space, on a cube: A = 1 stable at 0.7, not at 0.85;
/// A = 0.1 stable at 0.3, not at 0.45.
pub fn stage_rule_courant<S: Thresholds>(viscosity_a: f64) -> f64 {
    if viscosity_a > 1.0 {
        S::DAMPED_COURANT / viscosity_a
    } else {
        (S::DAMPED_COURANT * viscosity_a.cbrt()).max(S::UNDAMPED_COURANT)
    }
}

/// Largest step of the stage rule for an updated-Lagrangian body of smoothing length h \[m\] and longitudinal wave speed
/// c_L \[m/s\], C(A) h/c_L \[s\] with C of [`stage_rule_courant`].
pub fn updated_lagrangian_stage_rule<S: Thresholds>(
    smoothing_length: f64,
    longitudinal_speed: f64,
    viscosity_a: f64,
) -> f64 {
    stage_rule_courant::<S>(viscosity_a) * smoothing_length / longitudinal_speed
}

/// Largest sub-step for an updated-Lagrangian body, 0.6 h/(c_L max(A, 1)) \[s\], in space 0.4 h/(c_L max(A, 1)).
pub fn updated_lagrangian_substep<S: Thresholds>(
    smoothing_length: f64,
    longitudinal_speed: f64,
    viscosity_a: f64,
) -> f64 {
    let courant = S::VERLET_COURANT / viscosity_a.max(1.0);
    courant * smoothing_length / longitudinal_speed
}

/// Largest step of the stage rule for a total-Lagrangian body of the given spacing Δx \[m\], 0.4 C(A) 1.3 Δx/c_L \[s\]
/// with C of [`stage_rule_courant`].
pub fn total_lagrangian_stage_rule<S: Thresholds>(
    spacing: f64,
    longitudinal_speed: f64,
    viscosity_a: f64,
) -> f64 {
    let courant = S::REFERENCE_COURANT * stage_rule_courant::<S>(viscosity_a);
    courant * REFERENCE_KERNEL_RATIO * spacing / longitudinal_speed
}

/// Largest sub-step for a total-Lagrangian body whose stiffest vibration at rest has the angular frequency ω \[rad/s\],
/// 0.9 · 2/(ω (1 + A)) \[s\]: the limit of velocity Verlet, narrowed by the explicit viscosity.
///
/// 2 c_L/Δx estimates ω within 7 % for kernel ratios 0.72 to 0.9 and hourglass coefficients up to 0.5; in space 2.3 c_L/Δx
/// does so within 9 %.
pub fn total_lagrangian_substep<S: Thresholds>(largest_frequency: f64, viscosity_a: f64) -> f64 {
    let viscous = 1.0 + viscosity_a;
    if largest_frequency > 0.0 {
        S::VERLET_FRACTION * 2.0 / (largest_frequency * viscous)
    } else {
        f64::INFINITY
    }
}

/// Largest sub-step \[s\] of a body of particles of `spacing` \[m\], by an estimate that needs no particles; `None` for a
/// rigid one.
pub fn estimated_substep<S: Thresholds>(
    formulation: &Formulation,
    material: &ElasticParameters,
    spacing: f64,
) -> Option<f64> {
    let speed = material.longitudinal_speed();
    match formulation {
        Formulation::Rigid => None,
        Formulation::UpdatedLagrangian(set) => {
            Some(updated_lagrangian_substep::<S>(set.smoothing_length(spacing), speed, set.viscosity_a))
        }
        Formulation::TotalLagrangian(set) => {
            // The stiffest vibration of a lattice, which the solver finds exactly.
            Some(total_lagrangian_substep::<S>(S::STIFFEST_LATTICE * speed / spacing, set.viscosity_a))
        }
    }
}

/// Largest step \[s\] of such a body, by the same estimate.
pub fn estimated_step<S: Thresholds>(
    stepping: SolidStepping,
    formulation: &Formulation,
    material: &ElasticParameters,
    spacing: f64,
) -> Option<f64> {
    if stepping != SolidStepping::StageRule {
        return estimated_substep::<S>(formulation, material, spacing)
            .map(|limit| largest_count(stepping) * limit);
    }
    let speed = material.longitudinal_speed();
    match formulation {
        Formulation::Rigid => None,
        Formulation::UpdatedLagrangian(set) => {
            Some(updated_lagrangian_stage_rule::<S>(set.smoothing_length(spacing), speed, set.viscosity_a))
        }
        Formulation::TotalLagrangian(set) => {
            Some(total_lagrangian_stage_rule::<S>(spacing, speed, set.viscosity_a))
        }
    }
}

/// Largest sub-step \[s\] while a rigid body of `count` particles of `spacing` Δx \[m\] is in contact, by an estimate that needs no
/// particles: the frequency ω of a cube of R = `count`^(1/d) rows that stands on one face, with the bounds that the solver has
/// of stiffness and moment of inertia.
///
/// ```text
/// ω² = 16 kK/(2 ρ R Δx²)
/// ```
pub fn estimated_contact_substep<S: Thresholds>(
    material: &ElasticParameters,
    contact_stiffness: f64,
    spacing: f64,
    count: usize,
) -> f64 {
    let rows = (count as f64).powf(1.0 / S::DIMENSIONS as f64);
    let pressure = 0.5 * contact_stiffness * material.bulk_modulus;
    spacing * (rows * material.density / (STANDING_CUBE * pressure)).sqrt()
}

/// Automatic number of sub-steps in a step of `time_step` \[s\], an even number, for sub-steps that are stable up to
/// `substep_limit` \[s\].
pub fn automatic_substeps(time_step: f64, substep_limit: f64) -> u32 {
    let needed = time_step / (AUTOMATIC_FRACTION * substep_limit);
    // At most MOST_SUBSTEPS: the conversion is exact.
    2 * (0.5 * needed).ceil().clamp(1.0, 0.5 * MOST_SUBSTEPS) as u32
}

/// Largest step by the acceleration a of a particle \[m/s²\], ¼ √(Δx/a) \[s\].
pub fn acceleration_limit<S: Thresholds>(spacing: f64, acceleration: f64) -> f64 {
    S::ACCELERATION_COEFFICIENT * (spacing / acceleration).sqrt()
}

/// Largest step \[s\] in which nothing of `speed` \[m/s\] goes farther than a quarter of the spacing Δx \[m\].
pub fn travel_limit(spacing: f64, speed: f64) -> f64 {
    TRAVEL * spacing / speed
}

/// Largest frequency of the free rigid bodies on their contacts in `forces` \[rad/s\], in the step of `time`; over 0.5 with
/// the stage rule.
pub(crate) fn rigid_contact_frequency<S: SolidSpace>(
    model: &SolidModel<S>,
    forces: &[ParticleForces<S>],
    time: &StageTime,
) -> f64 {
    let free = model.bodies.iter().filter(|body| body.is_free_and_rigid(time));
    let rates = free.filter_map(|body| body.formulation.contact_rate(&forces[body.range.clone()]));
    let frequency = rates.fold(0.0, f64::max).sqrt();
    match model.stepping {
        SolidStepping::StageRule => frequency / RIGID_STAGE_RULE,
        SolidStepping::Substeps(_) => frequency,
    }
}

/// Largest step by the speed of what rigid bodies may run into, or that may run into them \[s\].
pub(crate) fn rigid_travel_limit<S: SolidSpace>(
    model: &SolidModel<S>,
    state: &SolidState<S>,
    walls: &WallState<S>,
) -> f64 {
    let is_rigid = |body: &Body<S>| body.formulation.is_rigid();
    let meets = model.has_contact() || model.walls.len() > 0;
    if !(meets && model.bodies.iter().any(is_rigid)) {
        return f64::INFINITY;
    }
    let fastest = |speeds: &[S::Vector]| speeds.iter().map(|v| v.norm()).fold(0.0, f64::max);
    travel_limit(model.spacing, fastest(&state.particles.velocity) + fastest(&walls.velocity))
}

/// Largest stable sub-step from `state` \[s\]: by the waves of the deformed bodies, and 1/ω of the stiffest contact.
pub(crate) fn substep_limit<S: SolidSpace>(model: &SolidModel<S>, state: &SolidState<S>) -> f64 {
    let waves = model.bodies.iter().map(|body| body.wave_limits.substep);
    let frequency_ratio = state.last.maxima.tangent_stiffness_ratio.max(1.0).sqrt();
    (waves.fold(f64::INFINITY, f64::min) / frequency_ratio).min(1.0 / state.last.maxima.contact_frequency)
}

/// Largest stable step from `state` \[s\] by the waves and contacts of the solids.
pub(crate) fn step_limit<S: SolidSpace>(model: &SolidModel<S>, state: &SolidState<S>) -> f64 {
    match model.stepping {
        SolidStepping::StageRule => {
            let waves = model.bodies.iter().map(|body| body.wave_limits.stage_rule);
            waves.fold(1.0 / state.last.maxima.contact_frequency, f64::min)
        }
        stepping => largest_count(stepping) * substep_limit(model, state),
    }
}

/// Step limit by particle `i` in the stage that `workspace` has just made \[s\].
pub(crate) fn particle_limit<S: SolidSpace>(
    model: &SolidModel<S>,
    workspace: &Workspace<S>,
    i: usize,
) -> f64 {
    let (mass, forces) = (model.particles.mass[i], &workspace.mean_forces[i]);
    let acceleration = workspace.total_force[i].norm() / mass;
    let body = model.body_of(i);
    let stiffness_ratio =
        body.formulation.tangent_stiffness_ratio(&workspace.stress.view(&body.range), i - body.range.start);
    let waves = body.wave_limits.substep / stiffness_ratio.max(1.0).sqrt();
    let contact = (mass / (2.0 * forces.contact_stiffness)).sqrt();
    acceleration_limit::<S>(model.spacing, acceleration)
        .min(largest_count(model.stepping) * waves.min(contact))
}

/// The largest stable step over the largest stable sub-step \[-\].
fn largest_count(stepping: SolidStepping) -> f64 {
    match stepping {
        SolidStepping::StageRule => 1.0,
        SolidStepping::Substeps(SubstepCount::Fixed(count)) => f64::from(count),
        SolidStepping::Substeps(SubstepCount::Automatic) => MOST_SUBSTEPS * AUTOMATIC_FRACTION,
    }
}

#[cfg(test)]
mod tests {
    use sph::space::Plane;

    use super::*;

    #[test]
    fn stage_rule_courant_lies_between_what_was_measured_stable_and_unstable() {
        assert!(stage_rule_courant::<Plane>(1.0) <= 1.2);
        assert!((0.45..0.5).contains(&stage_rule_courant::<Plane>(0.1)));
        assert_eq!(stage_rule_courant::<Plane>(0.0), 0.1);
        assert_eq!(stage_rule_courant::<Plane>(4.0), 0.25);
    }
}
