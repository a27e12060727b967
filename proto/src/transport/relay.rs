//! A Peer server between the two solvers of a run: the fluid dials it in the solid's place, and it dials the solid.
//!
//! It passes frames on as they are, so that neither side can tell, unless its tap changes them. A recording takes a copy of
//! each before it passes it on: the recording has all that a side has received.

use std::net::SocketAddr;
use std::pin::Pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use sph::coupling::solver::Role;
use tokio::runtime::Runtime;
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;
use tokio_stream::{Stream, StreamExt};
use tokio_util::sync::CancellationToken;
use tonic::{Request, Response, Status, Streaming};

use crate::error::with_causes;
use crate::limits::MAX_FRAME_BYTES;
use crate::recording::{Record, RecordingWriter};
use crate::service::ServeOptions;
use crate::transport::channel;
use crate::transport::connection::{Caller, Incoming};
use crate::transport::security::ServerSecurity;
use crate::transport::token::TOKEN_KEY;
use crate::wire;
use crate::wire::peer_client::PeerClient;
use crate::wire::peer_server::{Peer, PeerServer};

/// Wait for the solid.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(10);
/// Frames that may wait in either direction.
const PENDING_FRAMES: usize = 4;

/// Which way a frame goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Direction {
    ToFluid,
    ToSolid,
}

/// What becomes of a frame.
pub(crate) enum Pass {
    /// These are passed on in its place.
    On(Vec<wire::Frame>),
    /// Both streams are cut without a farewell.
    Cut,
}

/// Sees every frame.
pub(crate) type Tap = Box<dyn FnMut(Direction, wire::Frame) -> Pass + Send>;

/// What a relay does with the frames that it passes.
#[derive(Clone)]
enum Watch {
    /// Nothing.
    None,
    /// Shows them to a tap.
    Tap(Arc<Mutex<Tap>>),
    /// Sends a copy to a recording.
    Record(mpsc::Sender<Record>),
}

impl Watch {
    /// Takes a frame and says what becomes of it.
    async fn pass(&self, direction: Direction, frame: wire::Frame) -> Pass {
        match self {
            Watch::None => Pass::On(vec![frame]),
            Watch::Tap(tap) => {
                let mut tap = tap.lock().unwrap_or_else(PoisonError::into_inner);
                (*tap)(direction, frame)
            }
            Watch::Record(records) => {
                let from = match direction {
                    Direction::ToFluid => Role::Solid,
                    Direction::ToSolid => Role::Fluid,
                };
                // A recording that has failed takes no more; the run continues, and its end reports it.
                drop(records.send(Record::Frame(from, Box::new(frame.clone()))).await);
                Pass::On(vec![frame])
            }
        }
    }
}

/// A relay that serves; dropping it ends it.
#[derive(Debug)]
pub(crate) struct Relay {
    pub(crate) address: SocketAddr,
    stop: CancellationToken,
}

/// A relay for a run, on a thread of its own: nothing that the coordinator does holds frames up.
#[derive(Debug)]
pub struct FrameRelay {
    relay: Relay,
    tls: bool,
    runtime: Option<Runtime>,
}

pub(crate) struct RelayService {
    solid: String,
    security: ServerSecurity,
    watch: Watch,
    cut: CancellationToken,
}

impl Relay {
    /// Listens on a port of this machine for the fluid of a run whose solid is at `solid`, which it calls by `security`;
    /// `tap` sees all frames.
    pub(crate) fn start(solid: &str, security: ServerSecurity, tap: Tap) -> Result<Self, String> {
        let listen = SocketAddr::from(([127, 0, 0, 1], 0));
        Self::serve(listen, solid, security, Watch::Tap(Arc::new(Mutex::new(tap))))
    }

    fn serve(
        listen: SocketAddr,
        solid: &str,
        security: ServerSecurity,
        watch: Watch,
    ) -> Result<Self, String> {
        let cannot = |e: &dyn std::fmt::Display| format!("a relay cannot listen at {listen}: {e}");
        let incoming = Incoming::bind(listen).map_err(|e| cannot(&e))?;
        let address = incoming.local_addr().map_err(|e| cannot(&e))?;
        let stop = CancellationToken::new();
        let mut server = channel::server(&security, ServeOptions::default().lease)
            .map_err(|e| cannot(&with_causes(&e)))?;
        let service = RelayService { solid: solid.to_owned(), security, watch, cut: stop.child_token() };
        let peer = PeerServer::new(service).max_decoding_message_size(MAX_FRAME_BYTES);
        let stopped = stop.clone();
        tokio::spawn(async move {
            let serving = server.add_service(peer).serve_with_incoming(incoming);
            tokio::select! {
                () = stopped.cancelled() => {}
                // The fluid sees a relay that fails as a lost partner.
                _ = serving => {}
            }
        });
        Ok(Self { address, stop })
    }
}

