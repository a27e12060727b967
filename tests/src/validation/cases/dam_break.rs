//! Collapse of a water column on a dry bed: front against Martin & Moyce (1952), energy, pressure noise.

use std::path::Path;

use coordinator::results::table::Table;

use crate::validation::particles::{domain_around, pressure_noise, smallest_distance};
use crate::validation::snapshot::Snapshot;
use crate::validation::{Case, Figure, Goal, Member, Plot, Run, energy, series};

/// See the module.
pub struct DamBreak;

/// Width of the column \[m\].
const WIDTH: f64 = 0.146;
const GRAVITY: f64 = 9.81;
/// Range of the front over which its speed is compared, in widths.
const RANGE: (f64, f64) = (1.9, 3.8);
/// The measured series.
const MEASURED: [&str; 2] = ["front_martin_moyce_1952_a1p125in.csv", "front_martin_moyce_1952_a2p25in.csv"];

impl Case for DamBreak {
    fn name(&self) -> &'static str {
        "dam_break"
    }

    fn about(&self) -> &'static str {
        "collapsing column: front against Martin & Moyce, energy, pressure noise, particles held by the walls"
    }

    fn members(&self) -> Vec<Member> {
        vec![
            Member::new("dam_break", 0.008).quick(),
            Member::new("dam_break", 0.004),
            Member::new("dam_break", 0.004)
                .scheme("recommended, long tank")
                .with("domain.upper_m", vec![1.46, 0.584])
                .with("time.end_time_s", 0.3)
                .with("outputs.picture_times_s", vec![0.1, 0.2, 0.3]),
            Member::new("dam_break", 0.002)
                .with("time.end_time_s", 0.3)
                .with("outputs.picture_times_s", vec![0.1, 0.2, 0.3]),
        ]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let front = front(run)?;
        let measured = measured()?;
        let [one, two] = &measured;
        let slopes = [slope(one), slope(two)];
        let band = (0.95 * slopes[0].min(slopes[1]), 1.05 * slopes[0].max(slopes[1]));
        let spacing = run.member.spacing;
        // The goals are set for 4 mm and finer.
        let goal = |goal| if spacing > 0.005 { Goal::None } else { goal };
        let mut figures = vec![
            Figure::judged(
                "mean dZ/dT between Z = 1.9 and 3.8",
                slope(&front),
                goal(Goal::Between(band.0, band.1)),
            ),
            Figure::judged("lead of the front in T", lead(&front, &measured), goal(Goal::AtMost(0.25))),
        ];
        let energies = energy::total(run, "water")?;
        let start = energies[0].1;
        let left = series::at(&energies, 0.25) / start;
        let left_goal = if spacing < 0.003 { Goal::AtLeast(0.90) } else { Goal::None };
        figures.extend([
            Figure::judged("total energy at 0.25 s over that of the start", left, left_goal),
            energy::rise(run, "water")?,
            Figure::judged("particles lost", run.lost(), Goal::AtMost(0.0)),
        ]);
        figures.extend(of_snapshots(run)?);
        Ok(figures)
    }

    fn plots(&self, runs: &[Run]) -> Result<Vec<Plot>, String> {
        let mut plot = Plot::new("front", "T = t sqrt(2g/a)", "Z = front/a");
        for (points, name) in measured()?.into_iter().zip(["a = 1.125 in", "a = 2.25 in"]) {
            plot.points(format!("Martin & Moyce, {name}"), points);
        }
        let mut energies = Plot::new("energy", "t [s]", "total energy over that of the start");
        for run in runs {
            let name = format!("{} {} m", run.member.scheme, run.member.spacing);
            plot.line(name.clone(), front(run)?.into_iter().filter(|p| p.1 < 4.0).collect());
            let history = energy::total(run, "water")?;
            let start = history[0].1;
            energies.line(name, history.into_iter().map(|(t, e)| (t, e / start)).collect());
        }
        Ok(vec![plot, energies])
    }
}

/// Largest noise and closest pair over the snapshots.
fn of_snapshots(run: &Run) -> Result<Vec<Figure>, String> {
    let spacing = run.member.spacing;
    let h = run.number("fluid.kernel_ratio")? * spacing;
    let right = run.number("domain.upper_m.0").unwrap_or(f64::NAN);
    let (mut closest, mut squares, mut count) = (f64::INFINITY, 0.0, 0.0);
    for (time, path) in run.fluid_snapshots()? {
        let snapshot = Snapshot::read(&path, 1)?;
        let domain = domain_around(&snapshot.position, spacing);
        closest = closest.min(smallest_distance(&domain, &snapshot.position, spacing));
        if (0.2695..0.4005).contains(&time) {
            let near_wall = |x: &sph::space::Vector| x.x < 2.0 * h || x.y < 2.0 * h || x.x > right - 2.0 * h;
            squares += pressure_noise(&domain, &snapshot, h, near_wall).powi(2);
            count += 1.0;
        }
    }
    let mut figures = vec![Figure::reported("closest pair over spacing", closest / spacing)];
    if count > 1.0 && spacing == 0.004 && run.member.scheme == "recommended" {
        let noise = f64::sqrt(squares / count);
        figures.push(Figure::judged(
            "pressure noise, rms over 0.27 to 0.40 s [Pa]",
            noise,
            Goal::AtMost(100.0),
        ));
    }
    Ok(figures)
}

/// Front over width against T = t √(2g/a).
fn front(run: &Run) -> Result<Vec<(f64, f64)>, String> {
    let scale = (2.0 * GRAVITY / WIDTH).sqrt();
    Ok(run.history("head_front_x_m")?.into_iter().map(|(t, x)| (t * scale, x / WIDTH)).collect())
}

fn measured() -> Result<[Vec<(f64, f64)>; 2], String> {
    let read = |name: &str| -> Result<Vec<(f64, f64)>, String> {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("reference").join(name);
        let table = Table::read(&path).map_err(|e| e.to_string())?;
        Ok(table.column_at(0).into_iter().zip(table.column_at(1)).collect())
    };
    Ok([read(MEASURED[0])?, read(MEASURED[1])?])
}

/// Mean speed of a front over [`RANGE`], between its first passages.
fn slope(front: &[(f64, f64)]) -> f64 {
    let (low, high) = RANGE;
    (high - low) / (series::first_reach(front, high) - series::first_reach(front, low))
}

/// Mean time by which a front is ahead of the mean of the measured ones over [`RANGE`].
fn lead(front: &[(f64, f64)], measured: &[Vec<(f64, f64)>; 2]) -> f64 {
    let (low, high) = RANGE;
    let levels: Vec<f64> = (0..=20).map(|k| low + (high - low) * f64::from(k) / 20.0).collect();
    let ahead = |level: &f64| {
        let [one, two] = measured.each_ref().map(|points| series::first_reach(points, *level));
        0.5 * (one + two) - series::first_reach(front, *level)
    };
    levels.iter().map(ahead).sum::<f64>() / levels.len() as f64
}
