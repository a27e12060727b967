//! Doors through which made-up input is pushed: what a partner may send, read as the solvers read it.

use std::time::Duration;

use bytes::{Buf, BufMut, Bytes};
use prost::Message;
use sph::coupling::audit::{PartnerBody, PartnerParticles};
use sph::coupling::exchange::{Column, Extent, Frame, FrameContent, PreviousStage, StateColumns};
use sph::coupling::ledger::InterfaceSums;
use sph::coupling::ledger::MomentumReport;
use sph::coupling::solver::Role;
use sph::coupling::stage::{StageTime, StepStage};
use sph::setup::{CouplingKind, InterfaceLaw};

use tonic::Status;
use tonic::codec::{Codec, DecodeBuf, Decoder, EncodeBuf, Encoder};
use tonic::codegen::http::uri::PathAndQuery;

use crate::convert::{FrameReader, FrameWriter, Layout};
use crate::description::FrameField;
use crate::error::{RpcError, with_causes};
use crate::transport::channel;
use crate::transport::codec;
use crate::transport::security::ClientSecurity;
use crate::wire;

const RUN: &str = "run";

fn layout(role: Role, kind: CouplingKind) -> Layout {
    Layout { fields: FrameField::sent_by(role, InterfaceLaw::Wall, kind), dimensions: 2 }
}

/// A frame of three particles.
fn frame(content: FrameContent) -> Frame {
    Frame {
        time: StageTime { at: StepStage::FIRST, step_start: 0.25, time_step: 1e-3 },
        iteration: 0,
        acceptance: None,
        content,
        forces: Column::from_iter([[1.0, -2.0]; 3]),
        states: StateColumns {
            id: vec![1, 5, 4_000_000_000],
            group: vec![0, 0, 2],
            mass: vec![0.1, 0.2, 3.0],
            position: Column::from_iter([[0.1, 0.2]; 3]),
            velocity: Column::from_iter([[-1.0, 0.0]; 3]),
            density: vec![1000.0; 3],
            pressure: vec![-1e5; 3],
            stress: Column::from_iter([[1.0, 2.0, 0.1]; 3]),
        },
        set_version: 1,
        extent: Extent { version: 1, boxes: Column::from_iter([[0.0, 0.0, 1.0, 0.5]]) },
        partner_extent_version: 0,
        reach: 0.25,
        time_step_limit: 1e-3,
        previous: Some(PreviousStage {
            at: StepStage::FIRST,
            sums: InterfaceSums { gross_force: 3.0, pairs: 9, ..InterfaceSums::default() },
            used_digest: 7,
            momentum: Some(MomentumReport { gross: 1.0, ..MomentumReport::default() }),
        }),
    }
}

/// Good frames of every kind, as bytes.
pub fn frames() -> Vec<Vec<u8>> {
    let mut frames = Vec::new();
    for kind in CouplingKind::ALL {
        for role in [Role::Fluid, Role::Solid] {
            let layout = layout(role, kind);
            let mut writer = FrameWriter::new(RUN, 0, layout, 0);
            frames.push(writer.write(&frame(FrameField::content(layout.fields))).encode_to_vec());
            frames.push(writer.farewell("the end").encode_to_vec());
        }
    }
    frames
}

/// Reads `bytes` as a frame of a partner of every kind; how many of them take it.
///
/// # Errors
/// When it is no message at all.
pub fn read_frame(bytes: &[u8]) -> Result<u32, String> {
    let message: wire::Frame = codec::decode(bytes)?;
    let mut taken = 0;
    for kind in CouplingKind::ALL {
        for role in [Role::Fluid, Role::Solid] {
            let mut reader = FrameReader::new(RUN, 0, layout(role, kind), Extent::default());
            let mut into = frame(FrameContent::States);
            taken += u32::from(reader.read(&message, StepStage::FIRST, &mut into).is_ok());
        }
    }
    Ok(taken)
}

/// Reads `bytes` as the messages of the control plane; how many kinds of set-up and command they are.
pub fn read_control(bytes: &[u8]) -> u32 {
    use crate::convert::{Convert, Path, decode_batch, decode_command, link_from_wire};
    use crate::description::{Description, OpenReport};
    let root = Path::root("message");
    let fluid = codec::decode::<wire::FluidSetup>(bytes)
        .is_ok_and(|m| <sph::setup::AnyFluidSetup as Convert>::from_wire(&m, &root).is_ok());
    let solid = codec::decode::<wire::SolidSetup>(bytes)
        .is_ok_and(|m| <sph::setup::AnySolidSetup as Convert>::from_wire(&m, &root).is_ok());
    let link = codec::decode::<wire::LinkRequest>(bytes).is_ok_and(|m| link_from_wire(&m, 2, &root).is_ok());
    let reply =
        codec::decode::<wire::OpenReply>(bytes).is_ok_and(|m| OpenReport::from_wire(&m, &root).is_ok());
    let reported =
        codec::decode::<wire::Description>(bytes).is_ok_and(|m| Description::from_wire(&m, &root).is_ok());
    let command = codec::decode::<wire::Command>(bytes).is_ok_and(|m| decode_command(&m).is_ok());
    let events = codec::decode::<wire::EventBatch>(bytes).is_ok_and(|m| decode_batch(&m).is_ok());
    [fluid, solid, link, reply, reported, command, events].into_iter().map(u32::from).sum()
}

