//! A block near the floor of a tank: its approach and rest, and the force that lifts it off.

use std::cmp::Ordering;

use crate::validation::cases::floating::{coupling, rectangle};
use crate::validation::{Case, Figure, Goal, Member, Plot, Run};

/// A block sinks onto the floor.
pub struct Approach;

/// A force that grows slowly lifts a block off the floor.
pub struct Lift;

/// Side of the block \[m\].
const SIDE: f64 = 0.036;
/// Left side of the block \[m\].
const LEFT: f64 = 0.232;
/// Gap below the block at its release \[m\].
const RELEASE: f64 = 0.02;
/// Depth of the water before the block displaces any, and width of the tank \[m\].
const DEPTH: f64 = 0.1;
const WIDTH: f64 = 0.5;
const GRAVITY: f64 = 9.81;
const WATER: f64 = 1000.0;

/// Gap whose time of passage is compared \[m\].
const PASSED: f64 = 0.004;
/// Part of the run at its end over which the gap at rest is averaged.
const REST: f64 = 0.1;
/// Largest gap at rest in spacings \[-\].
const LARGEST_REST: f64 = 0.6;

/// Growth of the gap that counts as lift-off \[m\].
const LIFTED: f64 = 0.001;
/// The force grows to this multiple of the expected one.
const LARGEST: f64 = 2.0;

/// Part of the time of the pull after which a run ends.
const UNTIL: f64 = 0.65;

/// Gap below the block over time \[s, m\].
fn gap(run: &Run) -> Result<Vec<(f64, f64)>, String> {
    let history = run.history("block_centre_y_m")?;
    Ok(history.into_iter().map(|(t, y)| (t, y - 0.5 * SIDE)).collect())
}

/// First time at which `what` holds of the gap \[s\].
fn first(history: &[(f64, f64)], what: impl Fn(f64) -> bool) -> Option<f64> {
    history.iter().find(|(_, gap)| what(*gap)).map(|(t, _)| *t)
}

/// Density of the block of `run` \[kg/m³\].
fn density(run: &Run) -> Result<f64, String> {
    let changed = run.member.changes.iter().find(|(path, _)| path.ends_with("density_kg_m3"));
    changed
        .and_then(|(_, value)| value.as_float())
        .ok_or_else(|| "the member gives its block no density".to_owned())
}

/// Member of a block of `density` \[kg/m³\] whose lower side starts at `gap` \[m\] over the floor.
fn member(scheme: &'static str, spacing: f64, density: f64, gap: f64) -> Member {
    Member::new("near_floor", spacing)
        .scheme(scheme)
        .with("solid.body.0.material.density_kg_m3", density)
        .with("solid.body.0.shape", rectangle([LEFT, gap], [LEFT + SIDE, gap + SIDE]))
}

impl Case for Approach {
    fn name(&self) -> &'static str {
        "approach"
    }

    fn about(&self) -> &'static str {
        "a block sinks onto the floor of a tank: the time converges with the spacing, and it rests on the floor"
    }

    fn members(&self) -> Vec<Member> {
        let of = |scheme, density, end: f64| {
            [0.004, 0.002, 0.001]
                .map(|spacing| member(scheme, spacing, density, RELEASE).with("time.end_time_s", end))
        };
        [of("1100", 1100.0, 1.2), of("2500", 2500.0, 0.5)].concat()
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let gap = gap(run)?;
        let spacing = run.member.spacing;
        let end = gap.last().map_or(f64::NAN, |(t, _)| *t);
        let rest: Vec<f64> =
            gap.iter().filter(|(t, _)| *t > end - REST).map(|(_, gap)| *gap / spacing).collect();
        let mean = rest.iter().sum::<f64>() / rest.len() as f64;
        let inside = run.column("inside_immersed_count")?.into_iter().fold(0.0, f64::max);
        let time = |limit: f64| first(&gap, |gap| gap < limit).unwrap_or(f64::NAN);
        let mut figures = vec![
            Figure::reported("time at which the gap passes 4 mm [s]", time(PASSED)),
            Figure::reported("time at which the gap passes half a spacing [s]", time(0.5 * spacing)),
            Figure::judged("gap at rest over the spacing", mean, Goal::AtMost(LARGEST_REST)),
            Figure::judged("most water particles inside the block", inside, Goal::AtMost(0.0)),
        ];
        figures.extend(coupling(run));
        Ok(figures)
    }

    fn comparison(&self, runs: &[Run]) -> Result<Vec<Figure>, String> {
        let mut figures = Vec::new();
        for scheme in ["1100", "2500"] {
            let mut times = Vec::new();
            for run in runs.iter().filter(|run| run.member.scheme == scheme) {
                times.push((run.member.spacing, first(&gap(run)?, |gap| gap < PASSED).unwrap_or(f64::NAN)));
            }
            times.sort_by(|a, b| b.0.partial_cmp(&a.0).unwrap_or(Ordering::Equal));
            let [(_, coarse), (_, medium), (_, fine)] = times[..] else { continue };
            let order = ((coarse - medium) / (medium - fine)).abs().log2();
            let name = format!("observed order of the time at 4 mm, {scheme} kg/m3");
            figures.push(Figure::judged(name, order, Goal::AtLeast(0.8)));
        }
        Ok(figures)
    }

    fn plots(&self, runs: &[Run]) -> Result<Vec<Plot>, String> {
        gaps(runs)
    }
}

/// Gaps over time.
fn gaps(runs: &[Run]) -> Result<Vec<Plot>, String> {
    let mut plot = Plot::new("gap", "t [s]", "gap below the block [m]");
    for run in runs {
        plot.line(run.member.label(), gap(run)?);
    }
    Ok(vec![plot])
}

