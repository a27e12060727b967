//! What all checks use: runs of the participant alone and with a dummy, and raw calls.

use std::collections::HashSet;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use sph::coupling::audit::PartnerParticles;
use sph::coupling::driver::{Command, Event, StepReport};
use sph::coupling::exchange::Extent;
use sph::coupling::ledger::LedgerVector;
use sph::coupling::solver::{Fault, ParticleFields, Role};
use sph::in_space;
use sph::setup::{CouplingKind, ParticipantSetup};
use sph::space::{Plane, SomeSpace, Spatial};
use tonic::Status;

use super::dummy::{DummyServer, Quirk};
use super::scene::{Scene, in_dimensions};
use super::{Options, connect};
use crate::convert::{Convert, encode_setup};
use crate::description::{Description, LinkPlan, OpenReport, PROTOCOL, Partner};
use crate::error::{RpcCode, RpcError};
use crate::handshake;
use crate::transport::client::{CommandSender, Deadlines, EventReceiver, ParticipantClient, RunAccess};
use crate::transport::relay::{Relay, Tap};
use crate::transport::security::{ClientSecurity, SecuredChannel, ServerSecurity};
use crate::transport::token::Token;
use crate::wire;
use crate::wire::participant_client::ParticipantClient as WireClient;

/// The participant under examination.
pub(super) struct Bench {
    pub(super) address: String,
    pub(super) fresh: Option<String>,
    pub(super) deadline: Duration,
    pub(super) deadlines: Deadlines,
    pub(super) security: ClientSecurity,
    pub(super) description: Description,
    pub(super) role: Role,
    pub(super) kind: CouplingKind,
    /// Space in which it is examined.
    pub(super) space: SomeSpace,
    /// Whether it takes a body that nothing holds; a fluid has none.
    pub(super) takes_free_bodies: bool,
    /// Runs that raw calls opened, to be closed.
    left_open: Mutex<HashSet<(String, String)>>,
}

/// What came of a run on one side.
#[derive(Debug, Default)]
pub(super) struct Record {
    pub(super) reports: Vec<StepReport>,
    pub(super) state: ParticleFields,
    pub(super) fault: Option<Fault>,
    /// Phase of the last sign of life.
    pub(super) steps: u64,
}

impl Record {
    /// Values of a vector field of the final state in the order of ids.
    pub(super) fn field(&self, space: SomeSpace, name: &str) -> Result<Vec<LedgerVector>, String> {
        let dimensions = space.dimensions();
        let field = self.state.field(name).filter(|field| field.components == dimensions);
        let field = field.ok_or_else(|| {
            format!("the final state has no vector field `{name}` of {dimensions} components")
        })?;
        let number = |i: usize, k: usize| if k < dimensions { field.values[dimensions * i + k] } else { 0.0 };
        let mut order: Vec<usize> = (0..self.state.id.len()).collect();
        order.sort_unstable_by_key(|i| self.state.id[*i]);
        Ok(order.iter().map(|i| LedgerVector::from_fn(|k, _| number(*i, k))).collect())
    }

    /// That the run came to its end.
    pub(super) fn completed(self, who: &str) -> Result<Self, String> {
        match &self.fault {
            None => Ok(self),
            Some(fault) => Err(format!("the run of {who} failed: {fault}")),
        }
    }
}

/// A coupled run that continues: the participant first, then the dummy.
pub(super) struct Coupled {
    pub(super) clients: [ParticipantClient; 2],
    pub(super) commands: [CommandSender; 2],
    pub(super) events: [EventReceiver; 2],
    _dummy: DummyServer,
    _relay: Option<Relay>,
}

