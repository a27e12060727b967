//! One run of a family: made, or kept where it is finished.

use std::path::Path;

use serde::{Deserialize, Serialize};
use sph::coupling::solver::Role;

use super::FamilyRequest;
use super::figures::Histories;
use super::plan::{Place, Plan};
use crate::failure::{Failure, Kind};
use crate::results::directory::Existing;
use crate::results::files::write_file;
use crate::run::participants::in_process::description;
use crate::run::{RunOptions, RunOutcome, RunRequest, origin};

/// File that marks a run as finished, beside the folder of its results.
const FINISHED: &str = "finished.json";
/// Folder of its results.
const RESULTS: &str = "results";

/// What a finished run gave.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finished {
    /// Completed steps.
    pub steps: u64,
    /// Wall-clock time of its steps \[s\].
    pub wall_seconds: f64,
    /// Whether an earlier call made it.
    #[serde(skip)]
    pub kept: bool,
    /// Key figures in the order of the plan; `None` where the run has no such value.
    pub figures: Vec<Option<f64>>,
}

/// What is kept of a finished run.
#[derive(Debug, Serialize, Deserialize)]
struct Record {
    /// Resolved case, states it started from, builds, as a digest.
    made_from: String,
    steps: u64,
    wall_seconds: f64,
}

/// What makes runs here: builds of the solvers and arithmetic path, and where solvers come from.
pub struct Built(String);

impl Built {
    /// Of runs with `options`.
    pub fn here(options: &RunOptions) -> Self {
        let sources = options.servers().map(|servers| (&servers.fluid, &servers.solid));
        Self(format!("{} {sources:?}", made_by()))
    }
}

/// Names the builds of the solvers in this program and the arithmetic path.
pub fn made_by() -> String {
    let arithmetic = sph::lanes::Arithmetic::chosen().name();
    format!("{} {} {arithmetic}", description(Role::Fluid).build, description(Role::Solid).build)
}

/// That `options` can be those of several runs.
///
/// # Errors
/// When they name a file of one run.
pub fn must_suit_many(options: &RunOptions) -> Result<(), Failure> {
    let recorded = options.servers().and_then(|servers| servers.relay.as_ref()?.record.as_ref());
    match (&options.trace, recorded) {
        (None, None) => Ok(()),
        _ => Err(Failure::input("a trace and a recording are files of one run, and a family has several")),
    }
}

/// Makes the run at `place` in `folder`, or reads what it left.
///
/// # Errors
/// As a run, or when its outputs cannot be read.
pub fn run(
    request: &FamilyRequest,
    plan: &Plan,
    place: &Place,
    folder: &Path,
    built: &Built,
) -> Result<Finished, Failure> {
    let mut overrides = request.run.overrides.clone();
    overrides.extend(plan.changes(place));
    let (case, origin) = origin::load_with(&request.run.case, &overrides)?;
    let made_from = format!("{}\n{:?}\n{}", case.resolved_toml(), origin.digests(), built.0);
    let made_from = crate::run::completion::digest(&made_from);
    let (record, results) = (folder.join(FINISHED), folder.join(RESULTS));
    if !request.fresh {
        let before: Option<Record> =
            std::fs::read(&record).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok());
        let before = before.filter(|before| before.made_from == made_from);
        // What cannot be read is made again.
        if let Some(kept) = before.and_then(|record| finished(&record, plan, &results).ok()) {
            return Ok(Finished { kept: true, ..kept });
        }
    }
    let problem = |what: &str, path: &Path, e: std::io::Error| {
        Failure::output(format!("cannot {what} `{}`: {e}", path.display()))
    };
    std::fs::create_dir_all(folder).map_err(|e| problem("create", folder, e))?;
    if let Err(e) = std::fs::remove_file(&record)
        && e.kind() != std::io::ErrorKind::NotFound
    {
        return Err(problem("remove", &record, e));
    }
    let request = RunRequest {
        case: request.run.case.clone(),
        overrides,
        out: Some(results.clone()),
        existing: Existing::Replace,
        options: request.run.options.clone(),
    };
    let RunOutcome { summary, .. } = crate::run::run(&request)?.completed()?;
    let written = Record { made_from, steps: summary.steps, wall_seconds: summary.wall_seconds };
    let finished = finished(&written, plan, &results).map_err(|e| Failure::new(Kind::Output, e))?;
    write_file(&record, |out| serde_json::to_writer_pretty(out, &written).map_err(std::io::Error::from))?;
    Ok(finished)
}

/// Reads the figures of a run off its results.
fn finished(record: &Record, plan: &Plan, results: &Path) -> Result<Finished, String> {
    let histories = Histories::read(results)?;
    let figures = plan.figures.iter().map(|figure| {
        // A level that this member does not reach is a result, a column that is missing none.
        Ok(figure.of_history(&histories.of(&figure.column)?).ok())
    });
    Ok(Finished {
        steps: record.steps,
        wall_seconds: record.wall_seconds,
        kept: false,
        figures: figures.collect::<Result<_, String>>()?,
    })
}
