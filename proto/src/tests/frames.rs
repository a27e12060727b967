//! Frames on the wire: all bits survive, and every wrong frame is refused by name.

use bytes::Bytes;
use sph::coupling::exchange::{Acceptance, Column, Extent, Frame, FrameContent, PreviousStage, StateColumns};
use sph::coupling::ledger::{AngularBudget, InterfaceSums, LedgerVector, MomentumReport};
use sph::coupling::solver::Role;
use sph::coupling::stage::{Stage, StageTime, StepStage};
use sph::setup::{CouplingKind, InterfaceLaw};

use crate::convert::{FrameReader, FrameWriter, Layout, ReceivedFrame};
use crate::description::FrameField;
use crate::wire;

const AT: StepStage = StepStage { step: 3, stage: Stage::Corrector };

/// Numbers whose bits are easily lost.
const AWKWARD: [f64; 4] = [-0.0, 5e-324, -f64::MAX, 0.1];

fn extent(version: u64) -> Extent {
    Extent { version, boxes: Column::from_iter([[-1.0, -0.0, 1.0, 0.5]]) }
}

fn frame(at: StepStage) -> Frame {
    Frame {
        time: StageTime { at, step_start: 0.1 + 0.2, time_step: 1e-3 / 3.0 },
        iteration: 0,
        acceptance: None,
        content: FrameContent::States,
        forces: Column::default(),
        states: StateColumns {
            id: vec![1, 5, 4_000_000_000],
            group: vec![0, 0, 2],
            mass: vec![0.1, 5e-324, 3.0],
            position: Column::from_iter([[AWKWARD[0], AWKWARD[1]], [AWKWARD[2], AWKWARD[3]], [0.0, 0.0]]),
            velocity: Column::from_iter([[-0.0, 1.0], [2.0, -5e-324], [1e300, 0.3]]),
            density: vec![1000.0, 999.999_999_9, 5e-324],
            pressure: vec![-0.0, -1e5, 3.3],
            stress: Column::from_iter([[-0.0, 1.0, 0.1]; 3]),
        },
        set_version: 4,
        extent: extent(7),
        partner_extent_version: 2,
        reach: 0.25,
        time_step_limit: f64::INFINITY,
        previous: Some(PreviousStage {
            at: StepStage { step: 3, stage: Stage::Predictor },
            sums: InterfaceSums {
                force: LedgerVector::new(-0.0, 2.0, 5e-324),
                gross_force: 3.0,
                pairs: 9,
                ..InterfaceSums::default()
            },
            used_digest: 0xdead_beef,
            momentum: Some(MomentumReport {
                change: LedgerVector::new(1.0, -0.0, 0.0),
                gross: 4.0,
                angular: Some(AngularBudget { change: LedgerVector::new(0.0, -0.0, -2.5), gross: 5.0 }),
            }),
        }),
    }
}

fn layout(dimensions: usize) -> Layout {
    let fields = FrameField::sent_by(Role::Solid, InterfaceLaw::PlainSum, CouplingKind::States);
    Layout { fields, dimensions }
}

fn writer() -> FrameWriter {
    FrameWriter::new("run", 0, layout(2), 0)
}

fn reader() -> FrameReader {
    FrameReader::new("run", 0, layout(2), extent(7))
}

fn empty() -> Frame {
    Frame::empty(StageTime { at: StepStage::FIRST, step_start: 0.0, time_step: 1.0 })
}

/// All numbers of a frame as text with every bit: `Debug` of a float is exact but for NaN.
fn bits(frame: &Frame) -> String {
    format!("{frame:?}")
}

/// What a reader says of a frame after `spoil`.
fn refusal(spoil: impl FnOnce(&mut wire::Frame)) -> String {
    let mut message = writer().write(&frame(AT));
    spoil(&mut message);
    match reader().read(&message, AT, &mut empty()) {
        Ok(_) => "accepted".into(),
        Err(error) => error.to_string(),
    }
}

