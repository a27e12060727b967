//! Families of runs: one case at several spacings, sound speeds and seeds, one after another.
//!
//! For each key figure a family gives mean and spread over seeds at each resolution, and what these do under refinement:
//! order, extrapolated value and estimated error, or that they do not converge. Members that are finished are kept, so
//! that a family that was stopped continues; a member that fails is named and the others go ahead.

pub mod by_probe;
pub mod convergence;
pub mod defaults;
pub mod figures;
pub mod page;
pub mod plan;
mod results;
pub mod spread;
pub mod verdict;

use std::path::PathBuf;

use serde::Serialize;

use self::convergence::Trend;
use self::figures::Figure;
use self::plan::{Place, Plan};
use self::spread::Spread;
use crate::batch::{self, Batch};
use crate::case::file::member::MemberTable;
use crate::failure::Failure;
use crate::run::RunRequest;

/// A family of runs to be made.
#[derive(Clone, Debug)]
pub struct FamilyRequest {
    /// What the members have in common: case, values set over it, and how it is run. `out` is the folder of the family,
    /// by default `results/` and the name of the case file with `_family`; earlier results of members are replaced.
    pub run: RunRequest,
    /// Spacings \[m\] of the fluid, in a case without fluid of the solid; that of the case when empty.
    pub spacings: Vec<f64>,
    /// Sound speeds of the fluid \[m/s\]; that of the case when empty.
    pub sound_speeds: Vec<f64>,
    /// Seeds of the displacement of the water; as the case says when empty.
    pub seeds: Vec<u64>,
    /// Largest displacement along each axis over the spacing, where there are seeds.
    pub displacement_fraction: f64,
    /// Key figures; largest, smallest and last value of every probe column when empty.
    pub figures: Vec<Figure>,
    /// Repeat all runs; otherwise those that this build has finished in that folder are kept.
    pub fresh: bool,
    /// Runs at a time.
    pub jobs: usize,
}

impl Default for FamilyRequest {
    fn default() -> Self {
        Self {
            run: RunRequest::default(),
            spacings: Vec::new(),
            sound_speeds: Vec::new(),
            seeds: Vec::new(),
            displacement_fraction: MemberTable::DEFAULT_DISPLACEMENT,
            figures: Vec::new(),
            fresh: false,
            jobs: 1,
        }
    }
}

/// A family that was made.
#[derive(Debug, Serialize)]
pub struct Family {
    /// Its folder.
    #[serde(skip)]
    pub folder: PathBuf,
    /// Runs, in the order in which they were made.
    pub members: Vec<Member>,
    /// Key figures, in the order asked for.
    pub figures: Vec<FigureResult>,
}

/// One run of a family.
#[derive(Debug, Serialize)]
pub struct Member {
    /// Where it stands in the family.
    pub place: Place,
    /// Folder of its results.
    #[serde(skip)]
    pub folder: PathBuf,
    /// What it gave, or why it gave nothing.
    #[serde(serialize_with = "results::outcome")]
    pub outcome: Result<Finished, Failure>,
}

/// What a finished run gave.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finished {
    /// Completed steps.
    pub steps: u64,
    /// Wall-clock time of its steps \[s\].
    pub wall_seconds: f64,
    /// Key figures in the order of the plan; `None` where the run has no such value.
    pub figures: Vec<Option<f64>>,
}

/// A key figure over all resolutions.
#[derive(Debug, Serialize)]
pub struct FigureResult {
    /// The figure.
    #[serde(serialize_with = "results::text")]
    pub figure: Figure,
    /// At each resolution.
    pub values: Vec<Resolution>,
    /// Under refinement of the spacing, at each sound speed \[m/s\].
    pub over_spacing: Vec<(Option<f64>, Trend)>,
    /// Under growing sound speed, its inverse being the step, at each spacing \[m\].
    pub over_sound_speed: Vec<(f64, Trend)>,
}

