//! Bodies lighter and heavier than water: added mass, Archimedes' draught, and a water column on an elastic plate.

use crate::validation::{Case, Figure, Goal, Member, Plot, Run, series};

/// A block of 0.1 to 10 times the density of water falls into it: light ones are where explicit exchange could fail.
pub struct DensityRatio;

/// A block on rails settles at the draught of Archimedes.
pub struct Draught;

/// A float lighter than a row of water particles, held under by a load: where one exchange a half-step fails.
pub struct LightFloat;

/// A water column on a clamped aluminium plate.
pub struct HydrostaticPlate;

/// Water's rest density \[kg/m³\].
const DENSITY: f64 = 1000.0;
/// Gravity \[m/s²\].
const GRAVITY: f64 = 9.81;

/// Density of the block of `run` over that of water.
fn ratio(run: &Run) -> Result<f64, String> {
    let changed = run.member.changes.iter().find(|(path, _)| path.ends_with("density_kg_m3"));
    let value = changed.and_then(|(_, value)| value.as_float());
    Ok(value.ok_or("the member gives its block no density")? / DENSITY)
}

/// The shape of a case file from `lower` to `upper` \[m\].
pub(super) fn rectangle(lower: [f64; 2], upper: [f64; 2]) -> toml::Table {
    let mut shape = toml::Table::new();
    shape.insert("type".into(), "rectangle".into());
    shape.insert("lower_m".into(), lower.to_vec().into());
    shape.insert("upper_m".into(), upper.to_vec().into());
    shape
}

/// Steps, sub-steps and worst imbalances of a run that was coupled.
pub(super) fn coupling(run: &Run) -> Vec<Figure> {
    let number =
        |path: &str| run.summary.pointer(path).and_then(serde_json::Value::as_f64).unwrap_or(f64::NAN);
    let worst = |what: &str| number(&format!("/ledger/largest_{what}/value"));
    let residual = worst("fluid_momentum_residual").max(worst("solid_momentum_residual"));
    vec![
        Figure::reported("steps", number("/steps")),
        Figure::reported("smallest step [s]", number("/time_step/smallest_s")),
        Figure::reported("largest step [s]", number("/time_step/largest_s")),
        Figure::reported(
            "sub-steps of the solids per step, mean",
            number("/solid/counts/substeps") / number("/steps"),
        ),
        // The design's tolerance of the ledger.
        Figure::judged("largest imbalance of force, of gross", worst("force_imbalance"), Goal::AtMost(1e-12)),
        Figure::judged("largest residual of momentum, of gross", residual, Goal::AtMost(1e-12)),
    ]
}

impl Case for DensityRatio {
    fn name(&self) -> &'static str {
        "density_ratio"
    }

    fn about(&self) -> &'static str {
        "a block of 0.1 to 10 times water's density falls into water: stable with explicit exchange"
    }

    fn members(&self) -> Vec<Member> {
        let of = |scheme, density: f64| {
            Member::new("density_ratio", 0.002)
                .scheme(scheme)
                .with("solid.body.0.material.density_kg_m3", density)
        };
        vec![
            // It strikes the floor at 1 m/s; water pressed out from under it moves at some 10 m/s.
            of("10", 10_000.0).with("fluid.sound_speed_m_s", 36.0),
            of("1", 1000.0),
            of("0.5", 500.0),
            of("0.25", 250.0),
            of("0.1", 100.0),
        ]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        if let Some(reason) = run.stopped() {
            terminal::say(format_args!("  {} stopped: {reason}", run.member.label()));
        }
        let end = run.column("t_s")?.last().copied().unwrap_or(f64::NAN);
        let mut figures = vec![
            Figure::reported("density over that of water", ratio(run)?),
            Figure::judged("reached time [s]", end, Goal::AtLeast(0.5)),
            Figure::judged("particles lost", run.lost(), Goal::AtMost(0.0)),
            Figure::reported(
                "deepest centre [m]",
                run.column("block_centre_y_m")?.into_iter().fold(f64::INFINITY, f64::min),
            ),
        ];
        figures.extend(coupling(run));
        Ok(figures)
    }

    fn plots(&self, runs: &[Run]) -> Result<Vec<Plot>, String> {
        heights(runs)
    }
}

/// Heights of the blocks over time.
fn heights(runs: &[Run]) -> Result<Vec<Plot>, String> {
    let mut plot = Plot::new("height", "t [s]", "centre of the block [m]");
    for run in runs {
        plot.line(run.member.scheme.to_owned(), run.history("block_centre_y_m")?);
    }
    Ok(vec![plot])
}

