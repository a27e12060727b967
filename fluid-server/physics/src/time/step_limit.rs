//! The largest stable time step.

use sph::setup::FluidParameters;

use crate::system::model::FluidModel;
use crate::system::packed_particle::FluidSpace;
use crate::system::thresholds::Thresholds;

/// Largest stable step \[s\] of `model` for the given largest speed \[m/s\] and acceleration \[m/s²\].
///
/// ```text
/// min( acoustic limit,  ¼ √(h/|a|),  ⅛ h²/ν )
/// ```
/// with [`sph::setup::FluidParameters::acoustic_limit`].
pub fn time_step_limit<S: FluidSpace>(model: &FluidModel<S>, speed: f64, acceleration: f64) -> f64 {
    let (c, h) = (&model.constants, model.constants.smoothing_length());
    let mut limit = c.acoustic_limit(speed);
    if acceleration > 0.0 {
        limit = limit.min(S::ACCELERATION_FACTOR * (h / acceleration).sqrt());
    }
    limit.min(viscous_limit::<S>(c))
}

/// Largest step \[s\] by the viscosity, ⅛ h²/ν; infinite without it.
pub fn viscous_limit<S: Thresholds>(c: &FluidParameters) -> f64 {
    let h = c.smoothing_length();
    if c.dynamic_viscosity > 0.0 {
        S::VISCOUS_FACTOR * h * h * c.rest_density / c.dynamic_viscosity
    } else {
        f64::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use sph::space::Plane;

    use super::*;

    #[test]
    fn viscosity_of_water_at_2_mm_is_far_from_limiting() {
        let water = FluidParameters {
            particle_spacing: 0.002,
            kernel_ratio: 1.2,
            dynamic_viscosity: 1e-3,
            ..FluidParameters::PLAIN
        };
        assert!((viscous_limit::<Plane>(&water) - 0.72).abs() < 1e-9);
    }
}
