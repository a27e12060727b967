//! The first pressures of a dam break on a wall: loads that do not depend on the spacing, and little sound.

use crate::validation::{Case, Figure, Goal, Member, Plot, Run, series};

/// See the module.
pub struct WallImpact;

const GRAVITY: f64 = 9.81;
const DENSITY: f64 = 1000.0;

/// Depth of the column in the case file \[m\].
const DEPTH: f64 = 0.6;

/// Gauges: prefix of their probes, and height over the depth.
const GAUGES: [(&str, f64); 3] = [("low", 0.01), ("mid", 0.05), ("high", 0.2)];

/// Half the height of a gauge \[m\].
const HALF_GAUGE: f64 = 0.004;

/// Scheme of half the depth.
const HALF: &str = "half the depth";

/// Times over √(H/g): of the mean that is the peak, of the mean about which sound swings, of the first load, and until
/// when the peak may come.
const PEAK: f64 = 0.012;
const SLOW: f64 = 0.03;
const FIRST: f64 = 0.06;
const LATEST: f64 = 0.5;

/// Share of ρ g H from which on a gauge is wet.
const WET: f64 = 0.05;

impl Case for WallImpact {
    fn name(&self) -> &'static str {
        "wall_impact"
    }

    fn about(&self) -> &'static str {
        "first pressure peak of a dam break on a wall, three gauges, H/dx 30 to 150, two depths"
    }

    fn members(&self) -> Vec<Member> {
        let of = |spacing| Member::new("wall_impact", spacing);
        vec![of(0.02), of(0.01), of(0.004), half(0.005), half(0.002)]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let mut figures = Vec::new();
        for (gauge, height) in GAUGES {
            let (peak, noise) = first_load(run, gauge)?;
            figures.push(Figure::reported(format!("first peak over rho g H at {height} H"), peak));
            let name = format!("sound in the first load over the peak at {height} H");
            let judged = Figure::judged(name, noise, Goal::AtMost(0.3));
            figures.push(if resolved(run) { judged } else { judged.report_only() });
        }
        figures.push(Figure::judged("particles lost", run.lost(), Goal::AtMost(0.0)));
        Ok(figures)
    }

    fn comparison(&self, runs: &[Run]) -> Result<Vec<Figure>, String> {
        let mut figures = Vec::new();
        for scheme in ["recommended", HALF] {
            let mut of_depth: Vec<&Run> = runs.iter().filter(|run| run.member.scheme == scheme).collect();
            of_depth.sort_by(|a, b| a.member.spacing.total_cmp(&b.member.spacing));
            let [finest, others @ ..] = &of_depth[..] else { continue };
            for (gauge, height) in GAUGES {
                let reference = first_load(finest, gauge)?.0;
                for run in others {
                    let name = format!("first peak at {height} H, {scheme}, {} m", run.member.spacing);
                    let figure = Figure::compared(name, first_load(run, gauge)?.0, reference, 0.25);
                    figures.push(if resolved(run) { figure } else { figure.report_only() });
                }
            }
        }
        Ok(figures)
    }

    fn plots(&self, runs: &[Run]) -> Result<Vec<Plot>, String> {
        GAUGES
            .iter()
            .map(|(gauge, _)| {
                let mut plot = Plot::new(gauge, "t sqrt(g/H)", "p/(rho g H)");
                for run in runs {
                    plot.line(run.member.label(), history(run, gauge)?);
                }
                Ok(plot)
            })
            .collect()
    }
}

/// A member of half the depth, with the same ratio of the sound speed to the speed of the water.
fn half(spacing: f64) -> Member {
    let (depth, wall) = (0.5 * DEPTH, 1.61);
    let shape: toml::Table =
        "type = \"rectangle\"\nlower_m = [0.0, 0.0]\nupper_m = [0.6, 0.3]".parse().unwrap_or_default();
    let mut member = Member::new("wall_impact", spacing)
        .scheme(HALF)
        .with("domain.upper_m", vec![wall, 4.0 * depth])
        .with("fluid.region.0.shape", shape)
        .with("fluid.region.0.start.surface_m", depth)
        .with("fluid.sound_speed_m_s", 34.3 * f64::sqrt(0.5))
        .with("time.end_time_s", 0.8 * f64::sqrt(0.5))
        .with("outputs.probe_interval_s", 0.0001)
        .with("outputs.picture_times_s", vec![0.1, 0.3, 0.5]);
    for (k, (_, height)) in GAUGES.iter().enumerate() {
        for (part, offset) in [-HALF_GAUGE, 0.0, HALF_GAUGE].into_iter().enumerate() {
            let place = vec![wall, (height * depth + offset).max(0.0)];
            member = member.with(&format!("probe.{}.at_m", 3 * k + part), place);
        }
    }
    member
}

/// Whether goals hold: H/dx is 60 or more.
fn resolved(run: &Run) -> bool {
    run.member.spacing < (if run.member.scheme == HALF { 0.5 } else { 1.0 }) * DEPTH / 59.0
}

/// √(H/g) \[s\] and ρ g H \[Pa\] of a run.
fn scales(run: &Run) -> Result<(f64, f64), String> {
    let depth = run.number("fluid.region.0.start.surface_m")?;
    Ok((f64::sqrt(depth / GRAVITY), DENSITY * GRAVITY * depth))
}

/// Mean pressure over a gauge, by Simpson's rule, over ρ g H, and time over √(H/g).
fn history(run: &Run, gauge: &str) -> Result<Vec<(f64, f64)>, String> {
    let (time, pressure) = scales(run)?;
    let part = |k: usize| run.history(&format!("{gauge}{k}_pressure_pa"));
    let (lower, middle, upper) = (part(0)?, part(1)?, part(2)?);
    let of_parts = lower.iter().zip(middle).zip(upper);
    Ok(of_parts.map(|((a, b), c)| (a.0 / time, (a.1 + 4.0 * b.1 + c.1) / (6.0 * pressure))).collect())
}

/// The largest mean over [`PEAK`] since the gauge became wet, and the standard deviation from the mean over [`SLOW`] in the
/// time [`FIRST`] over that peak. What was before the gauge became wet does not count.
fn first_load(run: &Run, gauge: &str) -> Result<(f64, f64), String> {
    let history = history(run, gauge)?;
    let start = series::first_reach(&history, WET);
    let wet = series::window(&history, start, start + LATEST + PEAK);
    let mean = |t: f64, width: f64| series::mean(&wet, t - 0.5 * width, t + 0.5 * width);
    let whole = |t: f64| t >= start + 0.5 * PEAK && t <= start + LATEST;
    let peak = series::largest(wet.iter().filter(|(t, _)| whole(*t)).map(|(t, _)| mean(*t, PEAK)));
    let first = series::window(&wet, start, start + FIRST);
    let squares = first.iter().map(|(t, p)| (p - mean(*t, SLOW)).powi(2)).sum::<f64>();
    Ok((peak, (squares / first.len() as f64).sqrt() / peak))
}
