//! Plays one side of a run from a recording, so that the other can be run alone, and compares what that one sends.

use std::net::SocketAddr;
use std::pin::Pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use sph::coupling::solver::Role;
use tokio::runtime::Runtime;
use tokio::sync::{mpsc, watch};
use tokio_stream::Stream;
use tokio_stream::wrappers::ReceiverStream;
use tokio_util::sync::CancellationToken;
use tonic::{Request, Response, Status, Streaming};

use crate::limits::MAX_FRAME_BYTES;
use crate::recording::{Difference, Ids, Moment, Recording, RecordingError, difference};
use crate::service::ServeOptions;
use crate::transport::channel;
use crate::transport::client::RunAccess;
use crate::transport::connection::{Caller, Incoming};
use crate::transport::security::{ClientSecurity, ServerSecurity};
use crate::transport::token::Token;
use crate::wire;
use crate::wire::peer_client::PeerClient;
use crate::wire::peer_server::{Peer, PeerServer};

/// Wait for a solid that is examined.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(10);
/// Frames that may wait for the transport.
const PENDING_FRAMES: usize = 4;

/// What came of a replay so far.
#[derive(Clone, Debug, Default)]
pub struct Replayed {
    /// Frames that came and equal those of the recording to the last bit.
    pub equal_frames: u64,
    /// The first difference; the recording's value comes first.
    pub difference: Option<Difference>,
    /// Why frames could not be played or compared to the end.
    pub problem: Option<String>,
}

/// Plays one side; dropping it ends it.
#[derive(Debug)]
pub struct Player {
    address: Option<SocketAddr>,
    shared: Arc<Shared>,
    stop: CancellationToken,
    runtime: Option<Runtime>,
}

#[derive(Debug)]
struct Shared {
    /// Side under examination; the player is its partner.
    examined: Role,
    token: Token,
    recording: Mutex<Recording>,
    replayed: Mutex<Replayed>,
    /// Frames of the examined side that were compared.
    compared: watch::Sender<usize>,
}

impl Player {
    /// A player of the partner of `examined` in the run that `access` may speak for. It plays the first attempt of
    /// `recording`, which must begin with the run and be the only one.
    ///
    /// A solid that is examined is called by [`Player::dial`] when it has been linked; a fluid calls
    /// [`Player::address`].
    ///
    /// # Errors
    /// When the recording begins later or holds several attempts, or no port or thread is to be had.
    pub fn start(recording: Recording, examined: Role, access: &RunAccess) -> Result<Self, String> {
        let path = recording.path().display().to_string();
        if let [_, _, ..] = recording.attempts() {
            return Err(format!(
                "`{path}` is of a run whose servers were started again; replay needs one that went through"
            ));
        }
        if let Some(attempt) = recording.attempts().iter().find(|attempt| attempt.first_step > 0) {
            return Err(format!(
                "`{path}` begins at step {}; replay needs a recording from the start of a run",
                attempt.first_step
            ));
        }
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(1)
            .thread_name("player")
            .enable_all()
            .build()
            .map_err(|e| format!("no thread for a replay: {e}"))?;
        let shared = Arc::new(Shared {
            examined,
            token: access.token.clone(),
            recording: Mutex::new(recording),
            replayed: Mutex::default(),
            compared: watch::Sender::default(),
        });
        let mut player =
            Self { address: None, shared, stop: CancellationToken::new(), runtime: Some(runtime) };
        if examined == Role::Fluid {
            player.listen()?;
        }
        Ok(player)
    }

    /// Where it waits for a fluid.
    pub fn address(&self) -> Option<SocketAddr> {
        self.address
    }

    /// What came of the replay so far.
    pub fn replayed(&self) -> Replayed {
        self.shared.replayed().clone()
    }

    fn listen(&mut self) -> Result<(), String> {
        let Some(runtime) = &self.runtime else { return Ok(()) };
        let _entered = runtime.enter();
        let cannot = |e: &dyn std::fmt::Display| format!("a replay cannot listen: {e}");
        let here = SocketAddr::from(([127, 0, 0, 1], 0));
        let incoming = Incoming::bind(here).map_err(|e| cannot(&e))?;
        self.address = Some(incoming.local_addr().map_err(|e| cannot(&e))?);
        let mut server = channel::server(&ServerSecurity::default(), ServeOptions::default().lease)
            .map_err(|e| cannot(&e))?;
        let service = PlayerService(self.shared.clone());
        let peer = PeerServer::new(service).max_decoding_message_size(MAX_FRAME_BYTES);
        let stopped = self.stop.clone();
        runtime.spawn(async move {
            let serving = server.add_service(peer).serve_with_incoming(incoming);
            tokio::select! {
                () = stopped.cancelled() => {}
                // The fluid sees a player that fails as a lost partner.
                _ = serving => {}
            }
        });
        Ok(())
    }

