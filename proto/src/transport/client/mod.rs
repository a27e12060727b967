//! A server as the coordinator sees it.

mod checkpoint;
mod streams;

use std::time::Duration;

use sph::setup::ParticipantSetup;
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;
use tonic::service::interceptor::InterceptedService;
use tonic::transport::Channel;

use crate::convert::{Convert, Path, WireError, encode_setup, link_to_wire};
use crate::description::{Description, LinkPlan, OpenReport, PROTOCOL};
use crate::error::{RpcCode, RpcError};
use crate::limits::MAX_MESSAGE_BYTES;
use crate::transport::channel;
use crate::transport::security::{ClientSecurity, ShowAccess};
use crate::transport::token::Token;
use crate::transport::version1;
use crate::wire;
use crate::wire::participant_client::ParticipantClient as WireClient;

pub use streams::{CommandSender, EventReceiver};

/// Commands that may wait for the transport.
const PENDING_COMMANDS: usize = 16;

/// Longest waits for a server's answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Deadlines {
    /// To accept a connection.
    pub connect: Duration,
    /// To describe itself, which takes no work: whoever stays silent is no solver.
    pub describe: Duration,
    /// To link, close.
    pub call: Duration,
    /// To build its solver.
    pub open: Duration,
    /// Between two signs of life during a run; servers give one each second.
    pub silence: Duration,
}

impl Default for Deadlines {
    fn default() -> Self {
        Self {
            connect: Duration::from_secs(10),
            describe: Duration::from_secs(10),
            call: Duration::from_secs(30),
            open: Duration::from_secs(300),
            silence: Duration::from_secs(20),
        }
    }
}

/// Secret of a run and the name of who holds it; both servers of a run get the same.
#[derive(Clone, Debug)]
pub struct RunAccess {
    pub(crate) token: Token,
    holder: String,
}

impl RunAccess {
    /// A fresh secret; `holder` is the name that a second coordinator sees, such as program, host and process.
    ///
    /// # Errors
    /// When the system has no random numbers.
    pub fn new(holder: &str) -> Result<Self, RpcError> {
        let token =
            Token::fresh().map_err(|e| RpcError::new(RpcCode::Internal, "Open", "this machine", e))?;
        Ok(Self { token, holder: holder.chars().take(60).collect() })
    }
}

/// A connection to one server.
///
/// ```no_run
/// # async fn example(setup: sph::setup::ParticipantSetup, link: proto::description::LinkPlan) -> Result<(), proto::RpcError> {
/// use proto::transport::client::{Deadlines, ParticipantClient, RunAccess};
/// let access = RunAccess::new("coordinator 17")?;
/// let mut fluid = ParticipantClient::connect("127.0.0.1:4000", Deadlines::default()).await?;
/// let report = fluid.open(&setup, &access).await?;
/// fluid.link(&link).await?;
/// let (commands, mut events) = fluid.run().await?;
/// commands.send(sph::coupling::driver::Command::GrantThrough(100))?;
/// while let Some(event) = events.recv().await {
///     println!("{:?}", event?);
/// }
/// fluid.close().await
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct ParticipantClient {
    inner: WireClient<InterceptedService<Channel, ShowAccess>>,
    /// The connection below, for calls of another protocol version.
    service: InterceptedService<Channel, ShowAccess>,
    address: String,
    deadlines: Deadlines,
    run: Option<(String, Token)>,
    /// Number of dimensions of the run.
    dimensions: usize,
    /// Counts the restores of the run.
    epoch: u32,
}

impl ParticipantClient {
    /// Connects to the server at `address`, "host:port".
    ///
    /// # Errors
    /// When nothing accepts the connection in time.
    pub async fn connect(address: &str, deadlines: Deadlines) -> Result<Self, RpcError> {
        Self::connect_secured(address, deadlines, &ClientSecurity::default()).await
    }

    /// Connects to the server at `address`, "host:port", or by TLS at "https://host:port", and shows it what
    /// `security` holds.
    ///
    /// # Errors
    /// When nothing accepts the connection in time, or either side does not trust the other.
    pub async fn connect_secured(
        address: &str,
        deadlines: Deadlines,
        security: &ClientSecurity,
    ) -> Result<Self, RpcError> {
        let channel = channel::connect_secured(address, deadlines.connect, security)
            .await
            .map_err(|problem| RpcError::new(RpcCode::Unavailable, "connect", address, problem))?;
        let service = InterceptedService::new(channel, security.shower());
        let inner = WireClient::new(service.clone()).max_decoding_message_size(MAX_MESSAGE_BYTES);
        Ok(Self {
            inner,
            service,
            address: address.to_owned(),
            deadlines,
            run: None,
            dimensions: 2,
            epoch: 0,
        })
    }

    /// Address of the server.
    pub fn address(&self) -> &str {
        &self.address
    }

    /// What the server is and can do.
    ///
    /// # Errors
    /// When it does not answer, or is no solver of this protocol.
    pub async fn describe(&mut self) -> Result<Description, RpcError> {
        let deadline = self.deadlines.describe;
        let answer = self.inner.describe(wire::DescribeRequest {});
        let reply = match within(deadline, "Describe", &self.address, answer).await {
            Ok(reply) => reply,
            Err(mut error) => {
                // A refused certificate shows with the first call only: by words, or by the end of the connection.
                let by_tls = self.address.starts_with("https://") && error.code == RpcCode::Unavailable;
                if error.code == RpcCode::Unsupported && self.speaks_version_1().await {
                    error.message = format!(
                        "speaks protocol 1, this program needs {}: update the solver",
                        PROTOCOL.major
                    );
                } else if error.code != RpcCode::PermissionDenied && !by_tls {
                    error.message.push_str("; what listens there seems to be no solver of protocol fsi.v2");
                }
                return Err(error);
            }
        };
        self.accept("Describe", Description::from_wire(&reply, &Path::root("description")))
    }

