//! A solid server's address at which something is wrong: all calls are passed on to the server, and frames are damaged on the way.
//!
//! For tests of whole runs: neither the servers nor the coordinator know of it.

use std::convert::Infallible;
use std::net::SocketAddr;
use std::task::{Context, Poll};
use std::time::Duration;

use sph::coupling::stage::StepStage;
use tokio_util::sync::{CancellationToken, DropGuard};
use tonic::Status;
use tonic::body::Body;
use tonic::codegen::{BoxFuture, Service, http};
use tonic::server::NamedService;
use tonic::transport::Channel;
use tonic::transport::server::TcpIncoming;

use crate::convert::Choice;
use crate::error::with_causes;
use crate::limits::MAX_FRAME_BYTES;
use crate::service::ServeOptions;
use crate::transport::channel;
use crate::transport::relay::{Direction, Pass, RelayService};
use crate::transport::security::{ClientSecurity, ServerSecurity};
use crate::wire;
use crate::wire::peer_server::PeerServer;

/// Wait for the server.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(10);

/// What a [`Proxy`] does to one frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Damage {
    /// The stream is cut instead.
    Cut,
    /// It is withheld, and all after it.
    Withhold,
    /// It comes this much later.
    Delay(Duration),
    /// The last number of its first array is missing.
    Truncate,
    /// It comes twice.
    Duplicate,
    /// The one before it comes after it once more.
    Reorder,
}

/// A proxy that serves; dropping it ends it.
#[derive(Debug)]
pub struct Proxy {
    /// Where it listens, on this machine.
    pub address: SocketAddr,
    _stop: DropGuard,
}

impl Proxy {
    /// Stands before the solid server at `solid`, "host:port", and damages the frame of `at` that goes to the fluid or, with
    /// `to_solid`, to the solid. Must be called within a runtime.
    ///
    /// # Errors
    /// When the server cannot be reached, or no port is to be had.
    pub async fn start(solid: &str, at: StepStage, to_solid: bool, damage: Damage) -> Result<Self, String> {
        let channel = channel::connect_secured(solid, CONNECT_TIMEOUT, &ClientSecurity::default()).await?;
        let cannot = |e: &dyn std::fmt::Display| format!("a proxy cannot listen: {e}");
        let here = SocketAddr::from(([127, 0, 0, 1], 0));
        let incoming = TcpIncoming::bind(here).map_err(|e| cannot(&e))?.with_nodelay(Some(true));
        let address = incoming.local_addr().map_err(|e| cannot(&e))?;
        let mut server = channel::server(&ServerSecurity::default(), ServeOptions::default().lease)
            .map_err(|e| cannot(&e))?;
        let direction = if to_solid { Direction::ToSolid } else { Direction::ToFluid };
        let relay = RelayService::tapped(solid, Box::new(tap(at, direction, damage)));
        let peer = PeerServer::new(relay).max_decoding_message_size(MAX_FRAME_BYTES);
        let stop = CancellationToken::new();
        let stopped = stop.clone();
        tokio::spawn(async move {
            let serving = server.add_service(Onward(channel)).add_service(peer).serve_with_incoming(incoming);
            tokio::select! {
                () = stopped.cancelled() => {}
                // Whoever calls sees a proxy that fails as a lost server.
                _ = serving => {}
            }
        });
        Ok(Self { address, _stop: stop.drop_guard() })
    }
}

/// Damages the first frame of `at` that goes in `direction`; a run that starts again meets no damage.
fn tap(
    at: StepStage,
    direction: Direction,
    damage: Damage,
) -> impl FnMut(Direction, wire::Frame) -> Pass + Send {
    let (mut last, mut withheld, mut done): (Option<wire::Frame>, bool, bool) = (None, false, false);
    move |goes, frame| {
        if goes != direction || withheld {
            return Pass::On(if goes == direction { Vec::new() } else { vec![frame] });
        }
        let before = last.replace(frame.clone());
        let is_at = frame.farewell.is_none() && (frame.step, frame.stage) == (at.step, at.stage.code());
        if !is_at || std::mem::replace(&mut done, true) {
            return Pass::On(vec![frame]);
        }
        match damage {
            Damage::Cut => Pass::Cut,
            Damage::Withhold => {
                withheld = true;
                Pass::On(Vec::new())
            }
            Damage::Delay(duration) => {
                // The test's own runtime has further threads.
                std::thread::sleep(duration);
                Pass::On(vec![frame])
            }
            Damage::Truncate => {
                let mut frame = frame;
                for block in frame.blocks.iter_mut().take(1) {
                    block.data = block.data.slice(..block.data.len().saturating_sub(8));
                }
                Pass::On(vec![frame])
            }
            Damage::Duplicate => Pass::On(vec![frame.clone(), frame]),
            Damage::Reorder => Pass::On([Some(frame), before].into_iter().flatten().collect()),
        }
    }
}

/// The control plane of a server elsewhere, call by call as it comes.
#[derive(Clone)]
struct Onward(Channel);

impl NamedService for Onward {
    const NAME: &'static str = "fsi.v2.Participant";
}

impl Service<http::Request<Body>> for Onward {
    type Response = http::Response<Body>;
    type Error = Infallible;
    type Future = BoxFuture<Self::Response, Infallible>;

    fn poll_ready(&mut self, _: &mut Context<'_>) -> Poll<Result<(), Infallible>> {
        Poll::Ready(Ok(()))
    }

    fn call(&mut self, request: http::Request<Body>) -> Self::Future {
        let mut channel = self.0.clone();
        Box::pin(async move {
            let answer = match std::future::poll_fn(|context| channel.poll_ready(context)).await {
                Ok(()) => channel.call(request).await,
                Err(error) => Err(error),
            };
            Ok(answer.unwrap_or_else(|error| Status::unavailable(with_causes(&error)).into_http()))
        })
    }
}
