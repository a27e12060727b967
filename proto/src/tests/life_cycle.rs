//! The life-cycle table of participant.proto, walked call by call in every state.

use std::time::Duration;

use sph::coupling::driver::Command;
use sph::coupling::exchange::Extent;
use sph::coupling::solver::Role;
use sph::coupling::stage::ClockState;
use sph::setup::ParticipantSetup;
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;
use tonic::Code;
use tonic::transport::Channel;

use super::fake::{RowFactory, TestServer, alone, assert_usable, row, setup, soon};
use crate::checkpoint::{CheckpointData, CheckpointHeader};
use crate::convert::{Convert, encode_command, link_to_wire};
use crate::description::{LinkPlan, PROTOCOL, Partner};
use crate::error::RpcCode;
use crate::service::{ServeOptions, SolverFactory};
use crate::transport::channel;
use crate::transport::client::RunAccess;
use crate::transport::token::Token;
use crate::wire;
use crate::wire::participant_client::ParticipantClient;
use crate::wire::peer_client::PeerClient;

const RUN: &str = "run";

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum At {
    Idle,
    Open,
    Linked,
    Running,
    Ended,
}

#[derive(Clone, Copy, Debug)]
enum Call {
    Describe,
    Open,
    Restore,
    Link,
    Snapshots,
    Run,
    Checkpoint,
    Exchange,
    Close,
}

const STATES: [At; 5] = [At::Idle, At::Open, At::Linked, At::Running, At::Ended];
const CALLS: [Call; 9] = [
    Call::Describe,
    Call::Open,
    Call::Restore,
    Call::Link,
    Call::Snapshots,
    Call::Run,
    Call::Checkpoint,
    Call::Exchange,
    Call::Close,
];

/// The table: codes by state, in the order of `STATES`.
fn expected(call: Call) -> [Code; 5] {
    use Code::{FailedPrecondition as No, Ok as Yes, PermissionDenied, ResourceExhausted as Busy};
    match call {
        Call::Describe | Call::Close => [Yes; 5],
        Call::Open => [Yes, Busy, Busy, Busy, Busy],
        Call::Link => [No, Yes, No, No, No],
        Call::Snapshots | Call::Run => [No, No, Yes, No, No],
        Call::Exchange => [PermissionDenied, No, Yes, Yes, No],
        Call::Checkpoint => [No, No, No, Yes, No],
        Call::Restore => [No, Yes, No, No, No],
    }
}

fn open_request(setup: &ParticipantSetup, token: &Token) -> wire::OpenRequest {
    use wire::open_request::Setup;
    wire::OpenRequest {
        protocol: Some(PROTOCOL.to_wire()),
        token: token.text().into(),
        holder: "walker".into(),
        setup: Some(match setup {
            ParticipantSetup::Fluid(fluid) => Setup::Fluid(fluid.to_wire()),
            ParticipantSetup::Solid(solid) => Setup::Solid(solid.to_wire()),
        }),
    }
}

fn link_request(run_id: &str) -> wire::LinkRequest {
    let plan = LinkPlan {
        first_limit: 1.0,
        partner_extent: Extent::default(),
        partner: Partner::Listen,
        partner_particles: None,
    };
    wire::LinkRequest { run_id: run_id.into(), ..link_to_wire(&plan) }
}

/// The state of a solid at the start of its run.
fn start_of_a_run() -> CheckpointData {
    let row = row(&setup(Role::Solid, RUN, 10));
    let clock = ClockState { step: 0, time: 0.0, time_step: 1e-3, allowed_step: 1e-3, elapsed_before: 0.0 };
    let checkpoint = sph::coupling::driver::save(&*row, &clock);
    let description = RowFactory(Role::Solid).describe();
    CheckpointData::new(CheckpointHeader::new(&description, Role::Solid, &checkpoint), checkpoint)
}

/// A server brought to a state, with raw clients.
struct Walker {
    _server: TestServer,
    token: Token,
    participant: ParticipantClient<Channel>,
    peer: PeerClient<Channel>,
    /// Keeps the Run stream open.
    run: Option<(mpsc::Sender<wire::Command>, tonic::Streaming<wire::EventBatch>)>,
    /// Keep other request streams open.
    commands: Vec<mpsc::Sender<wire::Command>>,
    frames: Vec<mpsc::Sender<wire::Frame>>,
}

