//! The life-cycle table of participant.proto.

use sph::coupling::exchange::Extent;
use sph::setup::ParticipantSetup;
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;
use tonic::{Code, Status};

use super::bench::{Bench, open_request};
use super::scene::Scene;
use super::{Finding, passed};
use crate::convert::{encode_command, link_to_wire};
use crate::description::{LinkPlan, Partner};
use crate::transport::security::SecuredChannel;
use crate::transport::token::Token;
use crate::wire;
use crate::wire::participant_client::ParticipantClient as WireClient;
use crate::wire::peer_client::PeerClient;
use sph::coupling::driver::Command;

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum State {
    Idle,
    Open,
    Linked,
    Running,
    Ended,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Call {
    Open,
    Restore,
    Link,
    Snapshots,
    Run,
    Checkpoint,
    Exchange,
    Close,
}

const CALLS: [Call; 8] = [
    Call::Open,
    Call::Restore,
    Call::Link,
    Call::Snapshots,
    Call::Run,
    Call::Checkpoint,
    Call::Exchange,
    Call::Close,
];

/// A run brought to a state by raw calls. It has no partner, so that Exchange is never awaited.
struct Walker<'a> {
    bench: &'a Bench,
    client: WireClient<SecuredChannel>,
    peer: PeerClient<SecuredChannel>,
    setup: ParticipantSetup,
    token: Token,
    /// Keep request streams open.
    commands: Vec<mpsc::Sender<wire::Command>>,
    frames: Vec<mpsc::Sender<wire::Frame>>,
    events: Option<tonic::Streaming<wire::EventBatch>>,
}

impl<'a> Walker<'a> {
    async fn at(bench: &'a Bench, state: State) -> Result<Self, String> {
        let (client, channel) = bench.raw().await?;
        let scene = bench.fit(Scene { coupled: false, steps: 3, ..bench.still() });
        let mut walker = Self {
            bench,
            client,
            peer: PeerClient::new(channel),
            setup: scene.setup(bench.role),
            token: Token::fresh()?,
            commands: Vec::new(),
            frames: Vec::new(),
            events: None,
        };
        let on_the_way = |call: Call| move |status: Status| format!("{call:?} on the way: {status}");
        bench.opens(walker.setup.run_id(), &walker.token);
        if state >= State::Open {
            walker.call(Call::Open).await?.map_err(on_the_way(Call::Open))?;
        }
        if state >= State::Linked {
            walker.call(Call::Link).await?.map_err(on_the_way(Call::Link))?;
        }
        if state >= State::Running {
            walker.call(Call::Run).await?.map_err(on_the_way(Call::Run))?;
        }
        if state == State::Ended {
            walker.finish().await?;
        }
        Ok(walker)
    }

    async fn finish(&mut self) -> Result<(), String> {
        let run_id = self.setup.run_id();
        let Some(commands) = self.commands.first() else { return Err("there is no run".into()) };
        let grant = encode_command(run_id, 0, Command::GrantThrough(1 << 40));
        commands.send(grant).await.map_err(|_| "the server takes no commands")?;
        let Some(events) = self.events.as_mut() else { return Err("there are no events".into()) };
        let listening = async { while let Ok(Some(_)) = events.message().await {} };
        tokio::time::timeout(self.bench.deadline, listening)
            .await
            .map_err(|_| "the events do not end after the last one".to_owned())
    }

