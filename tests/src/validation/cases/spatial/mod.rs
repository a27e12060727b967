//! Cases in space, one file per subject.

mod bars;
mod bodies;
mod channel;
mod dam_break_box;
mod debris;
mod drop;
mod rotation;
mod twisting;
mod vortex;
mod water;

use super::super::{Figure, Run};

pub use bars::{Cantilever3d, TorsionRod};
pub use bodies::{FallingSphere, Floating3d, HydrostaticPlate3d};
pub use channel::{DuctFlow, PipeFlow};
pub use dam_break_box::DamBreakBox;
pub use debris::Debris3d;
pub use drop::Drop3d;
pub use rotation::{HeavyTop, SpinningCube};
pub use twisting::TwistingColumn;
pub use vortex::TaylorGreen3d;
pub use water::{SlabDamBreak, StandingWave3d, StillWater3d};

/// The columns `<name>_x_<unit>`, `_y_` and `_z_` of the probes as vectors, one per row.
fn vectors(run: &Run, name: &str, unit: &str) -> Result<Vec<[f64; 3]>, String> {
    let column = |axis: &str| run.column(&format!("{name}_{axis}_{unit}"));
    let (x, y, z) = (column("x")?, column("y")?, column("z")?);
    Ok(x.into_iter().zip(y).zip(z).map(|((x, y), z)| [x, y, z]).collect())
}

/// Length of a vector.
fn norm(vector: [f64; 3]) -> f64 {
    dot(vector, vector).sqrt()
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Kinetic and strain energy of `probe` over time \[J\].
fn energy(run: &Run, probe: &str) -> Result<Vec<f64>, String> {
    let column = |kind: &str| run.column(&format!("{probe}_{kind}_energy_j"));
    Ok(column("kinetic")?.iter().zip(column("strain")?).map(|(kinetic, strain)| kinetic + strain).collect())
}

/// An angle that is known up to whole turns \[rad\], made continuous.
fn unwrapped(angles: impl IntoIterator<Item = f64>) -> Vec<f64> {
    let mut found: Vec<f64> = Vec::new();
    for angle in angles {
        let before = found.last().copied().unwrap_or(angle);
        found.push(angle + std::f64::consts::TAU * ((before - angle) / std::f64::consts::TAU).round());
    }
    found
}

/// `figure` judged where `judged` says so, else only reported.
fn judged_if(judged: bool, figure: Figure) -> Figure {
    if judged { figure } else { figure.report_only() }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::path::Path;

    use super::*;
    use crate::validation::{Case, template};

    #[test]
    fn solvers_accept_the_coarsest_member_of_every_scheme() {
        let cases: [&dyn Case; 10] = [
            &Cantilever3d,
            &TorsionRod,
            &SpinningCube,
            &HeavyTop,
            &TwistingColumn,
            &PipeFlow,
            &FallingSphere,
            &Floating3d,
            &HydrostaticPlate3d,
            &Debris3d,
        ];
        let mut seen = BTreeSet::new();
        for member in cases.iter().flat_map(|case| case.members()) {
            if !seen.insert((member.file, member.scheme)) {
                continue;
            }
            let path = template::folder().join(member.file).with_extension("toml");
            let text = template::instantiate(&path, &member.changes).unwrap();
            let none = |path: &Path| Err(format!("no state: {}", path.display()));
            let accepted = coordinator::case::parse(&text, member.file, &template::folder(), &none)
                .map_err(|errors| errors.to_string())
                .and_then(|case| coordinator::check::open(&case).map_err(|failure| failure.message));
            assert!(accepted.is_ok(), "{}: {}", member.label(), accepted.err().unwrap_or_default());
        }
    }

    #[test]
    fn turns_of_an_angle_add_up() {
        let turning = (0..100).map(|k| f64::from(k) * 0.5);
        let known = turning.clone().map(|angle| angle.sin().atan2(angle.cos()));
        for (found, angle) in unwrapped(known).into_iter().zip(turning) {
            assert!((found - angle).abs() < 1e-9, "{found} {angle}");
        }
    }
}