/// Good messages of the control plane for `setup`, as bytes.
pub fn control(setup: &sph::setup::ParticipantSetup) -> Vec<Vec<u8>> {
    use crate::convert::{Convert, link_to_wire};
    use crate::description::{LinkPlan, Partner};
    let link = LinkPlan {
        first_limit: 1e-3,
        partner_extent: Extent { version: 1, boxes: Column::from_iter([[0.0, 0.0, 1.0, 0.5]]) },
        partner: Partner::Listen,
        partner_particles: Some(PartnerParticles {
            id: vec![3],
            body: vec![0],
            mass: vec![1.0],
            position: Column::from_iter([[0.0, 0.0]]),
            bodies: vec![PartnerBody { name: "body".into(), cell_inertia: Some(0.5), driven: false }],
        }),
    };
    let setup = match setup {
        sph::setup::ParticipantSetup::Fluid(fluid) => fluid.to_wire().encode_to_vec(),
        sph::setup::ParticipantSetup::Solid(solid) => solid.to_wire().encode_to_vec(),
    };
    vec![setup, link_to_wire(&link).encode_to_vec()]
}

/// Messages as the bytes that they are.
#[derive(Clone, Copy, Debug, Default)]
struct Raw;

impl Codec for Raw {
    type Encode = Bytes;
    type Decode = Bytes;
    type Encoder = Self;
    type Decoder = Self;

    fn encoder(&mut self) -> Self {
        Self
    }

    fn decoder(&mut self) -> Self {
        Self
    }
}

impl Encoder for Raw {
    type Item = Bytes;
    type Error = Status;

    fn encode(&mut self, message: Bytes, into: &mut EncodeBuf<'_>) -> Result<(), Status> {
        into.put(message);
        Ok(())
    }
}

impl Decoder for Raw {
    type Item = Bytes;
    type Error = Status;

    fn decode(&mut self, message: &mut DecodeBuf<'_>) -> Result<Option<Bytes>, Status> {
        Ok(Some(message.copy_to_bytes(message.remaining())))
    }
}

/// Names of all calls, with service.
pub const CALLS: [&str; 9] = [
    "/fsi.v2.Participant/Describe",
    "/fsi.v2.Participant/Open",
    "/fsi.v2.Participant/Link",
    "/fsi.v2.Participant/Run",
    "/fsi.v2.Participant/Snapshots",
    "/fsi.v2.Participant/Checkpoint",
    "/fsi.v2.Participant/Restore",
    "/fsi.v2.Participant/Close",
    "/fsi.v2.Peer/Exchange",
];

/// Makes the call of `path`, such as one of [`CALLS`], at `address` by a connection of its own, with `message` as it is.
///
/// # Errors
/// How the server refuses it.
pub async fn call(address: &str, path: &'static str, message: Vec<u8>) -> Result<(), RpcError> {
    const DEADLINE: Duration = Duration::from_secs(60);
    let refused = |status: Status| RpcError::from_status(path, address, &status);
    let channel = channel::connect_secured(address, DEADLINE, &ClientSecurity::default())
        .await
        .map_err(|problem| refused(Status::unavailable(problem)))?;
    let mut client = tonic::client::Grpc::new(channel);
    client.ready().await.map_err(|e| refused(Status::unavailable(with_causes(&e))))?;
    let request = tonic::Request::new(Bytes::from(message));
    let answer = client.unary(request, PathAndQuery::from_static(path), Raw);
    match tokio::time::timeout(DEADLINE, answer).await {
        Ok(answer) => answer.map(drop).map_err(refused),
        Err(_) => Err(refused(Status::deadline_exceeded("no answer"))),
    }
}

/// An `Open` of a solid whose set-up has this many empty bodies, two bytes each.
pub fn open_of_empty_bodies(bodies: usize) -> Vec<u8> {
    let mut setup = Vec::with_capacity(2 * bodies + 16);
    setup.resize(2 * bodies, 0);
    // Field 3 of SolidSetup, length 0.
    setup.iter_mut().step_by(2).for_each(|tag| *tag = 0x1a);
    let mut length = Vec::new();
    prost::encoding::encode_varint(setup.len() as u64, &mut length);
    // Field 5 of OpenRequest.
    [&[0x2a][..], &length, &setup].concat()
}
