//! The service skin that both servers share: convert, check the life cycle, call the solver, convert.
//!
//! ```text
//! participant.rs  the control plane's calls     exchange.rs  the data plane's call
//! session.rs      the one object of a run       compute.rs   its compute thread and event stream
//! checkpoint.rs   saving and restoring a run's state
//! ```

mod checkpoint;
mod compute;
mod exchange;
mod participant;
mod reply;
mod saver;
mod session;

use std::future::Future;
use std::net::SocketAddr;
use std::pin::Pin;
use std::sync::Arc;
use std::time::Duration;

use sph::coupling::solver::{Role, Solver};
use sph::setup::{InterfaceLaw, ParticipantSetup};
use tonic::service::interceptor::InterceptedService;

use crate::description::{
    BodyReport, Capabilities, Constants, CouplingKind, Description, Fact, Limits, PROTOCOL,
};
use crate::error::with_causes;
use crate::limits::{MAX_FRAME_BYTES, MAX_MESSAGE_BYTES};
use crate::transport::channel;
use crate::transport::connection::Incoming;
use crate::transport::security::ServerSecurity;
use crate::transport::version1::RefuseVersion1;
use crate::wire;
use session::{Host, Skin};

/// What a server needs of a solver program.
pub trait SolverFactory: Send + Sync + 'static {
    /// What the solver is and can do; start from [`Description::of_solver`].
    fn describe(&self) -> Description;

    /// Builds a solver for a run.
    ///
    /// # Errors
    /// All problems of the set-up.
    fn open(&self, setup: ParticipantSetup) -> Result<Opened, SetupProblems>;
}

impl SolverFactory for Box<dyn SolverFactory> {
    fn describe(&self) -> Description {
        (**self).describe()
    }

    fn open(&self, setup: ParticipantSetup) -> Result<Opened, SetupProblems> {
        (**self).open(setup)
    }
}

/// A solver that is ready for its run.
pub struct Opened {
    /// The solver.
    pub solver: Box<dyn Solver>,
    /// Constants that it really uses.
    pub constants: Constants,
    /// Further numbers for the run header.
    pub facts: Vec<Fact>,
    /// What moves each body of a solid, taken from where its equations read it; empty for a fluid.
    pub bodies: Vec<BodyReport>,
}

/// Why a solver cannot be built: each problem names place, value and what is allowed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SetupProblems(pub Vec<String>);

/// Builds a solver with its largest first step \[s\]: all that `Open` and a check before a run find wrong with a set-up.
///
/// # Errors
/// All problems of the set-up.
pub fn open_checked<F: SolverFactory + ?Sized>(
    factory: &F,
    setup: ParticipantSetup,
) -> Result<(Opened, f64), SetupProblems> {
    let opened = factory.open(setup)?;
    let limit = opened.solver.time_step_limit();
    if limit > 0.0 {
        Ok((opened, limit))
    } else {
        let problem = format!("the set-up allows no time step: its limit is {limit:?} s");
        Err(SetupProblems(vec![problem]))
    }
}

impl Description {
    /// A solver of this workspace that takes runs of these numbers of `dimensions`: states coupling, all laws, nothing
    /// optional but what it says.
    pub fn of_solver(name: &str, version: &str, role: Role, dimensions: &[u32], arithmetic: &str) -> Self {
        Self {
            name: name.into(),
            version: version.into(),
            build: String::new(),
            language: "rust".into(),
            protocols: [PROTOCOL; 2],
            roles: vec![role],
            dimensions: dimensions.to_vec(),
            coupling_kinds: CouplingKind::ALL.to_vec(),
            interface_laws: vec![InterfaceLaw::Wall, InterfaceLaw::WallNoSlip, InterfaceLaw::PlainSum],
            arithmetic: arithmetic.into(),
            capabilities: Capabilities {
                checkpoint: true,
                deterministic: true,
                adaptive_step: true,
                exact_times: true,
                expressions: true,
                implicit_coupling: true,
            },
            limits: ServeOptions::default().limits(),
        }
    }
}

/// How a server serves.
#[derive(Clone, Debug)]
pub struct ServeOptions {
    /// Threads of the pool that computes; at least one.
    pub threads: usize,
    /// A run that is not being stepped ends when no call came for this long; one that is, when its coordinator does not
    /// even answer pings.
    pub lease: Duration,
    /// Longest wait for a frame of the partner; `None` waits while the connection lives.
    pub partner_deadline: Option<Duration>,
    /// Open streams are cut this long after a shutdown was asked for.
    pub shutdown_limit: Duration,
    /// Who may speak.
    pub security: ServerSecurity,
}

impl Default for ServeOptions {
    fn default() -> Self {
        Self {
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            lease: Duration::from_secs(120),
            partner_deadline: None,
            shutdown_limit: Duration::from_secs(5),
            security: ServerSecurity::default(),
        }
    }
}

