//! Decay of the Taylor-Green vortices in a periodic box against the exact Navier-Stokes solution.

use coordinator::study::references;
use sph::space::Vector;
use sph::space::domain::Domain;

use crate::validation::particles::smallest_distance;
use crate::validation::snapshot::Snapshot;
use crate::validation::{Case, Figure, Goal, Member, Plot, Run, series};

/// See the module.
pub struct TaylorGreen;

impl Case for TaylorGreen {
    fn name(&self) -> &'static str {
        "taylor_green"
    }

    fn about(&self) -> &'static str {
        "Taylor-Green vortices at Re 100 from a displaced lattice: slope of ln KE over 0.2 to 1.5 s"
    }

    fn members(&self) -> Vec<Member> {
        vec![Member::new("taylor_green", 0.02), Member::new("taylor_green", 0.01)]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let spacing = run.member.spacing;
        let history = run.history("water_kinetic_energy_j_per_m")?;
        let (slope, exact) = (references::slope_of_logarithm(&history), references::taylor_green_slope());
        let tolerance = if spacing > 0.015 { 0.02 } else { 0.01 };
        let domain = Domain { lower: Vector::zeros(), upper: Vector::repeat(1.0), periodic: [true, true] };
        let mut closest = f64::INFINITY;
        for (_, path) in run.fluid_snapshots()?.iter().skip(1) {
            let positions: Vec<Vector> =
                Snapshot::read(path, 1)?.position.iter().map(|x| domain.wrapped(x)).collect();
            closest = closest.min(smallest_distance(&domain, &positions, spacing));
        }
        Ok(vec![
            Figure::compared("slope of ln KE [1/s]", slope, exact, tolerance),
            Figure::judged("closest pair over spacing", closest / spacing, Goal::AtLeast(0.5)),
        ])
    }

    fn plots(&self, runs: &[Run]) -> Result<Vec<Plot>, String> {
        let mut plot = Plot::new("decay", "t [s]", "ln of kinetic energy over that of the start");
        let times = (0..=20).map(|k| 0.1 * f64::from(k));
        plot.points("exact", times.map(|t| (t, references::taylor_green_slope() * t)).collect());
        for run in runs {
            let history = run.history("water_kinetic_energy_j_per_m")?;
            let start = series::at(&history, 0.0);
            let line = history.into_iter().map(|(t, e)| (t, (e / start).ln())).collect();
            plot.line(format!("{} m", run.member.spacing), line);
        }
        Ok(vec![plot])
    }
}