/// A pull that grows within a time.
#[derive(Clone, Copy)]
struct Pull {
    density: f64,
    /// Whether water presses below the block.
    wet: bool,
    /// Time in which the force grows to twice the expected one \[s\].
    time: f64,
}

impl Pull {
    /// Force at which the block leaves the floor \[N/m\]: wet its weight less its buoyancy, dry its weight and the water above.
    fn expected(self) -> f64 {
        let weight = self.density * GRAVITY * SIDE * SIDE;
        let surface = DEPTH + SIDE * SIDE / WIDTH;
        let (top, bottom) = (WATER * GRAVITY * (surface - SIDE), WATER * GRAVITY * surface);
        if self.wet { weight - (bottom - top) * SIDE } else { weight + top * SIDE }
    }

    /// Force at `t` \[s\] \[N/m\].
    fn force(self, t: f64) -> f64 {
        LARGEST * self.expected() * t / self.time
    }

    fn member(self, scheme: &'static str, spacing: f64) -> Member {
        let rate = LARGEST * self.expected() / self.time / (self.density * SIDE * SIDE);
        let pull = vec!["0".to_owned(), format!("{rate}*t")];
        member(scheme, spacing, self.density, 0.0)
            .with("solid.contact.wet", self.wet)
            .with("solid.body.0.acceleration_m_s2", pull)
            // Lift-off comes somewhat later than half-way.
            .with("time.end_time_s", UNTIL * self.time)
            .with("outputs.snapshot_interval_s", 0.25 * self.time)
    }

    /// That of `run`.
    fn of(run: &Run) -> Result<Self, String> {
        let change =
            |path: &str| run.member.changes.iter().find(|(found, _)| found == path).map(|(_, value)| value);
        let number =
            |path: &str| change(path).and_then(toml::Value::as_float).ok_or_else(|| format!("no `{path}`"));
        let wet = change("solid.contact.wet").and_then(toml::Value::as_bool) == Some(true);
        Ok(Self { density: density(run)?, wet, time: number("time.end_time_s")? / UNTIL })
    }
}

/// Force at lift-off over the expected one.
fn lift_off(run: &Run) -> Result<f64, String> {
    let (gap, pull) = (gap(run)?, Pull::of(run)?);
    let start = gap.iter().map(|(_, gap)| *gap).fold(f64::INFINITY, f64::min);
    let time = first(&gap, |gap| gap > start + LIFTED).ok_or("the block did not leave the floor")?;
    Ok(pull.force(time) / pull.expected())
}

impl Case for Lift {
    fn name(&self) -> &'static str {
        "lift"
    }

    fn about(&self) -> &'static str {
        "a block on the floor of a tank is lifted by its weight less its buoyancy; where contact is dry by the water above, too"
    }

    fn members(&self) -> Vec<Member> {
        let wet = |scheme, density, time, spacing| Pull { density, wet: true, time }.member(scheme, spacing);
        let dry = |scheme, time, spacing| Pull { density: 2500.0, wet: false, time }.member(scheme, spacing);
        vec![
            wet("2500 in 1 s", 2500.0, 1.0, 0.004).quick(),
            wet("2500 in 2 s", 2500.0, 2.0, 0.004),
            wet("2500 in 4 s", 2500.0, 4.0, 0.004),
            wet("2500 in 1 s", 2500.0, 1.0, 0.002),
            wet("2500 in 2 s", 2500.0, 2.0, 0.002),
            wet("2500 in 4 s", 2500.0, 4.0, 0.002),
            wet("1100 in 4 s", 1100.0, 4.0, 0.004),
            wet("1100 in 8 s", 1100.0, 8.0, 0.004),
            dry("dry in 1 s", 1.0, 0.002),
            dry("dry in 2 s", 2.0, 0.002),
        ]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let force = lift_off(run).unwrap_or(f64::NAN);
        let mut figures = vec![Figure::reported("force at lift-off over the expected one", force)];
        if run.member.quick {
            // By the force's time alone; see `comparison`.
            figures[0] = Figure::judged("force at lift-off over the expected one", force, Goal::AtMost(1.2));
        }
        figures.extend(coupling(run));
        Ok(figures)
    }

    /// The force over that of a slow pull: a block of mass m has risen by s under the excess F' t at t = (6 m s/F')^⅓, so that the
    /// excess goes with F' to the power 2/3.
    fn comparison(&self, runs: &[Run]) -> Result<Vec<Figure>, String> {
        let mut figures = Vec::new();
        for run in runs {
            let pull = Pull::of(run)?;
            let slower = |other: &&Run| {
                Pull::of(other).is_ok_and(|of_other| {
                    other.member.spacing == run.member.spacing
                        && of_other.density == pull.density
                        && of_other.wet == pull.wet
                        && of_other.time > 1.5 * pull.time
                        && of_other.time < 2.5 * pull.time
                })
            };
            let Some(slow) = runs.iter().find(slower) else { continue };
            let (Ok(fast), Ok(slow)) = (lift_off(run), lift_off(slow)) else { continue };
            let share = 0.5f64.powf(2.0 / 3.0);
            let limit = (slow - share * fast) / (1.0 - share);
            let kind = if pull.wet { "wet" } else { "dry" };
            let name = format!(
                "force of a slow pull over the expected one, {kind}, {} kg/m3, {} m, from {} s",
                pull.density, run.member.spacing, pull.time
            );
            figures.push(Figure::compared(name, limit, 1.0, 0.03));
        }
        Ok(figures)
    }

    fn plots(&self, runs: &[Run]) -> Result<Vec<Plot>, String> {
        gaps(runs)
    }
}
