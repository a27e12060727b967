//! Recordings of half-step frames: one solver against a recording, and two recordings against each other.

use std::path::{Path, PathBuf};

use proto::recording::{self, Recording};
use sph::coupling::solver::Role;

use crate::failure::{Failure, Kind};
use crate::messages::Messages;
use crate::results::directory::Existing;
use crate::run::job::{Job, Replay};
use crate::run::{self, Placement, RunOptions, RunOutcome, completion, origin};

/// One side of a recorded run, to be run again alone.
#[derive(Clone, Debug)]
pub struct ReplayRequest {
    /// Case file of the recorded run.
    pub case: PathBuf,
    /// Recording of the whole run.
    pub recording: PathBuf,
    /// Side that runs; the other is played.
    pub side: Role,
    /// Folder for the results; by default `results/` and the name of the case file with `_replay`.
    pub out: Option<PathBuf>,
    /// What becomes of the results of an earlier run in that folder.
    pub existing: Existing,
    /// How it is run: as a server whose frames are not relayed.
    pub options: RunOptions,
}

/// Runs one side of a recorded run alone and compares what it sends with the recording.
///
/// # Errors
/// When the recording is not one of the case from its start to its end, as [`run::run`], and when the side sends other bits
/// or ends before the end time.
pub fn replay(request: &ReplayRequest) -> Result<RunOutcome, Failure> {
    request.options.force_arithmetic()?;
    let (options, side) = (request.options.clone(), request.side);
    if !matches!(&options.solvers, Placement::Servers(servers) if servers.relay.is_none()) {
        return Err(Failure::input(
            "`replay` runs one server against a recording; `--in-process`, `--relay`, `--relay-listen` and `--record` are \
             for `run`",
        ));
    }
    let (case, origin) = origin::load(&request.case)?;
    let recording = Recording::open(&request.recording)?;
    check(&recording, &completion::digest(&case.identity()), &request.case)?;
    let out = request.out.clone().unwrap_or_else(|| run::default_folder(&request.case, "_replay"));
    let directory = run::new_folder(&out, request.existing, &origin)?;
    let messages = options.messages;
    let replay = Some(Replay { side, recording: request.recording.clone() });
    let outcome = run::execute(&Job { case, origin, directory, options, resume: None, replay })?;
    let replayed = outcome.replayed.clone().unwrap_or_default();
    // Where it differs says more than the end to which that led.
    if let Some(difference) = replayed.difference {
        return Err(Failure::new(
            Kind::Different,
            format!(
                "the {side} solver does not repeat the recording (first: recorded, second: now) after {} equal frames:\n\
                 {difference}",
                replayed.equal_frames
            ),
        ));
    }
    let outcome = outcome.completed()?;
    if let Some(problem) = replayed.problem {
        return Err(Failure::new(
            Kind::Different,
            format!("the {side}'s frames cannot be compared: {problem}"),
        ));
    }
    messages.progress(format_args!(
        "{} frames of the {side} equal the recording to the last bit",
        replayed.equal_frames
    ));
    Ok(outcome)
}

/// That `recording` is of the case at `path`, whose digest is `digest`.
fn check(recording: &Recording, digest: &str, path: &Path) -> Result<(), Failure> {
    let of = recording.attempts().iter().find(|attempt| attempt.case_digest != digest);
    match of {
        None => Ok(()),
        Some(attempt) => Err(Failure::input(format!(
            "recording `{}` is of another case than `{}`, or of other values of it: case `{}`, digest {:.12} where this one \
             has {digest:.12}; give the case that was recorded",
            recording.path().display(),
            path.display(),
            attempt.case_name,
            attempt.case_digest
        ))),
    }
}

/// Compares two recordings; returns the number of their half-steps, all equal to the last bit.
///
/// # Errors
/// Where they differ first, or when one cannot be read.
pub fn compare(first: &Path, second: &Path, messages: Messages) -> Result<u64, Failure> {
    let open = |path: &Path| Recording::open(path).map_err(|e| Failure::input(e.to_string()));
    let mut recordings = [open(first)?, open(second)?];
    for recording in &recordings {
        if !recording.is_complete() {
            messages.warning(format_args!("recording `{}` was cut off", recording.path().display()));
        }
    }
    let [first, second] = &mut recordings;
    let found = recording::compare(first, second).map_err(|e| Failure::input(e.to_string()))?;
    let equal = found.equal_half_steps;
    if let Some(difference) = found.difference {
        return Err(Failure::new(Kind::Different, format!("after {equal} equal half-steps: {difference}")));
    }
    if let Some((at, which)) = found.alone {
        let path = recordings[which].path().display();
        return Err(Failure::new(
            Kind::Different,
            format!("after {equal} equal half-steps: only `{path}` has frames of {at}"),
        ));
    }
    Ok(equal)
}
