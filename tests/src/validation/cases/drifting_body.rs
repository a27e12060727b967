//! Case 5.2: a collapsing water column carries an elastic body against an elastic plate.
//!
//! What is judged is what every sound scheme agrees on; after the body has touched the floor its path is chaotic, so
//! path and passage are reported only. The time mean of σ_yy at the foot is taken over 0.20-0.25 s, when body and water load
//! the plate and bend it away: tension on the left, compression on the right (Fig. 6 of the source paper).

use crate::validation::{Case, Figure, Goal, Member, Plot, Run, series};

/// See the module.
pub struct DriftingBody;

/// Left face of the plate and its width \[m\].
const PLATE: (f64, f64) = (0.398, 0.012);
/// Rows at the foot whose stress is averaged.
const ROWS: usize = 3;
/// Columns across the plate at which the stress is read.
const COLUMNS: usize = 6;

/// Name of the probe in a column and row of the foot, from the left and from the floor.
fn foot(column: usize, row: usize) -> String {
    format!("foot_{column}_{row}")
}

fn member(file: &'static str, spacing: f64) -> Member {
    let mut member = Member::new(file, spacing);
    for column in 0..COLUMNS {
        for row in 0..ROWS {
            let x = PLATE.0 + PLATE.1 * (column as f64 + 0.5) / COLUMNS as f64;
            let y = 0.002 * (row as f64 + 0.5);
            let mut probe = toml::Table::new();
            probe.insert("name".into(), foot(column, row).into());
            probe.insert("type".into(), "material-point".into());
            probe.insert("body".into(), "plate".into());
            probe.insert("at_m".into(), vec![x, y].into());
            member = member.with("probe.-", probe);
        }
    }
    member
}

/// The member with a row every two steps: its load rings with periods of a millisecond.
fn sampled(member: Member) -> Member {
    member.with("outputs.probe_interval_s", 1.25e-4)
}

/// Mean over rows and over 0.20-0.25 s of σ_yy in each column \[Pa\].
fn foot_stress(run: &Run) -> Result<Vec<f64>, String> {
    let mean = |column: usize| -> Result<f64, String> {
        let means = (0..ROWS).map(|row| {
            let history = run.history(&format!("{}_stress_yy_pa", foot(column, row)))?;
            Ok(series::mean(&history, 0.20, 0.25))
        });
        Ok(means.sum::<Result<f64, String>>()? / ROWS as f64)
    };
    (0..COLUMNS).map(mean).collect()
}

/// Displacement of the tip \[m\] over time.
fn tip(run: &Run) -> Result<Vec<(f64, f64)>, String> {
    let x = run.history("tip_displacement_x_m")?;
    let y = run.column("tip_displacement_y_m")?;
    Ok(x.into_iter().zip(y).map(|((t, x), y)| (t, x.hypot(y))).collect())
}

/// Scheme of the recommended case with the solid of the source paper in it.
const PAPER_SOLID: &str = "source paper's solid, corrected";
/// Scheme of the case as the source paper states it, water included.
const PAPER: &str = "source paper";

/// Scheme of the recommended case with twice the sound speed, in steps half as long.
const FASTER_SOUND: &str = "twice the sound speed";

/// Times between which the load on the plate is judged \[s\]: after the body's impact; its last bounce ends at 0.25 s.
const LOADED: (f64, f64) = (0.24, 0.40);
/// Times to which the impulse on the plate is compared \[s\].
const IMPULSES: [f64; 3] = [0.25, 0.30, 0.40];

/// Force of the water on the plate along x over time \[N/m\].
fn load(run: &Run) -> Result<Vec<(f64, f64)>, String> {
    run.history("plate_load_force_x_n_per_m")
}

/// Root mean square of the load about its mean over 5 ms, over its mean.
fn load_noise(run: &Run) -> Result<f64, String> {
    let load = load(run)?;
    let about_mean = |(t, f): &(f64, f64)| (*t, (f - series::mean(&load, t - 0.0025, t + 0.0025)).powi(2));
    let squares: Vec<(f64, f64)> = load.iter().map(about_mean).collect();
    let (from, to) = LOADED;
    Ok(series::mean(&squares, from, to).sqrt() / series::mean(&load, from, to))
}

/// The case with the source paper's formulation of both bodies, its gradients corrected; all else stays as it is, sub-steps
/// included.
fn with_paper_solid(mut member: Member) -> Member {
    let mut formulation = toml::Table::new();
    formulation.insert("type".into(), "updated-lagrangian".into());
    formulation.insert("kernel_ratio".into(), 1.3.into());
    for body in 0..2 {
        member = member.with(&format!("solid.body.{body}.formulation"), formulation.clone());
    }
    member.scheme(PAPER_SOLID)
}