impl Walker {
    async fn at(state: At) -> Self {
        let server = TestServer::start(Role::Solid);
        let channel = channel::connect_secured(
            &server.address.to_string(),
            Duration::from_secs(5),
            &Default::default(),
        )
        .await
        .unwrap();
        let mut walker = Self {
            _server: server,
            token: Token::fresh().unwrap(),
            participant: ParticipantClient::new(channel.clone()),
            peer: PeerClient::new(channel),
            run: None,
            commands: Vec::new(),
            frames: Vec::new(),
        };
        let steps = STATES.iter().position(|s| *s == state).unwrap();
        if steps >= 1 {
            walker.call(Call::Open, RUN).await.unwrap();
        }
        if steps >= 2 {
            walker.call(Call::Link, RUN).await.unwrap();
        }
        if steps >= 3 {
            let (commands, stream) = mpsc::channel(4);
            let request = walker.token.attach(ReceiverStream::new(stream));
            let events = walker.participant.run(request).await.unwrap().into_inner();
            walker.run = Some((commands, events));
        }
        if steps >= 4 {
            let (commands, events) = walker.run.as_mut().unwrap();
            commands.send(encode_command(RUN, 0, Command::Stop)).await.unwrap();
            while events.message().await.unwrap().is_some() {}
        }
        walker
    }

    /// Makes a call with the walker's token; run id where the call has one.
    async fn call(&mut self, call: Call, run_id: &str) -> Result<(), tonic::Status> {
        let run_id = run_id.to_owned();
        match call {
            Call::Describe => self.participant.describe(wire::DescribeRequest {}).await.map(drop),
            Call::Open => {
                let request = open_request(&setup(Role::Solid, &run_id, 10), &self.token);
                self.participant.open(request).await.map(drop)
            }
            Call::Restore => {
                let chunks = start_of_a_run().parts().map(move |part| wire::RestoreChunk {
                    run_id: run_id.clone(),
                    epoch: 1,
                    part: Some(part.into()),
                });
                let request = self.token.attach(tokio_stream::iter(chunks.collect::<Vec<_>>()));
                self.participant.restore(request).await.map(drop)
            }
            Call::Link => self.participant.link(self.token.attach(link_request(&run_id))).await.map(drop),
            Call::Snapshots => {
                let request = self.token.attach(wire::SnapshotsRequest { run_id });
                self.participant.snapshots(request).await.map(drop)
            }
            Call::Run => {
                let (sender, stream) = mpsc::channel(1);
                self.commands.push(sender);
                self.participant.run(self.token.attach(ReceiverStream::new(stream))).await.map(drop)
            }
            Call::Checkpoint => {
                let request = self.token.attach(wire::CheckpointRequest { run_id, epoch: 0, step: 0 });
                self.participant.checkpoint(request).await.map(drop)
            }
            Call::Exchange => {
                let (sender, stream) = mpsc::channel(1);
                self.frames.push(sender);
                self.peer.exchange(self.token.attach(ReceiverStream::new(stream))).await.map(drop)
            }
            Call::Close => {
                self.participant.close(self.token.attach(wire::CloseRequest { run_id })).await.map(drop)
            }
        }
    }
}

fn code(result: &Result<(), tonic::Status>) -> Code {
    result.as_ref().map_or_else(tonic::Status::code, |()| Code::Ok)
}