impl ServeOptions {
    fn limits(&self) -> Limits {
        // Both constants are far below 2^64.
        let bytes = |limit: usize| u64::try_from(limit).unwrap_or(u64::MAX);
        Limits {
            runs: 1,
            max_message_bytes: bytes(MAX_MESSAGE_BYTES),
            max_frame_bytes: bytes(MAX_FRAME_BYTES),
            lease: self.lease,
        }
    }
}

/// Why a server cannot serve.
#[derive(Debug, thiserror::Error)]
pub enum ServeError {
    /// The address is taken or not allowed.
    #[error("cannot listen on {address}: {source}; choose another port, or 0 for any free one")]
    Bind {
        /// Address asked for.
        address: SocketAddr,
        /// Why not.
        source: std::io::Error,
    },
    /// No threads.
    #[error("cannot start {threads} compute threads: {reason}")]
    Threads {
        /// Number asked for.
        threads: usize,
        /// Why not.
        reason: String,
    },
    /// The transport failed.
    #[error("the server failed: {0}")]
    Transport(String),
}

/// A server that holds its port and waits to serve.
#[derive(Debug)]
pub struct Server {
    incoming: Incoming,
    address: SocketAddr,
}

impl Server {
    /// Takes `address`; port 0 takes any free one. Must be called within a runtime.
    ///
    /// # Errors
    /// When the address is taken.
    pub fn bind(address: SocketAddr) -> Result<Self, ServeError> {
        let failed = |source| ServeError::Bind { address, source };
        let incoming = Incoming::bind(address).map_err(failed)?;
        let address = incoming.local_addr().map_err(failed)?;
        Ok(Self { incoming, address })
    }

    /// Address at which the server listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Serves solvers of `factory` until `shutdown` completes; runs that are open then are given up.
    ///
    /// # Errors
    /// When the compute threads cannot be started or the transport fails.
    pub async fn serve(
        self,
        factory: impl SolverFactory,
        options: ServeOptions,
        shutdown: impl Future<Output = ()> + Send,
    ) -> Result<(), ServeError> {
        self.serving(Box::new(factory), options, Box::pin(shutdown)).await
    }

    /// As [`Server::serve`]. Boxed, so that the transport is compiled once, here, and not again in every program.
    fn serving<'a>(
        self,
        factory: Box<dyn SolverFactory>,
        options: ServeOptions,
        shutdown: Pin<Box<dyn Future<Output = ()> + Send + 'a>>,
    ) -> Pin<Box<dyn Future<Output = Result<(), ServeError>> + Send + 'a>> {
        Box::pin(self.serve_host(factory, options, shutdown))
    }

    async fn serve_host(
        self,
        factory: Box<dyn SolverFactory>,
        options: ServeOptions,
        shutdown: Pin<Box<dyn Future<Output = ()> + Send + '_>>,
    ) -> Result<(), ServeError> {
        let host = Arc::new(Host::new(factory, options.clone())?);
        let transport_error = |e: &dyn std::error::Error| ServeError::Transport(with_causes(e));
        let reflection = tonic_reflection::server::Builder::configure()
            .register_encoded_file_descriptor_set(wire::DESCRIPTORS)
            .register_encoded_file_descriptor_set(tonic_health::pb::FILE_DESCRIPTOR_SET)
            .build_v1()
            .map_err(|e| transport_error(&e))?;
        let (health, health_service) = tonic_health::server::health_reporter();
        let participant = wire::participant_server::ParticipantServer::new(Skin(host.clone()))
            .max_decoding_message_size(MAX_MESSAGE_BYTES);
        let peer =
            wire::peer_server::PeerServer::new(Skin(host.clone())).max_decoding_message_size(MAX_FRAME_BYTES);
        health.set_serving::<wire::participant_server::ParticipantServer<Skin>>().await;
        health.set_serving::<wire::peer_server::PeerServer<Skin>>().await;
        let stopping = host.shutdown.clone();
        let mut server =
            channel::server(&options.security, options.lease).map_err(|e| transport_error(&e))?;
        let participant = InterceptedService::new(participant, options.security.gate());
        let serving = server
            .add_service(InterceptedService::new(health_service, options.security.open_gate()))
            .add_service(InterceptedService::new(reflection, options.security.open_gate()))
            .add_service(participant)
            .add_service(peer)
            .add_service(RefuseVersion1)
            .serve_with_incoming_shutdown(self.incoming, stopping.cancelled());
        tokio::pin!(serving, shutdown);
        tokio::select! {
            result = &mut serving => return result.map_err(|e| transport_error(&e)),
            () = &mut shutdown => host.shutdown.cancel(),
        }
        // A client that keeps its stream open must not hold the server.
        match tokio::time::timeout(options.shutdown_limit, serving).await {
            Ok(result) => result.map_err(|e| transport_error(&e)),
            Err(_) => Ok(()),
        }
    }
}