impl FrameRelay {
    /// Listens at `listen` for the fluid of a run whose solid is at `solid`, "host:port" or "https://host:port", and copies
    /// frames to `recording`. Port 0 takes any free one. `security` is for both ends. The solid still refuses whoever does
    /// not know the run's token.
    ///
    /// # Errors
    /// When the address cannot be had, or a thread.
    pub fn start(
        listen: SocketAddr,
        solid: &str,
        security: ServerSecurity,
        recording: Option<&RecordingWriter>,
    ) -> Result<Self, String> {
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(1)
            .thread_name("relay")
            .enable_all()
            .build()
            .map_err(|e| format!("no thread for a relay: {e}"))?;
        let watch = recording.map_or(Watch::None, |recording| Watch::Record(recording.queue()));
        let tls = security.has_tls();
        let relay = {
            let _entered = runtime.enter();
            Relay::serve(listen, solid, security, watch)?
        };
        Ok(Self { relay, tls, runtime: Some(runtime) })
    }

    /// Where it listens, as the fluid calls it.
    pub fn address(&self) -> String {
        let scheme = if self.tls { "https://" } else { "" };
        format!("{scheme}{}", self.relay.address)
    }
}

impl Drop for FrameRelay {
    fn drop(&mut self) {
        self.relay.stop.cancel();
        if let Some(runtime) = self.runtime.take() {
            runtime.shutdown_background();
        }
    }
}

impl Drop for Relay {
    fn drop(&mut self) {
        self.stop.cancel();
    }
}

impl RelayService {
    /// What stands before the solid at `solid`, "host:port"; `tap` sees all frames.
    pub(crate) fn tapped(solid: &str, tap: Tap) -> Self {
        let watch = Watch::Tap(Arc::new(Mutex::new(tap)));
        Self {
            solid: solid.to_owned(),
            security: ServerSecurity::default(),
            watch,
            cut: CancellationToken::new(),
        }
    }

    /// Passes `frames` on until they end.
    async fn forward(
        watch: Watch,
        cut: CancellationToken,
        direction: Direction,
        mut frames: Streaming<wire::Frame>,
        onward: mpsc::Sender<Result<wire::Frame, Status>>,
    ) {
        loop {
            let frame = tokio::select! {
                // Nothing passes a cut, however much is waiting.
                biased;
                () = cut.cancelled() => {
                    drop(onward.send(Err(Status::unavailable("the relay was cut"))).await);
                    return;
                }
                frame = frames.message() => frame,
            };
            let frame = match frame {
                Ok(Some(frame)) => frame,
                Ok(None) => return,
                Err(status) => {
                    // Why it broke off, where the other side can receive it.
                    drop(onward.send(Err(status)).await);
                    return;
                }
            };
            match watch.pass(direction, frame).await {
                Pass::On(frames) => {
                    for frame in frames {
                        if onward.send(Ok(frame)).await.is_err() {
                            return;
                        }
                    }
                }
                Pass::Cut => cut.cancel(),
            }
        }
    }
}

#[tonic::async_trait]
impl Peer for RelayService {
    type ExchangeStream = Pin<Box<dyn Stream<Item = Result<wire::Frame, Status>> + Send>>;

    async fn exchange(
        &self,
        request: Request<Streaming<wire::Frame>>,
    ) -> Result<Response<Self::ExchangeStream>, Status> {
        let caller = Caller::of(request.extensions()).cloned();
        if let Some(caller) = &caller {
            caller.called();
        }
        let channel = channel::connect_secured(&self.solid, CONNECT_TIMEOUT, self.security.partner());
        let channel = channel.await.map_err(Status::unavailable)?;
        let (metadata, _, from_fluid) = request.into_parts();
        let (to_solid, frames) = mpsc::channel(PENDING_FRAMES);
        // An error at the solid's end of a request stream can only cut it.
        let frames = ReceiverStream::new(frames).take_while(Result::is_ok).filter_map(Result::ok);
        let mut call = Request::new(frames);
        if let Some(token) = metadata.get(TOKEN_KEY) {
            call.metadata_mut().insert(TOKEN_KEY, token.clone());
        }
        let mut client = PeerClient::new(channel).max_decoding_message_size(MAX_FRAME_BYTES);
        let from_solid = client.exchange(call).await?.into_inner();
        // The solid knows the caller by the run's token.
        if let Some(caller) = caller {
            caller.admitted();
        }
        let (to_fluid, answers) = mpsc::channel(PENDING_FRAMES);
        let (watch, cut) = (self.watch.clone(), self.cut.clone());
        tokio::spawn(Self::forward(watch.clone(), cut.clone(), Direction::ToSolid, from_fluid, to_solid));
        tokio::spawn(Self::forward(watch, cut, Direction::ToFluid, from_solid, to_fluid));
        Ok(Response::new(Box::pin(ReceiverStream::new(answers))))
    }
}