fn block(message: &mut wire::Frame, field: wire::Field) -> &mut wire::Block {
    message.blocks.iter_mut().find(|block| block.field == i32::from(field)).unwrap()
}

fn set_number(data: &Bytes, index: usize, value: f64) -> Bytes {
    let mut raw = data.to_vec();
    raw[8 * index..8 * index + 8].copy_from_slice(&value.to_le_bytes());
    raw.into()
}

#[test]
fn a_frame_keeps_all_bits() {
    let (mut writer, mut reader) = (writer(), reader());
    let sent = frame(AT);
    let encoded = prost::Message::encode_to_vec(&writer.write(&sent));
    let message: wire::Frame = prost::Message::decode(encoded.as_slice()).unwrap();
    let mut received = empty();
    assert_eq!(reader.read(&message, AT, &mut received), Ok(ReceivedFrame::Frame));
    assert_eq!(bits(&received), bits(&sent));
    assert_eq!(received.digest(), sent.digest());
}

/// `frame` with its particles repeated until the bytes exceed any buffer.
fn long_frame() -> Frame {
    let mut frame = frame(AT);
    let one = frame.states.clone();
    for _ in 0..100 {
        frame.states.id.extend(&one.id);
        frame.states.position.values.extend(&one.position.values);
        frame.states.velocity.values.extend(&one.velocity.values);
        frame.states.density.extend(&one.density);
        frame.states.pressure.extend(&one.pressure);
        frame.states.stress.values.extend(&one.stress.values);
    }
    frame
}

#[test]
fn the_digest_is_that_of_the_proto_comment() {
    for frame in [frame(AT), long_frame()] {
        // The bytes as peer.proto lists them, through another implementation of CRC-32.
        let mut bytes = Vec::new();
        bytes.extend(AT.step.to_le_bytes());
        bytes.extend(1_u64.to_le_bytes());
        let s = &frame.states;
        bytes.extend(s.id.iter().flat_map(|id| u64::from(*id).to_le_bytes()));
        for block in writer().write(&frame).blocks {
            bytes.extend(block.data);
        }
        let mut crc = u32::MAX;
        for byte in bytes {
            crc ^= u32::from(byte);
            for _ in 0..8 {
                crc = if crc & 1 == 1 { (crc >> 1) ^ 0xEDB8_8320 } else { crc >> 1 };
            }
        }
        assert_eq!(frame.digest(), !crc);
        assert_eq!(writer().write(&frame).digest, !crc);
    }
}

#[test]
fn the_documented_order_of_the_digest_holds() {
    // Positions, then velocities: swapping two numbers of them changes the digest.
    let mut other = frame(AT);
    let StateColumns { position, velocity, .. } = &mut other.states;
    std::mem::swap(&mut position.values[1], &mut velocity.values[2]);
    assert_ne!(other.digest(), frame(AT).digest());
}

#[test]
fn sets_and_extents_travel_only_when_they_change() {
    let (mut writer, mut reader) = (writer(), reader());
    let mut received = empty();
    let first = writer.write(&frame(AT));
    assert!(first.set.is_some() && first.extent.is_some());
    reader.read(&first, AT, &mut received).unwrap();
    let mut second = frame(AT.next());
    second.states.position.values[0] = 0.7;
    let message = writer.write(&second);
    assert!(message.set.is_none() && message.extent.is_none());
    let mut received = empty();
    reader.read(&message, AT.next(), &mut received).unwrap();
    assert_eq!(bits(&received), bits(&second));
    // A shrinking set and a new extent.
    let at = AT.next().next();
    let mut third = frame(at);
    third.states.clear();
    third.set_version = 5;
    third.extent = Extent { version: 8, ..Extent::default() };
    let message = writer.write(&third);
    assert!(message.set.is_some() && message.extent.is_some());
    reader.read(&message, at, &mut received).unwrap();
    assert_eq!(bits(&received), bits(&third));
}

