//! Case 5.1: still water, settled and ringing, against the hydrostatic pressure.

use crate::validation::{Case, Figure, Goal, Member, Plot, Run, series};

/// See the module.
pub struct StillWater;

const DENSITY: f64 = 1000.0;
const GRAVITY: f64 = 9.81;
const WIDTH: f64 = 0.501;

/// End of the long member \[s\].
const LONG: f64 = 60.0;

/// Probes: name, height above the floor \[m\], tolerance.
const PROBES: [(&str, f64, f64); 5] = [
    ("p1", 0.005, 0.001),
    ("d24", 0.06, 0.005),
    ("d18", 0.12, 0.005),
    ("d12", 0.18, 0.005),
    ("d06", 0.24, 0.005),
];

impl Case for StillWater {
    fn name(&self) -> &'static str {
        "still_water"
    }

    fn about(&self) -> &'static str {
        "case 5.1: pressure of still water, damped to rest, and from p = 0 for 15 and 60 s"
    }

    fn members(&self) -> Vec<Member> {
        let step: toml::Table = "type = \"fixed\"\ntime_step_s = 1e-4".parse().unwrap_or_default();
        vec![
            Member::new("still_water", 0.006).quick(),
            Member::new("still_water", 0.003),
            Member::new("still_water_undamped", 0.003)
                .scheme("paper, undamped")
                .with("preset", "paper")
                .with("time.step", step),
            Member::new("still_water_undamped", 0.003).scheme("recommended, from p = 0"),
            Member::new("still_water_undamped", 0.006)
                .scheme("recommended, 60 s from p = 0")
                .with("time.end_time_s", LONG),
        ]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let lost = Figure::judged("particles lost", run.lost(), Goal::AtMost(0.0));
        let mut figures = if run.member.file == "still_water" { settled(run)? } else { ringing(run)? };
        figures.push(lost);
        Ok(figures)
    }

    fn plots(&self, runs: &[Run]) -> Result<Vec<Plot>, String> {
        let mut plot = Plot::new("p1", "t [s]", "pressure at P1 [Pa]");
        for run in runs {
            plot.line(
                format!("{} {} m", run.member.scheme, run.member.spacing),
                run.history("p1_pressure_pa")?,
            );
        }
        Ok(vec![plot])
    }
}

/// Pressures over the last tenth of the run against ρ g times the depth below the surface.
///
/// ρ = Σm/Σ(m/ρ), and the surface stands at Σ(m/ρ)/width.
fn settled(run: &Run) -> Result<Vec<Figure>, String> {
    let state = run.final_fluid()?;
    let field = |name: &str| state.field(name).ok_or_else(|| format!("no field `{name}`"));
    let (mass, density) = (field("mass")?, field("density")?);
    let fluid = || (0..state.group.len()).filter(|i| state.group[*i] == 0);
    let volume: f64 = fluid().map(|i| mass.values[i] / density.values[i]).sum();
    let surface = volume / WIDTH;
    // The water is a little compressed, by g H/(2 c0²) on average: its weight is that of its mean density.
    let mean_density = fluid().map(|i| mass.values[i]).sum::<f64>() / volume;
    let mut figures = vec![
        Figure::reported("height of the surface [m]", surface),
        Figure::reported("mean density over rest density", mean_density / DENSITY),
    ];
    for (name, height, tolerance) in PROBES {
        let history = run.history(&format!("{name}_pressure_pa"))?;
        let end = history.last().map_or(f64::NAN, |row| row.0);
        let mean = series::mean(&history, 0.9 * end, end);
        let exact = mean_density * GRAVITY * (surface - height);
        figures.push(Figure::compared(format!("pressure at {height} m [Pa]"), mean, exact, tolerance));
    }
    Ok(figures)
}

fn ringing(run: &Run) -> Result<Vec<Figure>, String> {
    let pressure = run.history("p1_pressure_pa")?;
    let exact = DENSITY * GRAVITY * 0.295;
    if run.number("time.end_time_s")? >= LONG {
        let error = |second: u32| {
            (series::mean(&pressure, f64::from(second), f64::from(second + 1)) / exact - 1.0).abs()
        };
        let largest = series::largest((10..60).map(error));
        return Ok(vec![Figure::judged(
            "largest error of the mean of P1 in a second from 10 s on",
            largest,
            Goal::AtMost(0.01),
        )]);
    }
    let mean = series::mean(&pressure, 10.0, 15.0);
    let tolerance = if run.member.scheme.starts_with("paper") { 0.012 } else { 0.003 };
    let kinetic = run.history("water_kinetic_energy_j_per_m")?;
    let peaks: Vec<f64> = (0..15)
        .map(f64::from)
        .map(|t| series::largest(series::window(&kinetic, t, t + 1.0).into_iter().map(|p| p.1)))
        .collect();
    let rises = peaks.windows(2).skip(1).filter(|p| p[1] > p[0]).count();
    Ok(vec![
        Figure::compared("mean pressure at P1, 10 to 15 s [Pa]", mean, exact, tolerance),
        Figure::judged(
            "seconds after the first whose largest kinetic energy rose",
            rises as f64,
            Goal::AtMost(0.0),
        ),
        Figure::reported("largest kinetic energy, last second over first", peaks[14] / peaks[0]),
    ])
}