    async fn call(&mut self, call: Call) -> Result<Result<(), Status>, String> {
        let token = self.token.clone();
        let run_id = self.setup.run_id().to_owned();
        let bench = self.bench;
        let name = format!("{call:?}");
        let client = &mut self.client;
        Ok(match call {
            Call::Open => {
                let request = open_request(&self.setup, &token);
                bench.within(&name, client.open(request)).await?.map(drop)
            }
            Call::Restore => {
                let (_, chunks) = mpsc::channel::<wire::RestoreChunk>(1);
                let request = token.attach(ReceiverStream::new(chunks));
                bench.within(&name, client.restore(request)).await?.map(drop)
            }
            Call::Link => {
                let plan = LinkPlan {
                    first_limit: 1.0,
                    partner_extent: Extent::default(),
                    partner: Partner::Alone,
                    partner_particles: None,
                };
                let request = token.attach(wire::LinkRequest { run_id, ..link_to_wire(&plan) });
                bench.within(&name, client.link(request)).await?.map(drop)
            }
            Call::Snapshots => {
                let request = token.attach(wire::SnapshotsRequest { run_id });
                bench.within(&name, client.snapshots(request)).await?.map(drop)
            }
            Call::Run => {
                let (commands, stream) = mpsc::channel(4);
                self.commands.push(commands);
                let request = token.attach(ReceiverStream::new(stream));
                let answer = bench.within(&name, client.run(request)).await?;
                answer.map(|events| {
                    // The first one holds the run.
                    self.events.get_or_insert(events);
                })
            }
            Call::Checkpoint => {
                let request = token.attach(wire::CheckpointRequest { run_id, epoch: 0, step: 0 });
                bench.within(&name, client.checkpoint(request)).await?.map(drop)
            }
            Call::Exchange => {
                let (frames, stream) = mpsc::channel(4);
                self.frames.push(frames);
                let request = token.attach(ReceiverStream::new(stream));
                bench.within(&name, self.peer.exchange(request)).await?.map(drop)
            }
            Call::Close => {
                let request = token.attach(wire::CloseRequest { run_id });
                bench.within(&name, client.close(request)).await?.map(drop)
            }
        })
    }
}

/// The code by which `call` is refused in `state`; `None` where it is allowed or depends on more than the state.
fn refusal(state: State, call: Call, checkpoints: bool) -> Option<Code> {
    let here = |allowed: &[State]| (!allowed.contains(&state)).then_some(Code::FailedPrecondition);
    match call {
        Call::Open => (state != State::Idle).then_some(Code::ResourceExhausted),
        Call::Restore | Call::Checkpoint if !checkpoints => Some(Code::Unimplemented),
        // Where it is allowed it wants data; see the checks of checkpoints.
        Call::Restore => here(&[State::Open]),
        Call::Checkpoint => here(&[State::Running]),
        Call::Link => here(&[State::Open]),
        Call::Snapshots | Call::Run => here(&[State::Linked]),
        Call::Exchange if state == State::Idle => Some(Code::PermissionDenied),
        Call::Exchange => Some(Code::FailedPrecondition),
        Call::Close => None,
    }
}

async fn walk(bench: &Bench, state: State) -> Finding {
    let mut walker = Walker::at(bench, state).await?;
    let (mut wrong, mut refused) = (Vec::new(), 0);
    for call in CALLS {
        let Some(code) = refusal(state, call, bench.description.capabilities.checkpoint) else { continue };
        refused += 1;
        match walker.call(call).await? {
            Err(status) if status.code() == code => {
                if status.message().is_empty() && code != Code::PermissionDenied {
                    wrong.push(format!("{call:?}: {code:?} as it should, but without a word"));
                }
            }
            Err(status) => wrong.push(format!("{call:?}: expected {code:?}, got {:?}", status.code())),
            Ok(()) => wrong.push(format!("{call:?}: expected {code:?}, is accepted")),
        }
    }
    for time in ["a first", "a second"] {
        if let Err(status) = walker.call(Call::Close).await? {
            wrong.push(format!("{time} Close is refused: {status}"));
        }
    }
    if wrong.is_empty() {
        passed(format!("{refused} calls refused by the right code"))
    } else {
        Err(wrong.join("; "))
    }
}

pub(super) async fn idle(bench: &Bench) -> Finding {
    walk(bench, State::Idle).await
}

pub(super) async fn open(bench: &Bench) -> Finding {
    walk(bench, State::Open).await
}

pub(super) async fn linked(bench: &Bench) -> Finding {
    walk(bench, State::Linked).await
}

pub(super) async fn running(bench: &Bench) -> Finding {
    walk(bench, State::Running).await
}

pub(super) async fn ended(bench: &Bench) -> Finding {
    walk(bench, State::Ended).await
}

