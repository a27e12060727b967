//! `coordinator replay` and `coordinator compare`: recordings of half-step frames.

use std::path::Path;
use std::sync::Arc;

use proto::recording::{self, Recording};
use sph::solver::Role;
use terminal::say;

use crate::cli::{CompareArguments, ReplayArguments};
use crate::failure::{Failure, Kind};
use crate::run::origin;
use crate::run::{self, Job, completion};

/// Runs one side of a recorded run alone and compares what it sends with the recording.
///
/// # Errors
/// When the recording is not one of the case from its start to its end, as [`run::run`], and when the side sends other bits.
pub fn replay(arguments: &ReplayArguments) -> Result<(), Failure> {
    arguments.new.options.force_arithmetic()?;
    let (options, side) = (arguments.new.options.clone(), arguments.side);
    if options.in_process || options.relay || options.relay_listen.is_some() || options.record.is_some() {
        return Err(Failure::input(
            "`replay` runs one server against a recording; `--in-process`, `--relay`, `--relay-listen` and `--record` are \
             for `run`",
        ));
    }
    let (case, origin) = origin::load(&arguments.case)?;
    let recording = Recording::open(&arguments.recording)?;
    check(&recording, &completion::digest(&case.identity()), &arguments.case)?;
    let directory = arguments.new.create(&arguments.case, "_replay", &origin)?;
    let origin = origin.keep(&directory)?;
    let quiet = options.quiet;
    let alone = Some((side, arguments.recording.clone()));
    let directory = Arc::new(directory);
    let job = Job { case, origin, directory, options, resume: None, alone };
    let replayed = run::execute(&job)?.unwrap_or_default();
    match (replayed.difference, replayed.problem) {
        (Some(difference), _) => Err(Failure::new(
            Kind::Different,
            format!(
                "the {side} solver does not repeat the recording (first: recorded, second: now) after {} equal frames:\n\
                 {difference}",
                replayed.equal_frames
            ),
        )),
        (None, Some(problem)) => {
            Err(Failure::new(Kind::Different, format!("the {side}'s frames cannot be compared: {problem}")))
        }
        (None, None) => {
            if !quiet {
                terminal::note(format_args!(
                    "{} frames of the {side} equal the recording to the last bit",
                    replayed.equal_frames
                ));
            }
            Ok(())
        }
    }
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

/// Tells where two recordings differ first.
///
/// # Errors
/// When they differ, or one cannot be read.
pub fn compare(arguments: &CompareArguments) -> Result<(), Failure> {
    let open = |path: &Path| Recording::open(path).map_err(|e| Failure::input(e.to_string()));
    let mut recordings = [open(&arguments.first)?, open(&arguments.second)?];
    for recording in &recordings {
        if !recording.is_complete() {
            terminal::note(format_args!("warning: recording `{}` was cut off", recording.path().display()));
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
    say(format_args!("{equal} half-steps, equal to the last bit"));
    Ok(())
}

/// The side that a word on the command line names.
///
/// # Errors
/// Another word.
pub fn side(word: &str) -> Result<Role, String> {
    [Role::Fluid, Role::Solid]
        .into_iter()
        .find(|role| role.to_string() == word)
        .ok_or_else(|| "must be `fluid` or `solid`".into())
}