#[test]
fn unknown_sets_and_extents_are_refused() {
    assert!(refusal(|m| m.set = None).contains("`frame.set`: is missing in the first frame"));
    let (mut writer, mut reader) = (writer(), reader());
    reader.read(&writer.write(&frame(AT)), AT, &mut empty()).unwrap();
    let mut message = writer.write(&frame(AT.next()));
    message.set_version = 9;
    let error = reader.read(&message, AT.next(), &mut empty()).unwrap_err().to_string();
    assert!(error.contains("`frame.set_version`: is 9 without a set, the last set was 4"), "{error}");
    let error = refusal(|m| {
        m.extent = None;
        m.extent_version = 8;
    });
    assert!(error.contains("`frame.extent_version`: is 8 without an extent, the last was 7"), "{error}");
    assert!(refusal(|m| m.extent_version = 9).contains("`frame.extent.version`: is 7, extent_version is 9"));
}

#[test]
fn order_run_and_epoch_are_compared() {
    assert!(
        refusal(|m| m.run_id = "other".into()).contains("`frame.run_id`: is \"other\", expected \"run\"")
    );
    assert!(refusal(|m| m.epoch = 1).contains("`frame.epoch`: is 1, expected 0"));
    assert!(refusal(|m| m.iteration = 1).contains("`frame.iteration`: is 1, expected 0"));
    assert!(
        refusal(|m| m.stage = 9).contains("`frame.stage`: is 9, must be one of 1 (Predictor), 2 (Corrector)")
    );
    let early = refusal(|m| m.step = 4);
    assert!(early.contains("expected that of step 3 corrector, got step 4 corrector"), "{early}");
    let (mut writer, mut reader) = (writer(), reader());
    let message = writer.write(&frame(AT));
    reader.read(&message, AT, &mut empty()).unwrap();
    let error = reader.read(&message, AT.next(), &mut empty()).unwrap_err().to_string();
    assert!(error.contains("expected that of step 4 predictor") && error.contains("duplicate"), "{error}");
}

#[test]
fn damaged_numbers_are_refused_by_field_and_particle() {
    let error = refusal(|m| {
        let density = block(m, wire::Field::Density);
        density.data = set_number(&density.data, 1, f64::NAN);
    });
    assert!(error.contains(".density`: of particle number 1 is NaN, must be finite"), "{error}");
    let error = refusal(|m| {
        let velocity = block(m, wire::Field::Velocity);
        velocity.data = set_number(&velocity.data, 5, f64::INFINITY);
    });
    assert!(error.contains(".velocity`: of particle number 2 is 1e300, inf"), "{error}");
    let error = refusal(|m| {
        let density = block(m, wire::Field::Density);
        density.data = set_number(&density.data, 0, -1.0);
    });
    assert!(error.contains("must be positive"), "{error}");
    let error = refusal(|m| {
        let position = block(m, wire::Field::Position);
        position.data = position.data.slice(..40);
    });
    assert!(
        error.contains(".position`: has 40 bytes, must have 3 particles x 2 numbers x 8 bytes"),
        "{error}"
    );
    let error = refusal(|m| {
        let pressure = block(m, wire::Field::Pressure);
        pressure.data = set_number(&pressure.data, 2, 3.300_000_1);
    });
    assert!(error.contains("`frame.digest`") && error.contains("DATA_LOSS"), "{error}");
    assert!(refusal(|m| m.digest ^= 1).contains("DATA_LOSS"));
    assert!(refusal(|m| m.count = 2).contains("`frame.count`: is 2, but the set has 3 particles"));
    assert!(refusal(|m| m.count = u64::MAX).contains("`frame.count`"));
}