impl Bench {
    pub(super) async fn new(
        address: &str,
        options: &Options,
        deadlines: Deadlines,
        description: Description,
    ) -> Result<Self, RpcError> {
        let kind = options.kind.or(description.coupling_kinds.first().copied()).unwrap_or_default();
        let role = description.roles.first().copied().unwrap_or(Role::Solid);
        let offers = |space: &SomeSpace| {
            description.dimensions.contains(&options.dimensions)
                && usize::try_from(options.dimensions) == Ok(space.dimensions())
        };
        let space = [SomeSpace::Plane(Plane), SomeSpace::Spatial(Spatial)].into_iter().find(offers);
        let space = space.ok_or_else(|| {
            let offered: Vec<String> = description.dimensions.iter().map(u32::to_string).collect();
            let text = format!(
                "{} computes in {} dimensions and cannot be examined in {}; choose by `--dimensions`",
                description.name,
                offered.join(" or "),
                options.dimensions
            );
            RpcError::new(RpcCode::FailedPrecondition, "Describe", address, text)
        })?;
        let mut bench = Self {
            address: address.to_owned(),
            fresh: options.fresh.clone(),
            deadline: options.deadline,
            deadlines,
            security: options.security.clone(),
            description,
            role,
            kind,
            space,
            takes_free_bodies: true,
            left_open: Mutex::default(),
        };
        let scene = |clamped: bool| Scene { clamped, ..Scene::still(space, kind) }.setup(role);
        let (mut client, _) = match bench.open(&scene(false)).await {
            Ok(opened) => opened,
            Err(free) => {
                bench.takes_free_bodies = false;
                bench.open(&scene(true)).await.map_err(|clamped| {
                    let text = format!(
                        "neither a free nor a clamped body can be opened, so that there is nothing to examine: {free}; \
                         {clamped}"
                    );
                    RpcError::new(RpcCode::FailedPrecondition, "Open", address, text)
                })?
            }
        };
        client.close().await?;
        Ok(bench)
    }

    /// `scene` as the participant takes it: clamped when it takes no free bodies.
    pub(super) fn fit(&self, scene: Scene) -> Scene {
        Scene { clamped: scene.clamped || !self.takes_free_bodies, ..scene }
    }

    /// A scene at rest without contact.
    pub(super) fn still(&self) -> Scene {
        Scene::still(self.space, self.kind)
    }

    /// The vector of `components`, the last one for space alone.
    pub(super) fn vector(&self, components: [f64; 3]) -> LedgerVector {
        in_dimensions(self.space, components)
    }

    pub(super) fn pushing(&self) -> Scene {
        self.fit(Scene::pushing(self.space, self.kind))
    }

    fn access() -> Result<RunAccess, String> {
        RunAccess::new("coordinator conform").map_err(|e| e.to_string())
    }

    pub(super) async fn open(
        &self,
        setup: &ParticipantSetup,
    ) -> Result<(ParticipantClient, OpenReport), String> {
        let client = ParticipantClient::connect_secured(&self.address, self.deadlines, &self.security);
        let mut client = client.await.map_err(|e| e.to_string())?;
        let access = Self::access()?;
        self.opens(setup.run_id(), &access.token);
        let report = client.open(setup, &access).await.map_err(|e| e.to_string())?;
        Ok((client, report))
    }

    /// Runs the participant without partner to its end.
    pub(super) async fn run_alone(&self, scene: Scene) -> Result<Record, String> {
        let scene = Scene { coupled: false, ..scene };
        let (mut client, report) = self.open(&scene.setup(self.role)).await?;
        let plan = LinkPlan {
            first_limit: report.time_step_limit,
            partner_extent: Extent::default(),
            partner: Partner::Alone,
            partner_particles: None,
        };
        client.link(&plan).await.map_err(|e| e.to_string())?;
        let (commands, mut events) = client.run().await.map_err(|e| e.to_string())?;
        grant(&commands);
        let record = self.collect(&mut events).await;
        // What went wrong in the run comes first.
        let closed = client.close().await;
        let record = record?.completed("the participant")?;
        closed.map_err(|e| e.to_string())?;
        Ok(record)
    }