#[tokio::test(flavor = "multi_thread")]
async fn every_call_in_every_state_is_answered_as_the_table_says() {
    for call in CALLS {
        for (state, expected) in STATES.into_iter().zip(expected(call)) {
            let mut walker = soon("a state", Walker::at(state)).await;
            let answer = soon("a call", walker.call(call, RUN)).await;
            assert_eq!(code(&answer), expected, "{call:?} in {state:?}: {answer:?}");
            if let Err(status) = answer {
                let text = status.message();
                match expected {
                    Code::FailedPrecondition => {
                        let named = format!("{state:?}").to_uppercase();
                        assert!(
                            text.contains(&named) && text.contains("expected"),
                            "{call:?} in {state:?}: {text}"
                        );
                    }
                    Code::ResourceExhausted => {
                        assert!(text.contains("walker") && text.contains(" s,"), "{text}")
                    }
                    _ => assert_eq!(text, "not allowed"),
                }
            }
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_wrong_token_is_refused_without_detail_in_every_state() {
    for state in STATES.into_iter().skip(1) {
        for call in [Call::Link, Call::Snapshots, Call::Run, Call::Exchange, Call::Close] {
            let mut walker = soon("a state", Walker::at(state)).await;
            walker.token = Token::fresh().unwrap();
            let answer = soon("a call", walker.call(call, RUN)).await;
            assert_eq!(code(&answer), Code::PermissionDenied, "{call:?} in {state:?}: {answer:?}");
            assert_eq!(answer.unwrap_err().message(), "not allowed");
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn another_run_id_is_refused_and_closing_it_does_nothing() {
    let mut walker = Walker::at(At::Open).await;
    let answer = walker.call(Call::Link, "other").await;
    assert_eq!(code(&answer), Code::FailedPrecondition);
    let request = walker.token.attach(wire::CloseRequest { run_id: "other".into() });
    assert!(!walker.participant.close(request).await.unwrap().into_inner().closed);
    walker.call(Call::Link, RUN).await.unwrap();
    for closed in [true, false] {
        let request = walker.token.attach(wire::CloseRequest { run_id: RUN.into() });
        assert_eq!(walker.participant.close(request).await.unwrap().into_inner().closed, closed);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn one_snapshot_stream_and_one_exchange_stream_only() {
    for call in [Call::Snapshots, Call::Exchange] {
        let mut walker = Walker::at(At::Linked).await;
        walker.call(call, RUN).await.unwrap();
        let answer = walker.call(call, RUN).await;
        assert_eq!(code(&answer), Code::FailedPrecondition, "{call:?}");
        assert!(answer.unwrap_err().message().contains("one stream only"));
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_command_for_another_run_or_epoch_ends_the_run() {
    for (run_id, epoch) in [("other", 0), (RUN, 1)] {
        let mut walker = Walker::at(At::Running).await;
        let (commands, events) = walker.run.as_mut().unwrap();
        commands.send(encode_command(run_id, epoch, Command::Stop)).await.unwrap();
        let status = soon("the stream", async {
            loop {
                match events.message().await {
                    Ok(Some(_)) => {}
                    Ok(None) => panic!("ended without a status"),
                    Err(status) => return status,
                }
            }
        })
        .await;
        assert_eq!(status.code(), Code::FailedPrecondition);
        assert!(status.message().contains("expected: \"run\", epoch 0"), "{status}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn requests_that_cannot_be_opened_are_refused_and_leave_the_server_usable() {
    let mut walker = Walker::at(At::Idle).await;
    let good = open_request(&alone(Role::Solid, RUN, 3), &walker.token);
    let mut refused = Vec::new();
    let mut request = good.clone();
    request.protocol.as_mut().unwrap().major = 3;
    refused.push((request, Code::Unimplemented, "is 3.0, this server speaks 2.0"));
    let mut request = good.clone();
    request.protocol = None;
    refused.push((request, Code::Unimplemented, "is 0.0"));
    refused.push((
        wire::OpenRequest { token: "short".into(), ..good.clone() },
        Code::InvalidArgument,
        "`open.token`",
    ));
    refused.push((
        wire::OpenRequest { holder: "x".repeat(257), ..good.clone() },
        Code::InvalidArgument,
        "`open.holder`",
    ));
    refused.push((
        wire::OpenRequest { setup: None, ..good.clone() },
        Code::InvalidArgument,
        "`open.setup`: is missing",
    ));
    let fluid = open_request(&alone(Role::Fluid, RUN, 3), &walker.token);
    refused.push((fluid, Code::InvalidArgument, "is for a fluid, but row plays [Solid]"));
    let bad = open_request(&alone(Role::Solid, "bad", 3), &walker.token);
    refused.push((bad, Code::InvalidArgument, "first problem\nsecond problem"));
    let panics = open_request(&alone(Role::Solid, "open-panic", 3), &walker.token);
    refused.push((panics, Code::Internal, "seeded panic in open"));
    let mut request = good.clone();
    let Some(wire::open_request::Setup::Solid(solid)) = request.setup.as_mut() else { panic!() };
    solid.particle_spacing_m = Some(f64::NAN);
    refused.push((request, Code::InvalidArgument, "`open.solid.particle_spacing_m`: is NaN"));
    for (request, code, text) in refused {
        let status = walker.participant.open(request).await.unwrap_err();
        assert_eq!(status.code(), code, "{status}");
        assert!(status.message().contains(text), "{status}");
    }
    // A later minor version is welcome.
    let mut request = good;
    request.protocol.as_mut().unwrap().minor = 7;
    walker.participant.open(request).await.unwrap();
}

#[tokio::test(flavor = "multi_thread")]
async fn a_link_must_fit_the_set_up() {
    let server = TestServer::start(Role::Fluid);
    let mut client = server.client().await;
    let plan = |partner| LinkPlan {
        first_limit: 1.0,
        partner_extent: Extent::default(),
        partner,
        partner_particles: None,
    };
    assert_eq!(client.link(&plan(Partner::Alone)).await.unwrap_err().code, RpcCode::FailedPrecondition);
    client.open(&setup(Role::Fluid, RUN, 3), &RunAccess::new("x").unwrap()).await.unwrap();
    let error = client.link(&plan(Partner::Alone)).await.unwrap_err();
    assert!(error.message.contains("opened with a coupling"), "{error}");
    // No server listens there: a port that was free a moment ago.
    let port = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let error = soon("the dial", client.link(&plan(Partner::Dial(port.to_string())))).await.unwrap_err();
    assert_eq!(error.code, RpcCode::Unavailable);
    assert!(
        error.message.contains(&port.to_string()) && error.message.contains("cannot be reached"),
        "{error}"
    );
    // A server that has no such run.
    let other = TestServer::start(Role::Solid);
    let error = client.link(&plan(Partner::Dial(other.address.to_string()))).await.unwrap_err();
    assert!(error.message.contains("refused the exchange"), "{error}");
    // The run is still open and can be linked yet.
    client.close().await.unwrap();
    client.open(&alone(Role::Fluid, RUN, 3), &RunAccess::new("x").unwrap()).await.unwrap();
    let error = client.link(&plan(Partner::Listen)).await.unwrap_err();
    assert!(error.message.contains("without a coupling"), "{error}");
    client.link(&plan(Partner::Alone)).await.unwrap();
}

#[tokio::test(flavor = "multi_thread")]
async fn an_idle_run_is_closed_after_the_lease() {
    let options = ServeOptions { lease: Duration::from_millis(100), threads: 1, ..ServeOptions::default() };
    let server = TestServer::with_options(Role::Solid, options);
    let mut client = server.client().await;
    client.open(&alone(Role::Solid, RUN, 3), &RunAccess::new("forgetful").unwrap()).await.unwrap();
    let mut second = server.client().await;
    let error = second.open(&alone(Role::Solid, "b", 3), &RunAccess::new("b").unwrap()).await.unwrap_err();
    assert_eq!(error.code, RpcCode::Busy);
    assert!(error.message.contains("forgetful"), "{error}");
    assert_usable(&mut second, Role::Solid).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn closing_while_opening_frees_the_server() {
    let mut walker = Walker::at(At::Idle).await;
    let mut opening = Walker::at(At::Idle).await;
    std::mem::swap(&mut opening.participant, &mut walker.participant);
    let request = open_request(&alone(Role::Solid, "open-slow", 3), &opening.token);
    let mut participant = opening.participant.clone();
    let pending = tokio::spawn(async move { participant.open(request).await });
    tokio::time::sleep(Duration::from_millis(100)).await;
    opening.call(Call::Close, "open-slow").await.unwrap();
    let status = soon("the open", pending).await.unwrap().unwrap_err();
    assert!(status.message().contains("closed while"), "{status}");
    opening.call(Call::Open, RUN).await.unwrap();
}
