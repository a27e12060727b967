//! Connections of a server: how many there are, how long one may bring no call, and when it ends.
//!
//! Whoever connects and makes no call is cut off soon, and first where connections are short, so that such callers do not keep
//! others out. A call without the token that the server demands counts as none.

use std::collections::BTreeMap;
use std::io;
use std::net::SocketAddr;
use std::pin::Pin;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll, ready};
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::{TcpListener, TcpStream};
use tokio::time::Sleep;
use tokio_stream::Stream;
use tokio_util::sync::{CancellationToken, DropGuard};
use tonic::Extensions;
use tonic::transport::server::{Connected, TlsConnectInfo};

use crate::limits::{FIRST_CALL, MAX_CONNECTIONS};

/// Wait after a connection could not be accepted, such as for want of file handles.
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);

/// Connections as they come to a port.
#[derive(Debug)]
pub(crate) struct Incoming {
    listener: TcpListener,
    pause: Option<Pin<Box<Sleep>>>,
    places: Arc<Places>,
    /// The last connection could not be accepted, which was said.
    failing: bool,
}

impl Incoming {
    /// Takes `address`; port 0 takes any free one. Must be called within a runtime.
    ///
    /// # Errors
    /// When the address is taken.
    pub(crate) fn bind(address: SocketAddr) -> io::Result<Self> {
        let listener = std::net::TcpListener::bind(address)?;
        listener.set_nonblocking(true)?;
        let listener = TcpListener::from_std(listener)?;
        Ok(Self { listener, pause: None, places: Arc::default(), failing: false })
    }

    /// Where it listens.
    pub(crate) fn local_addr(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// Waits before the next try, unless only the one connection failed.
    fn failed(&mut self, error: &io::Error) {
        if matches!(error.kind(), io::ErrorKind::ConnectionAborted | io::ErrorKind::ConnectionReset) {
            return;
        }
        if !std::mem::replace(&mut self.failing, true) {
            tracing::warn!("cannot accept a connection: {error}; tries are repeated");
        }
        self.pause = Some(Box::pin(tokio::time::sleep(ACCEPT_PAUSE)));
    }
}

impl Stream for Incoming {
    type Item = io::Result<Connection>;

    fn poll_next(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Self::Item>> {
        loop {
            if let Some(pause) = &mut self.pause {
                ready!(pause.as_mut().poll(context));
                self.pause = None;
            }
            match ready!(self.listener.poll_accept(context)) {
                Ok((stream, _)) => {
                    self.failing = false;
                    // Frames are small and awaited; a socket without the option still serves.
                    drop(stream.set_nodelay(true));
                    if let Some(connection) = self.places.take(stream) {
                        return Poll::Ready(Some(Ok(connection)));
                    }
                }
                Err(error) => self.failed(&error),
            }
        }
    }
}

/// All connections of a server, by the order in which they came.
#[derive(Debug, Default)]
struct Places(Mutex<(u64, BTreeMap<u64, Caller>)>);

impl Places {
    /// A place for `stream`: where all are taken, that of the oldest connection without a call; `None` when there is none.
    fn take(self: &Arc<Self>, stream: TcpStream) -> Option<Connection> {
        let mut held = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let (next, callers) = &mut *held;
        if callers.len() >= MAX_CONNECTIONS {
            let idle = callers.iter().find(|(_, caller)| !caller.is_admitted()).map(|(number, _)| *number)?;
            callers.remove(&idle)?.cut.cancel();
        }
        let number = *next;
        *next += 1;
        let caller = Caller::default();
        callers.insert(number, caller.clone());
        Some(Connection {
            stream,
            limit: Some(Box::pin(caller.clone().limit())),
            _end: caller.ended.clone().drop_guard(),
            caller,
            place: Place { number, places: self.clone() },
        })
    }
}

/// A place that is given back when dropped.
#[derive(Debug)]
struct Place {
    number: u64,
    places: Arc<Places>,
}

impl Drop for Place {
    fn drop(&mut self) {
        let mut held = self.places.0.lock().unwrap_or_else(PoisonError::into_inner);
        held.1.remove(&self.number);
    }
}

/// Who is at the other end of a connection, as calls see it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Caller {
    calls: Arc<[AtomicBool; 2]>,
    cut: CancellationToken,
    ended: CancellationToken,
}

impl Caller {
    /// The caller with these extensions of a call, through TLS or not.
    pub(crate) fn of(extensions: &Extensions) -> Option<&Self> {
        let secured = || extensions.get::<TlsConnectInfo<Self>>().map(TlsConnectInfo::get_ref);
        extensions.get::<Self>().or_else(secured)
    }

    /// Cancelled when the connection has ended.
    pub(crate) fn ended(&self) -> CancellationToken {
        self.ended.clone()
    }

    /// It has made a call that anybody may make: it may stay while there is room.
    pub(crate) fn called(&self) {
        self.calls[0].store(true, Ordering::Relaxed);
    }

    /// It has made a call that it may make: it stays.
    pub(crate) fn admitted(&self) {
        self.called();
        self.calls[1].store(true, Ordering::Relaxed);
    }

    fn is_admitted(&self) -> bool {
        self.calls[1].load(Ordering::Relaxed)
    }

    /// Completes when the connection is to be cut off.
    async fn limit(self) {
        let first_call = async {
            tokio::time::sleep(FIRST_CALL).await;
            if self.calls[0].load(Ordering::Relaxed) {
                std::future::pending::<()>().await;
            }
        };
        tokio::select! {
            () = self.cut.cancelled() => {}
            () = first_call => {}
        }
    }
}

/// A connection that knows its caller.
pub(crate) struct Connection {
    stream: TcpStream,
    caller: Caller,
    /// Completes when it is to be cut off; `None` when it stays.
    limit: Option<Pin<Box<dyn Future<Output = ()> + Send>>>,
    _end: DropGuard,
    #[allow(dead_code, reason = "given back when dropped")]
    place: Place,
}

impl Connected for Connection {
    type ConnectInfo = Caller;

    fn connect_info(&self) -> Caller {
        self.caller.clone()
    }
}

impl AsyncRead for Connection {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        let read = Pin::new(&mut self.stream).poll_read(context, buffer);
        if read.is_pending() && self.caller.is_admitted() {
            self.limit = None;
        }
        if read.is_pending()
            && let Some(limit) = &mut self.limit
            && limit.as_mut().poll(context).is_ready()
        {
            self.limit = None;
            return Poll::Ready(Err(io::Error::new(io::ErrorKind::TimedOut, "no call came")));
        }
        read
    }
}

impl AsyncWrite for Connection {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.stream).poll_write(context, bytes)
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        parts: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.stream).poll_write_vectored(context, parts)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }
}
