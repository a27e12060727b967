//! Beams and bars with known static deflections and periods: what bending and stretching cost in accuracy.

use std::f64::consts::TAU;

use coordinator::study::references;

use crate::validation::{Case, Figure, Goal, Member, Plot, Run, series};

/// Oscillating cantilever of Gray, Monaghan & Swift (2001).
pub struct Cantilever;

/// The same plate at rest under its weight.
pub struct StaticCantilever;

/// The plate of case 5.2 pushed sideways by its weight.
pub struct PlateStiffness;

/// Flag of Turek & Hron (2006) under its weight.
pub struct TurekHron;

/// First axial mode of a bar, and a bar that is loaded suddenly.
pub struct ElasticBar;

/// The same, gripped along both faces over 0.05 m \[s\].
const SLOT_CLAMP: f64 = 0.2617;
/// Thickness of the plate and of the flag \[m\].
const THICKNESS: f64 = 0.02;

/// A member of a case file that holds only solids.
fn solid(file: &'static str, scheme: &'static str, spacing: f64) -> Member {
    Member::solid(file, spacing).scheme(scheme)
}

impl Case for Cantilever {
    fn name(&self) -> &'static str {
        "cantilever"
    }

    fn about(&self) -> &'static str {
        "period of a cantilever against plane finite elements, with an ideal clamp and in a slot"
    }

    fn members(&self) -> Vec<Member> {
        vec![
            solid("cantilever_4", "ideal clamp", 0.005).quick(),
            solid("cantilever_6", "ideal clamp", 0.003333333333),
            solid("cantilever_10", "ideal clamp", 0.002),
            solid("cantilever_20", "ideal clamp", 0.001),
            solid("cantilever_slot_10", "slot", 0.002),
            solid("cantilever_large_10", "tip speed 0.05 c0", 0.002),
            solid("cantilever_6_paper", "solid of the source paper", 0.003333333333),
        ]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let tip = run.history("tip_displacement_y_m")?;
        let (rate, period) = references::swing(&tip);
        let loss = 1.0 - (-rate * period).exp();
        let end = tip.last().map_or(f64::NAN, |(t, _)| *t);
        let reference = if run.member.scheme == "slot" { SLOT_CLAMP } else { references::CANTILEVER_PERIOD };
        let mut figures = match run.member.scheme {
            "ideal clamp" => vec![
                Figure::compared("period [s]", period, reference, period_goal(run.member.spacing)),
                Figure::judged("loss of amplitude per period", loss, Goal::Between(-0.01, 0.01)),
            ],
            "tip speed 0.05 c0" => vec![
                Figure::compared("period [s]", period, reference, 0.0).report_only(),
                Figure::judged("periods without failure", end / period, Goal::AtLeast(10.0)),
                Figure::reported("loss of amplitude per period", loss),
            ],
            _ => vec![
                Figure::compared("period [s]", period, reference, 0.0).report_only(),
                Figure::judged("periods run", end / period, Goal::AtLeast(4.0)),
                Figure::reported("loss of amplitude per period", loss),
            ],
        };
        figures.push(Figure::reported("largest energy over that of the start", energy_ratio(run, "plate")?));
        figures.push(cost(run)?);
        Ok(figures)
    }

    fn plots(&self, runs: &[Run]) -> Result<Vec<Plot>, String> {
        tip_plot(runs, "tip_displacement_y_m")
    }
}

/// The table: 6, 3, 1.5 % at 6, 10, 20 particles across.
fn period_goal(spacing: f64) -> f64 {
    match THICKNESS / spacing {
        across if across > 15.0 => 0.015,
        across if across > 8.0 => 0.03,
        _ => 0.06,
    }
}

