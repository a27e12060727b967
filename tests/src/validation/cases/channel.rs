//! Steady plane Couette and Poiseuille flow between no-slip walls.

use crate::validation::{Case, Figure, Goal, Member, Plot, Run};

/// A plane channel 1 m high with a largest speed of 1 m/s at Re = 10.
pub struct Channel {
    name: &'static str,
    about: &'static str,
    /// Exact velocity \[m/s\] at height y \[m\].
    exact: fn(f64) -> f64,
}

/// Driven by the upper wall.
pub static COUETTE: Channel = Channel {
    name: "couette",
    about: "steady plane Couette flow at Re 10 against the linear profile",
    exact: |y| y,
};

/// Driven by a body force.
pub static POISEUILLE: Channel = Channel {
    name: "poiseuille",
    about: "steady plane Poiseuille flow at Re 10 against the parabola",
    exact: |y| 4.0 * y * (1.0 - y),
};

impl Case for Channel {
    fn name(&self) -> &'static str {
        self.name
    }

    fn about(&self) -> &'static str {
        self.about
    }

    fn members(&self) -> Vec<Member> {
        vec![Member::new(self.name, 0.05).quick(), Member::new(self.name, 0.025)]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let profile = profile(run)?;
        let worst = profile.iter().map(|(y, v)| (v - (self.exact)(*y)).abs()).fold(0.0, f64::max);
        let n = profile.len() as f64;
        let square: f64 = profile.iter().map(|(y, v)| (v - (self.exact)(*y)).powi(2)).sum();
        let goal = if run.member.spacing > 0.03 { Goal::AtMost(0.02) } else { Goal::AtMost(0.01) };
        Ok(vec![
            Figure::judged("largest error of the profile [m/s of 1 m/s]", worst, goal),
            Figure::reported("rms error of the profile [m/s of 1 m/s]", (square / n).sqrt()),
            Figure::judged("particles lost", run.lost(), Goal::AtMost(0.0)),
        ])
    }

    fn plots(&self, runs: &[Run]) -> Result<Vec<Plot>, String> {
        let mut plot = Plot::new("profile", "y [m]", "velocity [m/s]");
        let heights = (0..=40).map(|k| f64::from(k) / 40.0);
        plot.line("exact", heights.map(|y| (y, (self.exact)(y))).collect());
        for run in runs {
            plot.points(format!("{} m", run.member.spacing), profile(run)?);
        }
        Ok(vec![plot])
    }
}

/// Mean height and velocity of the particles in bins of one spacing.
fn profile(run: &Run) -> Result<Vec<(f64, f64)>, String> {
    let state = run.final_fluid()?;
    let field = |name: &str| state.field(name).ok_or_else(|| format!("no field `{name}`"));
    let (position, velocity) = (field("position")?, field("velocity")?);
    let spacing = run.member.spacing;
    let mut bins: Vec<(f64, f64, f64)> = vec![(0.0, 0.0, 0.0); (1.0 / spacing).round() as usize];
    let last = bins.len() - 1;
    for i in (0..state.group.len()).filter(|i| state.group[*i] == 0) {
        let (y, v) = (position.values[2 * i + 1], velocity.values[2 * i]);
        // Negative heights saturate to the lowest bin.
        let bin = &mut bins[((y / spacing) as usize).min(last)];
        *bin = (bin.0 + 1.0, bin.1 + y, bin.2 + v);
    }
    Ok(bins.iter().filter(|bin| bin.0 > 0.0).map(|bin| (bin.1 / bin.0, bin.2 / bin.0)).collect())
}
