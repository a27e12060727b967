//! Time-step limits of both solvers and what to use of them.
//!
//! Formulas of solids and fractions stand here only; the solvers state the same limits while they run.

/// Viscous limit h²/(8ν) \[s\] (Morris, Fox & Zhu 1997), ν the kinematic viscosity \[m²/s\].
pub fn viscous(smoothing_length: f64, kinematic_viscosity: f64) -> f64 {
    smoothing_length * smoothing_length / (8.0 * kinematic_viscosity)
}

/// Elastic limit h/c_L \[s\] of a solid of smoothing length h \[m\] and longitudinal wave speed c_L \[m/s\].
pub fn elastic(smoothing_length: f64, longitudinal_speed: f64) -> f64 {
    smoothing_length / longitudinal_speed
}

/// Limit Δx/c_L \[s\] of a velocity-Verlet sub-step of a total-Lagrangian solid.
///
/// 2/ω of the stiffest lattice mode; between 0.97 and 1.05 of Δx/c_L for kernel ratios 0.72 to 0.9 and hourglass
/// coefficients up to 0.5. The solver states the exact value.
pub fn reference_elastic(particle_spacing: f64, longitudinal_speed: f64) -> f64 {
    particle_spacing / longitudinal_speed
}

/// Limit of linear damping of rate k, 1/k \[s\].
pub fn damping(rate: f64) -> f64 {
    1.0 / rate
}

/// Fraction of the acoustic limit of a fluid to use.
pub const RECOMMENDED_ACOUSTIC_FRACTION: f64 = 0.8;

/// Fraction of the elastic limit to use: A = 1 ran at 1.2 of it, A = 0.1 at 0.5 and not at 0.85.
pub fn recommended_elastic_fraction(viscosity_a: f64) -> f64 {
    if viscosity_a >= 0.5 { 0.8 } else { 0.5 }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_of_the_drifting_body_at_2_mm() {
        // c_L = √((20 + 4/3 · 4.27) MPa / 1100 kg/m³) = 152.83 m/s, h = 1.3 · 2 mm.
        let speed = ((20e6 + 4.0 / 3.0 * 4.27e6) / 1100.0_f64).sqrt();
        assert!((elastic(0.0026, speed) - 1.7012e-5).abs() < 1e-9);
        // Water at 2.4 mm: far from mattering.
        assert!((viscous(0.0024, 1e-6) - 0.72).abs() < 1e-9);
    }
}