#[test]
fn components_of_another_space_are_refused() {
    let message = writer().write(&frame(AT));
    let mut reader = FrameReader::new("run", 0, layout(3), extent(7));
    let error = reader.read(&message, AT, &mut empty()).unwrap_err().to_string();
    let expected = "is 2 for the position, must be 3 in a run of 3 dimensions";
    assert_eq!(error, format!("`frame.blocks[0].components`: {expected}"));
    // As many bytes as the plane's tensor has: six numbers are needed.
    let mut message = FrameWriter::new("run", 0, layout(3), 0).write(&spatial_frame());
    block(&mut message, wire::Field::Stress).components = 3;
    let error = FrameReader::new("run", 0, layout(3), Extent::default()).read(&message, AT, &mut empty());
    let error = error.unwrap_err().to_string();
    assert!(error.contains("is 3 for the stress, must be 6 in a run of 3 dimensions"), "{error}");
    // An extent of the plane has four numbers for each box.
    let mut message = FrameWriter::new("run", 0, layout(3), 0).write(&spatial_frame());
    message.extent = Some(wire::Extent { version: 7, boxes_m: Bytes::from(vec![0; 32]) });
    let error = FrameReader::new("run", 0, layout(3), Extent::default()).read(&message, AT, &mut empty());
    let error = error.unwrap_err().to_string();
    let expected = "has 32 bytes, must have 48 for each box in a run of 3 dimensions";
    assert_eq!(error, format!("`frame.extent.boxes_m`: {expected}"));
}

/// A frame of a run in space.
fn spatial_frame() -> Frame {
    let mut frame = frame(AT);
    let states = &mut frame.states;
    states.position = Column::from_iter([[0.1, -0.0, 5e-324]; 3]);
    states.velocity = Column::from_iter([[1.0, -f64::MAX, 0.3]; 3]);
    states.stress = Column::from_iter([[1.0, -0.0, 3.0, 4.0, 5e-324, 6.0]; 3]);
    frame.extent.boxes = Column::from_iter([[-1.0, -0.0, 0.0, 1.0, 0.5, 0.1]; 2]);
    frame
}

#[test]
fn a_frame_of_space_keeps_all_bits() {
    let (sent, mut received) = (spatial_frame(), empty());
    let message = FrameWriter::new("run", 0, layout(3), 0).write(&sent);
    let components: Vec<u32> = message.blocks.iter().map(|block| block.components).collect();
    assert_eq!(components, [3, 3, 1, 1, 6]);
    let mut reader = FrameReader::new("run", 0, layout(3), Extent::default());
    assert_eq!(reader.read(&message, AT, &mut received), Ok(ReceivedFrame::Frame));
    assert_eq!(bits(&received), bits(&sent));
}

#[test]
fn missing_repeated_and_unknown_blocks_are_refused() {
    let stress = |m: &mut wire::Frame| m.blocks.retain(|b| b.field != i32::from(wire::Field::Stress));
    assert!(refusal(stress).contains("`frame.blocks`: lack the stress"));
    assert!(refusal(|m| m.blocks.clear()).contains("lack the position"));
    assert!(
        refusal(|m| m.blocks.push(m.blocks[0].clone())).contains("is the position, which is not expected")
    );
    assert!(refusal(|m| m.blocks.swap(0, 1)).contains("is the velocity, must be the position"));
    assert!(refusal(|m| m.blocks[0].field = 77).contains("is 77, must be one of"));
    let counted = refusal(|m| m.blocks[0].components = 3);
    assert!(counted.contains("`frame.blocks[0].components`: is 3 for the position, must be 2"), "{counted}");
}

