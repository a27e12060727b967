//! Doors through which made-up input is pushed: what a partner may send, read as the solvers read it.

use prost::Message;
use sph::audit::{MomentumReport, PartnerBody, PartnerParticles};
use sph::exchange::{Extent, Frame, FrameContent, InterfaceStates, PreviousStage};
use sph::ledger::InterfaceSums;
use sph::setup::{CouplingKind, InterfaceLaw};
use sph::solver::Role;
use sph::stage::{StageTime, StepStage};
use sph::vector::{SymmetricTensor, Vector};

use crate::convert::{FrameReader, FrameWriter};
use crate::description::FrameField;
use crate::wire;

const RUN: &str = "run";

fn fields(role: Role, kind: CouplingKind) -> &'static [FrameField] {
    FrameField::sent_by(role, InterfaceLaw::Wall, kind)
}

/// A frame of three particles.
fn frame(content: FrameContent) -> Frame {
    Frame {
        time: StageTime { at: StepStage::FIRST, step_start: 0.25, time_step: 1e-3 },
        iteration: 0,
        acceptance: None,
        content,
        forces: vec![Vector::new(1.0, -2.0); 3],
        states: InterfaceStates {
            id: vec![1, 5, 4_000_000_000],
            group: vec![0, 0, 2],
            mass: vec![0.1, 0.2, 3.0],
            position: vec![Vector::new(0.1, 0.2); 3],
            velocity: vec![Vector::new(-1.0, 0.0); 3],
            density: vec![1000.0; 3],
            pressure: vec![-1e5; 3],
            stress: vec![SymmetricTensor { xx: 1.0, yy: 2.0, xy: 0.1 }; 3],
        },
        set_version: 1,
        extent: Extent { version: 1, boxes: vec![(Vector::zeros(), Vector::new(1.0, 0.5))] },
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
            let fields = fields(role, kind);
            let mut writer = FrameWriter::new(RUN, 0, fields, 0);
            frames.push(writer.write(&frame(FrameField::content(fields))).encode_to_vec());
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
    let message = wire::Frame::decode(bytes).map_err(|e| e.to_string())?;
    let mut taken = 0;
    for kind in CouplingKind::ALL {
        for role in [Role::Fluid, Role::Solid] {
            let mut reader = FrameReader::new(RUN, 0, fields(role, kind), Extent::default());
            let mut into = frame(FrameContent::States);
            taken += u32::from(reader.read(&message, StepStage::FIRST, &mut into).is_ok());
        }
    }
    Ok(taken)
}

/// Reads `bytes` as the messages of the control plane; how many kinds of set-up and command they are.
pub fn read_control(bytes: &[u8]) -> u32 {
    use crate::convert::{Convert, Path, decode_batch, decode_command};
    use crate::description::{Description, LinkPlan, OpenReport};
    let root = Path::root("message");
    let fluid = wire::FluidSetup::decode(bytes)
        .is_ok_and(|m| <sph::setup::FluidSetup as Convert>::from_wire(&m, &root).is_ok());
    let solid = wire::SolidSetup::decode(bytes)
        .is_ok_and(|m| <sph::setup::SolidSetup as Convert>::from_wire(&m, &root).is_ok());
    let link = wire::LinkRequest::decode(bytes).is_ok_and(|m| LinkPlan::from_wire(&m, &root).is_ok());
    let reply = wire::OpenReply::decode(bytes).is_ok_and(|m| OpenReport::from_wire(&m, &root).is_ok());
    let told = wire::Description::decode(bytes).is_ok_and(|m| Description::from_wire(&m, &root).is_ok());
    let command = wire::Command::decode(bytes).is_ok_and(|m| decode_command(&m).is_ok());
    let events = wire::EventBatch::decode(bytes).is_ok_and(|m| decode_batch(&m).is_ok());
    [fluid, solid, link, reply, told, command, events].into_iter().map(u32::from).sum()
}

/// Good messages of the control plane for `setup`, as bytes.
pub fn control(setup: &sph::setup::ParticipantSetup) -> Vec<Vec<u8>> {
    use crate::convert::Convert;
    use crate::description::{LinkPlan, Partner};
    let link = LinkPlan {
        first_limit: 1e-3,
        partner_extent: Extent { version: 1, boxes: vec![(Vector::zeros(), Vector::new(1.0, 0.5))] },
        partner: Partner::Listen,
        partner_particles: Some(PartnerParticles {
            id: vec![3],
            body: vec![0],
            mass: vec![1.0],
            position: vec![Vector::zeros()],
            bodies: vec![PartnerBody { name: "body".into(), cell_inertia: Some(0.5), driven: false }],
        }),
    };
    let setup = match setup {
        sph::setup::ParticipantSetup::Fluid(fluid) => fluid.to_wire().encode_to_vec(),
        sph::setup::ParticipantSetup::Solid(solid) => solid.to_wire().encode_to_vec(),
    };
    vec![setup, link.to_wire().encode_to_vec()]
}
