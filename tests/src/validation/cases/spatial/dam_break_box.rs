//! Dam break on a box in a tank against the measurements of Kleefsman et al. (2005).

use std::path::Path;

use coordinator::results::table::Table;

use super::common::judged_if;
use crate::validation::snapshot::Arrays;
use crate::validation::{Case, Figure, Goal, Member, Plot, Run, series};

/// SPHERIC test 2.
pub struct DamBreakBox;

/// What the record of a pressure gauge says, its offset before the impact removed.
struct Gauge {
    /// Column of the probe, and of the file.
    name: &'static str,
    file: &'static str,
    /// Time at which a quarter of the peak is passed \[s\].
    arrival: f64,
    /// Largest mean over 10 ms \[Pa\].
    peak: f64,
    /// Integrals from 0.38 s to 0.6 and to 1.0 s \[Pa s\].
    integrals: [f64; 2],
    /// Reading before the impact \[Pa\].
    offset: f64,
}

const GAUGES: [Gauge; 2] = [
    Gauge {
        name: "p1_pressure_pa",
        file: "pressure_kleefsman_2005_p1.csv",
        arrival: 0.395,
        peak: 10_112.0 + 28.0,
        integrals: [1419.0 + 28.0 * 0.22, 2884.0 + 28.0 * 0.62],
        offset: -28.0,
    },
    Gauge {
        name: "p3_pressure_pa",
        file: "pressure_kleefsman_2005_p3.csv",
        arrival: 0.426,
        peak: 6437.0 + 51.0,
        integrals: [909.0 + 51.0 * 0.22, 2353.0 + 51.0 * 0.62],
        offset: -51.0,
    },
];

/// Gauges of the height: x \[m\] on the middle plane and file.
const HEIGHTS: [(&str, f64, &str); 2] =
    [("H2", 0.992, "height_kleefsman_2005_h2.csv"), ("H4", 2.638, "height_kleefsman_2005_h4.csv")];

/// Time and value of a file of `tests/reference/`.
fn reference(file: &str, column: &str) -> Result<Vec<(f64, f64)>, String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("reference").join(file);
    let table = Table::read(&path).map_err(|e| e.to_string())?;
    let numbers = |name: &str| table.column(name).ok_or_else(|| format!("`{file}` has no column `{name}`"));
    Ok(numbers("t_s")?.into_iter().zip(numbers(column)?).collect())
}

impl DamBreakBox {
    /// Largest mean over 10 ms.
    fn peak(pressure: &[(f64, f64)]) -> f64 {
        let ends = pressure.iter().map(|row| row.0).filter(|t| (0.38..=1.0).contains(t));
        series::largest(ends.map(|t| series::mean(pressure, t - 0.005, t + 0.005)))
    }

    fn integral(pressure: &[(f64, f64)], from: f64, to: f64) -> f64 {
        series::mean(pressure, from, to) * (to - from)
    }

    /// Height \[m\] over x = `at` on the middle plane in time: volume of the water over a square of three spacings around
    /// the gauge, divided by its area, which is the wetted length of a vertical line.
    fn height(run: &Run, at: f64) -> Result<Vec<(f64, f64)>, String> {
        let half = 1.5 * run.member.spacing;
        let mut found = Vec::new();
        for (time, path) in run.fluid_snapshots()? {
            let arrays = Arrays::open(&path)?;
            let (position, group) = (arrays.numbers("Points")?, arrays.integers("group")?);
            let (mass, density) = (arrays.numbers("mass")?, arrays.numbers("density")?);
            let over = |i: &usize| {
                group[*i] == 0
                    && (position[3 * i] - at).abs() < half
                    && (position[3 * i + 1] - 0.5).abs() < half
            };
            let volume: f64 = (0..group.len()).filter(over).map(|i| mass[i] / density[i]).sum();
            found.push((time, volume / (4.0 * half * half)));
        }
        Ok(found)
    }
}