impl Case for StaticCantilever {
    fn name(&self) -> &'static str {
        "static_cantilever"
    }

    fn about(&self) -> &'static str {
        "tip deflection of a cantilever under 0.5 m/s2 against thin-plate theory with shear"
    }

    fn members(&self) -> Vec<Member> {
        let member = |file, spacing| solid(file, "ideal clamp", spacing);
        vec![
            member("cantilever_static_6", 0.003333333333).quick(),
            member("cantilever_static_10", 0.002),
            member("cantilever_static_20", 0.001),
        ]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let goal = match THICKNESS / run.member.spacing {
            across if across > 15.0 => 0.03,
            across if across > 8.0 => 0.06,
            _ => 0.11,
        };
        let tip = last(run, "tip_displacement_y_m")?;
        let weight = 0.5 * 1000.0 * 0.2 * THICKNESS;
        // Four held columns weigh on the clamp too.
        let held = 0.5 * 1000.0 * 4.0 * run.member.spacing * THICKNESS;
        let reaction = last(run, "clamp_force_y_n_per_m")? - held;
        Ok(vec![
            Figure::compared("tip deflection [m]", -tip, 1.28e-3, goal),
            Figure::compared("reaction over weight of the free part", reaction / weight, 1.0, 0.001),
            cost(run)?,
        ])
    }
}

/// Tip deflection \[m\] of the plate of `plate_static.toml` by beam theory with shear, in plane strain:
/// q L⁴/(8 E'I) + q L²/(2 κ G b), E' = E/(1 − ν²), κ = 5/6.
fn plate_deflection() -> f64 {
    let (bulk, shear): (f64, f64) = (20.0e6, 4.27e6);
    let young = 9.0 * bulk * shear / (3.0 * bulk + shear);
    let poisson = (3.0 * bulk - 2.0 * shear) / (6.0 * bulk + 2.0 * shear);
    let (width, height): (f64, f64) = (0.012, 0.08);
    let load = 1100.0 * width * 9.81;
    let bending = young / (1.0 - poisson * poisson) * width.powi(3) / 12.0;
    load * height.powi(4) / (8.0 * bending) + load * height.powi(2) / (2.0 * 5.0 / 6.0 * shear * width)
}

impl Case for PlateStiffness {
    fn name(&self) -> &'static str {
        "plate_stiffness"
    }

    fn about(&self) -> &'static str {
        "static deflection of case 5.2's plate under its weight sideways against beam theory with shear"
    }

    fn members(&self) -> Vec<Member> {
        let member = |scheme: &'static str, spacing: f64| {
            // Three held rows, as in case 5.2.
            let lower: toml::Value = vec![0.0, -3.0 * spacing].into();
            solid("plate_static", scheme, spacing)
                .with("solid.body.0.shape.lower_m", lower.clone())
                .with("solid.body.0.support.0.shape.lower_m", lower)
        };
        let paper = |spacing: f64| {
            let mut formulation = toml::Table::new();
            formulation.insert("type".into(), "updated-lagrangian".into());
            formulation.insert("kernel_ratio".into(), 1.3.into());
            member("solid of the source paper", spacing)
                .with("solid.body.0.formulation", formulation)
                .with("solid.substeps", "none")
                .with("time.step.time_step_s", 1.25e-5 * spacing / 0.002)
        };
        vec![
            member("total-lagrangian", 0.004).quick(),
            member("total-lagrangian", 0.002),
            member("total-lagrangian", 0.001),
            paper(0.004),
            paper(0.002),
            paper(0.001),
        ]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let tip = last(run, "tip_displacement_x_m")?;
        let figure = Figure::compared("tip deflection [m]", tip, plate_deflection(), 0.11);
        let report_only = run.member.scheme != "total-lagrangian";
        Ok(vec![if report_only { figure.report_only() } else { figure }, cost(run)?])
    }
}

impl Case for TurekHron {
    fn name(&self) -> &'static str {
        "turek_hron"
    }

    fn about(&self) -> &'static str {
        "tip displacement of CSM1 and CSM2 against finite elements with the same straight clamp"
    }

    fn members(&self) -> Vec<Member> {
        let coarse = |file, scheme| {
            // Four held columns at a spacing of 4 mm.
            let lower: toml::Value = vec![0.234, 0.19].into();
            solid(file, scheme, 0.004)
                .with("solid.body.0.shape.lower_m", lower.clone())
                .with("solid.body.0.support.0.shape.lower_m", lower)
        };
        vec![
            coarse("turek_hron_csm1_10", "CSM1"),
            solid("turek_hron_csm1_10", "CSM1", 0.002),
            solid("turek_hron_csm1_20", "CSM1", 0.001),
            coarse("turek_hron_csm2_10", "CSM2").quick(),
            solid("turek_hron_csm2_10", "CSM2", 0.002),
            solid("turek_hron_csm2_20", "CSM2", 0.001),
        ]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let [ux, uy] =
            if run.member.scheme == "CSM1" { [-7.060e-3, -65.43e-3] } else { [-0.460e-3, -16.79e-3] };
        let goal = if run.member.spacing < 0.0015 { 0.03 } else { 0.06 };
        Ok(vec![
            Figure::compared("uy [m]", last(run, "tip_displacement_y_m")?, uy, goal),
            Figure::compared("ux [m]", last(run, "tip_displacement_x_m")?, ux, 0.0).report_only(),
            cost(run)?,
        ])
    }
}

