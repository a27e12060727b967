//! What the cases with known answers are compared with, and how the same is read off a run; shared with `validate`.

use std::f64::consts::{PI, TAU};

use super::series;

/// Reynolds number UL/ν of the Taylor-Green case.
pub const TAYLOR_GREEN_REYNOLDS: f64 = 100.0;

/// Exact rate at which ln of the kinetic energy of the Taylor-Green vortices falls \[1/s\]: twice that of the velocity,
/// −8π²/Re.
pub fn taylor_green_slope() -> f64 {
    -16.0 * PI * PI / TAYLOR_GREEN_REYNOLDS
}

/// The same as measured: slope \[1/s\] of ln of the kinetic energy \[J/m\] over time \[s\] from 0.2 to 1.5 s.
pub fn slope_of_logarithm(kinetic_energy: &[(f64, f64)]) -> f64 {
    let logarithms: Vec<(f64, f64)> = kinetic_energy.iter().map(|(t, e)| (*t, e.ln())).collect();
    series::line(&series::window(&logarithms, 0.2, 1.5)).1
}

/// Period of the cantilever of Gray, Monaghan & Swift (2001) by plane finite elements, clamped at its root \[s\].
pub const CANTILEVER_PERIOD: f64 = 0.2551;

/// Damping rate \[1/s\] and period \[s\] of a swinging tip.
pub fn swing(tip: &[(f64, f64)]) -> (f64, f64) {
    let (_, rate, omega) = series::damped_oscillation(tip, (0.0, TAU / series::mean_period(tip)));
    (rate, TAU / omega)
}

/// Exact linear decay rate \[1/s\] and period \[s\] of the standing wave at Re = 250 with a free-slip bottom, g = H = 1:
/// s² + g k T (1−S) + 2νk²s − 2νkmSsT coth(mH) = 0, m² = k² + s/ν, S = 2k²/(m²+k²), T = tanh kH.
pub const STANDING_WAVE: (f64, f64) = (0.070_554_629_2, 3.568_104_29);

/// Rate of strain of the drop at its start \[1/s\].
const DROP_STRAIN_RATE: f64 = 100.0;

/// Semi-axes along x and y \[m\] at `time` \[s\] of the drop that starts as the unit circle with v = A₀ (−x, y).
///
/// ```text
/// dA/dt = A² (b² − a²)/(a² + b²),  da/dt = A a,  db/dt = −A b,  v = A (x, −y);  A(0) = −A₀
/// ```
pub fn drop_semi_axes(time: f64) -> [f64; 2] {
    semi_axes(-DROP_STRAIN_RATE, 0.0, time)
}

/// Semi-axes along x and y \[m\] at `time` \[s\] of the unit circle that starts with v = A₀ (x, −y), A₀ = `strain_rate`
/// \[1/s\], under a central acceleration −Ω² x, Ω = `frequency` \[1/s\].
///
/// ```text
/// dA/dt = (A² + Ω²) (b² − a²)/(a² + b²),  da/dt = A a,  db/dt = −A b        Monaghan & Rafiee 2013
/// ```
/// From the momentum along both axes with p/ρ = K (1 − x²/a² − y²/b²): A' + A² + Ω² = 2K/a², −A' + A² + Ω² = 2K/b².
pub fn oscillating_drop_semi_axes(strain_rate: f64, frequency: f64, time: f64) -> [f64; 2] {
    semi_axes(strain_rate, frequency, time)
}

fn semi_axes(strain_rate: f64, frequency: f64, time: f64) -> [f64; 2] {
    let rate = |[strain, a, b]: [f64; 3]| {
        let (a2, b2) = (a * a, b * b);
        [(strain * strain + frequency * frequency) * (b2 - a2) / (a2 + b2), strain * a, -strain * b]
    };
    let steps = 2000;
    let dt = time / f64::from(steps);
    let mut state = [strain_rate, 1.0, 1.0];
    let moved = |state: [f64; 3], rate: [f64; 3], by: f64| std::array::from_fn(|k| state[k] + by * rate[k]);
    for _ in 0..steps {
        // Runge-Kutta of fourth order.
        let k1 = rate(state);
        let k2 = rate(moved(state, k1, 0.5 * dt));
        let k3 = rate(moved(state, k2, 0.5 * dt));
        let k4 = rate(moved(state, k3, dt));
        state = std::array::from_fn(|k| state[k] + dt / 6.0 * (k1[k] + 2.0 * k2[k] + 2.0 * k3[k] + k4[k]));
    }
    [state[1], state[2]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exact_drop_keeps_its_area_and_its_known_end() {
        let [a, b] = drop_semi_axes(0.0076);
        // The solution conserves a·b; the integrator has an error far below 1e-10 at these steps.
        assert!((a * b - 1.0).abs() < 1e-10, "{a} {b}");
        // Known semi-axes at A₀t = 0.8: about 0.500 and 2.000.
        let [a, b] = drop_semi_axes(0.008);
        assert!((a - 0.5).abs() < 0.01 && (b - 2.0).abs() < 0.04, "{a} {b}");
    }

    #[test]
    fn the_drop_under_a_central_force_swings_with_its_known_period() {
        // For small amplitudes a'' = −2 Ω² (a − 1): the period is √2 π/Ω.
        let quarter = std::f64::consts::SQRT_2 * PI / (4.0 * 3.0);
        let [a, b] = oscillating_drop_semi_axes(1e-4, 3.0, quarter);
        assert!(((a - 1.0) / (1e-4 / (3.0 * std::f64::consts::SQRT_2)) - 1.0).abs() < 1e-3, "{a}");
        assert!((a * b - 1.0).abs() < 1e-10, "{a} {b}");
        // At A₀ = Ω = 1/s the period is 4.827 s (Monaghan & Rafiee 2013).
        let [a, b] = oscillating_drop_semi_axes(1.0, 1.0, 4.827_343);
        assert!((a - 1.0).abs() < 1e-5 && (b - 1.0).abs() < 1e-5, "{a} {b}");
        let [before, after] = [4.82, 4.83].map(|time| oscillating_drop_semi_axes(1.0, 1.0, time)[0]);
        assert!(before < 1.0 && after > 1.0, "it passes the circle as at its start");
    }
}
