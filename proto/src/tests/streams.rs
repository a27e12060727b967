//! Broken, hostile and vanishing partners and coordinators: each is named, and the server stays usable.

use std::time::Duration;

use bytes::Bytes;
use sph::coupling::driver::{Command, Event};
use sph::coupling::exchange::{Extent, Frame};
use sph::coupling::solver::{Fault, Role, Solver};
use sph::coupling::stage::{StageTime, StepStage};
use sph::setup::{CouplingKind, InterfaceLaw};
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;

use super::fake::{Pair, TestServer, alone, assert_usable, row, setup, soon};
use crate::convert::{FrameWriter, Layout, Phase};
use crate::description::{FrameField, LinkPlan, Partner};
use crate::error::RpcCode;
use crate::limits::MAX_FRAME_BYTES;
use crate::transport::channel;
use crate::transport::client::{CommandSender, EventReceiver, ParticipantClient, RunAccess};
use crate::wire;
use crate::wire::peer_client::PeerClient;

const RUN: &str = "run";

/// A solid server in a run, and a scripted fluid that feeds it frames.
struct Script {
    server: TestServer,
    client: ParticipantClient,
    commands: CommandSender,
    events: EventReceiver,
    to_solid: mpsc::Sender<wire::Frame>,
    from_solid: tonic::Streaming<wire::Frame>,
    writer: FrameWriter,
    row: Box<dyn Solver>,
}

impl Script {
    async fn start() -> Self {
        let server = TestServer::start(Role::Solid);
        let mut client = server.client().await;
        let access = RunAccess::new("script").unwrap();
        client.open(&setup(Role::Solid, RUN, 100), &access).await.unwrap();
        let row = row(&setup(Role::Fluid, RUN, 100));
        let partner_extent = row.extent().clone();
        let writer = FrameWriter::new(
            RUN,
            0,
            Layout {
                fields: FrameField::sent_by(Role::Fluid, InterfaceLaw::Wall, CouplingKind::States),
                dimensions: 2,
            },
            partner_extent.version,
        );
        let plan =
            LinkPlan { first_limit: 1e-3, partner_extent, partner: Partner::Listen, partner_particles: None };
        client.link(&plan).await.unwrap();
        let channel = channel::connect_secured(
            &server.address.to_string(),
            Duration::from_secs(5),
            &Default::default(),
        )
        .await
        .unwrap();
        let (to_solid, frames) = mpsc::channel(4);
        let request = access.token.attach(ReceiverStream::new(frames));
        let from_solid = PeerClient::new(channel).exchange(request).await.unwrap().into_inner();
        let (commands, events) = client.run().await.unwrap();
        commands.send(Command::GrantThrough(100)).unwrap();
        Self { server, client, commands, events, to_solid, from_solid, writer, row }
    }

    /// A right frame of half-step `at`; sums and provenance are made to fit by `previous`.
    fn frame(&mut self, at: StepStage) -> wire::Frame {
        let time = StageTime { at, step_start: at.step as f64 * 1e-3, time_step: 1e-3 };
        let mut frame = Frame::empty(time);
        let partner = Extent::default();
        frame.set_version = self.row.interface(&partner, 1.0, &mut frame.states);
        frame.extent.clone_from(self.row.extent());
        frame.partner_extent_version = 1;
        frame.reach = 0.25;
        self.writer.write(&frame)
    }

    /// The fault with which the solid ends, and whether its server is usable after that.
    async fn fault(mut self) -> String {
        let fault = soon("the solid", async {
            loop {
                match self.events.recv().await {
                    Some(Ok(Event::Failed(report))) => return report.fault,
                    Some(Ok(_)) => {}
                    other => panic!("no fault but {other:?}"),
                }
            }
        })
        .await;
        self.client.close().await.unwrap();
        assert_usable(&mut self.client, Role::Solid).await;
        drop(self.commands);
        self.server.end().await;
        assert!(matches!(fault, Fault::Peer { .. }), "{fault:?}");
        fault.to_string()
    }
}

fn damage(frame: &mut wire::Frame, block: usize, edit: impl FnOnce(&mut Vec<u8>)) {
    let mut data = frame.blocks[block].data.to_vec();
    edit(&mut data);
    frame.blocks[block].data = Bytes::from(data);
}

/// Sends the first frame after `spoil` and returns how the solid ends.
async fn first_frame(spoil: impl FnOnce(&mut wire::Frame)) -> String {
    let mut script = Script::start().await;
    let mut frame = script.frame(StepStage::FIRST);
    spoil(&mut frame);
    script.to_solid.send(frame).await.unwrap();
    script.fault().await
}

