//! What several cases in space need.

use crate::validation::{Figure, Run};

/// The columns `<name>_x_<unit>`, `_y_` and `_z_` of the probes as vectors, one per row.
pub fn vectors(run: &Run, name: &str, unit: &str) -> Result<Vec<[f64; 3]>, String> {
    let column = |axis: &str| run.column(&format!("{name}_{axis}_{unit}"));
    let (x, y, z) = (column("x")?, column("y")?, column("z")?);
    Ok(x.into_iter().zip(y).zip(z).map(|((x, y), z)| [x, y, z]).collect())
}

/// Length of a vector.
pub fn norm(vector: [f64; 3]) -> f64 {
    dot(vector, vector).sqrt()
}

/// Scalar product.
pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Kinetic and strain energy of `probe` over time \[J\].
pub fn energy(run: &Run, probe: &str) -> Result<Vec<f64>, String> {
    let column = |kind: &str| run.column(&format!("{probe}_{kind}_energy_j"));
    Ok(column("kinetic")?.iter().zip(column("strain")?).map(|(kinetic, strain)| kinetic + strain).collect())
}

/// An angle that is known up to whole turns \[rad\], made continuous.
pub fn unwrapped(angles: impl IntoIterator<Item = f64>) -> Vec<f64> {
    let mut found: Vec<f64> = Vec::new();
    for angle in angles {
        let before = found.last().copied().unwrap_or(angle);
        found.push(angle + std::f64::consts::TAU * ((before - angle) / std::f64::consts::TAU).round());
    }
    found
}

/// `figure` judged where `judged` says so, else only reported.
pub fn judged_if(judged: bool, figure: Figure) -> Figure {
    if judged { figure } else { figure.report_only() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_of_an_angle_add_up() {
        let turning = (0..100).map(|k| f64::from(k) * 0.5);
        let known = turning.clone().map(|angle| angle.sin().atan2(angle.cos()));
        for (found, angle) in unwrapped(known).into_iter().zip(turning) {
            assert!((found - angle).abs() < 1e-9, "{found} {angle}");
        }
    }
}
