//! Limits beyond which a run of solids has no meaning.

use sph::coupling::solver::Divergence;
use sph::coupling::stage::StepStage;
use sph::space::components::Components;
use sph::space::tensors::SpaceVector;
use sph::tasks::first;

use crate::particles::variables::Particles;
use crate::space::SolidSpace;
use crate::system::model::SolidModel;
use crate::time::limits::LARGEST_SPEED;

/// Fails with the first particle, by index, of `particles` that breaks a limit.
///
/// # Errors
/// When a quantity is not finite, density or shear leave their range, or a particle is much faster than the waves in its body.
pub fn check<S: SolidSpace>(
    model: &SolidModel<S>,
    particles: &Particles<S>,
    at: StepStage,
) -> Result<(), Box<Divergence>> {
    first(particles.len(), 1024, |i| broken_limit(model, particles, i, at)).map_or(Ok(()), Err)
}

/// Fails when more particles than allowed are outside the domain; returns how many are.
///
/// Held particles do not count: a clamp may continue a body beyond the domain.
///
/// # Errors
/// Names the first particle outside.
pub fn check_domain<S: SolidSpace>(
    model: &SolidModel<S>,
    particles: &Particles<S>,
    time: &sph::coupling::stage::StageTime,
) -> Result<u64, Box<Divergence>> {
    let is_outside = |i: &usize| {
        !model.domain.contains(&particles.position[*i]) && model.acting_support(*i, time).is_none()
    };
    let outside = (0..particles.len()).filter(is_outside).count() as u64;
    if outside <= model.lost_particle_limit {
        return Ok(outside);
    }
    let first = (0..particles.len()).find(is_outside);
    Err(Box::new(Divergence {
        at: time.at,
        particle: first.map(|i| model.particles.id[i]),
        position: first.map(|i| particles.position[i].row().as_ref().to_vec()),
        quantity: format!(
            "number of particles outside the domain [-]{}",
            first.map_or_else(String::new, |i| format!(" (first of body `{}`)", model.body_of(i).name))
        ),
        value: outside as f64,
        allowed: format!("at most {}", model.lost_particle_limit),
        hint: "the body left the scene: enlarge the domain, close it with walls, or end the run earlier"
            .into(),
    }))
}

const SHORTER_STEP: &str = "the step may be too long for the solid: reduce the time step, raise the number of its \
                            sub-steps, or its artificial viscosity A";

/// The first limit that particle `i` breaks.
fn broken_limit<S: SolidSpace>(
    model: &SolidModel<S>,
    particles: &Particles<S>,
    i: usize,
    at: StepStage,
) -> Option<Box<Divergence>> {
    let body = model.body_of(i);
    let (x, v) = (particles.position[i], particles.velocity[i]);
    let (rho, s) = (particles.density[i], particles.deviatoric_stress[i]);
    let broken = |quantity: &str, value: f64, allowed: String, hint: &str| {
        Some(Box::new(Divergence {
            at,
            particle: Some(model.particles.id[i]),
            position: Some(x.row().as_ref().to_vec()),
            quantity: format!("{quantity} of body `{}`", body.name),
            value,
            allowed,
            hint: hint.into(),
        }))
    };
    let not_finite = |values: &[f64]| values.iter().copied().find(|value| !value.is_finite());
    for (quantity, value) in [
        ("position [m]", not_finite(x.row().as_ref())),
        ("velocity [m/s]", not_finite(v.row().as_ref())),
        ("density [kg/m3]", not_finite(&[rho])),
        ("deviatoric stress [Pa]", not_finite(s.row().as_ref())),
    ] {
        if let Some(value) = value {
            return broken(quantity, value, "finite values".into(), SHORTER_STEP);
        }
    }
    let wave_speed = body.material.longitudinal_speed();
    if v.norm() > LARGEST_SPEED * wave_speed {
        let allowed =
            format!("at most {LARGEST_SPEED} times the longitudinal wave speed {wave_speed:.4e} m/s");
        return broken("speed [m/s]", v.norm(), allowed, SHORTER_STEP);
    }
    if body.formulation.is_rigid() {
        return None;
    }
    let limits = body.formulation.limits();
    let ratio = rho / body.material.density;
    let (smallest, largest) = limits.density_ratios;
    if !(smallest..=largest).contains(&ratio) {
        return broken(
            "density over rest density [-]",
            ratio,
            format!("{smallest} to {largest}"),
            "the body is torn or crushed beyond what the elastic law can mean: reduce the load or the time step",
        );
    }
    let shear = S::squared_deviator(&s).sqrt() / (2.0 * body.material.shear_modulus);
    if shear > limits.largest_shear {
        return broken(
            "elastic shear strain sqrt(s:s)/(2G) [-]",
            shear,
            format!("at most {}", limits.largest_shear),
            "the body is deformed beyond what the elastic law can mean: reduce the load or the time step",
        );
    }
    None
}