#[tokio::test(flavor = "multi_thread")]
async fn damaged_frames_end_the_run_by_name() {
    let truncated = first_frame(|frame| damage(frame, 1, |data| data.truncate(100))).await;
    assert!(truncated.contains("velocity`: has 100 bytes"), "{truncated}");
    assert!(truncated.contains("step 0 predictor"), "{truncated}");
    let nan =
        first_frame(|frame| damage(frame, 2, |data| data[..8].copy_from_slice(&f64::NAN.to_le_bytes())))
            .await;
    assert!(nan.contains("density`: of particle number 0 is NaN"), "{nan}");
    let wrong_sum = first_frame(|frame| damage(frame, 0, |data| data[0] ^= 1)).await;
    assert!(wrong_sum.contains("DATA_LOSS"), "{wrong_sum}");
    let stale_epoch = first_frame(|frame| frame.epoch = 3).await;
    assert!(stale_epoch.contains("`frame.epoch`: is 3, expected 0"), "{stale_epoch}");
    let early = first_frame(|frame| frame.stage = 2).await;
    assert!(early.contains("expected that of step 0 predictor, got step 0 corrector"), "{early}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_repeated_frame_is_called_a_duplicate() {
    let mut script = Script::start().await;
    let frame = script.frame(StepStage::FIRST);
    script.to_solid.send(frame.clone()).await.unwrap();
    script.to_solid.send(frame).await.unwrap();
    let fault = script.fault().await;
    assert!(fault.contains("step 0 corrector") && fault.contains("duplicate"), "{fault}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_frame_beyond_the_limit_is_refused_as_such() {
    let fault = first_frame(|frame| damage(frame, 0, |data| data.resize(MAX_FRAME_BYTES + 1, 0))).await;
    assert!(fault.contains("too large") && fault.contains("limit"), "{fault}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_partner_that_leaves_is_lost_with_or_without_farewell() {
    let mut script = Script::start().await;
    script.to_solid.send(script.writer.farewell("the case is withdrawn")).await.unwrap();
    // The solid has sent its own first frame before.
    let own = soon("the solid's frame", script.from_solid.message()).await.unwrap().unwrap();
    assert_eq!((own.step, own.stage, own.set.is_some()), (0, i32::from(wire::Stage::Predictor), true));
    let fault = script.fault().await;
    assert!(fault.contains("it ended its run: the case is withdrawn"), "{fault}");
    // Half closed.
    let mut script = Script::start().await;
    script.to_solid = mpsc::channel(1).0;
    let fault = script.fault().await;
    assert!(fault.contains("ended without a farewell"), "{fault}");
    // Both halves gone, as when its process dies.
    let mut script = Script::start().await;
    let spare = Script::start().await;
    script.from_solid = spare.from_solid;
    script.to_solid = spare.to_solid;
    let fault = script.fault().await;
    assert!(fault.contains("lost the partner"), "{fault}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_coordinator_that_vanishes_frees_both_servers() {
    let mut pair = Pair::linked(RUN, 1_000_000).await;
    let mut others = [pair.servers[0].client().await, pair.servers[1].client().await];
    let (fluid_commands, mut fluid_events) = pair.fluid.run().await.unwrap();
    let (solid_commands, solid_events) = pair.solid.run().await.unwrap();
    fluid_commands.send(Command::GrantThrough(1_000_000)).unwrap();
    solid_commands.send(Command::GrantThrough(1_000_000)).unwrap();
    soon("the first event", fluid_events.recv()).await.unwrap().unwrap();
    // A second coordinator learns who holds the server, and changes nothing.
    let access = RunAccess::new("intruder").unwrap();
    let error = others[0].open(&alone(Role::Fluid, "other", 1), &access).await.unwrap_err();
    assert_eq!(error.code, RpcCode::Busy);
    assert!(error.message.contains("held by a test for"), "{error}");
    assert!(error.message.contains("state RUNNING"), "{error}");
    drop((fluid_commands, fluid_events, solid_commands, solid_events, pair.fluid, pair.solid));
    soon("the fluid's server", assert_usable(&mut others[0], Role::Fluid)).await;
    soon("the solid's server", assert_usable(&mut others[1], Role::Solid)).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn an_unclosed_run_ends_with_its_connection() {
    let mut pair = Pair::linked(RUN, 3).await;
    let mut others = [pair.servers[0].client().await, pair.servers[1].client().await];
    let (fluid_commands, mut fluid_events) = pair.fluid.run().await.unwrap();
    let (solid_commands, mut solid_events) = pair.solid.run().await.unwrap();
    fluid_commands.send(Command::GrantThrough(3)).unwrap();
    solid_commands.send(Command::GrantThrough(3)).unwrap();
    soon("the run", async {
        while fluid_events.recv().await.is_some_and(|event| event.is_ok()) {}
        while solid_events.recv().await.is_some_and(|event| event.is_ok()) {}
    })
    .await;
    let access = RunAccess::new("the next").unwrap();
    let error = others[0].open(&alone(Role::Fluid, "next", 1), &access).await.unwrap_err();
    assert!(error.message.contains("state ENDED"), "{error}");
    // All was heard, but `Close` was never called.
    drop((fluid_commands, fluid_events, solid_commands, solid_events, pair.fluid, pair.solid));
    soon("the fluid's server", assert_usable(&mut others[0], Role::Fluid)).await;
    soon("the solid's server", assert_usable(&mut others[1], Role::Solid)).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_wait_for_the_partner_ends_when_the_coordinator_does() {
    // No partner ever connects: the compute thread waits in `receive`.
    let server = TestServer::start(Role::Solid);
    let mut client = server.client().await;
    let mut other = server.client().await;
    let plan = LinkPlan {
        first_limit: 1.0,
        partner_extent: Extent::default(),
        partner: Partner::Listen,
        partner_particles: None,
    };
    client.open(&setup(Role::Solid, RUN, 10), &RunAccess::new("a").unwrap()).await.unwrap();
    client.link(&plan).await.unwrap();
    let (commands, mut events) = client.run().await.unwrap();
    commands.send(Command::GrantThrough(10)).unwrap();
    soon("the sign of waiting", async {
        while events.latest_beat().is_none_or(|beat| beat.phase != Phase::WaitingForPartner) {
            // Probes and the first snapshot come before.
            drop(tokio::time::timeout(Duration::from_millis(50), events.recv()).await);
        }
    })
    .await;
    drop((commands, events));
    soon("the server", assert_usable(&mut other, Role::Solid)).await;
    // By command the same, and reported.
    client.close().await.unwrap();
    client.open(&setup(Role::Solid, RUN, 10), &RunAccess::new("a").unwrap()).await.unwrap();
    client.link(&plan).await.unwrap();
    let (commands, mut events) = client.run().await.unwrap();
    commands.send(Command::GrantThrough(10)).unwrap();
    tokio::time::sleep(Duration::from_millis(50)).await;
    commands.send(Command::Abort).unwrap();
    let last = soon("the abort", async {
        let mut last = None;
        while let Some(event) = events.recv().await {
            last = Some(event.unwrap());
        }
        last
    })
    .await;
    let Some(Event::Failed(report)) = last else { panic!("{last:?}") };
    assert!(matches!(report.fault, Fault::Aborted { .. }), "{:?}", report.fault);
    client.close().await.unwrap();
    soon("the server", assert_usable(&mut other, Role::Solid)).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn closing_a_running_run_ends_it() {
    let server = TestServer::start(Role::Fluid);
    let mut client = server.client().await;
    client.open(&alone(Role::Fluid, "slow", 100_000), &RunAccess::new("a").unwrap()).await.unwrap();
    let plan = LinkPlan {
        first_limit: 1.0,
        partner_extent: Extent::default(),
        partner: Partner::Alone,
        partner_particles: None,
    };
    client.link(&plan).await.unwrap();
    let (commands, _events) = client.run().await.unwrap();
    commands.send(Command::GrantThrough(100_000)).unwrap();
    tokio::time::sleep(Duration::from_millis(100)).await;
    soon("the close", client.close()).await.unwrap();
    // Freed when the answer came: no waiting here.
    client.open(&alone(Role::Fluid, "b", 1), &RunAccess::new("b").unwrap()).await.unwrap();
}

#[tokio::test(flavor = "multi_thread")]
async fn a_shutdown_does_not_wait_for_open_streams() {
    let mut pair = Pair::linked(RUN, 1_000_000).await;
    let (fluid_commands, mut fluid_events) = pair.fluid.run().await.unwrap();
    let (solid_commands, solid_events) = pair.solid.run().await.unwrap();
    fluid_commands.send(Command::GrantThrough(1_000_000)).unwrap();
    solid_commands.send(Command::GrantThrough(1_000_000)).unwrap();
    soon("the first event", fluid_events.recv()).await.unwrap().unwrap();
    let [fluid_server, solid_server] = pair.servers;
    soon("the shutdown", fluid_server.end()).await;
    soon("the shutdown", solid_server.end()).await;
    // The coordinator hears how it ended, or that the server is gone.
    let mut reported = false;
    soon("the events", async {
        while let Some(event) = fluid_events.recv().await {
            reported |= matches!(&event, Ok(Event::Failed(_)) | Err(_));
        }
    })
    .await;
    assert!(reported);
    drop((solid_events, fluid_commands, solid_commands));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_solver_that_panics_is_a_defect_told_and_survived() {
    let server = TestServer::start(Role::Fluid);
    let mut client = server.client().await;
    client.open(&alone(Role::Fluid, "panic", 10), &RunAccess::new("a").unwrap()).await.unwrap();
    let plan = LinkPlan {
        first_limit: 1.0,
        partner_extent: Extent::default(),
        partner: Partner::Alone,
        partner_particles: None,
    };
    client.link(&plan).await.unwrap();
    let (commands, mut events) = client.run().await.unwrap();
    commands.send(Command::GrantThrough(10)).unwrap();
    let error = soon("the defect", async {
        loop {
            match events.recv().await {
                Some(Ok(_)) => {}
                Some(Err(error)) => return error,
                None => panic!("ended without a word"),
            }
        }
    })
    .await;
    assert_eq!(error.code, RpcCode::Internal);
    assert!(error.message.contains("seeded panic"), "{error}");
    assert!(soon("the end", events.recv()).await.is_none());
    assert_usable(&mut client, Role::Fluid).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_server_that_is_no_solver_is_named() {
    use tokio::io::{AsyncReadExt, AsyncWriteExt};
    let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap().to_string();
    tokio::spawn(async move {
        while let Ok((mut stream, _)) = listener.accept().await {
            let mut buffer = [0; 64];
            drop(stream.read(&mut buffer).await);
            drop(stream.write_all(b"HTTP/1.1 200 OK\r\ncontent-length: 0\r\n\r\n").await);
        }
    });
    let deadlines = crate::transport::client::Deadlines::default();
    let outcome = soon("the web server", async {
        match ParticipantClient::connect(&address, deadlines).await {
            Ok(mut client) => client.describe().await.map(drop),
            Err(error) => Err(error),
        }
    })
    .await;
    let error = outcome.unwrap_err();
    assert!(error.to_string().contains(&address), "{error}");
    let error = ParticipantClient::connect("no address", deadlines).await.unwrap_err();
    assert!(error.message.contains("host:port"), "{error}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_taken_port_is_named() {
    let server = TestServer::start(Role::Fluid);
    let error = crate::service::Server::bind(server.address).unwrap_err().to_string();
    assert!(error.contains(&server.address.to_string()) && error.contains("another port"), "{error}");
}

#[tokio::test(flavor = "multi_thread")]
async fn descriptions_are_complete_and_repeatable() {
    let server = TestServer::start(Role::Solid);
    let mut client = server.client().await;
    let first = client.describe().await.unwrap();
    assert_eq!(first, client.describe().await.unwrap());
    assert_eq!((first.name.as_str(), first.roles.as_slice()), ("row", [Role::Solid].as_slice()));
    assert!(first.capabilities.checkpoint && first.limits.runs == 1);
}

#[tokio::test(flavor = "multi_thread")]
async fn health_and_reflection_answer() {
    use tonic_health::pb::HealthCheckRequest;
    use tonic_health::pb::health_check_response::ServingStatus;
    use tonic_health::pb::health_client::HealthClient;
    use tonic_reflection::pb::v1::ServerReflectionRequest;
    use tonic_reflection::pb::v1::server_reflection_client::ServerReflectionClient;
    use tonic_reflection::pb::v1::server_reflection_request::MessageRequest;
    let server = TestServer::start(Role::Solid);
    let channel =
        channel::connect_secured(&server.address.to_string(), Duration::from_secs(5), &Default::default())
            .await
            .unwrap();
    for service in ["", "fsi.v2.Participant", "fsi.v2.Peer"] {
        let request = HealthCheckRequest { service: service.into() };
        let reply = HealthClient::new(channel.clone()).check(request).await.unwrap().into_inner();
        assert_eq!(reply.status(), ServingStatus::Serving, "{service}");
    }
    let question = MessageRequest::FileContainingSymbol("fsi.v2.Frame".into());
    let request = ServerReflectionRequest { host: String::new(), message_request: Some(question) };
    let mut answers = ServerReflectionClient::new(channel)
        .server_reflection_info(tokio_stream::once(request))
        .await
        .unwrap()
        .into_inner();
    let answer = format!("{:?}", answers.message().await.unwrap().unwrap());
    assert!(answer.contains("FileDescriptorResponse"), "{answer}");
}