/// Period of the first axial mode of the bar: 4 L/c \[s\].
const BAR_PERIOD: f64 = 17.889e-3;

impl Case for ElasticBar {
    fn name(&self) -> &'static str {
        "elastic_bar"
    }

    fn about(&self) -> &'static str {
        "axial vibration of a bar: period, energy; mean and period of a bar loaded suddenly"
    }

    fn members(&self) -> Vec<Member> {
        let free = |spacing: f64| resized("elastic_bar", "first mode", spacing);
        let loaded = |spacing: f64| resized("elastic_bar_loaded", "loaded suddenly", spacing);
        vec![
            free(0.01).quick(),
            free(0.005),
            free(0.0025),
            loaded(0.01),
            loaded(0.005).quick(),
            loaded(0.0025),
        ]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let tip = run.history("tip_displacement_x_m")?;
        // The goals hold at 40 along.
        let goal = if run.member.spacing > 0.006 { 0.02 } else { 0.01 };
        let (mean, _, omega) = series::damped_oscillation(&tip, (0.0, TAU / BAR_PERIOD));
        let period = Figure::compared("period [s]", TAU / omega, BAR_PERIOD, goal);
        if run.member.scheme == "loaded suddenly" {
            // σL/E = 0.1 mm.
            return Ok(vec![period, Figure::compared("mean of the tip [m]", mean, 1e-4, goal), cost(run)?]);
        }
        let energy = total_energy(run, "bar")?;
        let drift = series::largest(energy.iter().map(|e| (e / energy[0] - 1.0).abs()));
        Ok(vec![
            period,
            Figure::judged("drift of energy in 10 periods", drift, Goal::AtMost(0.005)),
            cost(run)?,
        ])
    }

    fn plots(&self, runs: &[Run]) -> Result<Vec<Plot>, String> {
        tip_plot(runs, "tip_displacement_x_m")
    }
}

/// The bar of `file` at another spacing, with four held columns and the step in proportion.
fn resized(file: &'static str, scheme: &'static str, spacing: f64) -> Member {
    let lower: toml::Value = vec![-4.0 * spacing, -0.02].into();
    solid(file, scheme, spacing)
        .with("time.step.time_step_s", 1e-4 * spacing / 0.005)
        .with("solid.body.0.shape.lower_m", lower.clone())
        .with("solid.body.0.support.0.shape.lower_m", lower)
}

/// Last value of a probe column.
pub fn last(run: &Run, column: &str) -> Result<f64, String> {
    run.column(column)?.last().copied().ok_or_else(|| "no probe row".into())
}

/// Kinetic and strain energy of `probe` over time \[J/m\].
pub fn total_energy(run: &Run, probe: &str) -> Result<Vec<f64>, String> {
    let column = |kind: &str| run.column(&format!("{probe}_{kind}_energy_j_per_m"));
    Ok(column("kinetic")?.iter().zip(column("strain")?).map(|(k, s)| k + s).collect())
}

/// Largest total energy of `probe` over that of the start.
pub fn energy_ratio(run: &Run, probe: &str) -> Result<f64, String> {
    let energy = total_energy(run, probe)?;
    Ok(series::largest(energy.iter().map(|e| e / energy[0])))
}

/// CPU time per particle and stage.
pub fn cost(run: &Run) -> Result<Figure, String> {
    let stages = 2.0 * run.count("/steps")? * run.count("/solid/counts/particles")?;
    Ok(Figure::reported("CPU time per particle and stage [us]", 1e6 * run.cpu_seconds / stages))
}

fn tip_plot(runs: &[Run], column: &str) -> Result<Vec<Plot>, String> {
    let mut plot = Plot::new("tip", "t [s]", "displacement of the tip [m]");
    for run in runs {
        plot.line(format!("{}, {} m", run.member.scheme, run.member.spacing), run.history(column)?);
    }
    Ok(vec![plot])
}
