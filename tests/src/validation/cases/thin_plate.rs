//! A thin plate between water of different heights: its load, and whether one side affects the other through it.

use super::floating::{coupling, rectangle};
use crate::validation::{Case, Figure, Goal, Member, Run, series};

/// See the module.
pub struct ThinPlate;

/// Particle spacing \[m\].
const SPACING: f64 = 0.0025;
/// Heights of the deep and the shallow water, and the deep one's in the run beside it \[m\].
const DEEP: f64 = 0.1;
const SHALLOW: f64 = 0.06;
const DEEPER: f64 = 0.14;
/// Width of either water \[m\].
const WIDTH: f64 = 0.1;

/// Rows of the plate of `run`, and height of its deep water \[m\].
fn scene(run: &Run) -> Result<(f64, f64), String> {
    let rows = run.number("solid.body.0.shape.upper_m.0")? / SPACING;
    Ok((rows.round(), run.number("fluid.region.1.start.surface_m")?))
}

/// Positions of the shallow water's particles at the end \[m\], x and y in turn.
fn shallow_water(run: &Run) -> Result<Vec<f64>, String> {
    let state = run.final_fluid()?;
    let position = state.field("position").ok_or("no field `position`")?;
    let own = |i: &usize| state.group[*i] == 0;
    Ok((0..state.group.len()).filter(own).flat_map(|i| position.values[2 * i..2 * i + 2].to_vec()).collect())
}

impl Case for ThinPlate {
    fn name(&self) -> &'static str {
        "thin_plate"
    }

    fn about(&self) -> &'static str {
        "a plate of 2, 3 and 4 rows between two regions of water: load, and neither affects the other"
    }

    fn members(&self) -> Vec<Member> {
        let of = |scheme, rows: f64, deep: f64| {
            let right = rows * SPACING;
            let plate = rectangle([0.0, -0.01], [right, 0.16]);
            Member::new("thin_plate", SPACING)
                .scheme(scheme)
                .with("domain.upper_m", vec![right + WIDTH, 0.2])
                .with("fluid.region.0.shape", rectangle([right, 0.0], [right + WIDTH, SHALLOW]))
                .with("fluid.region.1.shape", rectangle([-WIDTH, 0.0], [0.0, deep]))
                .with("fluid.region.1.start.surface_m", deep)
                .with("solid.body.0.support.0.shape", plate.clone())
                .with("solid.body.0.shape", plate)
        };
        vec![
            of("1 row", 1.0, DEEP),
            of("1 row, deeper", 1.0, DEEPER),
            of("2 rows", 2.0, DEEP).quick(),
            of("2 rows, deeper", 2.0, DEEPER).quick(),
            of("3 rows", 3.0, DEEP),
            of("3 rows, deeper", 3.0, DEEPER),
            of("4 rows", 4.0, DEEP),
            of("4 rows, deeper", 4.0, DEEPER),
        ]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let (rows, deep) = scene(run)?;
        let load = series::mean(&run.history("plate_force_x_n_per_m")?, 0.5, 0.8);
        let exact = 0.5 * 1000.0 * 9.81 * (deep.powi(2) - SHALLOW.powi(2));
        let state = run.final_fluid()?;
        let position = state.field("position").ok_or("no field `position`")?;
        let middle = 0.5 * rows * SPACING;
        let beyond = (0..state.group.len())
            .filter(|i| state.group[*i] < 2 && (position.values[2 * i] > middle) != (state.group[*i] == 0));
        // Water is compressed by gH/c₀² = 0.3 to 0.4 %, and its surface known to a tenth of a row, 0.25 % of the height.
        let load = Figure::compared("load, mean over 0.5 to 0.8 s [N/m]", load, exact, 0.01);
        let through = Figure::judged("particles beyond the plate", beyond.count() as f64, Goal::AtMost(0.0));
        let mut figures = vec![
            if rows > 1.0 { load } else { load.report_only() },
            if rows > 1.0 { through } else { through.report_only() },
            Figure::judged("particles lost", run.lost(), Goal::AtMost(0.0)),
        ];
        figures.extend(coupling(run));
        Ok(figures)
    }

    fn comparison(&self, runs: &[Run]) -> Result<Vec<Figure>, String> {
        let mut figures = Vec::new();
        for run in runs {
            let (rows, deep) = scene(run)?;
            let beside = |other: &&Run| scene(other).is_ok_and(|(r, d)| r == rows && d > deep);
            let Some(other) = runs.iter().find(beside) else { continue };
            let (one, two) = (shallow_water(run)?, shallow_water(other)?);
            let apart = series::largest(one.iter().zip(&two).map(|(a, b)| (a - b).abs()));
            // Neither reads anything of the other. Round-off, by sums in another order, is up to 4e-14 m.
            let goal = if rows > 1.0 { Goal::AtMost(1e-10) } else { Goal::None };
            let name = format!("{rows} rows: shallow water, largest change when the deep one is raised [m]");
            figures.push(Figure::judged(name, apart, goal));
        }
        Ok(figures)
    }
}
