//! When a connection ends.

use std::io;
use std::pin::Pin;
use std::task::{Context, Poll};

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::TcpStream;
use tokio_util::sync::{CancellationToken, DropGuard};
use tonic::Extensions;
use tonic::transport::server::{Connected, TlsConnectInfo};

/// A connection whose calls can ask when it ends.
pub(super) struct Tracked {
    stream: TcpStream,
    ended: CancellationToken,
    _guard: DropGuard,
}

/// Cancelled when the connection of a call has ended.
#[derive(Clone)]
pub(super) struct Ended(CancellationToken);

impl Tracked {
    pub(super) fn new(stream: TcpStream) -> Self {
        let ended = CancellationToken::new();
        Self { stream, _guard: ended.clone().drop_guard(), ended }
    }
}

impl Connected for Tracked {
    type ConnectInfo = Ended;

    fn connect_info(&self) -> Ended {
        Ended(self.ended.clone())
    }
}

impl Ended {
    /// The end of the connection of a call with these extensions, through TLS or not.
    pub(super) fn of(extensions: &Extensions) -> Option<CancellationToken> {
        let plain = extensions.get::<Self>();
        let secured = || extensions.get::<TlsConnectInfo<Self>>().map(TlsConnectInfo::get_ref);
        plain.or_else(secured).map(|Self(ended)| ended.clone())
    }
}

impl AsyncRead for Tracked {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_read(context, buffer)
    }
}

impl AsyncWrite for Tracked {
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
