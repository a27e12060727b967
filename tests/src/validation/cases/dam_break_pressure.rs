//! Pressure on the far wall of a dam break (Buchner 2002).

use crate::validation::{Case, Figure, Goal, Member, Plot, Run, series};

/// See the module.
pub struct DamBreakPressure;

/// Depth of the column \[m\] and ρ g H \[Pa\].
const DEPTH: f64 = 0.6;
const SCALE: f64 = 1000.0 * 9.81 * DEPTH;

impl Case for DamBreakPressure {
    fn name(&self) -> &'static str {
        "dam_break_pressure"
    }

    fn about(&self) -> &'static str {
        "pressure on the far wall of a dam break, mean over 4 < t sqrt(g/H) < 5, against Buchner"
    }

    fn members(&self) -> Vec<Member> {
        vec![Member::new("dam_break_pressure", 0.02), Member::new("dam_break_pressure", 0.01)]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let mean = |probe| -> Result<f64, String> { Ok(series::mean(&history(run, probe)?, 4.0, 5.0)) };
        // Asked for at H/dx of 60 or more.
        let goal = if run.member.spacing > 0.0101 { Goal::None } else { Goal::Between(0.46, 0.62) };
        Ok(vec![
            Figure::judged("mean p/(rho g H) at 0.2 H", mean("at_02")?, goal),
            Figure::reported("mean p/(rho g H) at 0.267 H", mean("at_0267")?),
            Figure::judged("particles lost", run.lost(), Goal::AtMost(0.0)),
        ])
    }

    fn plots(&self, runs: &[Run]) -> Result<Vec<Plot>, String> {
        let mut plot = Plot::new("pressure", "t sqrt(g/H)", "p/(rho g H)");
        for run in runs {
            for (probe, name) in [("at_02", "0.2 H"), ("at_0267", "0.267 H")] {
                plot.line(format!("{name}, {} m", run.member.spacing), history(run, probe)?);
            }
        }
        Ok(vec![plot])
    }
}

/// p/(ρ g H) of a probe over t √(g/H).
fn history(run: &Run, probe: &str) -> Result<Vec<(f64, f64)>, String> {
    let scale = f64::sqrt(9.81 / DEPTH);
    Ok(run
        .history(&format!("{probe}_pressure_pa"))?
        .into_iter()
        .map(|(t, p)| (t * scale, p / SCALE))
        .collect())
}
