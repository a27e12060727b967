//! Stretching of a free drop (Monaghan 1994) against the exact ordinary differential equation.

use coordinator::family::convergence::order_of_errors;
use coordinator::study::references::drop_semi_axes;

use crate::validation::{Case, Figure, Goal, Member, Plot, Run, series};

/// See the module.
pub struct Drop;

const PROBE: &str = "drop";

impl Case for Drop {
    fn name(&self) -> &'static str {
        "drop"
    }

    fn about(&self) -> &'static str {
        "semi-axes of a free elliptic drop at 0.0076 s against the exact solution"
    }

    fn members(&self) -> Vec<Member> {
        vec![Member::new("drop", 0.05).quick(), Member::new("drop", 0.025), Member::new("drop", 0.0125)]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let end = *run.column("t_s")?.last().ok_or("no probe row")?;
        let [short, long] = drop_semi_axes(end);
        let moment = |axis: &str| -> Result<f64, String> {
            let column = run.column(&format!("{PROBE}_second_moment_{axis}_m2"))?;
            // The second moment of an ellipse along a semi-axis a is a²/4.
            Ok(2.0 * column.last().copied().unwrap_or(f64::NAN).sqrt())
        };
        let (a, b) = (moment("xx")?, moment("yy")?);
        let kinetic = run.column(&format!("{PROBE}_kinetic_energy_j_per_m"))?;
        let energy = |k: usize| kinetic.get(k).copied().unwrap_or(f64::NAN);
        Ok(vec![
            Figure::compared(
                "short semi-axis [m]",
                a,
                short,
                if run.member.spacing > 0.025 { 0.02 } else { 0.01 },
            ),
            Figure::compared(
                "long semi-axis [m]",
                b,
                long,
                if run.member.spacing > 0.025 { 0.02 } else { 0.01 },
            ),
            Figure::compared(
                "area over that of the circle",
                a * b,
                1.0,
                if run.member.spacing > 0.025 { 0.01 } else { 0.005 },
            ),
            Figure::compared("kinetic energy [J/m]", energy(kinetic.len() - 1), energy(0), 0.1).report_only(),
            Figure::judged("particles lost", run.lost(), Goal::AtMost(0.0)),
        ])
    }

    fn comparison(&self, runs: &[Run]) -> Result<Vec<Figure>, String> {
        let [first, .., last] = runs else { return Ok(Vec::new()) };
        // Of the drop as the lattice makes it: its edge has steps, so that its axes miss those of the circle at first
        // by some tenths of a percent, up or down as the spacing happens to fall.
        let error = |run: &Run| -> Result<f64, String> {
            let moment = run.history(&format!("{PROBE}_second_moment_yy_m2"))?;
            let ends = moment.first().zip(moment.last()).ok_or("no probe row")?;
            let ((_, start), (end, moment)) = ends;
            Ok((moment / start).sqrt() / drop_semi_axes(*end)[1] - 1.0)
        };
        let (coarse, fine) = ((first.member.spacing, error(first)?), (last.member.spacing, error(last)?));
        let order = order_of_errors(coarse, fine).unwrap_or(f64::NAN);
        Ok(vec![Figure::judged(
            "observed order of the long semi-axis over that of the start",
            order,
            Goal::AtLeast(0.8),
        )])
    }

    fn plots(&self, runs: &[Run]) -> Result<Vec<Plot>, String> {
        let mut plot = Plot::new("axes", "t [s]", "semi-axis [m]");
        let times: Vec<f64> = (0..=38).map(|k| 2e-4 * f64::from(k)).collect();
        for axis in [0, 1] {
            plot.points("exact", times.iter().map(|t| (*t, drop_semi_axes(*t)[axis])).collect());
        }
        for run in runs {
            for axis in ["xx", "yy"] {
                let history = run.history(&format!("{PROBE}_second_moment_{axis}_m2"))?;
                let name = format!("{} m, {axis}", run.member.spacing);
                plot.line(name, history.into_iter().map(|(t, m)| (t, 2.0 * m.sqrt())).collect());
            }
        }
        let mut energy = Plot::new("energy", "t [s]", "kinetic energy over that of the start");
        for run in runs {
            let history = run.history(&format!("{PROBE}_kinetic_energy_j_per_m"))?;
            let start = series::at(&history, 0.0);
            energy.line(
                format!("{} m", run.member.spacing),
                history.into_iter().map(|(t, e)| (t, e / start)).collect(),
            );
        }
        Ok(vec![plot, energy])
    }
}
