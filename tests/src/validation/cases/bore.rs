//! A breaking bore that a piston drives over a wet bed, against the Rankine-Hugoniot relations of shallow water.

use crate::validation::{Case, Figure, Goal, Member, Plot, Run, series};

/// See the module.
pub struct Bore;

/// Depth ahead of the bore \[m\], speed of the piston \[m/s\] and its travel while it speeds up \[m\].
const DEPTH: f64 = 0.1;
const PISTON: f64 = 0.6987;
const GRAVITY: f64 = 9.81;
/// Gauges: probe and place \[m\]. Before them the bore still steepens and its first crest plunges.
const GAUGES: [(&str, f64); 4] = [("x28", 2.8), ("x34", 3.4), ("x40", 4.0), ("x46", 4.6)];

impl Case for Bore {
    fn name(&self) -> &'static str {
        "bore"
    }

    fn about(&self) -> &'static str {
        "piston-made breaking bore: speed and depth behind it against Rankine-Hugoniot"
    }

    fn members(&self) -> Vec<Member> {
        vec![Member::new("bore", 0.02), Member::new("bore", 0.01)]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let (speed, depth) = rankine_hugoniot();
        let arrivals = arrivals(run, depth)?;
        let (_, slowness) = series::line(&arrivals);
        // The goals are asked for at ten particles over the depth or more.
        let judged = |name: &str, value, reference| {
            let figure = Figure::compared(name, value, reference, 0.05);
            if run.member.spacing > 0.0101 { figure.report_only() } else { figure }
        };
        Ok(vec![
            judged("speed of the bore [m/s]", 1.0 / slowness, speed),
            judged("mean depth behind it [m]", depth_behind(run, speed)?, depth),
            Figure::judged("particles lost", run.lost(), Goal::AtMost(0.0)),
        ])
    }

    fn plots(&self, runs: &[Run]) -> Result<Vec<Plot>, String> {
        let mut plot = Plot::new("levels", "t [s]", "water level [m]");
        for run in runs {
            for (probe, x) in GAUGES {
                let name = format!("x = {x} m, {} m", run.member.spacing);
                plot.line(name, run.history(&format!("{probe}_level_m"))?);
            }
        }
        Ok(vec![plot])
    }
}

/// Speed \[m/s\] of the bore and depth \[m\] behind it.
///
/// ```text
/// (S − V) d₂ = S d₁,  S² = g d₂ (d₁ + d₂)/(2 d₁)
/// ```
fn rankine_hugoniot() -> (f64, f64) {
    let speed = |depth: f64| (GRAVITY * depth * (DEPTH + depth) / (2.0 * DEPTH)).sqrt();
    let (mut low, mut high) = (DEPTH, 10.0 * DEPTH);
    for _ in 0..80 {
        let depth = 0.5 * (low + high);
        if speed(depth) * (1.0 - DEPTH / depth) < PISTON { low = depth } else { high = depth }
    }
    (speed(low), low)
}

/// Place \[m\] and time \[s\] at which the level first stands half-way between both depths.
fn arrivals(run: &Run, depth: f64) -> Result<Vec<(f64, f64)>, String> {
    let level = 0.5 * (DEPTH + depth);
    GAUGES
        .into_iter()
        .map(|(probe, x)| Ok((x, series::first_reach(&run.history(&format!("{probe}_level_m"))?, level))))
        .collect()
}

/// Mean depth \[m\] at the end between a water depth before the piston and six depths behind the bore.
fn depth_behind(run: &Run, speed: f64) -> Result<f64, String> {
    let state = run.final_fluid()?;
    let field = |name: &str| state.field(name).ok_or_else(|| format!("no field `{name}`"));
    let (position, mass, density) = (field("position")?, field("mass")?, field("density")?);
    let piston = PISTON * (state.time - 0.15);
    let arrivals = arrivals(run, rankine_hugoniot().1)?;
    let passed = arrivals.iter().rfind(|a| a.1.is_finite()).ok_or("the bore reached no gauge")?;
    let bore = passed.0 + speed * (state.time - passed.1);
    let range = piston + DEPTH..bore - 6.0 * DEPTH;
    let volume: f64 = (0..state.group.len())
        .filter(|i| state.group[*i] == 0 && range.contains(&position.values[2 * i]))
        .map(|i| mass.values[i] / density.values[i])
        .sum();
    Ok(volume / (range.end - range.start))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bore_of_the_case_file_is_that_of_the_relations() {
        let (speed, depth) = rankine_hugoniot();
        // The case file rounds to four digits.
        assert!((depth - 0.18).abs() < 1e-4 && (speed - 1.572).abs() < 1e-3, "{speed} {depth}");
    }
}
