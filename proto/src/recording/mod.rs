//! Recordings of the half-step frames of a run: FORM of `recording.proto` says what a file holds.

mod compare;
pub mod player;
mod reader;
mod writer;

pub use compare::{Comparison, Difference, compare};
pub(crate) use compare::{Ids, difference};
pub use reader::Recording;
pub(crate) use writer::Record;
pub use writer::RecordingWriter;

use std::path::{Path, PathBuf};

use sph::coupling::exchange::Extent;
use sph::coupling::solver::Role;
use sph::coupling::stage::StepStage;
use sph::setup::CouplingKind;

use crate::convert::{
    self, Convert, WireError, choice, extent_from_wire, extent_to_wire, positive_or_infinite,
};
use crate::limits::MAX_FRAME_BYTES;
use crate::wire;

/// First bytes of a recording.
const MAGIC: &[u8; 6] = b"FSIREC";
/// Version of the form that is written and read.
const VERSION: u16 = 2;
/// Bytes of magic and version.
const HEAD_BYTES: u64 = 8;
/// Bytes of a record before its payload.
const RECORD_BYTES: usize = 9;

/// A recording that cannot be written or read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("recording `{}`: {problem}", path.display())]
pub struct RecordingError {
    path: PathBuf,
    problem: String,
}

impl RecordingError {
    fn new(path: &Path, problem: impl Into<String>) -> Self {
        Self { path: path.to_owned(), problem: problem.into() }
    }
}

/// What the frames of one attempt at a run belong to.
#[derive(Clone, Debug, PartialEq)]
pub struct Attempt {
    /// Run to which they belong.
    pub run_id: String,
    /// Name of the case.
    pub case_name: String,
    /// Digest of what decides the case's results.
    pub case_digest: String,
    /// Name and version of the fluid's and the solid's solver.
    pub solvers: [String; 2],
    /// What the solid sent and got.
    pub coupling_kind: CouplingKind,
    /// Counts the restores.
    pub epoch: u32,
    /// Completed steps before the first frame.
    pub first_step: u64,
    /// Smaller of both sides' first limits of the time step \[s\].
    pub first_limit: f64,
    /// Where the particles of the fluid and of the solid were.
    pub extents: [Extent; 2],
}

impl Convert for Attempt {
    type Wire = wire::Attempt;

    fn to_wire(&self) -> wire::Attempt {
        let [fluid_solver, solid_solver] = self.solvers.clone();
        // Two corners of three numbers; of a run without any box it does not matter.
        let spatial = self.extents.iter().any(|extent| extent.boxes.components == 6);
        wire::Attempt {
            run_id: self.run_id.clone(),
            case_name: self.case_name.clone(),
            case_digest: self.case_digest.clone(),
            fluid_solver,
            solid_solver,
            coupling_kind: convert::Choice::code(self.coupling_kind),
            epoch: self.epoch,
            first_step: self.first_step,
            first_limit_s: Some(self.first_limit),
            fluid_extent: Some(extent_to_wire(&self.extents[0])),
            solid_extent: Some(extent_to_wire(&self.extents[1])),
            dimensions: if spatial { 3 } else { 2 },
        }
    }

    fn from_wire(wire: &wire::Attempt, at: &convert::Path<'_>) -> Result<Self, WireError> {
        let dimensions = match wire.dimensions {
            0 | 2 => 2,
            3 => 3,
            other => return Err(at.field("dimensions").error(format!("is {other}, must be 2 or 3"))),
        };
        Ok(Self {
            run_id: wire.run_id.clone(),
            case_name: wire.case_name.clone(),
            case_digest: wire.case_digest.clone(),
            solvers: [wire.fluid_solver.clone(), wire.solid_solver.clone()],
            coupling_kind: choice(wire.coupling_kind, &at.field("coupling_kind"))?,
            epoch: wire.epoch,
            first_step: wire.first_step,
            first_limit: positive_or_infinite(wire.first_limit_s, &at.field("first_limit_s"))?,
            extents: [
                extent_from_wire(&wire.fluid_extent, dimensions, &at.field("fluid_extent"))?,
                extent_from_wire(&wire.solid_extent, dimensions, &at.field("solid_extent"))?,
            ],
        })
    }
}

/// Where a frame stands in a run: half-step, iteration, and the solid's acceptance after its samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Moment {
    /// Half-step.
    pub at: StepStage,
    /// Repetition of it; 0 unless half-steps are iterated.
    pub iteration: u32,
    /// Whether the frame accepts that iteration.
    pub accepts: bool,
}

impl Moment {
    /// That of `frame`.
    pub(crate) fn of(frame: &wire::Frame) -> Result<Self, WireError> {
        let stage = choice(frame.stage, &convert::Path::root("frame").field("stage"))?;
        let at = StepStage { step: frame.step, stage };
        Ok(Self { at, iteration: frame.iteration, accepts: frame.acceptance.is_some() })
    }
}

impl std::fmt::Display for Moment {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { at, iteration, accepts } = self;
        match (iteration, accepts) {
            (0, false) => at.fmt(f),
            (_, false) => write!(f, "{at}, iteration {iteration}"),
            (_, true) => write!(f, "{at}, acceptance of iteration {iteration}"),
        }
    }
}

/// What a record is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum RecordKind {
    Attempt,
    Frame(Role),
    End,
}

impl RecordKind {
    const ALL: [RecordKind; 4] =
        [Self::Attempt, Self::Frame(Role::Fluid), Self::Frame(Role::Solid), Self::End];

    fn code(self) -> u8 {
        match self {
            Self::Attempt => 1,
            Self::Frame(Role::Fluid) => 2,
            Self::Frame(Role::Solid) => 3,
            Self::End => 4,
        }
    }

    fn named(code: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.code() == code)
    }
}

/// First bytes of a record with this payload; `None` for one that is too large.
fn record_head(kind: RecordKind, payload: &[u8]) -> Option<[u8; RECORD_BYTES]> {
    let length = u32::try_from(payload.len()).ok().filter(|_| payload.len() <= MAX_FRAME_BYTES)?;
    let mut head = [0; RECORD_BYTES];
    head[0] = kind.code();
    head[1..5].copy_from_slice(&length.to_le_bytes());
    let mut digest = crc32fast::Hasher::new();
    digest.update(&head[..5]);
    digest.update(payload);
    head[5..].copy_from_slice(&digest.finalize().to_le_bytes());
    Some(head)
}

#[cfg(test)]
mod tests;
