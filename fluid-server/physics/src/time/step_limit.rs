//! The largest stable time step.

use crate::system::model::FluidModel;
use crate::system::packed_particle::FluidSpace;

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
    if c.dynamic_viscosity > 0.0 {
        limit = limit.min(S::VISCOUS_FACTOR * h * h * c.rest_density / c.dynamic_viscosity);
    }
    limit
}
