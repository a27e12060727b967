//! The largest stable time step.

use crate::system::model::FluidModel;

/// Factor on √(h/|a|) \[-\].
const ACCELERATION_FACTOR: f64 = 0.25;

/// Factor on h²/ν \[-\].
const VISCOUS_FACTOR: f64 = 0.125;

/// Largest stable step \[s\] of `model` for the given largest speed \[m/s\] and acceleration \[m/s²\].
///
/// ```text
/// min( acoustic limit,  ¼ √(h/|a|),  ⅛ h²/ν )
/// ```
/// with [`sph::setup::FluidParameters::acoustic_limit`].
pub fn time_step_limit(model: &FluidModel, speed: f64, acceleration: f64) -> f64 {
    let (c, h) = (&model.constants, model.constants.smoothing_length());
    let mut limit = c.acoustic_limit(speed);
    if acceleration > 0.0 {
        limit = limit.min(ACCELERATION_FACTOR * (h / acceleration).sqrt());
    }
    if c.dynamic_viscosity > 0.0 {
        limit = limit.min(VISCOUS_FACTOR * h * h * c.rest_density / c.dynamic_viscosity);
    }
    limit
}
