//! Time-step limits of a scene and what to use of them. Formulas of acoustic and elastic waves are the solvers' own
//! (`FluidParameters::acoustic_limit`, `solid::limits`).

/// Viscous limit h²/(8ν) \[s\] (Morris, Fox & Zhu 1997), ν the kinematic viscosity \[m²/s\].
pub fn viscous(smoothing_length: f64, kinematic_viscosity: f64) -> f64 {
    smoothing_length * smoothing_length / (8.0 * kinematic_viscosity)
}

/// Limit of linear damping of rate k, 1/k \[s\].
pub fn damping(rate: f64) -> f64 {
    1.0 / rate
}

/// Fraction of a limit by sound or elastic waves to use \[-\]: speeds and contacts grow after the start.
pub const RECOMMENDED_FRACTION: f64 = 0.8;

/// Fraction of the limit of total-Lagrangian sub-steps to use \[-\]; that limit has a margin of its own.
pub const RECOMMENDED_REFERENCE_FRACTION: f64 = 0.9;

/// Fraction of a limit by linear damping to use \[-\].
pub const RECOMMENDED_DAMPING_FRACTION: f64 = 0.5;

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn viscosity_of_water_at_2_mm_is_far_from_limiting() {
        assert!((viscous(0.0024, 1e-6) - 0.72).abs() < 1e-9);
    }
}
