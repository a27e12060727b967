//! A run to be made, its case and folder at hand.

use std::path::PathBuf;
use std::sync::Arc;

use sph::coupling::solver::Role;

use super::origin::Origin;
use super::request::RunOptions;
use crate::case::Case;
use crate::checkpoint::{OriginDigests, RunCheckpoint};
use crate::results::directory::OutputDirectory;
use crate::results::table::Changed;

/// A run to be made or to be continued.
pub(crate) struct Job {
    /// What is computed.
    pub case: Case,
    /// The states that it starts from; none where it continues.
    pub origin: Origin,
    /// Where results go.
    pub directory: Arc<OutputDirectory>,
    /// How it is run.
    pub options: RunOptions,
    /// Where it continues.
    pub resume: Option<Resumption>,
    /// The only side that runs; the other is played from a recording.
    pub replay: Option<Replay>,
}

/// Where a run continues, and which differences are accepted.
pub(crate) struct Resumption {
    /// State of both sides and of the outputs.
    pub checkpoint: RunCheckpoint,
    /// Another build of a solver may take over.
    pub accept_other_build: bool,
    /// What to do with outputs that are not as they were.
    pub changed: Changed,
}

/// One side that runs against a recording.
pub(crate) struct Replay {
    /// Side that runs.
    pub side: Role,
    /// Recording from which the other is played.
    pub recording: PathBuf,
}

impl Job {
    /// Digests of the states that the run started from.
    pub fn origin_digests(&self) -> OriginDigests {
        match &self.resume {
            Some(resume) => resume.checkpoint.outputs.origin.clone(),
            None => self.origin.digests(),
        }
    }

    /// Whether the solver of `role` is started.
    pub fn runs(&self, role: Role) -> bool {
        self.case.has(role) && self.replay.as_ref().is_none_or(|replay| replay.side == role)
    }
}