    /// Calls the solid at `address`, which has been linked, by `security`.
    ///
    /// # Errors
    /// When it cannot be reached.
    pub async fn dial(&self, address: &str, security: &ClientSecurity) -> Result<(), String> {
        let Some(runtime) = &self.runtime else { return Ok(()) };
        let (shared, address, security) = (self.shared.clone(), address.to_owned(), security.clone());
        let (connected, connection) = tokio::sync::oneshot::channel();
        runtime.spawn(async move {
            let channel = match channel::connect_secured(&address, CONNECT_TIMEOUT, &security).await {
                Ok(channel) => channel,
                Err(problem) => return drop(connected.send(Err(format!("{address} {problem}")))),
            };
            drop(connected.send(Ok(())));
            let (frames, outbound) = mpsc::channel(PENDING_FRAMES);
            let feeding = shared.clone();
            tokio::spawn(async move {
                feeding.feed(|frame| async { frames.send(frame).await.is_ok() }).await;
            });
            let mut client = PeerClient::new(channel).max_decoding_message_size(MAX_FRAME_BYTES);
            match client.exchange(shared.token.attach(ReceiverStream::new(outbound))).await {
                Ok(answer) => shared.watch(answer.into_inner()).await,
                Err(status) => shared.fail(status.to_string()),
            }
        });
        connection.await.unwrap_or_else(|_| Err("the replay ended before it began".into()))
    }
}

impl Drop for Player {
    fn drop(&mut self) {
        self.stop.cancel();
        if let Some(runtime) = self.runtime.take() {
            runtime.shutdown_background();
        }
    }
}

impl Shared {
    fn replayed(&self) -> std::sync::MutexGuard<'_, Replayed> {
        self.replayed.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn fail(&self, problem: String) {
        self.replayed().problem.get_or_insert(problem);
    }

    fn recorded(&self, at: Moment, role: Role) -> Result<Option<wire::Frame>, RecordingError> {
        self.recording.lock().unwrap_or_else(PoisonError::into_inner).frame(at, role)
    }

    /// Sends all frames of the player's side, then a farewell; `send` says whether anybody takes them.
    ///
    /// A frame waits until all frames of the examined side of earlier moments have been compared: it tells that side what
    /// its partner computed from, and a side that finds itself contradicted ends the run.
    async fn feed<F: Future<Output = bool>>(&self, send: impl Fn(wire::Frame) -> F) {
        let side = self.examined.partner();
        let (moments, examined, of) = {
            let recording = self.recording.lock().unwrap_or_else(PoisonError::into_inner);
            let of = recording.attempts().first().cloned();
            (recording.moments(side), recording.moments(self.examined), of)
        };
        let mut compared = self.compared.subscribe();
        for at in moments {
            let before = examined.partition_point(|moment| *moment < at);
            // The sender is this player's own.
            let _ = compared.wait_for(|compared| *compared >= before).await;
            match self.recorded(at, side) {
                Ok(Some(frame)) => {
                    if !send(frame).await {
                        return;
                    }
                }
                Ok(None) => {}
                Err(error) => return self.fail(error.to_string()),
            }
        }
        let Some(of) = of else { return };
        let farewell = wire::Frame {
            run_id: of.run_id,
            epoch: of.epoch,
            farewell: Some(wire::Farewell { reason: "the recording ends here".into() }),
            ..wire::Frame::default()
        };
        send(farewell).await;
    }

    /// Compares all frames of the examined side with those of the recording.
    async fn watch(&self, mut frames: Streaming<wire::Frame>) {
        self.compare(&mut frames).await;
        // Nothing is left to wait for.
        self.compared.send_replace(usize::MAX);
        // A stream that is dropped here ends the call, and the farewell would not arrive.
        while let Ok(Some(_)) = frames.message().await {}
    }

    async fn compare(&self, frames: &mut Streaming<wire::Frame>) {
        let mut ids = Ids::default();
        while let Ok(Some(frame)) = frames.message().await {
            if frame.farewell.is_some() {
                // The other half of the stream ends by itself.
                continue;
            }
            let Ok(at) = Moment::of(&frame) else {
                return self.fail(format!("a frame of step {} has no stage", frame.step));
            };
            let recorded = match self.recorded(at, self.examined) {
                Ok(Some(recorded)) => recorded,
                Ok(None) => return self.fail(format!("the recording has no frame of {at} to compare")),
                Err(error) => return self.fail(error.to_string()),
            };
            ids.note(&frame);
            let found = difference(at, self.examined, &recorded, &frame, &ids);
            let mut replayed = self.replayed();
            match found {
                Some(found) => {
                    // What follows are consequences.
                    replayed.difference.get_or_insert(found);
                }
                None if replayed.difference.is_none() => replayed.equal_frames += 1,
                None => {}
            }
            drop(replayed);
            self.compared.send_modify(|compared| *compared += 1);
        }
    }
}

struct PlayerService(Arc<Shared>);

#[tonic::async_trait]
impl Peer for PlayerService {
    type ExchangeStream = Pin<Box<dyn Stream<Item = Result<wire::Frame, Status>> + Send>>;

    async fn exchange(
        &self,
        request: Request<Streaming<wire::Frame>>,
    ) -> Result<Response<Self::ExchangeStream>, Status> {
        if !self.0.token.admits(request.metadata()) {
            return Err(Status::permission_denied("not allowed"));
        }
        if let Some(caller) = Caller::of(request.extensions()) {
            caller.admitted();
        }
        let (frames, outbound) = mpsc::channel(PENDING_FRAMES);
        let (feeding, watching) = (self.0.clone(), self.0.clone());
        tokio::spawn(async move {
            feeding.feed(|frame| async { frames.send(Ok(frame)).await.is_ok() }).await;
        });
        tokio::spawn(async move { watching.watch(request.into_inner()).await });
        Ok(Response::new(Box::pin(ReceiverStream::new(outbound))))
    }
}
