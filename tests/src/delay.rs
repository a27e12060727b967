//! A longer way between fluid and solid: a loopback proxy that holds back what passes.

use std::net::SocketAddr;
use std::time::Duration;

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::mpsc;
use tokio::time::Instant;

/// Bytes read at once: more than a frame of some hundred particles.
const PIECE: usize = 1 << 16;

/// Passes connections on to one address, each piece of data after a fixed time, in both directions, so that a way of any
/// length stays open for what follows; dropping it ends it.
#[derive(Debug)]
pub struct DelayLine {
    /// Where it listens.
    pub address: SocketAddr,
    runtime: Option<tokio::runtime::Runtime>,
}

impl DelayLine {
    /// A line to `target` that holds every piece back by `delay`.
    pub fn start(target: SocketAddr, delay: Duration) -> Self {
        let runtime =
            tokio::runtime::Builder::new_multi_thread().worker_threads(1).enable_all().build().unwrap();
        let listener = runtime.block_on(TcpListener::bind("127.0.0.1:0")).unwrap();
        let address = listener.local_addr().unwrap();
        runtime.spawn(async move {
            while let Ok((near, _)) = listener.accept().await {
                tokio::spawn(async move {
                    let Ok(far) = TcpStream::connect(target).await else { return };
                    for stream in [&near, &far] {
                        drop(stream.set_nodelay(true));
                    }
                    let (from_near, to_near) = near.into_split();
                    let (from_far, to_far) = far.into_split();
                    tokio::spawn(pass(from_near, to_far, delay));
                    pass(from_far, to_near, delay).await;
                });
            }
        });
        Self { address, runtime: Some(runtime) }
    }
}

impl Drop for DelayLine {
    fn drop(&mut self) {
        if let Some(runtime) = self.runtime.take() {
            runtime.shutdown_background();
        }
    }
}

async fn pass(
    mut from: tokio::net::tcp::OwnedReadHalf,
    mut to: tokio::net::tcp::OwnedWriteHalf,
    delay: Duration,
) {
    let (pieces, mut waiting) = mpsc::unbounded_channel::<(Instant, Vec<u8>)>();
    let reading = async move {
        loop {
            let mut piece = vec![0; PIECE];
            match from.read(&mut piece).await {
                Ok(length) if length > 0 => {
                    piece.truncate(length);
                    if pieces.send((Instant::now() + delay, piece)).is_err() {
                        return;
                    }
                }
                _ => return,
            }
        }
    };
    let writing = async move {
        while let Some((due, piece)) = waiting.recv().await {
            wait_until(due).await;
            if to.write_all(&piece).await.is_err() {
                return;
            }
        }
        drop(to.shutdown().await);
    };
    tokio::join!(reading, writing);
}

/// Waits to the grain of the system's clock; the runtime's timers round up to whole milliseconds.
async fn wait_until(due: Instant) {
    let wait = due.saturating_duration_since(Instant::now());
    if !wait.is_zero() {
        drop(tokio::task::spawn_blocking(move || std::thread::sleep(wait)).await);
    }
}
