//! Steady flow between two cylinders that turn against each other.

use sph::space::Vector;

use super::confined::kept;
use crate::validation::snapshot::Snapshot;
use crate::validation::{Case, Figure, Goal, Member, Plot, Run};

/// Water between two cylinders that turn against each other, full and under pressure.
pub struct CircularCouette;

/// Radii of the faces \[m\].
const INNER: f64 = 0.2;
const OUTER: f64 = 0.4;

/// Exact velocity about the axis \[m/s\] at distance r \[m\] from it: inner face at 5 rad/s, outer face at −1 rad/s.
fn exact(r: f64) -> f64 {
    let (a, b) = (INNER * INNER, OUTER * OUTER);
    (-b - 5.0 * a) / (b - a) * r + 6.0 * a * b / (b - a) / r
}

impl Case for CircularCouette {
    fn name(&self) -> &'static str {
        "circular_couette"
    }

    fn about(&self) -> &'static str {
        "steady flow between two cylinders that turn against each other against the exact profile; pressure kept"
    }

    fn members(&self) -> Vec<Member> {
        let body = |spacing: f64| {
            Member::new("circular_couette_body", spacing)
                .with("solid.particle_spacing_m", spacing)
                .scheme("a body inside")
        };
        vec![
            Member::new("circular_couette", 0.01).quick(),
            Member::new("circular_couette", 0.005),
            body(0.01),
            body(0.005),
        ]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let profile = profile(run)?;
        let worst = profile.iter().map(|(r, v)| (v - exact(*r)).abs()).fold(0.0, f64::max);
        let n = profile.len() as f64;
        let square: f64 = profile.iter().map(|(r, v)| (v - exact(*r)).powi(2)).sum();
        let area = std::f64::consts::PI * (OUTER * OUTER - INNER * INNER);
        let mut figures = vec![
            // As for plane Couette flow.
            Figure::judged("largest error of the profile [m/s of 1 m/s]", worst, Goal::AtMost(0.01)),
            Figure::reported("rms error of the profile [m/s of 1 m/s]", (square / n).sqrt()),
        ];
        let mut kept = kept(run, 1000.0, area)?;
        if run.member.spacing > 0.008 {
            // Water that leaves its layers fills the curved space a little better: 4.1e-4.
            kept[0] = kept[0].clone().report_only();
        }
        figures.extend(kept);
        Ok(figures)
    }

    fn plots(&self, runs: &[Run]) -> Result<Vec<Plot>, String> {
        let mut plot = Plot::new("profile", "r [m]", "velocity [m/s]");
        let radii = (0..=40).map(|k| INNER + (OUTER - INNER) * f64::from(k) / 40.0);
        plot.line("exact", radii.map(|r| (r, exact(r))).collect());
        for run in runs {
            plot.points(format!("{} {} m", run.member.scheme, run.member.spacing), profile(run)?);
        }
        Ok(vec![plot])
    }
}

/// Mean distance from the axis and mean velocity about it of the particles in rings one spacing wide, at the end.
fn profile(run: &Run) -> Result<Vec<(f64, f64)>, String> {
    let snapshots = run.fluid_snapshots()?;
    let (_, path) = snapshots.last().ok_or("no snapshot")?;
    let water = Snapshot::read(path, 1)?;
    let spacing = run.member.spacing;
    let mut rings: Vec<(f64, f64, f64)> = vec![(0.0, 0.0, 0.0); ((OUTER - INNER) / spacing).round() as usize];
    let last = rings.len() - 1;
    for (x, v) in water.position.iter().zip(&water.velocity) {
        let r = x.norm();
        let about = Vector::new(-x.y, x.x).dot(v) / r;
        // Distances below the inner face saturate to the first ring.
        let ring = &mut rings[(((r - INNER) / spacing) as usize).min(last)];
        *ring = (ring.0 + 1.0, ring.1 + r, ring.2 + about);
    }
    Ok(rings.iter().filter(|ring| ring.0 > 0.0).map(|ring| (ring.1 / ring.0, ring.2 / ring.0)).collect())
}
