//! Half-step frames. Writer and reader keep what the protocol sends only on change.

use bytes::Bytes;
use sph::coupling::exchange::{Column, Extent, Frame, FrameContent, PreviousStage, StateColumns};
use sph::coupling::stage::{StageTime, StepStage};

use super::arrays::{
    index_count, pack, pack_indices, unpack_column, unpack_ids, unpack_indices, unpack_positive,
};
use super::{
    Choice, Convert, Path, WireError, choice, count, finite, not_negative, optional, positive,
    positive_or_infinite, required,
};
use crate::description::FrameField;
use crate::limits::MAX_PARTICLES;
use crate::wire;

/// Makes the messages of own frames.
pub(crate) struct FrameWriter {
    run_id: String,
    epoch: u32,
    fields: &'static [FrameField],
    sent_set: Option<u64>,
    /// Version of the own extent that the partner has.
    told_extent: u64,
}

impl FrameWriter {
    /// A writer of frames with `fields`, whose partner knows extent `told_extent` from the hand-shake.
    pub(crate) fn new(run_id: &str, epoch: u32, fields: &'static [FrameField], told_extent: u64) -> Self {
        Self { run_id: run_id.to_owned(), epoch, fields, sent_set: None, told_extent }
    }

    /// The message of `frame`.
    pub(crate) fn write(&mut self, frame: &Frame) -> wire::Frame {
        if let Some(acceptance) = &frame.acceptance {
            return wire::Frame { acceptance: Some(acceptance.to_wire()), ..self.head(frame) };
        }
        let states = &frame.states;
        let content = FrameField::content(self.fields);
        let number = if content == FrameContent::Forces { frame.forces.len() } else { states.len() };
        let changed = self.sent_set != Some(frame.set_version) && content != FrameContent::Forces;
        let masses: &[f64] = if content == FrameContent::States { &states.mass } else { &[] };
        let set = changed.then(|| wire::ParticleSet {
            ids: pack_indices(&states.id),
            groups: pack_indices(&states.group),
            masses_kg: pack(masses),
        });
        self.sent_set = Some(frame.set_version);
        let extent = (self.told_extent != frame.extent.version).then(|| frame.extent.to_wire());
        self.told_extent = frame.extent.version;
        wire::Frame {
            set_version: frame.set_version,
            count: count(number),
            set,
            blocks: self.fields.iter().map(|field| block(*field, frame)).collect(),
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

fn block(field: FrameField, frame: &Frame) -> wire::Block {
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
    wire::Block { field: field.code(), components: field.components().into(), data }
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

/// What a message of the partner was.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum ReceivedFrame {
    /// The frame of the expected half-step.
    Frame,
    /// The partner has ended, for this reason.
    Farewell(String),
}

/// Checks the partner's messages and makes frames of them.
pub(crate) struct FrameReader {
    run_id: String,
    epoch: u32,
    required: &'static [FrameField],
    /// Half-step and iteration of the last frame.
    last: Option<(StepStage, u32)>,
    set: Option<KnownSet>,
    extent: Extent,
}

/// The last set that came.
struct KnownSet {
    version: u64,
    id: Vec<u32>,
    group: Vec<u32>,
    mass: Vec<f64>,
}

impl FrameReader {
    /// A reader for frames with the fields `required` of a partner whose extent is `extent` from the hand-shake.
    pub(crate) fn new(run_id: &str, epoch: u32, required: &'static [FrameField], extent: Extent) -> Self {
        Self { run_id: run_id.to_owned(), epoch, required, last: None, set: None, extent }
    }

    /// Checks that `wire` is the partner's frame of half-step `expected` and fills `frame` from it.
    pub(crate) fn read(
        &mut self,
        wire: &wire::Frame,
        expected: StepStage,
        frame: &mut Frame,
    ) -> Result<ReceivedFrame, WireError> {
        let at = Path::root("frame");
        if wire.run_id != self.run_id {
            let problem = format!("is {:?}, expected {:?}", wire.run_id, self.run_id);
            return Err(at.field("run_id").error(problem));
        }
        if wire.epoch != self.epoch {
            return Err(at.field("epoch").error(format!("is {}, expected {}", wire.epoch, self.epoch)));
        }
        if let Some(farewell) = &wire.farewell {
            return Ok(ReceivedFrame::Farewell(farewell.reason.chars().take(1000).collect()));
        }
        self.check_order(wire, expected, &at)?;
        frame.time = StageTime {
            at: expected,
            step_start: finite(f64::from_bits(wire.step_start_s_bits), &at.field("step_start_s_bits"))?,
            time_step: positive(f64::from_bits(wire.time_step_s_bits), &at.field("time_step_s_bits"))?,
        };
        frame.iteration = wire.iteration;
        frame.acceptance = optional(&wire.acceptance, &at.field("acceptance"))?;
        if frame.acceptance.is_some() {
            return Ok(ReceivedFrame::Frame);
        }
        frame.content = FrameField::content(self.required);
        if frame.content == FrameContent::Forces {
            self.read_forces(wire, frame, &at)?;
        } else {
            self.read_set(wire, &at)?;
            self.read_states(wire, frame.content, &mut frame.states, &at)?;
        }
        frame.set_version = wire.set_version;
        let digest = frame.digest();
        if digest != wire.digest {
            let problem = format!("is {:08x}, but the data have {digest:08x} (DATA_LOSS)", wire.digest);
            return Err(at.field("digest").error(problem));
        }
        self.read_extent(wire, &at)?;
        frame.extent.clone_from(&self.extent);
        frame.partner_extent_version = wire.partner_extent_version;
        frame.reach = not_negative(wire.reach_m, &at.field("reach_m"))?;
        frame.time_step_limit = positive_or_infinite(wire.time_step_limit_s, &at.field("time_step_limit_s"))?;
        frame.previous = optional(&wire.previous, &at.field("previous"))?;
        self.last = Some((expected, wire.iteration));
        Ok(ReceivedFrame::Frame)
    }

    fn check_order(&self, wire: &wire::Frame, expected: StepStage, at: &Path<'_>) -> Result<(), WireError> {
        let got = StepStage { step: wire.step, stage: choice(wire.stage, &at.field("stage"))? };
        if got != expected {
            let remark = match self.last {
                Some((last, _)) if got == last => ", which came before: a duplicate",
                Some((last, _)) if got < last => ", which is past",
                _ => "",
            };
            return Err(at.error(format!("expected that of {expected}, got {got}{remark}")));
        }
        // Only implicit coupling has a second frame.
        let due = match self.last {
            Some((last, iteration)) if last == expected => iteration + 1,
            _ => 0,
        };
        let (accepts, points) =
            (wire.acceptance.is_some(), FrameField::content(self.required) == FrameContent::CouplingPoints);
        if wire.iteration == due && !accepts || accepts && points && wire.iteration + 1 == due {
            return Ok(());
        }
        if accepts {
            let problem =
                format!("is of iteration {}, expected is a frame of iteration {due}", wire.iteration);
            return Err(at.field("acceptance").error(problem));
        }
        Err(at.field("iteration").error(format!("is {}, expected {due}", wire.iteration)))
    }

    fn read_set(&mut self, wire: &wire::Frame, at: &Path<'_>) -> Result<(), WireError> {
        let Some(set) = &wire.set else {
            return match &self.set {
                Some(known) if known.version == wire.set_version => Ok(()),
                Some(known) => {
                    let problem =
                        format!("is {} without a set, the last set was {}", wire.set_version, known.version);
                    Err(at.field("set_version").error(problem))
                }
                None => Err(at.field("set").error("is missing in the first frame")),
            };
        };
        let at = at.field("set");
        let count = index_count(&set.ids, &at.field("ids"))?;
        let points = FrameField::content(self.required) == FrameContent::CouplingPoints;
        let masses = if points { 0 } else { count };
        self.set = Some(KnownSet {
            version: wire.set_version,
            id: unpack_ids(&set.ids, count, &at.field("ids"))?,
            group: unpack_indices(&set.groups, count, &at.field("groups"))?,
            mass: unpack_positive(&set.masses_kg, masses, &at.field("masses_kg"))?,
        });
        Ok(())
    }

    /// Forces of the partner, which the receiver compares with the coupling points that it sent.
    fn read_forces(&self, wire: &wire::Frame, frame: &mut Frame, at: &Path<'_>) -> Result<(), WireError> {
        if wire.set.is_some() {
            return Err(at.field("set").error("is given with forces, which belong to the receiver's set"));
        }
        frame.states.clear();
        let number = usize::try_from(wire.count).unwrap_or(usize::MAX);
        self.check_fields(&wire.blocks, at)?;
        for (k, block) in wire.blocks.iter().enumerate() {
            unpack_block(FrameField::Force, block, number, &mut frame.forces, &at.item("blocks", k))?;
        }
        Ok(())
    }

    /// Checks that the blocks are those of the required fields, in their order.
    fn check_fields(&self, blocks: &[wire::Block], at: &Path<'_>) -> Result<(), WireError> {
        for (k, block) in blocks.iter().enumerate() {
            let at = at.item("blocks", k);
            let field: FrameField = choice(block.field, &at.field("field"))?;
            match self.required.get(k) {
                Some(required) if *required == field => {}
                Some(required) => {
                    let problem = format!("is the {}, must be the {}", field.name(), required.name());
                    return Err(at.field("field").error(problem));
                }
                None => {
                    return Err(at
                        .field("field")
                        .error(format!("is the {}, which is not expected", field.name())));
                }
            }
        }
        match self.required.get(blocks.len()) {
            None => Ok(()),
            Some(missing) => Err(at.field("blocks").error(format!("lack the {}", missing.name()))),
        }
    }

    fn read_states(
        &self,
        wire: &wire::Frame,
        content: FrameContent,
        states: &mut StateColumns,
        at: &Path<'_>,
    ) -> Result<(), WireError> {
        let Some(known) = &self.set else { return Err(at.field("set").error("is missing")) };
        let count = known.id.len();
        if count > MAX_PARTICLES || wire.count != super::count(count) {
            let problem = format!("is {}, but the set has {count} particles", wire.count);
            return Err(at.field("count").error(problem));
        }
        states.clear();
        states.id.extend_from_slice(&known.id);
        states.group.extend_from_slice(&known.group);
        states.mass.extend_from_slice(&known.mass);
        self.check_fields(&wire.blocks, at)?;
        for ((k, block), field) in wire.blocks.iter().enumerate().zip(self.required) {
            let at = at.item("blocks", k);
            match field {
                FrameField::Position => unpack_block(*field, block, count, &mut states.position, &at)?,
                FrameField::Velocity => unpack_block(*field, block, count, &mut states.velocity, &at)?,
                FrameField::Stress => unpack_block(*field, block, count, &mut states.stress, &at)?,
                FrameField::Density => unpack_numbers(*field, block, count, &mut states.density, &at)?,
                FrameField::Volume => unpack_numbers(*field, block, count, &mut states.mass, &at)?,
                FrameField::Pressure => unpack_numbers(*field, block, count, &mut states.pressure, &at)?,
                FrameField::Force => return Err(at.error("is no field of a frame of particles")),
            }
        }
        if content == FrameContent::CouplingPoints {
            // Only the volume m/ρ of a coupling point has a meaning.
            states.density.clear();
            states.density.resize(count, 1.0);
            states.pressure.clear();
            states.pressure.resize(count, 0.0);
        }
        Ok(())
    }

    fn read_extent(&mut self, wire: &wire::Frame, at: &Path<'_>) -> Result<(), WireError> {
        match &wire.extent {
            Some(extent) => {
                let extent: Extent = Convert::from_wire(extent, &at.field("extent"))?;
                if extent.version != wire.extent_version {
                    let problem = format!("is {}, extent_version is {}", extent.version, wire.extent_version);
                    return Err(at.field("extent").field("version").error(problem));
                }
                self.extent = extent;
                Ok(())
            }
            None if wire.extent_version == self.extent.version => Ok(()),
            None => {
                let problem = format!(
                    "is {} without an extent, the last was {}",
                    wire.extent_version, self.extent.version
                );
                Err(at.field("extent_version").error(problem))
            }
        }
    }
}

/// Unpacks the numbers of `count` particles into `column`.
fn unpack_block(
    field: FrameField,
    block: &wire::Block,
    count: usize,
    column: &mut Column,
    at: &Path<'_>,
) -> Result<(), WireError> {
    let components = field.components();
    if block.components != u32::from(components) {
        let problem = format!("is {} for the {}, must be {components}", block.components, field.name());
        return Err(at.field("components").error(problem));
    }
    unpack_column(&block.data, count, components.into(), column, &at.field(field.name()))
}

/// Unpacks a number for each of `count` particles into `numbers`; densities and volumes are positive.
fn unpack_numbers(
    field: FrameField,
    block: &wire::Block,
    count: usize,
    numbers: &mut Vec<f64>,
    at: &Path<'_>,
) -> Result<(), WireError> {
    let mut column = Column { components: 1, values: std::mem::take(numbers) };
    unpack_block(field, block, count, &mut column, at)?;
    *numbers = column.values;
    match numbers.iter().position(|value| *value <= 0.0) {
        Some(i) if field != FrameField::Pressure => {
            let problem = format!("of particle number {i} is {:?}, must be positive", numbers[i]);
            Err(at.field(field.name()).error(problem))
        }
        _ => Ok(()),
    }
}