/// Draught \[m\].
const DRAUGHT: f64 = 0.05;
/// Water on either side of the block \[m\].
const BESIDE: f64 = 0.08;
/// Angular velocity of free blocks at the start \[rad/s\].
const TURNING: f64 = 0.5;
/// Width of a block on rails \[m\].
const NARROW: f64 = 0.04;
/// Lower side of the block at the start, and depth of the water before the block cuts it \[m\].
const START: f64 = 0.06;
const DEPTH: f64 = 0.1;

impl Case for Draught {
    fn name(&self) -> &'static str {
        "draught"
    }

    fn about(&self) -> &'static str {
        "floating blocks settle at the draught of Archimedes, 25 particles deep"
    }

    fn members(&self) -> Vec<Member> {
        let of = |scheme, ratio: f64, width: f64| {
            let tank = width + 2.0 * BESIDE;
            let block = rectangle([BESIDE, START], [BESIDE + width, START + DRAUGHT / ratio]);
            Member::new("draught", 0.002)
                .scheme(scheme)
                .with("solid.body.0.material.density_kg_m3", ratio * DENSITY)
                .with("solid.body.0.shape", block)
                .with("domain.upper_m", vec![tank, 0.7])
                .with("fluid.region.0.shape", rectangle([0.0, 0.0], [tank, DEPTH]))
        };
        // Set turning, which the water must right.
        let free = |scheme, ratio: f64, width: f64| {
            let (x, y) = (BESIDE + 0.5 * width, START + 0.5 * DRAUGHT / ratio);
            let turning = [format!("{TURNING}*({y} - y)"), format!("{TURNING}*(x - {x})")];
            of(scheme, ratio, width)
                .with("solid.body.0.support", toml::Value::Array(Vec::new()))
                .with("solid.body.0.velocity_m_s", turning.to_vec())
        };
        // Wide enough to float upright: width²/(12 draught) is above the height of the weight over the displaced water's.
        vec![
            of("0.5", 0.5, NARROW),
            of("0.25", 0.25, NARROW),
            of("0.1", 0.1, NARROW),
            free("0.5, free", 0.5, 0.2),
            free("0.25, free", 0.25, 0.3),
        ]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let ratio = ratio(run)?;
        let tank = run.number("domain.upper_m.0")?;
        let block = tank - 2.0 * BESIDE;
        let centre = run.history("block_centre_y_m")?;
        let lower = |height: f64| height - 0.5 * DRAUGHT / ratio;
        // Damping ends at 0.5 s.
        let mean = lower(series::mean(&centre, 0.5, 0.8));
        // Water keeps its area A: it stands at L with (L − b) the draught, L W − (L − b) w = A.
        let area = tank * DEPTH - block * (DEPTH - START);
        let draught = (area - mean * tank) / (tank - block);
        let late = series::window(&centre, 0.5, 0.8);
        let span =
            series::largest(late.iter().map(|row| row.1)) + series::largest(late.iter().map(|row| -row.1));
        let turned = run.history("block_angle_rad")?;
        let largest = series::largest(turned.iter().map(|row| row.1.abs()));
        let angle = series::mean(&turned, 0.5, 0.8);
        let mut figures = vec![
            Figure::compared("draught, mean over 0.5 to 0.8 s [m]", draught, DRAUGHT, 0.02),
            Figure::reported("span of the heave then, over the draught", span / DRAUGHT),
            Figure::reported("largest angle [rad]", largest),
            // Half a degree. One too narrow falls over; one on rails cannot turn.
            Figure::judged("angle, mean over 0.5 to 0.8 s [rad]", angle, Goal::Between(-0.009, 0.009)),
            Figure::judged("particles lost", run.lost(), Goal::AtMost(0.0)),
        ];
        figures.extend(coupling(run));
        Ok(figures)
    }

    fn plots(&self, runs: &[Run]) -> Result<Vec<Plot>, String> {
        heights(runs)
    }
}

/// Height of the float's middle at its draught, and draught \[m\].
const MIDDLE: f64 = 0.08;
const FLOAT_DRAUGHT: f64 = 0.02;

