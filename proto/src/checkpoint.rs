//! Checkpoints as they travel: what one belongs to, its data, and the digest of these.

use bytes::Bytes;
use sha2::{Digest, Sha256};
use sph::coupling::driver::{Checkpoint, restore, save};
use sph::coupling::exchange::Extent;
use sph::coupling::saved::SavedState;
use sph::coupling::solver::{Role, Solver};
use sph::coupling::stage::ClockState;

use crate::convert::{Convert, Path, WireError, choice, count, decode_state, encode_state, finite, name};
use crate::convert::{extent_from_wire, positive, positive_or_infinite, text};
use crate::description::Description;
use crate::limits::{CHUNK_BYTES, EAGER_BYTES};
use crate::wire;

/// Name and version of the layout of the data of this workspace's solvers.
pub const FORMAT: &str = "tidelock-state/1";

/// What a checkpoint belongs to.
#[derive(Clone, Debug, PartialEq)]
pub struct CheckpointHeader {
    /// Name and version of the layout of the data.
    pub format: String,
    /// Name of the program.
    pub name: String,
    /// Its version.
    pub version: String,
    /// What else tells builds apart.
    pub build: String,
    /// How floating-point sums are made.
    pub arithmetic: String,
    /// Side.
    pub role: Role,
    /// Completed steps.
    pub step: u64,
    /// Time \[s\].
    pub time: f64,
    /// Size of the next step \[s\].
    pub next_time_step: f64,
}

/// A checkpoint of one side. Only the solver reads its data.
#[derive(Clone, Debug, PartialEq)]
pub struct CheckpointData {
    /// What it belongs to.
    pub header: CheckpointHeader,
    /// The solver's data.
    pub data: Bytes,
    /// SHA-256 of the data.
    pub sha256: [u8; 32],
}

/// SHA-256 of `data`.
pub fn digest(data: &[u8]) -> [u8; 32] {
    Sha256::digest(data).into()
}

impl CheckpointHeader {
    /// What `checkpoint` belongs to, by the `role` of the solver that `description` describes.
    pub fn new(description: &Description, role: Role, checkpoint: &Checkpoint) -> Self {
        Self {
            format: FORMAT.into(),
            name: description.name.clone(),
            version: description.version.clone(),
            build: description.build.clone(),
            arithmetic: description.arithmetic.clone(),
            role,
            step: checkpoint.step,
            time: checkpoint.time,
            next_time_step: checkpoint.time_step,
        }
    }

    /// What keeps a solver of `description` from going on as `role`; empty when nothing does.
    ///
    /// Differences of the build, which a user may accept, come apart: first what may not differ, then what may.
    pub fn differences(&self, description: &Description, role: Role) -> [Vec<String>; 2] {
        let compare = |list: &mut Vec<String>, what: &str, saved: &str, here: &str| {
            if saved != here {
                list.push(format!("{what}: {saved:?} in the checkpoint, {here:?} here"));
            }
        };
        let (mut fatal, mut build) = (Vec::new(), Vec::new());
        compare(&mut fatal, "format", &self.format, FORMAT);
        compare(&mut fatal, "role", &self.role.to_string(), &role.to_string());
        compare(&mut fatal, "arithmetic path", &self.arithmetic, &description.arithmetic);
        compare(&mut build, "solver", &self.name, &description.name);
        compare(&mut build, "version", &self.version, &description.version);
        compare(&mut build, "build", &self.build, &description.build);
        [fatal, build]
    }
}

impl CheckpointData {
    /// The checkpoint as it travels and is kept.
    pub fn new(header: CheckpointHeader, checkpoint: Checkpoint) -> Self {
        let data = Bytes::from(encode_state(checkpoint.state));
        let sha256 = digest(&data);
        Self { header, data, sha256 }
    }

    /// The state.
    ///
    /// # Errors
    /// When the data are no saved state.
    pub fn state(&self) -> Result<SavedState, String> {
        decode_state(&self.data)
    }

    /// Header, pieces of data and trailer, in this order.
    pub(crate) fn parts(&self) -> impl Iterator<Item = Part> + use<> {
        let header = wire::CheckpointHeader { total_bytes: count(self.data.len()), ..self.header.to_wire() };
        let data = self.data.clone();
        let pieces = (0..data.len()).step_by(CHUNK_BYTES);
        let pieces: Vec<Part> = pieces
            .map(|start| Part::Data(data.slice(start..(start + CHUNK_BYTES).min(data.len()))))
            .collect();
        let trailer = wire::CheckpointTrailer { sha256: self.sha256.to_vec().into() };
        std::iter::once(Part::Header(header)).chain(pieces).chain([Part::Trailer(trailer)])
    }
}

/// A state that a solver has taken over, with its digest computed again from the solver's memory.
///
/// # Errors
/// When the state does not fit the solver's set-up; the solver is then of no further use.
pub fn restore_solver(solver: &mut dyn Solver, data: &CheckpointData) -> Result<ClockState, String> {
    let state = data.state()?;
    let clock = restore(solver, &state).map_err(|error| error.to_string())?;
    let header = &data.header;
    if (clock.step, clock.time.to_bits()) != (header.step, header.time.to_bits()) {
        return Err(format!(
            "its data are of step {} at {:?} s, its header says step {} at {:?} s",
            clock.step, clock.time, header.step, header.time
        ));
    }
    if digest(&encode_state(save(solver, &clock).state)) != data.sha256 {
        return Err("the solver holds another state after taking it over".into());
    }
    Ok(clock)
}