pub(super) async fn token(bench: &Bench) -> Finding {
    let mut walker = Walker::at(bench, State::Open).await?;
    let right = std::mem::replace(&mut walker.token, Token::fresh()?);
    for call in [Call::Link, Call::Close, Call::Exchange] {
        match walker.call(call).await? {
            Err(status) if status.code() == Code::PermissionDenied => {}
            Err(status) => return Err(format!("{call:?}: expected PermissionDenied, got {status}")),
            Ok(()) => return Err(format!("{call:?} with a wrong token is accepted")),
        }
    }
    walker.token = right;
    match walker.call(Call::Link).await? {
        Ok(()) => passed("the right token still opens the way"),
        Err(status) => Err(format!("after that the right token is refused: {status}")),
    }
}

pub(super) async fn bad_setups(bench: &Bench) -> Finding {
    use wire::open_request::Setup;
    let (mut client, _) = bench.raw().await?;
    let setup = bench.fit(Scene { coupled: false, ..bench.still() }).setup(bench.role);
    let token = Token::fresh()?;
    bench.opens(setup.run_id(), &token);
    type Spoil = fn(&mut wire::OpenRequest);
    let cases: [(&str, Spoil); 6] = [
        ("no set-up", |request| request.setup = None),
        ("a short token", |request| request.token = "short".into()),
        ("no run", |request| match request.setup.as_mut() {
            Some(Setup::Fluid(fluid)) => fluid.run = None,
            Some(Setup::Solid(solid)) => solid.run = None,
            None => {}
        }),
        ("a NaN in the gravity", |request| {
            let run = match request.setup.as_mut() {
                Some(Setup::Fluid(fluid)) => fluid.run.as_mut(),
                Some(Setup::Solid(solid)) => solid.run.as_mut(),
                None => None,
            };
            let gravity =
                run.and_then(|run| run.body_force.as_mut()).and_then(|b| b.gravity_m_per_s2.as_mut());
            if let Some(gravity) = gravity {
                gravity.components[0] = f64::NAN;
            }
        }),
        ("a truncated array", |request| match request.setup.as_mut() {
            Some(Setup::Fluid(fluid)) => {
                fluid.particles.iter_mut().for_each(|p| p.positions_m = p.positions_m.slice(..8));
            }
            Some(Setup::Solid(solid)) => {
                solid.particles.iter_mut().for_each(|p| p.positions_m = p.positions_m.slice(..8));
            }
            None => {}
        }),
        ("a mass of zero", |request| match request.setup.as_mut() {
            Some(Setup::Fluid(fluid)) => fluid.particles.iter_mut().for_each(|p| {
                p.masses_kg = vec![0; p.masses_kg.len()].into();
            }),
            Some(Setup::Solid(solid)) => solid.particles.iter_mut().for_each(|p| {
                p.masses_kg = vec![0; p.masses_kg.len()].into();
            }),
            None => {}
        }),
    ];
    let mut wrong = Vec::new();
    for (what, spoil) in cases {
        let mut request = open_request(&setup, &token);
        spoil(&mut request);
        match bench.within("Open", client.open(request)).await? {
            Err(status) if status.code() == Code::InvalidArgument && !status.message().is_empty() => {}
            Err(status) => wrong.push(format!("{what}: expected INVALID_ARGUMENT in words, got {status}")),
            Ok(_) => {
                wrong.push(format!("{what} is accepted"));
                bench.free().await?;
                bench.opens(setup.run_id(), &token);
            }
        }
    }
    if wrong.is_empty() { passed(format!("{} refused", cases.len())) } else { Err(wrong.join("; ")) }
}

pub(super) async fn coordinator_vanishes(bench: &Bench) -> Finding {
    let walker = Walker::at(bench, State::Running).await?;
    let Walker { commands, events, client, .. } = walker;
    drop((commands, events, client));
    let (mut client, _) = bench.raw().await?;
    let setup = bench.fit(Scene { coupled: false, ..bench.still() }).setup(bench.role);
    let token = Token::fresh()?;
    let started = tokio::time::Instant::now();
    loop {
        match bench.within("Open", client.open(open_request(&setup, &token))).await? {
            Ok(_) => {
                bench.opens(setup.run_id(), &token);
                return passed(format!("free after {:.1} s", started.elapsed().as_secs_f64()));
            }
            Err(status) if started.elapsed() > bench.deadline => {
                return Err(format!("the server is still held: {status}"));
            }
            Err(_) => tokio::time::sleep(std::time::Duration::from_millis(50)).await,
        }
    }
}
