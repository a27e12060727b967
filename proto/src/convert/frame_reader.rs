//! Checks of the partner's frames. The reader keeps what the protocol sends only on change.

use sph::coupling::exchange::{Column, Extent, Frame, FrameContent, StateColumns};
use sph::coupling::stage::{StageTime, StepStage};

use super::arrays::{index_count, unpack_column, unpack_ids, unpack_indices, unpack_positive};
use super::frame::Layout;
use super::{
    Path, WireError, choice, extent_from_wire, finite, not_negative, optional, positive, positive_or_infinite,
};
use crate::description::FrameField;
use crate::limits::MAX_PARTICLES;
use crate::wire;

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
    required: Layout,
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
    /// A reader for frames of layout `required` of a partner whose extent is `extent` from the hand-shake.
    pub(crate) fn new(run_id: &str, epoch: u32, required: Layout, extent: Extent) -> Self {
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
        frame.content = self.required.content();
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
            (wire.acceptance.is_some(), self.required.content() == FrameContent::CouplingPoints);
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
        let points = self.required.content() == FrameContent::CouplingPoints;
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
            self.unpack_block(FrameField::Force, block, number, &mut frame.forces, &at.item("blocks", k))?;
        }
        Ok(())
    }

    /// Checks that the blocks are those of the required fields, in their order.
    fn check_fields(&self, blocks: &[wire::Block], at: &Path<'_>) -> Result<(), WireError> {
        for (k, block) in blocks.iter().enumerate() {
            let at = at.item("blocks", k);
            let field: FrameField = choice(block.field, &at.field("field"))?;
            match self.required.fields.get(k) {
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
        match self.required.fields.get(blocks.len()) {
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
        for ((k, block), field) in wire.blocks.iter().enumerate().zip(self.required.fields) {
            let at = at.item("blocks", k);
            match field {
                FrameField::Position => self.unpack_block(*field, block, count, &mut states.position, &at)?,
                FrameField::Velocity => self.unpack_block(*field, block, count, &mut states.velocity, &at)?,
                FrameField::Stress => self.unpack_block(*field, block, count, &mut states.stress, &at)?,
                FrameField::Density => self.unpack_numbers(*field, block, count, &mut states.density, &at)?,
                FrameField::Volume => self.unpack_numbers(*field, block, count, &mut states.mass, &at)?,
                FrameField::Pressure => {
                    self.unpack_numbers(*field, block, count, &mut states.pressure, &at)?
                }
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
            Some(_) => {
                let extent = extent_from_wire(&wire.extent, self.required.dimensions, &at.field("extent"))?;
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

    /// Unpacks the numbers of `count` particles into `column`.
    fn unpack_block(
        &self,
        field: FrameField,
        block: &wire::Block,
        count: usize,
        column: &mut Column,
        at: &Path<'_>,
    ) -> Result<(), WireError> {
        let components = field.components(self.required.dimensions);
        if block.components != components {
            let problem = format!(
                "is {} for the {}, must be {components} in a run of {} dimensions",
                block.components,
                field.name(),
                self.required.dimensions
            );
            return Err(at.field("components").error(problem));
        }
        let components = usize::try_from(components).unwrap_or(usize::MAX);
        unpack_column(&block.data, count, components, column, &at.field(field.name()))
    }

    /// Unpacks a number for each of `count` particles into `numbers`; densities and volumes are positive.
    fn unpack_numbers(
        &self,
        field: FrameField,
        block: &wire::Block,
        count: usize,
        numbers: &mut Vec<f64>,
        at: &Path<'_>,
    ) -> Result<(), WireError> {
        let mut column = Column { components: 1, values: std::mem::take(numbers) };
        self.unpack_block(field, block, count, &mut column, at)?;
        *numbers = column.values;
        match numbers.iter().position(|value| *value <= 0.0) {
            Some(i) if field != FrameField::Pressure => {
                let problem = format!("of particle number {i} is {:?}, must be positive", numbers[i]);
                Err(at.field(field.name()).error(problem))
            }
            _ => Ok(()),
        }
    }
}