    /// Starts a run with a dummy; `tap` sees all frames.
    pub(super) async fn couple(
        &self,
        scene: Scene,
        quirk: Quirk,
        tap: Option<Tap>,
    ) -> Result<Coupled, String> {
        let partner = self.role.partner();
        let dummy = DummyServer::start(partner, quirk, self.security.clone())?;
        let access = Self::access()?;
        self.opens(scene.setup(self.role).run_id(), &access.token);
        let mut clients = Vec::new();
        for address in [&self.address, &dummy.address] {
            let client = ParticipantClient::connect_secured(address, self.deadlines, &self.security).await;
            clients.push(client.map_err(|e| e.to_string())?);
        }
        let mut reports = Vec::new();
        for (client, role) in clients.iter_mut().zip([self.role, partner]) {
            reports.push(client.open(&scene.setup(role), &access).await.map_err(|e| e.to_string())?);
        }
        let [fluid, solid] = if self.role == Role::Fluid { [0, 1] } else { [1, 0] };
        let differences = handshake::mismatches(&reports[fluid], &reports[solid]);
        if !differences.is_empty() {
            return Err(format!("it does not fit its partner: {}", differences.join("; ")));
        }
        let first_limit = reports[0].time_step_limit.min(reports[1].time_step_limit);
        let plan = |of: usize, partner, partner_particles| LinkPlan {
            first_limit,
            partner_extent: reports[of].extent.clone(),
            partner,
            partner_particles,
        };
        clients[solid].link(&plan(fluid, Partner::Listen, None)).await.map_err(|e| e.to_string())?;
        let listening = clients[solid].address().to_owned();
        let security = ServerSecurity::calling(self.security.clone());
        let relay = tap.map(|tap| Relay::start(&listening, security, tap)).transpose()?;
        let dialled = relay.as_ref().map_or(listening, |relay| relay.address.to_string());
        let particles = match scene.setup(Role::Solid) {
            ParticipantSetup::Solid(setup) => Some(in_space!(&setup, setup => PartnerParticles::of(setup))),
            ParticipantSetup::Fluid(_) => None,
        };
        clients[fluid]
            .link(&plan(solid, Partner::Dial(dialled), particles))
            .await
            .map_err(|e| e.to_string())?;
        let mut lines = Vec::new();
        for client in &mut clients {
            lines.push(client.run().await.map_err(|e| e.to_string())?);
        }
        let pair = |what: &str| format!("a run has two sides, {what}");
        let clients = <[ParticipantClient; 2]>::try_from(clients).map_err(|_| pair("clients"))?;
        let (commands, events): (Vec<_>, Vec<_>) = lines.into_iter().unzip();
        let commands = <[CommandSender; 2]>::try_from(commands).map_err(|_| pair("commands"))?;
        let events = <[EventReceiver; 2]>::try_from(events).map_err(|_| pair("events"))?;
        Ok(Coupled { clients, commands, events, _dummy: dummy, _relay: relay })
    }

    /// Runs with a dummy to the end of both sides: the participant's record first, then the dummy's.
    pub(super) async fn run_coupled(
        &self,
        scene: Scene,
        quirk: Quirk,
        tap: Option<Tap>,
    ) -> Result<[Record; 2], String> {
        let mut run = self.couple(scene, quirk, tap).await?;
        run.commands.iter().for_each(grant);
        let [own, partner] = &mut run.events;
        let (own, partner) = tokio::join!(self.collect(own), self.collect(partner));
        let [client, dummy] = &mut run.clients;
        let closed = client.close().await;
        // The dummy ends with this process, if not now.
        drop(dummy.close().await);
        let records = [own?, partner?];
        closed.map_err(|e| e.to_string())?;
        Ok(records)
    }

    /// Runs with a dummy; both sides must come to the end.
    pub(super) async fn completed(&self, scene: Scene, quirk: Quirk) -> Result<[Record; 2], String> {
        let [own, dummy] = self.run_coupled(scene, quirk, None).await?;
        // The partner knows what is wrong with the participant; that it ended is a consequence.
        if let Some(fault @ Fault::Contradiction { .. }) = &dummy.fault {
            return Err(fault.to_string());
        }
        Ok([own.completed("the participant")?, dummy.completed("its partner")?])
    }

