//! The exchange over gRPC, as the compute thread sees it.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use sph::coupling::exchange::{Exchange, Frame, PeerError};
use sph::coupling::stage::StepStage;
use tokio::runtime::Handle;
use tokio::sync::{mpsc, oneshot};
use tokio_stream::wrappers::ReceiverStream;
use tokio_util::sync::CancellationToken;
use tonic::transport::Channel;

use crate::convert::{FrameReader, FrameWriter, ReceivedFrame};
use crate::error::describe;
use crate::limits::MAX_FRAME_BYTES;
use crate::transport::channel;
use crate::transport::security::ClientSecurity;
use crate::transport::token::Token;
use crate::wire;

/// Frames that may wait for the transport: lock-step needs two, a farewell one more.
const OUTBOUND_FRAMES: usize = 4;
/// Wait for the partner's first frame to open a connection to it.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(10);
/// Wait for the partner's end after the own one: dropping a stream sooner would cut frames that are still on the way.
const LINGER: Duration = Duration::from_secs(20);
/// The same for a run that was given up: time for the farewell to leave.
const LINGER_CANCELLED: Duration = Duration::from_millis(300);
/// Wait for response headers, so that a refusal is seen in `Link`.
const HEADER_TIMEOUT: Duration = Duration::from_secs(5);

/// The partner's frames, or why there are none.
type Inbound = Result<tonic::Streaming<wire::Frame>, String>;

/// What the transport needs of a peer.
pub(crate) struct PeerSlot {
    /// Takes the partner's stream when it is there.
    pub(crate) inbound: oneshot::Sender<Inbound>,
    /// Own frames, to be sent as they come.
    pub(crate) outbound: mpsc::Receiver<wire::Frame>,
}

/// An [`Exchange`] over one gRPC stream.
pub(crate) struct GrpcPeer {
    runtime: Handle,
    outbound: mpsc::Sender<wire::Frame>,
    arriving: Option<oneshot::Receiver<Inbound>>,
    inbound: Option<tonic::Streaming<wire::Frame>>,
    writer: FrameWriter,
    reader: FrameReader,
    cancel: CancellationToken,
    deadline: Option<Duration>,
    monitor: Arc<PeerMonitor>,
}

/// What others can see and say of a peer that its compute thread owns.
#[derive(Debug, Default)]
pub(crate) struct PeerMonitor {
    waiting: AtomicBool,
    awaited: Mutex<Option<StepStage>>,
    farewell: Mutex<Option<String>>,
}

impl PeerMonitor {
    /// Whether the compute thread waits for the partner.
    pub(crate) fn is_waiting(&self) -> bool {
        self.waiting.load(Ordering::Relaxed)
    }

    /// Half-step of the frame that is or was awaited last.
    pub(crate) fn awaited(&self) -> Option<StepStage> {
        *self.awaited.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn set_awaited(&self, at: StepStage) {
        *self.awaited.lock().unwrap_or_else(PoisonError::into_inner) = Some(at);
    }

    /// Sets the reason that the partner receives at the end.
    pub(crate) fn set_farewell(&self, reason: String) {
        *self.farewell.lock().unwrap_or_else(PoisonError::into_inner) = Some(reason);
    }

    fn farewell(&self) -> String {
        let farewell = self.farewell.lock().unwrap_or_else(PoisonError::into_inner);
        farewell.clone().unwrap_or_else(|| "its run was given up".into())
    }
}

impl GrpcPeer {
    /// A peer and the slot by which it meets its stream. Must be called within the runtime.
    pub(crate) fn new(
        writer: FrameWriter,
        reader: FrameReader,
        cancel: CancellationToken,
        deadline: Option<Duration>,
    ) -> (Self, PeerSlot) {
        let (outbound, frames) = mpsc::channel(OUTBOUND_FRAMES);
        let (sender, arriving) = oneshot::channel();
        let peer = Self {
            runtime: Handle::current(),
            outbound,
            arriving: Some(arriving),
            inbound: None,
            writer,
            reader,
            cancel,
            deadline,
            monitor: Arc::default(),
        };
        (peer, PeerSlot { inbound: sender, outbound: frames })
    }

    /// What others see and say of this peer.
    pub(crate) fn monitor(&self) -> Arc<PeerMonitor> {
        self.monitor.clone()
    }