impl Case for LightFloat {
    fn name(&self) -> &'static str {
        "light_float"
    }

    fn about(&self) -> &'static str {
        "a float of 0.02 times water's density under a load rests at the draught of Archimedes: iterated half-steps"
    }

    fn members(&self) -> Vec<Member> {
        let of = |scheme, ratio: f64| {
            // With its load it weighs as much as the water of half its height.
            let load = toml::Value::from((1.0 - 0.5 / ratio) * GRAVITY);
            Member::new("light_float", 0.004)
                .scheme(scheme)
                .with("solid.body.0.material.density_kg_m3", ratio * DENSITY)
                .with("solid.body.0.acceleration_m_s2", vec![toml::Value::from(0.0), load])
        };
        vec![of("0.02", 0.02), of("0.05", 0.05), of("0.5", 0.5)]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let centre = run.history("float_centre_y_m")?;
        let draught = FLOAT_DRAUGHT + MIDDLE - series::mean(&centre, 0.25, 0.5);
        let speed = series::largest(run.column("float_velocity_y_m_s")?.into_iter().map(f64::abs));
        let mut figures = vec![
            Figure::compared("draught, mean over 0.25 to 0.5 s [m]", draught, FLOAT_DRAUGHT, 0.02),
            // The speed of sound over 1000: water that finds its balance moves at some mm/s, a float that hops at 1 m/s.
            Figure::judged("largest speed of the float [m/s]", speed, Goal::AtMost(0.015)),
            Figure::reported("iterations a step, mean", run.count("/iterations/mean")?),
            Figure::reported("iterations a step, most", run.count("/iterations/largest")?),
            Figure::judged(
                "steps that had not settled",
                run.count("/iterations/unsettled_steps")?,
                Goal::AtMost(0.0),
            ),
            Figure::judged("particles lost", run.lost(), Goal::AtMost(0.0)),
        ];
        figures.extend(coupling(run));
        Ok(figures)
    }

    fn plots(&self, runs: &[Run]) -> Result<Vec<Plot>, String> {
        let mut plot = Plot::new("height", "t [s]", "centre of the float [m]");
        for run in runs {
            plot.line(run.member.scheme.to_owned(), run.history("float_centre_y_m")?);
        }
        Ok(vec![plot])
    }
}

/// Thickness of the plate \[m\].
const PLATE: f64 = 0.05;
/// Three periods 4H/c₀ of the column \[s\].
const WINDOW: (f64, f64) = (0.2, 0.5);

impl Case for HydrostaticPlate {
    fn name(&self) -> &'static str {
        "hydrostatic_plate"
    }

    fn about(&self) -> &'static str {
        "2 m of water on a clamped aluminium plate: load and deflection (Fourey et al. 2017; plane finite elements)"
    }

    fn members(&self) -> Vec<Member> {
        [4.0, 6.0, 10.0].map(|across| Member::new("hydrostatic_plate", PLATE / across)).into()
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let mean =
            |name: &str| -> Result<f64, String> { Ok(series::mean(&run.history(name)?, WINDOW.0, WINDOW.1)) };
        // The plate rings at more than the rate of the probes: only the impulse knows the mean.
        let impulse = run.ledger("fluid_interface_impulse_y_n_s_per_m")?;
        let given = series::at(&impulse, WINDOW.1) - series::at(&impulse, WINDOW.0);
        // 2 m on 1 m of span.
        let weight = -DENSITY * GRAVITY * 2.0;
        // Plane finite elements at ν = 0.34 under water and own weight; 8 % is asked for at 10 particles across.
        let deflection = Figure::compared(
            "deflection of mid-span, mean over 0.2 to 0.5 s [m]",
            mean("plate_mid_displacement_y_m")?,
            -7.063e-5,
            0.08,
        );
        let mut figures = vec![
            Figure::compared(
                "load, mean over 0.2 to 0.5 s [N/m]",
                -given / (WINDOW.1 - WINDOW.0),
                weight,
                0.01,
            ),
            Figure::reported("the same by the probe [N/m]", mean("plate_force_y_n_per_m")?),
            if run.member.spacing > PLATE / 9.0 { deflection.report_only() } else { deflection },
            Figure::judged("particles lost", run.lost(), Goal::AtMost(0.0)),
        ];
        figures.extend(coupling(run));
        Ok(figures)
    }

    fn plots(&self, runs: &[Run]) -> Result<Vec<Plot>, String> {
        let mut plot = Plot::new("deflection", "t [s]", "deflection of mid-span [m]");
        for run in runs {
            plot.line(
                format!("{:.0} across", PLATE / run.member.spacing),
                run.history("plate_mid_displacement_y_m")?,
            );
        }
        Ok(vec![plot])
    }
}
