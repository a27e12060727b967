//! Settings of connections, tokens and addresses.

use std::net::SocketAddr;
use std::time::Duration;

use tonic::metadata::{Ascii, MetadataMap, MetadataValue};
use tonic::transport::{Channel, Endpoint, Server};

use crate::limits::{
    CONNECTION_WINDOW_BYTES, HTTP2_FRAME_BYTES, KEEPALIVE_INTERVAL, KEEPALIVE_TIMEOUT, MAX_NAME_BYTES,
    MAX_STREAMS, MIN_TOKEN_BYTES, STREAM_WINDOW_BYTES,
};
use crate::security::{ClientSecurity, ServerSecurity};

/// Metadata key of the run's token.
pub(crate) const TOKEN_KEY: &str = "fsi-token";

/// Secret of a run: who knows it may speak for the run.
#[derive(Clone)]
pub(crate) struct Token(String);

impl std::fmt::Debug for Token {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Token(hidden)")
    }
}

impl Token {
    /// A token that nobody can guess.
    pub(crate) fn fresh() -> Result<Self, String> {
        let mut bytes = [0; 32];
        getrandom::fill(&mut bytes).map_err(|e| format!("no random numbers for a token: {e}"))?;
        Ok(Self(bytes.iter().map(|byte| format!("{byte:02x}")).collect()))
    }

    /// A token from the wire.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let printable = text.bytes().all(|byte| byte.is_ascii_graphic());
        if printable && (MIN_TOKEN_BYTES..=MAX_NAME_BYTES).contains(&text.len()) {
            Ok(Self(text.to_owned()))
        } else {
            // The value stays unsaid: it may be a secret with a slip.
            Err(format!("must have {MIN_TOKEN_BYTES} to {MAX_NAME_BYTES} printable ASCII characters"))
        }
    }

    /// Text for the message that opens a run.
    pub(crate) fn text(&self) -> &str {
        &self.0
    }

    /// `message` with the token in its metadata.
    pub(crate) fn attach<T>(&self, message: T) -> tonic::Request<T> {
        let mut request = tonic::Request::new(message);
        // Printable ASCII is always a valid value.
        if let Ok(value) = self.0.parse::<MetadataValue<Ascii>>() {
            request.metadata_mut().insert(TOKEN_KEY, value);
        }
        request
    }

    /// Whether `metadata` carry this token.
    pub(crate) fn admits(&self, metadata: &MetadataMap) -> bool {
        self.is_in(metadata.get(TOKEN_KEY))
    }

    /// Whether `given` is this token; takes the same time wherever the first difference lies.
    pub(crate) fn is_in(&self, given: Option<&MetadataValue<Ascii>>) -> bool {
        let Some(given) = given else { return false };
        let (given, own) = (given.as_bytes(), self.0.as_bytes());
        if given.len() != own.len() {
            return false;
        }
        let difference = given.iter().zip(own).fold(0, |sum, (a, b)| sum | std::hint::black_box(a ^ b));
        std::hint::black_box(difference) == 0
    }
}

/// Connects to `address`, "host:port" or "http://host:port", or by TLS to "https://host:port".
pub(crate) async fn connect_secured(
    address: &str,
    timeout: Duration,
    security: &ClientSecurity,
) -> Result<Channel, String> {
    let uri = if address.contains("://") { address.to_owned() } else { format!("http://{address}") };
    let endpoint = Endpoint::from_shared(uri)
        .map_err(|e| format!("is not an address of the form host:port: {e}"))?
        .connect_timeout(timeout)
        .tcp_nodelay(true)
        .initial_stream_window_size(STREAM_WINDOW_BYTES)
        .initial_connection_window_size(CONNECTION_WINDOW_BYTES)
        .max_frame_size(HTTP2_FRAME_BYTES)
        .http2_keep_alive_interval(KEEPALIVE_INTERVAL)
        .keep_alive_timeout(KEEPALIVE_TIMEOUT)
        .keep_alive_while_idle(true);
    let endpoint = security.apply(endpoint)?;
    match tokio::time::timeout(timeout, endpoint.connect()).await {
        Ok(Ok(channel)) => Ok(channel),
        Ok(Err(error)) => Err(format!("cannot be reached: {}", with_causes(&error))),
        Err(_) => Err(format!("did not accept a connection within {} s", timeout.as_secs_f64())),
    }
}

/// Text of an error with its causes.
pub(crate) fn with_causes(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut source = error.source();
    while let Some(cause) = source {
        text.push_str(": ");
        text.push_str(&cause.to_string());
        source = cause.source();
    }
    text
}

/// A server with the settings of this protocol; delays of the socket are set where it is bound. A caller that is frozen, or
/// out of reach, is given up within `lease`, if that is shorter than what is usual.
///
/// # Errors
/// When the certificate of `security` cannot be used.
pub(crate) fn server(security: &ServerSecurity, lease: Duration) -> Result<Server, tonic::transport::Error> {
    let [interval, timeout] = pings(lease);
    let server = Server::builder()
        .max_concurrent_streams(MAX_STREAMS)
        .initial_stream_window_size(STREAM_WINDOW_BYTES)
        .initial_connection_window_size(CONNECTION_WINDOW_BYTES)
        .max_frame_size(HTTP2_FRAME_BYTES)
        .http2_keepalive_interval(Some(interval))
        .http2_keepalive_timeout(Some(timeout));
    match security.tls() {
        Some(tls) => server.tls_config(tls.clone()),
        None => Ok(server),
    }
}

/// Time between HTTP/2 pings, and the wait for an answer. Together they are below `lease`, so that a run ends within it
/// though its caller is frozen; pings are answered whatever a caller computes.
fn pings(lease: Duration) -> [Duration; 2] {
    [KEEPALIVE_INTERVAL.min(lease / 3), KEEPALIVE_TIMEOUT.min(lease / 2)]
}

/// Whether only this machine can reach `address`.
pub(crate) fn is_loopback(address: &SocketAddr) -> bool {
    address.ip().is_loopback()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frozen_caller_is_given_up_within_the_lease() {
        for seconds in [1, 5, 25, 120, 86400] {
            let lease = Duration::from_secs(seconds);
            let [interval, timeout] = pings(lease);
            assert!(
                interval + timeout < lease.min(Duration::from_secs(31)),
                "{lease:?}: {interval:?}, {timeout:?}"
            );
        }
        assert_eq!(pings(Duration::from_secs(120)), [KEEPALIVE_INTERVAL, KEEPALIVE_TIMEOUT]);
    }

    #[test]
    fn tokens_admit_themselves_only() {
        let token = Token::fresh().unwrap();
        assert!(token.admits(token.attach(()).metadata()));
        assert!(!token.admits(&MetadataMap::new()));
        assert!(!token.admits(Token::fresh().unwrap().attach(()).metadata()));
        let mut other = token.text().to_owned();
        other.pop();
        assert!(!token.admits(Token::parse(&other).unwrap().attach(()).metadata()));
        assert!(!format!("{token:?}").contains(token.text()));
        assert!(Token::parse("short").is_err());
        assert!(Token::parse(&"a b".repeat(10)).is_err());
    }
}