impl Case for DriftingBody {
    fn name(&self) -> &'static str {
        "drifting_body"
    }

    fn about(&self) -> &'static str {
        "case 5.2: arrival at the plate, bending of its foot, no overlap, no leak, closed books"
    }

    fn members(&self) -> Vec<Member> {
        vec![
            member("../drifting_body_coarse", 0.004),
            with_paper_solid(member("../drifting_body_coarse", 0.004)),
            sampled(member("../drifting_body", 0.002)),
            sampled(member("../drifting_body", 0.002))
                .with("fluid.sound_speed_m_s", 50.0)
                .with("time.step.time_step_s", 3.125e-5)
                .scheme(FASTER_SOUND),
            with_paper_solid(member("../drifting_body", 0.002)),
            member("../drifting_body_paper", 0.002).scheme(PAPER),
        ]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let spacing = run.member.spacing;
        let smallest = |name: &str| -> Result<f64, String> {
            Ok(run.column(name)?.into_iter().fold(f64::INFINITY, f64::min) / spacing)
        };
        let counted =
            ["particles", "outflow", "lost"].map(|kind| run.count(&format!("/fluid/counts/{kind}")));
        let start: f64 = counted.into_iter().sum::<Result<f64, String>>()?;
        let immersed = series::largest(run.column("water_in_solids_immersed_count")?);
        let (x, y) = (run.history("body_centre_x_m")?, run.history("body_centre_y_m")?);
        let stress = foot_stress(run)?;
        let (left, right) = stress.split_at(COLUMNS / 2);
        let ledger = |check: &str| run.count(&format!("/ledger/largest_{check}/value"));
        let figures = vec![
            Figure::judged(
                "tip moves by 1 mm at [s]",
                series::first_reach(&tip(run)?, 1e-3),
                Goal::Between(0.18, 0.26),
            ),
            Figure::judged(
                "body centre above 0.06 m at [s]",
                series::first_reach(&y, 0.06),
                Goal::AtMost(0.40),
            ),
            Figure::reported(
                "body centre passes the plate's right face at [s]",
                series::first_reach(&x, PLATE.0 + PLATE.1),
            ),
            Figure::reported("body centre x at the end [m]", x.last().map_or(f64::NAN, |p| p.1)),
            Figure::reported("body centre y at the end [m]", y.last().map_or(f64::NAN, |p| p.1)),
            Figure::judged(
                "smallest mean sigma_yy, left columns of the foot [Pa]",
                left.iter().copied().fold(f64::INFINITY, f64::min),
                Goal::AtLeast(f64::MIN_POSITIVE),
            ),
            Figure::judged(
                "largest mean sigma_yy, right columns of the foot [Pa]",
                right.iter().copied().fold(f64::NEG_INFINITY, f64::max),
                Goal::AtMost(-f64::MIN_POSITIVE),
            ),
            Figure::judged(
                "load on the plate from 0.24 to 0.40 s: rms about its mean over 5 ms, over its mean",
                load_noise(run)?,
                if spacing < 0.003 { Goal::AtMost(0.15) } else { Goal::None },
            ),
            Figure::judged(
                "closest pair of two bodies over spacing",
                smallest("closest_gap_body_m")?,
                Goal::AtLeast(0.5),
            ),
            Figure::judged(
                "closest pair of body and wall over spacing",
                smallest("closest_gap_wall_m")?,
                Goal::AtLeast(0.5),
            ),
            Figure::judged(
                "largest share of water inside solids [%]",
                100.0 * immersed / start,
                Goal::AtMost(0.2),
            ),
            Figure::judged("water through walls [particles]", run.lost(), Goal::AtMost(0.0)),
            Figure::reported("water over the rim [particles]", run.count("/fluid/counts/outflow")?),
            Figure::judged(
                "largest imbalance of force, of gross",
                ledger("force_imbalance")?,
                Goal::AtMost(1e-12),
            ),
            Figure::judged(
                "largest imbalance of torque, of gross",
                ledger("torque_imbalance")?,
                Goal::AtMost(1e-12),
            ),
            Figure::judged(
                "largest residual of momentum, fluid",
                ledger("fluid_momentum_residual")?,
                Goal::AtMost(1e-12),
            ),
            Figure::judged(
                "largest residual of momentum, solid",
                ledger("solid_momentum_residual")?,
                Goal::AtMost(1e-12),
            ),
        ];
        // The recommended scheme alone is judged.
        let report_only = [PAPER_SOLID, PAPER, FASTER_SOUND].contains(&run.member.scheme);
        Ok(figures
            .into_iter()
            .map(|figure| if report_only { figure.report_only() } else { figure })
            .collect())
    }

    fn comparison(&self, runs: &[Run]) -> Result<Vec<Figure>, String> {
        let of = |scheme: &str| {
            runs.iter().find(|run| run.member.scheme == scheme && run.member.stem() == "drifting_body")
        };
        let (Some(usual), Some(faster)) = (of("recommended"), of(FASTER_SOUND)) else {
            return Ok(Vec::new());
        };
        let (usual, faster) = (load(usual)?, load(faster)?);
        let compared = |name: String, from: f64, to: f64, goal: f64| {
            let [usual, faster] = [&usual, &faster].map(|load| series::mean(load, from, to) * (to - from));
            Figure::compared(name, faster, usual, goal)
        };
        let impulse = |to: f64| {
            compared(format!("impulse on the plate to {to} s, {FASTER_SOUND} [N s/m]"), 0.0, to, 0.06)
        };
        let part = |k: u32| {
            let from = LOADED.0 + 0.03 * f64::from(k);
            let name = format!("impulse on the plate in the 30 ms from {from:.2} s, {FASTER_SOUND} [N s/m]");
            compared(name, from, from + 0.03, 0.12)
        };
        Ok(IMPULSES.into_iter().map(impulse).chain((0..5).map(part)).collect())
    }

    fn plots(&self, runs: &[Run]) -> Result<Vec<Plot>, String> {
        let mut tips = Plot::new("tip", "t [s]", "displacement of the plate's tip [m]");
        let mut paths = Plot::new("path", "x [m]", "y [m], centre of the body");
        for run in runs {
            let label = format!("{}, {} mm", run.member.scheme, 1e3 * run.member.spacing);
            tips.line(label.clone(), tip(run)?);
            let path = run.column("body_centre_x_m")?.into_iter().zip(run.column("body_centre_y_m")?);
            paths.line(label, path.collect());
        }
        Ok(vec![tips, paths])
    }
}