/// What a server holds after a restore.
#[derive(Clone, Debug, PartialEq)]
pub struct RestoreReport {
    /// Completed steps.
    pub step: u64,
    /// Time \[s\].
    pub time: f64,
    /// Where its particles are.
    pub extent: Extent,
    /// Largest stable next step \[s\].
    pub time_step_limit: f64,
}

impl RestoreReport {
    /// That of a run of `dimensions` dimensions.
    pub(crate) fn from_wire(wire: &wire::RestoreReply, dimensions: usize) -> Result<Self, WireError> {
        let at = Path::root("reply");
        Ok(Self {
            step: wire.step,
            time: finite(f64::from_bits(wire.time_s_bits), &at.field("time_s_bits"))?,
            extent: extent_from_wire(&wire.extent, dimensions, &at.field("extent"))?,
            time_step_limit: positive_or_infinite(wire.time_step_limit_s, &at.field("time_step_limit_s"))?,
        })
    }
}

impl Convert for CheckpointHeader {
    type Wire = wire::CheckpointHeader;

    fn to_wire(&self) -> wire::CheckpointHeader {
        use crate::convert::Choice;
        wire::CheckpointHeader {
            format: self.format.clone(),
            name: self.name.clone(),
            version: self.version.clone(),
            build: self.build.clone(),
            arithmetic: self.arithmetic.clone(),
            role: self.role.code(),
            step: self.step,
            time_s_bits: self.time.to_bits(),
            next_time_step_s_bits: self.next_time_step.to_bits(),
            total_bytes: 0,
        }
    }

    fn from_wire(wire: &wire::CheckpointHeader, at: &Path<'_>) -> Result<Self, WireError> {
        Ok(Self {
            format: name(&wire.format, &at.field("format"))?,
            name: name(&wire.name, &at.field("name"))?,
            version: text(&wire.version, &at.field("version"))?,
            build: text(&wire.build, &at.field("build"))?,
            arithmetic: text(&wire.arithmetic, &at.field("arithmetic"))?,
            role: choice(wire.role, &at.field("role"))?,
            step: wire.step,
            time: finite(f64::from_bits(wire.time_s_bits), &at.field("time_s_bits"))?,
            next_time_step: positive(
                f64::from_bits(wire.next_time_step_s_bits),
                &at.field("next_time_step_s_bits"),
            )?,
        })
    }
}

/// One message of a stream that carries a checkpoint.
pub(crate) enum Part {
    Header(wire::CheckpointHeader),
    Data(Bytes),
    Trailer(wire::CheckpointTrailer),
}

macro_rules! parts_of {
    ($module:ident) => {
        impl From<wire::$module::Part> for Part {
            fn from(part: wire::$module::Part) -> Self {
                match part {
                    wire::$module::Part::Header(header) => Self::Header(header),
                    wire::$module::Part::Data(data) => Self::Data(data),
                    wire::$module::Part::Trailer(trailer) => Self::Trailer(trailer),
                }
            }
        }

        impl From<Part> for wire::$module::Part {
            fn from(part: Part) -> Self {
                match part {
                    Part::Header(header) => Self::Header(header),
                    Part::Data(data) => Self::Data(data),
                    Part::Trailer(trailer) => Self::Trailer(trailer),
                }
            }
        }
    };
}

parts_of!(checkpoint_chunk);
parts_of!(restore_chunk);

/// Puts a checkpoint together from its parts.
pub(crate) struct CheckpointAssembler {
    largest: u64,
    current: Option<(CheckpointHeader, usize, Vec<u8>)>,
}

impl CheckpointAssembler {
    /// An assembler for a checkpoint of at most `largest` bytes.
    pub(crate) fn new(largest: u64) -> Self {
        Self { largest, current: None }
    }

    /// Takes the next part; answers the checkpoint with its trailer.
    pub(crate) fn take(&mut self, part: Option<Part>) -> Result<Option<CheckpointData>, WireError> {
        let at = Path::root("checkpoint");
        match (part, self.current.take()) {
            (Some(Part::Header(wire)), None) => {
                let at = at.field("header");
                let header = CheckpointHeader::from_wire(&wire, &at)?;
                let total = usize::try_from(wire.total_bytes)
                    .ok()
                    .filter(|_| wire.total_bytes <= self.largest)
                    .ok_or_else(|| {
                        let problem =
                            format!("is {}, at most {} are allowed", wire.total_bytes, self.largest);
                        at.field("total_bytes").error(problem)
                    })?;
                self.current = Some((header, total, Vec::with_capacity(total.min(EAGER_BYTES))));
                Ok(None)
            }
            (Some(Part::Data(piece)), Some((header, total, mut data))) => {
                let left = total - data.len();
                if piece.is_empty() || piece.len() > left {
                    let problem = format!("has {} bytes where 1 to {left} were expected", piece.len());
                    return Err(at.field("data").error(problem));
                }
                data.extend_from_slice(&piece);
                self.current = Some((header, total, data));
                Ok(None)
            }
            (Some(Part::Trailer(trailer)), Some((header, total, data))) => {
                let at = at.field("trailer");
                if data.len() != total {
                    let problem = format!("came after {} of {total} bytes of data", data.len());
                    return Err(at.error(problem));
                }
                let sha256 = digest(&data);
                if trailer.sha256 != sha256.as_slice() {
                    return Err(at
                        .field("sha256")
                        .error("is not that of the data: they were damaged on the way"));
                }
                Ok(Some(CheckpointData { header, data: data.into(), sha256 }))
            }
            (Some(Part::Header(_)), Some(_)) => Err(at.field("header").error("came twice")),
            (Some(Part::Data(_) | Part::Trailer(_)), None) => Err(at.error("data came before a header")),
            (None, _) => Err(at.field("part").error("is missing")),
        }
    }
}