#[test]
fn other_numbers_of_a_frame_are_checked() {
    assert!(
        refusal(|m| m.time_step_s_bits = 0).contains("`frame.time_step_s_bits`: is 0.0, must be positive")
    );
    assert!(
        refusal(|m| m.step_start_s_bits = f64::NAN.to_bits()).contains("`frame.step_start_s_bits`: is NaN")
    );
    assert!(refusal(|m| m.time_step_limit_s = Some(f64::NAN)).contains("`frame.time_step_limit_s`: is NaN"));
    assert!(refusal(|m| m.reach_m = Some(-0.1)).contains("`frame.reach_m`"));
    assert!(refusal(|m| m.previous.as_mut().unwrap().at = None).contains("`frame.previous.at`: is missing"));
    let ids = |m: &mut wire::Frame| m.set.as_mut().unwrap().ids = Bytes::from_static(&[1; 12]);
    assert!(refusal(ids).contains("`frame.set.ids`: must ascend strictly"));
    let extent = |m: &mut wire::Frame| m.extent.as_mut().unwrap().boxes_m = Bytes::from_static(&[0; 31]);
    assert!(refusal(extent).contains("has 31 bytes, must have 32 for each box"));
    let reversed = |m: &mut wire::Frame| {
        let extent = m.extent.as_mut().unwrap();
        extent.boxes_m = set_number(&extent.boxes_m, 2, -9.0);
    };
    assert!(refusal(reversed).contains("lower <= upper"));
    assert_eq!(refusal(|_| {}), "accepted");
}

#[test]
fn a_farewell_states_its_reason() {
    let message = writer().farewell("diverged at step 3");
    let read = reader().read(&message, AT, &mut empty());
    assert_eq!(read, Ok(ReceivedFrame::Farewell("diverged at step 3".into())));
}

/// A frame of coupling points, or of the forces on them.
fn loads_frame(at: StepStage, role: Role) -> Frame {
    let mut frame = frame(at);
    frame.states.stress.values.clear();
    match role {
        Role::Solid => {
            frame.content = FrameContent::CouplingPoints;
            frame.states.mass = vec![0.1, 3.3, 3.0];
            frame.states.density = vec![1.0, 4.0, 0.7];
        }
        Role::Fluid => {
            frame.content = FrameContent::Forces;
            frame.forces = Column::from_iter([[-0.0, 5e-324], [1.0, -2.0]]);
        }
    }
    frame
}

fn loads_pair(role: Role) -> (FrameWriter, FrameReader) {
    let fields = FrameField::sent_by(role, InterfaceLaw::Wall, CouplingKind::Loads);
    let layout = Layout { fields, dimensions: 2 };
    (FrameWriter::new("run", 0, layout, 0), FrameReader::new("run", 0, layout, extent(7)))
}

#[test]
fn coupling_points_travel_as_position_velocity_and_volume() {
    let (mut writer, mut reader) = loads_pair(Role::Solid);
    let sent = loads_frame(AT, Role::Solid);
    let message = writer.write(&sent);
    assert_eq!(message.blocks.len(), 3);
    assert!(message.set.as_ref().unwrap().masses_kg.is_empty());
    let mut received = empty();
    reader.read(&message, AT, &mut received).unwrap();
    assert_eq!(
        (&received.states.position, &received.states.velocity),
        (&sent.states.position, &sent.states.velocity)
    );
    let volumes = |frame: &Frame| frame.states.volumes().map(f64::to_bits).collect::<Vec<_>>();
    assert_eq!(volumes(&received), volumes(&sent));
    assert_eq!(received.digest(), sent.digest());
    let mut spoilt = loads_pair(Role::Solid).0.write(&sent);
    let volume = block(&mut spoilt, wire::Field::Volume);
    volume.data = set_number(&volume.data, 1, 0.0);
    let error = loads_pair(Role::Solid).1.read(&spoilt, AT, &mut empty()).unwrap_err().to_string();
    assert!(error.contains(".volume`: of particle number 1 is 0.0, must be positive"), "{error}");
}

