//! The Taylor-Green vortex in space.

use std::f64::consts::PI;

use crate::validation::{Case, Figure, Goal, Member, Plot, Run, series};

/// The Taylor-Green vortex against a spectral computation.
pub struct TaylorGreen3d;

/// Kinetic energy per mass over V² at times t V/L: pseudo-spectral computation with 64³ modes, good to 1e-4.
const SPECTRAL: [(f64, f64); 9] = [
    (0.0, 0.125),
    (1.0, 0.11748),
    (2.0, 0.10905),
    (3.0, 0.09879),
    (4.0, 0.08682),
    (5.0, 0.07396),
    (6.0, 0.06124),
    (8.0, 0.03997),
    (10.0, 0.0262),
];

impl TaylorGreen3d {
    /// Kinetic energy per mass over V² in time.
    fn energy(run: &Run) -> Result<Vec<(f64, f64)>, String> {
        let mass = (2.0 * PI).powi(3);
        Ok(run.history("water_kinetic_energy_j")?.into_iter().map(|(t, e)| (t, e / mass)).collect())
    }
}

impl Case for TaylorGreen3d {
    fn name(&self) -> &'static str {
        "taylor_green_3d"
    }

    fn about(&self) -> &'static str {
        "Taylor-Green vortex in space at Re 100 from a displaced lattice, against a spectral computation"
    }

    fn members(&self) -> Vec<Member> {
        let across = |n: f64| Member::new("taylor_green_3d", 2.0 * PI / n);
        vec![across(24.0), across(48.0), across(64.0)]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let energy = Self::energy(run)?;
        let errors = SPECTRAL.iter().map(|(t, e)| (series::at(&energy, *t) - e).abs() / SPECTRAL[0].1);
        let loss = |at: &dyn Fn(f64) -> f64| at(0.0) - at(5.0);
        let exact = |t: f64| SPECTRAL.iter().find(|(time, _)| *time == t).map_or(f64::NAN, |(_, e)| *e);
        let judged = |figure: Figure| {
            // The goals are asked for at 48 across.
            if run.member.spacing > 0.132 { figure.report_only() } else { figure }
        };
        let worst = errors.fold(0.0, f64::max);
        Ok(vec![
            judged(Figure::judged(
                "largest error of the kinetic energy over that of the start",
                worst,
                Goal::AtMost(0.02),
            )),
            judged(Figure::compared(
                "loss of kinetic energy per mass over t = 0 to 5 [m2/s2]",
                loss(&|t| series::at(&energy, t)),
                loss(&exact),
                0.05,
            )),
        ])
    }

    fn plots(&self, runs: &[Run]) -> Result<Vec<Plot>, String> {
        let mut plot = Plot::new("energy", "t V/L", "kinetic energy per mass over V^2");
        plot.points("spectral", SPECTRAL.to_vec());
        for run in runs {
            plot.line(format!("{:.0} across", 2.0 * PI / run.member.spacing), Self::energy(run)?);
        }
        Ok(vec![plot])
    }
}
