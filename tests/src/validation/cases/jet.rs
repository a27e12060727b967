//! The force of a steady jet on a plate.

use crate::validation::{Case, Figure, Goal, Member, Plot, Run, series};

/// See the module.
pub struct Jet;

/// ρ U² b \[N/m\].
const FORCE: f64 = 1000.0 * 0.1;

/// From when on the flow is steady at the plate, and until when water arrives \[s\].
const STEADY: (f64, f64) = (0.3, 0.8);

impl Case for Jet {
    fn name(&self) -> &'static str {
        "jet"
    }

    fn about(&self) -> &'static str {
        "mean force of a steady jet on a plate against the momentum that it brings"
    }

    fn members(&self) -> Vec<Member> {
        vec![Member::new("jet", 0.01).quick(), Member::new("jet", 0.005), Member::new("jet", 0.0025)]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let force = run.history("plate_force_x_n_per_m")?;
        let (start, end) = (STEADY.0, STEADY.1.min(run.number("time.end_time_s")?));
        let mean = series::mean(&force, start, end);
        let squares = series::window(&force, start, end).into_iter().map(|(_, f)| (f - mean).powi(2));
        let count = series::window(&force, start, end).len() as f64;
        let swing = (squares.sum::<f64>() / count).sqrt();
        let kinetic = run.column("water_kinetic_energy_j_per_m")?;
        let compression = run.column("water_compression_energy_j_per_m")?;
        let energy: Vec<f64> =
            kinetic.iter().zip(compression).map(|(kinetic, stored)| kinetic + stored).collect();
        Ok(vec![
            Figure::compared("mean force on the plate [N/m]", mean, FORCE, 0.03),
            Figure::reported("standard deviation of the force over its mean", swing / mean),
            Figure::judged(
                "rise of the energy over the start",
                series::largest_rise(&energy) / energy[0],
                Goal::AtMost(0.002),
            ),
            Figure::judged("particles lost", run.lost(), Goal::AtMost(0.0)),
        ])
    }

    fn plots(&self, runs: &[Run]) -> Result<Vec<Plot>, String> {
        let mut plot = Plot::new("force", "t [s]", "force on the plate [N/m]");
        for run in runs {
            plot.line(run.member.label(), run.history("plate_force_x_n_per_m")?);
        }
        Ok(vec![plot])
    }
}