    async fn speaks_version_1(&self) -> bool {
        let question = version1::is_spoken_by(self.service.clone());
        tokio::time::timeout(self.deadlines.describe, question).await.unwrap_or(false)
    }

    /// Opens a run; returns what the solver will actually do; `link`, `run` and `close` are for this run.
    ///
    /// # Errors
    /// When another run is held, or with all problems of the set-up.
    pub async fn open(
        &mut self,
        setup: &ParticipantSetup,
        access: &RunAccess,
    ) -> Result<OpenReport, RpcError> {
        let run_id = setup.run_id().to_owned();
        let request = wire::OpenRequest {
            protocol: Some(PROTOCOL.to_wire()),
            token: access.token.text().to_owned(),
            holder: access.holder.clone(),
            setup: Some(encode_setup(setup)),
        };
        let reply = within(self.deadlines.open, "Open", &self.address, self.inner.open(request)).await?;
        self.run = Some((run_id.clone(), access.token.clone()));
        (self.dimensions, self.epoch) = (setup.dimensions(), 0);
        let report = self.accept("Open", OpenReport::from_wire(&reply, &Path::root("reply")))?;
        if report.run_id != run_id {
            let message = format!("the reply is for run {:?}, expected {run_id:?}", report.run_id);
            return Err(self.error(RpcCode::Malformed, "Open", message));
        }
        let dimensions = report.constants.domain.lower.len();
        if dimensions != self.dimensions {
            let message =
                format!("the reply is of a run of {dimensions} dimensions, expected are {}", self.dimensions);
            return Err(self.error(RpcCode::Malformed, "Open", message));
        }
        Ok(report)
    }

    /// Tells the solver of its partner. Link the listening side first: the dialling side calls it at once.
    ///
    /// # Errors
    /// When the partner cannot be reached or refuses.
    pub async fn link(&mut self, plan: &LinkPlan) -> Result<(), RpcError> {
        let (run_id, token) = self.opened("Link")?;
        let request = token.attach(wire::LinkRequest { run_id, ..link_to_wire(plan) });
        within(self.deadlines.call, "Link", &self.address, self.inner.link(request)).await.map(drop)
    }

    /// Starts the run: commands go in, events come out until the last one, `Finished` or `Failed`.
    ///
    /// The solver steps only as far as it is granted.
    ///
    /// # Errors
    /// When the run is not linked.
    pub async fn run(&mut self) -> Result<(CommandSender, EventReceiver), RpcError> {
        let (run_id, token) = self.opened("Run")?;
        let deadline = self.deadlines.call;
        // Opened first, so that no snapshot is taken before anybody listens.
        let request = token.attach(wire::SnapshotsRequest { run_id: run_id.clone() });
        let snapshots = within(deadline, "Snapshots", &self.address, self.inner.snapshots(request)).await?;
        let (to_server, wire_commands) = mpsc::channel(PENDING_COMMANDS);
        let request = token.attach(ReceiverStream::new(wire_commands));
        let batches = within(deadline, "Run", &self.address, self.inner.run(request)).await?;
        let run = streams::Run {
            run_id,
            epoch: self.epoch,
            address: self.address.clone(),
            silence: self.deadlines.silence,
        };
        Ok(run.start(to_server, batches, snapshots))
    }

    /// Ends the run, whatever its state, and frees the server; does nothing when there is none.
    ///
    /// # Errors
    /// When the server does not answer.
    pub async fn close(&mut self) -> Result<(), RpcError> {
        let Some((run_id, token)) = self.run.take() else { return Ok(()) };
        let request = token.attach(wire::CloseRequest { run_id });
        within(self.deadlines.call, "Close", &self.address, self.inner.close(request)).await.map(drop)
    }

    fn opened(&self, call: &'static str) -> Result<(String, Token), RpcError> {
        self.run.clone().ok_or_else(|| {
            self.error(RpcCode::FailedPrecondition, call, "no run was opened on this connection")
        })
    }

    fn accept<T>(&self, call: &'static str, reply: Result<T, WireError>) -> Result<T, RpcError> {
        reply.map_err(|e| self.error(RpcCode::Malformed, call, e.to_string()))
    }

    fn error(&self, code: RpcCode, call: &'static str, message: impl Into<String>) -> RpcError {
        RpcError::new(code, call, &self.address, message)
    }
}

/// The answer of a call, bounded in time.
async fn within<T>(
    deadline: Duration,
    call: &'static str,
    address: &str,
    answer: impl Future<Output = Result<tonic::Response<T>, tonic::Status>>,
) -> Result<T, RpcError> {
    match tokio::time::timeout(deadline, answer).await {
        Ok(Ok(reply)) => Ok(reply.into_inner()),
        Ok(Err(status)) => Err(RpcError::from_status(call, address, &status)),
        Err(_) => {
            let message = format!("no answer within {} s", deadline.as_secs_f64());
            Err(RpcError::new(RpcCode::DeadlineExceeded, call, address, message))
        }
    }
}
