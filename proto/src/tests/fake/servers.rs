//! Servers that run rows of masses.

use std::net::SocketAddr;
use std::time::Duration;

use sph::coupling::exchange::Extent;
use sph::coupling::solver::Role;
use sph::setup::ParticipantSetup;
use sph::space::SomeSpace;
use tokio_util::sync::CancellationToken;

use super::row::RowFactory;
use super::setups::{PLANE, alone, setup_in};
use crate::description::{LinkPlan, Partner};
use crate::service::{ServeOptions, Server};
use crate::transport::client::{Deadlines, ParticipantClient, RunAccess};

/// A server in this process, ended by [`TestServer::end`] or when dropped.
pub(crate) struct TestServer {
    pub(crate) address: SocketAddr,
    stop: CancellationToken,
    serving: tokio::task::JoinHandle<()>,
}

impl TestServer {
    pub(crate) fn start(role: Role) -> Self {
        Self::with_options(role, ServeOptions { threads: 2, ..ServeOptions::default() })
    }

    pub(crate) fn with_options(role: Role, options: ServeOptions) -> Self {
        let server = Server::bind("127.0.0.1:0".parse().unwrap()).unwrap();
        let address = server.address();
        let stop = CancellationToken::new();
        let stopped = stop.clone();
        let serving = tokio::spawn(async move {
            server.serve(RowFactory(role), options, stopped.cancelled()).await.unwrap();
        });
        Self { address, stop, serving }
    }

    pub(crate) async fn client(&self) -> ParticipantClient {
        ParticipantClient::connect(&self.address.to_string(), Deadlines::default()).await.unwrap()
    }

    /// Asks the server to end and waits for it.
    pub(crate) async fn end(mut self) {
        self.stop.cancel();
        (&mut self.serving).await.unwrap();
    }
}

impl Drop for TestServer {
    fn drop(&mut self) {
        self.stop.cancel();
    }
}

/// Both servers with an opened and linked run.
pub(crate) struct Pair {
    pub(crate) servers: [TestServer; 2],
    pub(crate) fluid: ParticipantClient,
    pub(crate) solid: ParticipantClient,
}

impl Pair {
    pub(crate) async fn linked(run_id: &str, steps: u32) -> Self {
        Self::linked_in(PLANE, run_id, steps).await
    }

    pub(crate) async fn linked_in(space: SomeSpace, run_id: &str, steps: u32) -> Self {
        let servers = [TestServer::start(Role::Fluid), TestServer::start(Role::Solid)];
        let mut fluid = servers[0].client().await;
        let mut solid = servers[1].client().await;
        link(
            &mut fluid,
            &mut solid,
            [Role::Fluid, Role::Solid].map(|role| setup_in(space, role, run_id, steps)),
        )
        .await;
        Self { servers, fluid, solid }
    }
}

/// Opens and links a run on two servers.
pub(crate) async fn link(
    fluid: &mut ParticipantClient,
    solid: &mut ParticipantClient,
    setups: [ParticipantSetup; 2],
) {
    let access = RunAccess::new("a test").unwrap();
    let f = fluid.open(&setups[0], &access).await.unwrap();
    let s = solid.open(&setups[1], &access).await.unwrap();
    assert_eq!(crate::handshake::mismatches(&f, &s), Vec::<String>::new());
    let first_limit = f.time_step_limit.min(s.time_step_limit);
    let plan = |partner_extent: &Extent, partner| LinkPlan {
        first_limit,
        partner_extent: partner_extent.clone(),
        partner,
        partner_particles: None,
    };
    solid.link(&plan(&f.extent, Partner::Listen)).await.unwrap();
    fluid.link(&plan(&s.extent, Partner::Dial(solid.address().into()))).await.unwrap();
}

/// Waits until `client` can open and close a run again: the server is free and whole.
pub(crate) async fn assert_usable(client: &mut ParticipantClient, role: Role) {
    let access = RunAccess::new("the next").unwrap();
    let deadline = tokio::time::Instant::now() + Duration::from_secs(10);
    loop {
        match client.open(&alone(role, "next", 1), &access).await {
            Ok(_) => break,
            Err(error) if tokio::time::Instant::now() > deadline => panic!("server is not usable: {error}"),
            Err(_) => tokio::time::sleep(Duration::from_millis(20)).await,
        }
    }
    client.close().await.unwrap();
}

/// Fails instead of hanging.
pub(crate) async fn soon<T>(what: &str, future: impl Future<Output = T>) -> T {
    match tokio::time::timeout(Duration::from_secs(20), future).await {
        Ok(value) => value,
        Err(_) => panic!("{what} hangs"),
    }
}