    /// All events up to the last.
    pub(super) async fn collect(&self, events: &mut EventReceiver) -> Result<Record, String> {
        let mut record = Record::default();
        loop {
            let event = tokio::time::timeout(self.deadline, events.recv());
            match event.await.map_err(|_| {
                format!("no event within {} s after step {}", self.deadline.as_secs_f64(), record.steps)
            })? {
                Some(Ok(Event::Step(report))) => {
                    record.steps = report.step + 1;
                    record.reports.push(report);
                }
                Some(Ok(Event::Finished(report))) => {
                    record.state = report.state;
                    return Ok(record);
                }
                Some(Ok(Event::Failed(report))) => {
                    record.fault = Some(report.fault);
                    record.state = report.state;
                    return Ok(record);
                }
                Some(Ok(_)) => {}
                Some(Err(error)) => return Err(format!("the run broke off: {error}")),
                None => return Err("the events ended before the last one".into()),
            }
        }
    }

    /// A raw client.
    pub(super) async fn raw(&self) -> Result<(WireClient<SecuredChannel>, SecuredChannel), String> {
        let channel = connect(&self.address, self).await?;
        let limit = crate::limits::MAX_MESSAGE_BYTES;
        Ok((WireClient::new(channel.clone()).max_decoding_message_size(limit), channel))
    }

    /// The answer of a raw call, bounded in time.
    pub(super) async fn within<T>(
        &self,
        call: &str,
        answer: impl Future<Output = Result<tonic::Response<T>, Status>>,
    ) -> Result<Result<T, Status>, String> {
        match tokio::time::timeout(self.deadline, answer).await {
            Ok(answer) => Ok(answer.map(tonic::Response::into_inner)),
            Err(_) => Err(format!("`{call}` gives no answer within {} s", self.deadline.as_secs_f64())),
        }
    }

    /// Remembers that a raw call may have opened run `run_id` with `token`.
    pub(super) fn opens(&self, run_id: &str, token: &Token) {
        let mut open = self.left_open.lock().unwrap_or_else(PoisonError::into_inner);
        open.insert((run_id.to_owned(), token.text().to_owned()));
    }

    /// Closes what raw calls opened and waits until the server takes a run again.
    pub(super) async fn free(&self) -> Result<(), String> {
        let open: Vec<_> = {
            let mut open = self.left_open.lock().unwrap_or_else(PoisonError::into_inner);
            open.drain().collect()
        };
        let (mut client, _) = self.raw().await?;
        for (run_id, token) in open {
            let Ok(token) = Token::parse(&token) else { continue };
            let request = token.attach(wire::CloseRequest { run_id });
            // A run that is closed already refuses no call.
            drop(self.within("Close", client.close(request)).await?);
        }
        let setup = self.fit(Scene { coupled: false, ..self.still() }).setup(self.role);
        let until = tokio::time::Instant::now() + self.deadline;
        loop {
            match self.open(&setup).await {
                Ok((mut client, _)) => {
                    return client.close().await.map_err(|e| format!("the server is not usable: {e}"));
                }
                Err(problem) if tokio::time::Instant::now() > until => {
                    return Err(format!("the server is not usable: {problem}"));
                }
                Err(_) => tokio::time::sleep(Duration::from_millis(50)).await,
            }
        }
    }
}

/// Allows all steps.
pub(super) fn grant(commands: &CommandSender) {
    // A participant that has ended tells why on its events.
    drop(commands.send(Command::GrantThrough(1 << 40)));
}

/// The message that opens a run of `setup`.
pub(super) fn open_request(setup: &ParticipantSetup, token: &Token) -> wire::OpenRequest {
    wire::OpenRequest {
        protocol: Some(PROTOCOL.to_wire()),
        token: token.text().into(),
        holder: "coordinator conform".into(),
        setup: Some(encode_setup(setup)),
    }
}
