//! One run of a batch: prepared, made, continued, or kept where it is finished.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sph::coupling::solver::Role;

use crate::case::Case;
use crate::case::overrides::Override;
use crate::failure::{Failure, Kind};
use crate::results::directory::Existing;
use crate::results::files::write_file;
use crate::results::names;
use crate::results::table::Table;
use crate::resume::{self, ResumeRequest};
use crate::run::origin::{self, Origin};
use crate::run::participants::in_process::description;
use crate::run::{RunOptions, RunOutcome, RunRequest, completion};

/// File with the state of a member, beside the folder of its results.
const RECORD: &str = "member.json";
/// Folder of its results.
const RESULTS: &str = "results";

/// What a run gave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finished {
    /// Completed steps.
    pub steps: u64,
    /// Wall-clock time of its steps \[s\].
    pub wall_seconds: f64,
    /// Whether an earlier call made it.
    pub kept: bool,
    /// Step from which it was continued, where it had been interrupted.
    pub resumed_from: Option<u64>,
}

/// What is known of a member.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Resolved case and states it starts from, as a digest.
    pub case_digest: String,
    /// Builds of the solvers, arithmetic path and where solvers come from.
    pub made_by: String,
    /// How far it is.
    pub state: State,
}

/// How far a member is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum State {
    /// It runs, or was interrupted.
    Started,
    /// Its results are complete.
    Finished {
        /// Completed steps.
        steps: u64,
        /// Wall-clock time of its steps \[s\].
        wall_seconds: f64,
    },
    /// It ended before its end time.
    Failed {
        /// Exit code of its kind of failure.
        code: u8,
        /// Why.
        reason: String,
    },
}

impl Record {
    /// Reads the record in the folder of a member; `None` where there is none that can be read.
    pub fn read(folder: &Path) -> Option<Self> {
        let bytes = std::fs::read(folder.join(RECORD)).ok()?;
        serde_json::from_slice(&bytes).ok()
    }

    fn write(&self, folder: &Path) -> Result<(), Failure> {
        let write = |out: &mut _| serde_json::to_writer_pretty(out, self).map_err(std::io::Error::from);
        Ok(write_file(&folder.join(RECORD), write)?)
    }
}

/// Folder with the results of the member in `folder`.
pub fn results_of(folder: &Path) -> PathBuf {
    folder.join(RESULTS)
}

/// File with the resolved case of the member in `folder`.
pub fn case_of(folder: &Path) -> PathBuf {
    folder.join(names::CASE)
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
        _ => Err(Failure::input("a trace and a recording are files of one run, and here are several")),
    }
}

/// Digest of what decides the results of a case: its resolved text and the states that it starts from.
fn digest(case: &Case, origin: &Origin) -> String {
    completion::digest(&format!("{}\n{:?}", case.resolved_toml(), origin.digests()))
}

/// Writes the resolved case of a member, `case` with `overrides` set over it, into its `folder`; the digest of the case.
///
/// # Errors
/// All errors of the case, or when a file cannot be written.
pub fn prepare(case: &Path, overrides: &[Override], folder: &Path) -> Result<String, Failure> {
    let (case, origin) = origin::load_with(case, overrides)?;
    std::fs::create_dir_all(folder)
        .map_err(|e| Failure::output(format!("cannot create `{}`: {e}", folder.display())))?;
    let (path, text) = (case_of(folder), case.recorded_toml());
    if std::fs::read_to_string(&path).ok().as_ref() != Some(&text) {
        write_file(&path, |out| out.write_all(text.as_bytes()))?;
    }
    Ok(digest(&case, &origin))
}

/// Makes members.
pub struct Maker {
    options: RunOptions,
    made_by: String,
    fresh: bool,
}

impl Maker {
    /// Of runs with `options`; `fresh` repeats those that are finished.
    pub fn new(options: &RunOptions, fresh: bool) -> Self {
        let sources = options.servers().map(|servers| (&servers.fluid, &servers.solid));
        Self { options: options.clone(), made_by: format!("{} {sources:?}", made_by()), fresh }
    }