#[test]
fn forces_travel_alone_and_name_the_set_they_answer() {
    let (mut writer, mut reader) = loads_pair(Role::Fluid);
    let sent = loads_frame(AT, Role::Fluid);
    let message = writer.write(&sent);
    assert!(message.set.is_none());
    assert_eq!((message.blocks.len(), message.count, message.set_version), (1, 2, 4));
    let mut received = empty();
    reader.read(&message, AT, &mut received).unwrap();
    assert_eq!(format!("{:?}", received.forces), format!("{:?}", sent.forces));
    assert_eq!(received.digest(), sent.digest());
    assert_ne!(sent.digest(), loads_frame(AT, Role::Solid).digest());
    let refused = |spoil: fn(&mut wire::Frame)| {
        let mut message = loads_pair(Role::Fluid).0.write(&sent);
        spoil(&mut message);
        loads_pair(Role::Fluid).1.read(&message, AT, &mut empty()).unwrap_err().to_string()
    };
    let nan = refused(|m| {
        let force = block(m, wire::Field::Force);
        force.data = set_number(&force.data, 3, f64::NAN);
    });
    assert!(nan.contains(".force`: of particle number 1 is 1.0, NaN"), "{nan}");
    assert!(refused(|m| m.count = 3).contains(".force`: has 32 bytes"));
    assert!(refused(|m| m.blocks.clear()).contains("lack the force"));
    assert!(refused(|m| m.digest ^= 1).contains("DATA_LOSS"));
}

#[test]
fn iterations_follow_each_other_and_an_acceptance_ends_them() {
    let (mut writer, mut reader) = loads_pair(Role::Solid);
    let points = |iteration: u32| Frame { iteration, ..loads_frame(AT, Role::Solid) };
    let word = |iteration: u32| Frame {
        acceptance: Some(Acceptance { converged: true, residual: 1e-7 }),
        ..points(iteration)
    };
    let mut received = empty();
    for iteration in 0..3 {
        reader.read(&writer.write(&points(iteration)), AT, &mut received).unwrap();
        assert_eq!((received.iteration, received.acceptance), (iteration, None));
    }
    let repeated = reader.read(&writer.write(&points(2)), AT, &mut empty()).unwrap_err().to_string();
    assert!(repeated.contains("`frame.iteration`: is 2, expected 3"), "{repeated}");
    let old = reader.read(&writer.write(&word(1)), AT, &mut empty()).unwrap_err().to_string();
    assert!(old.contains("`frame.acceptance`: is of iteration 1"), "{old}");
    let message = writer.write(&word(2));
    assert!(message.blocks.is_empty() && message.set.is_none() && message.previous.is_none());
    reader.read(&message, AT, &mut received).unwrap();
    assert_eq!((received.iteration, received.acceptance), (2, word(2).acceptance));
    // The set of points is known still.
    let next = AT.next();
    reader.read(&writer.write(&loads_frame(next, Role::Solid)), next, &mut received).unwrap();
    assert_eq!((received.iteration, received.acceptance), (0, None));
    // Forces have nothing to accept, and no half-step begins with an acceptance.
    let forces = Frame { iteration: 0, ..loads_frame(AT, Role::Fluid) };
    let (mut writer, mut reader) = loads_pair(Role::Fluid);
    reader.read(&writer.write(&forces), AT, &mut empty()).unwrap();
    let mut wrong = writer.write(&forces);
    wrong.acceptance = message.acceptance;
    assert!(reader.read(&wrong, AT, &mut empty()).unwrap_err().to_string().contains("`frame.acceptance`"));
    let first = loads_pair(Role::Solid).1.read(&message, AT, &mut empty()).unwrap_err().to_string();
    assert!(first.contains("`frame.acceptance`: is of iteration 2"), "{first}");
    let mut negative = message.clone();
    negative.acceptance = Some(wire::Acceptance { converged: true, residual: Some(-1.0) });
    let (mut writer, mut reader) = loads_pair(Role::Solid);
    for iteration in 0..3 {
        reader.read(&writer.write(&points(iteration)), AT, &mut empty()).unwrap();
    }
    let error = reader.read(&negative, AT, &mut empty()).unwrap_err().to_string();
    assert!(error.contains("`frame.acceptance.residual`: is -1.0"), "{error}");
}