/// A figure at one spacing and sound speed.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Resolution {
    /// Spacing \[m\].
    pub spacing_m: f64,
    /// Sound speed \[m/s\]; `None` in a case without fluid.
    pub sound_speed_m_s: Option<f64>,
    /// Members that gave no value: they failed, or have no such value.
    pub missing: usize,
    /// Mean and spread over seeds; `None` when no member gave a value.
    pub spread: Option<Spread>,
}

/// Runs a family, calls `each` with a line about each run, and writes `members.csv` and `family.json`.
///
/// # Errors
/// When the case or a figure is wrong, a file cannot be written, or the family is stopped from outside; finished runs are
/// kept. A member that fails for reasons of its own is in the result.
pub fn run(request: &FamilyRequest, each: impl Fn(&str)) -> Result<Family, Failure> {
    batch::member::must_suit_many(&request.run.options)?;
    let plan = Plan::of(request)?;
    let folder =
        request.run.out.clone().unwrap_or_else(|| crate::run::default_folder(&request.run.case, "_family"));
    let batch = Batch {
        case: &request.run.case,
        options: &request.run.options,
        folder: &folder,
        jobs: request.jobs,
        fresh: request.fresh,
    };
    let runs: Vec<batch::Member> = plan.places.iter().map(|place| plan.member(request, place)).collect();
    let mut done = 0;
    let outcomes = batch.run(&runs, |place, outcome| {
        done += 1;
        each(&format!("[{done}/{}] {}: {}", runs.len(), runs[place].label, batch::line(outcome)));
    })?;
    let mut members: Vec<Member> = Vec::new();
    for ((place, run), outcome) in plan.places.iter().zip(&runs).zip(outcomes) {
        let results = batch::member::results_of(&batch.folder_of(&run.label));
        let outcome = outcome.and_then(|run| {
            let (steps, wall_seconds) = (run.steps, run.wall_seconds);
            Ok(Finished { steps, wall_seconds, figures: figures::of_results(&results, &plan.figures)? })
        });
        members.push(Member { place: *place, folder: results, outcome });
    }
    let figures =
        plan.figures.iter().enumerate().map(|(k, figure)| judge(k, figure, &members, &plan)).collect();
    let family = Family { folder, members, figures };
    results::write(&family)?;
    Ok(family)
}

/// Joins the values of figure `k` of all members.
fn judge(k: usize, figure: &Figure, members: &[Member], plan: &Plan) -> FigureResult {
    let mut values = Vec::new();
    for (spacing, sound_speed) in plan.resolutions() {
        let here =
            members.iter().filter(|m| (m.place.spacing, m.place.sound_speed) == (spacing, sound_speed));
        let found: Vec<Option<f64>> =
            here.map(|member| *member.outcome.as_ref().ok()?.figures.get(k)?).collect();
        let known: Vec<f64> = found.iter().flatten().copied().collect();
        values.push(Resolution {
            spacing_m: spacing,
            sound_speed_m_s: sound_speed,
            missing: found.len() - known.len(),
            spread: Spread::of(&known),
        });
    }
    let trend = |chosen: &dyn Fn(&Resolution) -> Option<f64>| {
        let point = |at: &Resolution| Some((chosen(at)?, at.spread?));
        convergence::trend(&values.iter().filter_map(point).collect::<Vec<_>>())
    };
    let over_spacing = plan
        .sound_speeds
        .iter()
        .filter(|_| plan.spacings.len() > 1)
        .map(|speed| (*speed, trend(&|at| (at.sound_speed_m_s == *speed).then_some(at.spacing_m))));
    let over_sound_speed = plan.spacings.iter().filter(|_| plan.sound_speeds.len() > 1).map(|spacing| {
        (*spacing, trend(&|at| at.sound_speed_m_s.filter(|_| at.spacing_m == *spacing).map(f64::recip)))
    });
    let (over_spacing, over_sound_speed) = (over_spacing.collect(), over_sound_speed.collect());
    FigureResult { figure: figure.clone(), values, over_spacing, over_sound_speed }
}

#[cfg(test)]
mod tests;