    /// The partner's next message, or why there is none.
    async fn next(
        arriving: &mut Option<oneshot::Receiver<Inbound>>,
        inbound: &mut Option<tonic::Streaming<wire::Frame>>,
    ) -> Result<wire::Frame, PeerError> {
        if let Some(receiver) = arriving.as_mut() {
            let stream = receiver.await.map_err(|_| PeerError::Lost("it never called".into()))?;
            *arriving = None;
            *inbound = Some(stream.map_err(PeerError::Lost)?);
        }
        let Some(stream) = inbound.as_mut() else {
            return Err(PeerError::Lost("its stream has ended".into()));
        };
        match stream.message().await {
            Ok(Some(frame)) => Ok(frame),
            Ok(None) => Err(PeerError::Lost("its stream ended without a farewell".into())),
            Err(status) if status.code() == tonic::Code::OutOfRange => {
                Err(PeerError::Refused(describe(&status)))
            }
            Err(status) => Err(PeerError::Lost(describe(&status))),
        }
    }
}

impl Exchange for GrpcPeer {
    fn send(&mut self, frame: &Frame) -> Result<(), PeerError> {
        let message = self.writer.write(frame);
        let Self { runtime, outbound, cancel, .. } = self;
        // A full queue means that the transport is stuck; a closed one, that the reason waits at the receiving end.
        match outbound.try_send(message) {
            Ok(()) | Err(mpsc::error::TrySendError::Closed(_)) => Ok(()),
            Err(mpsc::error::TrySendError::Full(message)) => runtime.block_on(async {
                tokio::select! {
                    () = cancel.cancelled() => Err(PeerError::Cancelled),
                    _ = outbound.send(message) => Ok(()),
                }
            }),
        }
    }

    fn receive(&mut self, at: StepStage, frame: &mut Frame) -> Result<(), PeerError> {
        let Self { runtime, arriving, inbound, cancel, deadline, monitor, .. } = self;
        monitor.set_awaited(at);
        monitor.waiting.store(true, Ordering::Relaxed);
        let deadline = *deadline;
        let message = runtime.block_on(async {
            tokio::select! {
                biased;
                message = Self::next(arriving, inbound) => message,
                () = cancel.cancelled() => Err(PeerError::Cancelled),
                limit = expire(deadline) => {
                    Err(PeerError::Lost(format!("no frame of {at} within {} s", limit.as_secs_f64())))
                }
            }
        });
        monitor.waiting.store(false, Ordering::Relaxed);
        match self.reader.read(&message?, at, frame) {
            Ok(ReceivedFrame::Frame) => Ok(()),
            Ok(ReceivedFrame::Farewell(reason)) => {
                Err(PeerError::Lost(format!("it ended its run: {reason}")))
            }
            Err(error) => Err(PeerError::Refused(error.to_string())),
        }
    }
}

/// Answers `deadline` when it has passed; never without one.
async fn expire(deadline: Option<Duration>) -> Duration {
    match deadline {
        Some(deadline) => {
            tokio::time::sleep(deadline).await;
            deadline
        }
        None => std::future::pending().await,
    }
}

impl Drop for GrpcPeer {
    fn drop(&mut self) {
        let farewell = self.writer.farewell(&self.monitor.farewell());
        let (outbound, arriving, inbound) =
            (self.outbound.clone(), self.arriving.take(), self.inbound.take());
        let cancel = self.cancel.clone();
        self.runtime.spawn(async move {
            // A partner that is gone needs neither farewell nor patience.
            tokio::select! {
                () = linger(farewell, outbound, arriving, inbound) => {}
                () = tokio::time::sleep(LINGER) => {}
                () = async { cancel.cancelled().await; tokio::time::sleep(LINGER_CANCELLED).await } => {}
            }
        });
    }
}

/// Says farewell, ends the own half of the stream and hears the partner out.
async fn linger(
    farewell: wire::Frame,
    outbound: mpsc::Sender<wire::Frame>,
    mut arriving: Option<oneshot::Receiver<Inbound>>,
    mut inbound: Option<tonic::Streaming<wire::Frame>>,
) {
    if outbound.send(farewell).await.is_err() {
        return;
    }
    drop(outbound);
    while GrpcPeer::next(&mut arriving, &mut inbound).await.is_ok() {}
}

/// Calls the partner's Exchange at `address` and hands its stream to `slot`.
///
/// # Errors
/// When the address cannot be reached, or the call is refused within a few seconds.
pub(crate) async fn dial(
    address: &str,
    token: &Token,
    security: &ClientSecurity,
    slot: PeerSlot,
) -> Result<(), String> {
    let channel = channel::connect_secured(address, CONNECT_TIMEOUT, security).await?;
    let request = token.attach(ReceiverStream::new(slot.outbound));
    let (refusal, refused) = oneshot::channel();
    tokio::spawn(async move {
        let stream = call(channel, request).await;
        drop(refusal.send(stream.as_ref().err().cloned()));
        // A peer that is gone takes nothing.
        drop(slot.inbound.send(stream));
    });
    match tokio::time::timeout(HEADER_TIMEOUT, refused).await {
        Ok(Ok(Some(problem))) => Err(problem),
        // No headers yet: some servers send them with their first frame.
        Ok(Ok(None) | Err(_)) | Err(_) => Ok(()),
    }
}

async fn call(channel: Channel, request: tonic::Request<ReceiverStream<wire::Frame>>) -> Inbound {
    let mut client = wire::peer_client::PeerClient::new(channel).max_decoding_message_size(MAX_FRAME_BYTES);
    match client.exchange(request).await {
        Ok(response) => Ok(response.into_inner()),
        Err(status) => Err(format!("refused the exchange: {}", describe(&status))),
    }
}
