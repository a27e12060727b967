//! Half-step frames: what they carry, and their messages. The writer keeps what the protocol sends only on change.

use bytes::Bytes;
use sph::coupling::exchange::{Frame, FrameContent, PreviousStage};

use super::arrays::{pack, pack_indices};
use super::{Choice, Convert, Path, WireError, count, extent_to_wire, optional, required};
use crate::description::FrameField;
use crate::wire;

/// Makes the messages of own frames.
pub(crate) struct FrameWriter {
    run_id: String,
    epoch: u32,
    layout: Layout,
    sent_set: Option<u64>,
    /// Version of the own extent that the partner has.
    told_extent: u64,
}

/// Which fields the frames of one side carry, in a run of how many dimensions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    pub(crate) fields: &'static [FrameField],
    pub(crate) dimensions: usize,
}

impl Layout {
    /// What frames of these fields carry.
    pub(super) fn content(&self) -> FrameContent {
        FrameField::content(self.fields)
    }
}

impl FrameWriter {
    /// A writer of frames of `layout`, whose partner knows extent `told_extent` from the hand-shake.
    pub(crate) fn new(run_id: &str, epoch: u32, layout: Layout, told_extent: u64) -> Self {
        Self { run_id: run_id.to_owned(), epoch, layout, sent_set: None, told_extent }
    }

    /// The message of `frame`.
    pub(crate) fn write(&mut self, frame: &Frame) -> wire::Frame {
        if let Some(acceptance) = &frame.acceptance {
            return wire::Frame { acceptance: Some(acceptance.to_wire()), ..self.head(frame) };
        }
        let states = &frame.states;
        let content = self.layout.content();
        let number = if content == FrameContent::Forces { frame.forces.len() } else { states.len() };
        let changed = self.sent_set != Some(frame.set_version) && content != FrameContent::Forces;
        let masses: &[f64] = if content == FrameContent::States { &states.mass } else { &[] };
        let set = changed.then(|| wire::ParticleSet {
            ids: pack_indices(&states.id),
            groups: pack_indices(&states.group),
            masses_kg: pack(masses),
        });
        self.sent_set = Some(frame.set_version);
        let extent = (self.told_extent != frame.extent.version).then(|| extent_to_wire(&frame.extent));
        self.told_extent = frame.extent.version;
        wire::Frame {
            set_version: frame.set_version,
            count: count(number),
            set,
            blocks: self.layout.fields.iter().map(|field| self.block(*field, frame)).collect(),
            digest: frame.digest(),
            extent_version: frame.extent.version,
            extent,
            partner_extent_version: frame.partner_extent_version,
            reach_m: Some(frame.reach),
            time_step_limit_s: Some(frame.time_step_limit),
            previous: frame.previous.as_ref().map(Convert::to_wire),
            ..self.head(frame)
        }
    }

    /// What every frame of a half-step begins with.
    fn head(&self, frame: &Frame) -> wire::Frame {
        wire::Frame {
            run_id: self.run_id.clone(),
            epoch: self.epoch,
            step: frame.time.at.step,
            stage: frame.time.at.stage.code(),
            iteration: frame.iteration,
            step_start_s_bits: frame.time.step_start.to_bits(),
            time_step_s_bits: frame.time.time_step.to_bits(),
            ..wire::Frame::default()
        }
    }

    fn block(&self, field: FrameField, frame: &Frame) -> wire::Block {
        let states = &frame.states;
        let data: Bytes = match field {
            FrameField::Position => pack(&states.position.values),
            FrameField::Velocity => pack(&states.velocity.values),
            FrameField::Density => pack(&states.density),
            FrameField::Pressure => pack(&states.pressure),
            FrameField::Stress => pack(&states.stress.values),
            FrameField::Volume => pack(&states.volumes().collect::<Vec<_>>()),
            FrameField::Force => pack(&frame.forces.values),
        };
        wire::Block { field: field.code(), components: field.components(self.layout.dimensions), data }
    }

    /// The message that ends the stream.
    pub(crate) fn farewell(&self, reason: &str) -> wire::Frame {
        wire::Frame {
            run_id: self.run_id.clone(),
            epoch: self.epoch,
            farewell: Some(wire::Farewell { reason: reason.to_owned() }),
            ..wire::Frame::default()
        }
    }
}

impl Convert for PreviousStage {
    type Wire = wire::PreviousStage;

    fn to_wire(&self) -> wire::PreviousStage {
        wire::PreviousStage {
            at: Some(self.at.to_wire()),
            sums: Some(self.sums.to_wire()),
            used_digest: self.used_digest,
            momentum: self.momentum.as_ref().map(Convert::to_wire),
        }
    }

    fn from_wire(wire: &wire::PreviousStage, at: &Path<'_>) -> Result<Self, WireError> {
        Ok(Self {
            at: required(&wire.at, &at.field("at"))?,
            sums: required(&wire.sums, &at.field("sums"))?,
            used_digest: wire.used_digest,
            momentum: optional(&wire.momentum, &at.field("momentum"))?,
        })
    }
}
