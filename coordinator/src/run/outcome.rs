//! What a run gives back.

use std::path::PathBuf;

use proto::recording::player::Replayed;

use crate::failure::Failure;
use crate::results::summary::Summary;

/// A run that has ended and written its results, whether or not it reached its end time.
#[derive(Clone, Debug)]
pub struct RunOutcome {
    /// Folder of the results.
    pub directory: PathBuf,
    /// Verdict and figures, as `summary.json` holds them.
    pub summary: Summary,
    /// Why the run ended before its end time, if it did, or its reservations where these fail it.
    pub failure: Option<Failure>,
    /// How the solver compares with the recording, if one was replayed.
    pub replayed: Option<Replayed>,
}

impl RunOutcome {
    /// This run, if it reached its end time.
    ///
    /// # Errors
    /// Why it did not.
    pub fn completed(self) -> Result<Self, Failure> {
        match self.failure {
            None => Ok(self),
            Some(failure) => Err(failure),
        }
    }
}