    /// [`prepare`], then [`Maker::make`].
    ///
    /// # Errors
    /// As both.
    pub fn prepare_and_make(
        &self,
        case: &Path,
        overrides: &[Override],
        folder: &Path,
    ) -> Result<Finished, Failure> {
        prepare(case, overrides, folder)?;
        self.make(folder)
    }

    /// Makes the member that is prepared in `folder`, continues it where it was interrupted, or reads what it left. One
    /// whose physics failed under the same case and build has the same failure.
    ///
    /// # Errors
    /// As a run, or when a file cannot be written.
    pub fn make(&self, folder: &Path) -> Result<Finished, Failure> {
        let (case, origin) = origin::load(&case_of(folder))?;
        let case_digest = digest(&case, &origin);
        drop((case, origin));
        let results = results_of(folder);
        let same = |record: &Record| record.case_digest == case_digest && record.made_by == self.made_by;
        let before = Record::read(folder).filter(|record| !self.fresh && same(record));
        match before.as_ref().map(|record| &record.state) {
            // What cannot be read is made again.
            Some(State::Finished { steps, wall_seconds }) if is_readable(&results) => {
                let (steps, wall_seconds) = (*steps, *wall_seconds);
                return Ok(Finished { steps, wall_seconds, kept: true, resumed_from: None });
            }
            Some(State::Failed { code, reason }) => {
                if let Some(kind) = [Kind::Diverged, Kind::Ledger].into_iter().find(|k| k.code() == *code) {
                    return Err(Failure::new(kind, reason));
                }
            }
            _ => {}
        }
        let record =
            |state| Record { case_digest: case_digest.clone(), made_by: self.made_by.clone(), state };
        record(State::Started).write(folder)?;
        let interrupted = before.is_some_and(|record| !matches!(record.state, State::Finished { .. }));
        match self.outcome(folder, interrupted).and_then(RunOutcome::completed) {
            Ok(RunOutcome { summary, .. }) => {
                let (steps, wall_seconds) = (summary.steps, summary.wall_seconds);
                if !is_readable(&results) {
                    let text = format!("the probes in `{}` cannot be read", results.display());
                    return Err(Failure::output(text));
                }
                record(State::Finished { steps, wall_seconds }).write(folder)?;
                let resumed_from = summary.checkpoints.resumed_from;
                Ok(Finished { steps, wall_seconds, kept: false, resumed_from })
            }
            Err(failure) => {
                // One that was stopped continues; a folder in use is another's.
                if !matches!(failure.kind, Kind::Stopped | Kind::Output) {
                    let state = State::Failed { code: failure.kind.code(), reason: failure.message.clone() };
                    record(state).write(folder)?;
                }
                Err(failure)
            }
        }
    }

    /// Runs the member in `folder`, from its last checkpoint where it was `interrupted`.
    fn outcome(&self, folder: &Path, interrupted: bool) -> Result<RunOutcome, Failure> {
        let results = results_of(folder);
        if interrupted && results.join(names::CHECKPOINTS).is_dir() {
            let request = ResumeRequest {
                folder: results.clone(),
                options: self.options.clone(),
                ..ResumeRequest::default()
            };
            match resume::resume(&request) {
                // Without a checkpoint that fits it starts once more.
                Err(failure) if matches!(failure.kind, Kind::Input) => {}
                outcome => return outcome,
            }
        }
        crate::run::run(&RunRequest {
            case: case_of(folder),
            out: Some(results),
            existing: Existing::Replace,
            options: self.options.clone(),
            ..RunRequest::default()
        })
    }
}

/// Whether the probes of a finished run can be read.
fn is_readable(results: &Path) -> bool {
    Table::read(&results.join(names::PROBES)).is_ok()
}
