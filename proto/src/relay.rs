//! A Peer server between the two solvers of a run: the fluid dials it in the solid's place, and it dials the solid.
//!
//! It passes frames on as they are, so that neither side can tell, unless its tap changes them.

use std::net::SocketAddr;
use std::pin::Pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;
use tokio_stream::{Stream, StreamExt};
use tokio_util::sync::CancellationToken;
use tonic::transport::server::TcpIncoming;
use tonic::{Request, Response, Status, Streaming};

use crate::limits::MAX_FRAME_BYTES;
use crate::transport;
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
    /// These go on in its place.
    On(Vec<wire::Frame>),
    /// Both streams are cut without a farewell.
    Cut,
}

/// Sees every frame.
pub(crate) type Tap = Box<dyn FnMut(Direction, wire::Frame) -> Pass + Send>;

/// A relay that serves; dropping it ends it.
pub(crate) struct Relay {
    pub(crate) address: SocketAddr,
    stop: CancellationToken,
}

struct RelayService {
    solid: String,
    tap: Arc<Mutex<Tap>>,
    cut: CancellationToken,
}

impl Relay {
    /// Listens on a port of this machine for the fluid of a run whose solid is at `solid`.
    pub(crate) fn start(solid: &str, tap: Tap) -> Result<Self, String> {
        let listener = TcpIncoming::bind(SocketAddr::from(([127, 0, 0, 1], 0)));
        let incoming = listener.map_err(|e| format!("a relay cannot listen: {e}"))?.with_nodelay(Some(true));
        let address = incoming.local_addr().map_err(|e| format!("a relay cannot listen: {e}"))?;
        let stop = CancellationToken::new();
        let service =
            RelayService { solid: solid.to_owned(), tap: Arc::new(Mutex::new(tap)), cut: stop.child_token() };
        let peer = PeerServer::new(service).max_decoding_message_size(MAX_FRAME_BYTES);
        let stopped = stop.clone();
        tokio::spawn(async move {
            let serving = transport::server().add_service(peer).serve_with_incoming(incoming);
            tokio::select! {
                () = stopped.cancelled() => {}
                // The fluid sees a relay that fails as a lost partner.
                _ = serving => {}
            }
        });
        Ok(Self { address, stop })
    }
}

impl Drop for Relay {
    fn drop(&mut self) {
        self.stop.cancel();
    }
}

impl RelayService {
    /// Passes `frames` through the tap until they end.
    async fn forward(
        tap: Arc<Mutex<Tap>>,
        cut: CancellationToken,
        direction: Direction,
        mut frames: Streaming<wire::Frame>,
        onward: mpsc::Sender<Result<wire::Frame, Status>>,
    ) {
        loop {
            let frame = tokio::select! {
                () = cut.cancelled() => {
                    drop(onward.send(Err(Status::unavailable("the relay was cut"))).await);
                    return;
                }
                frame = frames.message() => frame,
            };
            let Ok(Some(frame)) = frame else { return };
            let pass = {
                let mut tap = tap.lock().unwrap_or_else(PoisonError::into_inner);
                (*tap)(direction, frame)
            };
            match pass {
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
        let channel = transport::connect(&self.solid, CONNECT_TIMEOUT).await.map_err(Status::unavailable)?;
        let (metadata, _, from_fluid) = request.into_parts();
        let (to_solid, frames) = mpsc::channel(PENDING_FRAMES);
        // An error at the solid's end of a request stream can only cut it.
        let frames = ReceiverStream::new(frames).take_while(Result::is_ok).filter_map(Result::ok);
        let mut call = Request::new(frames);
        if let Some(token) = metadata.get(transport::TOKEN_KEY) {
            call.metadata_mut().insert(transport::TOKEN_KEY, token.clone());
        }
        let mut client = PeerClient::new(channel).max_decoding_message_size(MAX_FRAME_BYTES);
        let from_solid = client.exchange(call).await?.into_inner();
        let (to_fluid, answers) = mpsc::channel(PENDING_FRAMES);
        let (tap, cut) = (self.tap.clone(), self.cut.clone());
        tokio::spawn(Self::forward(tap.clone(), cut.clone(), Direction::ToSolid, from_fluid, to_solid));
        tokio::spawn(Self::forward(tap, cut, Direction::ToFluid, from_solid, to_fluid));
        Ok(Response::new(Box::pin(ReceiverStream::new(answers))))
    }
}
