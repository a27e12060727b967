//! Rotation of a square patch of fluid: invariants, lattice order and voids under negative pressure.

use crate::validation::particles::{domain_around, smallest_distance, surrounded, widest_gap};
use crate::validation::snapshot::Snapshot;
use crate::validation::{Case, Figure, Goal, Member, Plot, Run, energy, series};

/// See the module.
pub struct SquarePatch;

impl Case for SquarePatch {
    fn name(&self) -> &'static str {
        "square_patch"
    }

    fn about(&self) -> &'static str {
        "rotating square patch to t omega = 2: no voids or clumps, angular momentum, energy, symmetry"
    }

    fn members(&self) -> Vec<Member> {
        vec![Member::new("square_patch", 0.02).quick(), Member::new("square_patch", 0.01)]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let spacing = run.member.spacing;
        let (mut closest, mut gap) = (f64::INFINITY, 0.0_f64);
        for (_, path) in run.fluid_snapshots()? {
            let positions = Snapshot::read(&path, 1)?.position;
            let domain = domain_around(&positions, 2.0 * spacing);
            closest = closest.min(smallest_distance(&domain, &positions, spacing));
            gap = gap.max(widest_gap(&domain, &positions, spacing, surrounded(&positions, spacing)));
        }
        let column = |name: &str| run.column(&format!("patch_{name}"));
        let drift = |values: &[f64]| series::largest(values.iter().map(|v| (v / values[0] - 1.0).abs()));
        let kinetic = column("kinetic_energy_j_per_m")?;
        let end = |values: &[f64]| values.last().copied().unwrap_or(f64::NAN);
        let (xx, yy) = (end(&column("second_moment_xx_m2")?), end(&column("second_moment_yy_m2")?));
        // Of a turned square both are equal, and the mixed one is zero by the symmetry of a quarter turn.
        let mixed = end(&column("second_moment_xy_m2")?) / xx;
        Ok(vec![
            Figure::judged("widest gap over spacing", gap / spacing, Goal::AtMost(2.0)),
            Figure::judged("closest pair over spacing", closest / spacing, Goal::AtLeast(0.5)),
            Figure::judged(
                "largest drift of angular momentum",
                drift(&column("angular_momentum_kg_m_per_s")?),
                Goal::AtMost(0.005),
            ),
            Figure::judged(
                "loss of kinetic energy",
                1.0 - end(&kinetic) / kinetic[0],
                Goal::Between(-0.002, 0.05),
            ),
            Figure::compared("second moment xx over yy", xx / yy, 1.0, 0.01),
            Figure::judged("second moment |xy| over xx", mixed.abs(), Goal::AtMost(0.01)),
            energy::rise(run, "patch")?,
        ])
    }

    fn plots(&self, runs: &[Run]) -> Result<Vec<Plot>, String> {
        let mut plot = Plot::new("invariants", "t [s]", "over that of the start");
        for run in runs {
            for name in ["kinetic_energy_j_per_m", "angular_momentum_kg_m_per_s"] {
                let history = run.history(&format!("patch_{name}"))?;
                let start = series::at(&history, 0.0);
                let line = history.into_iter().map(|(t, value)| (t, value / start)).collect();
                plot.line(format!("{name} {} m", run.member.spacing), line);
            }
        }
        Ok(vec![plot])
    }
}
