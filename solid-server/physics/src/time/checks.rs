//! Limits beyond which a run of solids has no meaning.

use rayon::prelude::*;

use sph::coupling::solver::Divergence;
use sph::coupling::stage::StepStage;
use sph::space::components::Components;
use sph::space::tensors::SpaceVector;

use crate::particles::variables::Particles;
use crate::space::SolidSpace;
use crate::system::model::SolidModel;

/// Fails with the first particle, by index, of `particles` that breaks a limit.
///
/// # Errors
/// When a quantity is not finite, density or shear leave their range, or a particle outruns the waves in its body.
pub fn check<S: SolidSpace>(
    model: &SolidModel<S>,
    particles: &Particles<S>,
    at: StepStage,
) -> Result<(), Box<Divergence>> {
    (0..particles.len())
        .into_par_iter()
        .with_min_len(1024)
        .filter_map(|i| broken_limit(model, particles, i).map(|limit| (i, limit)))
        .find_first(|_| true)
        .map_or(Ok(()), |(i, limit)| Err(limit.divergence(model, particles, i, at)))
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

/// A limit that a particle broke.
struct BrokenLimit {
    quantity: &'static str,
    value: f64,
    allowed: String,
    hint: &'static str,
}

const SHORTER_STEP: &str = "the step may be too long for the solid: reduce the time step, raise the number of its \
                            sub-steps, or its artificial viscosity A";

fn broken_limit<S: SolidSpace>(
    model: &SolidModel<S>,
    particles: &Particles<S>,
    i: usize,
) -> Option<BrokenLimit> {
    let body = model.body_of(i);
    let (x, v) = (particles.position[i], particles.velocity[i]);
    let (rho, s) = (particles.density[i], particles.deviatoric_stress[i]);
    let finite = |quantity, values: &[f64]| {
        values.iter().copied().find(|value| !value.is_finite()).map(|value| BrokenLimit {
            quantity,
            value,
            allowed: "finite values".into(),
            hint: SHORTER_STEP,
        })
    };
    let not_finite = finite("position [m]", x.row().as_ref())
        .or_else(|| finite("velocity [m/s]", v.row().as_ref()))
        .or_else(|| finite("density [kg/m3]", &[rho]))
        .or_else(|| finite("deviatoric stress [Pa]", s.row().as_ref()));
    if not_finite.is_some() {
        return not_finite;
    }
    let wave_speed = body.material.longitudinal_speed();
    if v.norm() > wave_speed {
        return Some(BrokenLimit {
            quantity: "speed [m/s]",
            value: v.norm(),
            allowed: format!("at most the longitudinal wave speed {wave_speed:.4e} m/s"),
            hint: SHORTER_STEP,
        });
    }
    if body.formulation.is_rigid() {
        return None;
    }
    let limits = body.formulation.limits();
    let ratio = rho / body.material.density;
    let (smallest, largest) = limits.density_ratios;
    if !(smallest..=largest).contains(&ratio) {
        return Some(BrokenLimit {
            quantity: "density over rest density [-]",
            value: ratio,
            allowed: format!("{smallest} to {largest}"),
            hint: "the body is torn or crushed beyond what the elastic law can mean: reduce the load or the time step",
        });
    }
    let shear = S::squared_deviator(&s).sqrt() / (2.0 * body.material.shear_modulus);
    (shear > limits.largest_shear).then(|| BrokenLimit {
        quantity: "elastic shear strain sqrt(s:s)/(2G) [-]",
        value: shear,
        allowed: format!("at most {}", limits.largest_shear),
        hint: "the body is deformed beyond what the elastic law can mean: reduce the load or the time step",
    })
}

impl BrokenLimit {
    fn divergence<S: SolidSpace>(
        self,
        model: &SolidModel<S>,
        particles: &Particles<S>,
        i: usize,
        at: StepStage,
    ) -> Box<Divergence> {
        Box::new(Divergence {
            at,
            particle: Some(model.particles.id[i]),
            position: Some(particles.position[i].row().as_ref().to_vec()),
            quantity: format!("{} of body `{}`", self.quantity, model.body_of(i).name),
            value: self.value,
            allowed: self.allowed,
            hint: self.hint.into(),
        })
    }
}