impl Case for DamBreakBox {
    fn name(&self) -> &'static str {
        "dam_break_box_3d"
    }

    fn about(&self) -> &'static str {
        "dam break on a box in a tank against measured pressures and heights"
    }

    fn members(&self) -> Vec<Member> {
        let of = |spacing: f64| {
            let gauge = |z: f64| vec![0.8245 + 0.5 * spacing, 0.471, z];
            Member::new("dam_break_box_3d", spacing)
                .with("probe.0.at_m", gauge(0.021))
                .with("probe.1.at_m", gauge(0.101))
        };
        let impact = |spacing: f64| {
            of(spacing).with("time.end_time_s", 1.2).with("outputs.picture_times_s", vec![0.0, 0.4, 0.6, 1.0])
        };
        vec![impact(0.04), of(0.02), of(0.015), impact(0.01)]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let spacing = run.member.spacing;
        let end = run.column("t_s")?.last().copied().unwrap_or(f64::NAN);
        let goal = if spacing < 0.011 { 0.15 } else { 0.25 };
        let judged = |figure: Figure| judged_if(spacing < 0.021, figure);
        let mut figures = Vec::new();
        for gauge in &GAUGES {
            let pressure = run.history(gauge.name)?;
            let peak = Self::peak(&pressure);
            let name = gauge.name.split('_').next().unwrap_or_default().to_uppercase();
            let arrival = series::first_reach(&pressure, 0.25 * peak) - gauge.arrival;
            figures.push(judged(Figure::judged(
                format!("{name}: a quarter of the peak passed after the measurement [s]"),
                arrival,
                Goal::Between(-0.02, 0.02),
            )));
            let value =
                Figure::compared(format!("{name}: largest mean over 10 ms [Pa]"), peak, gauge.peak, goal);
            // The goals of the peak are those of 20 and 10 mm.
            figures.push(judged_if(spacing < 0.011 || (0.019..0.021).contains(&spacing), value));
            for (to, reference) in [0.6, 1.0].into_iter().zip(gauge.integrals) {
                let integral = Self::integral(&pressure, 0.38, to);
                let name = format!("{name}: integral from 0.38 to {to} s [Pa s]");
                figures.push(judged(Figure::compared(name, integral, reference, 0.12)));
            }
        }
        for (name, at, file) in HEIGHTS {
            let measured = reference(file, "height_m")?;
            let height = Self::height(run, at)?;
            let errors: Vec<f64> = height
                .iter()
                .map(|(t, h)| (h - series::at(&measured, *t)).abs())
                .filter(|error| error.is_finite())
                .collect();
            let mean = errors.iter().sum::<f64>() / errors.len() as f64;
            let figure =
                Figure::judged(format!("{name}: mean error to {end} s [m]"), mean, Goal::AtMost(0.04));
            figures.push(judged_if(end > 5.9, figure));
        }
        figures.push(Figure::judged("particles lost", run.lost(), Goal::AtMost(0.0)));
        Ok(figures)
    }

    fn plots(&self, runs: &[Run]) -> Result<Vec<Plot>, String> {
        let mut plots = Vec::new();
        for gauge in &GAUGES {
            let name = gauge.name.split('_').next().unwrap_or_default();
            let mut plot = Plot::new(name, "t [s]", "pressure [Pa]");
            let measured = reference(gauge.file, "pressure_pa")?;
            plot.points("measured", measured.into_iter().map(|(t, p)| (t, p - gauge.offset)).collect());
            for run in runs {
                let history = run.history(gauge.name)?;
                plot.line(format!("{} m", run.member.spacing), series::window(&history, 0.3, 1.2));
            }
            plots.push(plot);
        }
        for (name, at, file) in HEIGHTS {
            let mut plot = Plot::new(&name.to_lowercase(), "t [s]", "height of the water [m]");
            plot.points("measured", reference(file, "height_m")?);
            for run in runs {
                plot.line(format!("{} m", run.member.spacing), Self::height(run, at)?);
            }
            plots.push(plot);
        }
        Ok(plots)
    }
}
