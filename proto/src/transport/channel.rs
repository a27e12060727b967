//! Settings of connections and addresses.

use std::time::Duration;

use tonic::transport::{Channel, Endpoint, Server};

use crate::error::with_causes;
use crate::limits::{
    CONNECTION_WINDOW_BYTES, HTTP2_FRAME_BYTES, KEEPALIVE_INTERVAL, KEEPALIVE_TIMEOUT, MAX_STREAMS,
    STREAM_WINDOW_BYTES,
};
use crate::transport::security::{ClientSecurity, ServerSecurity};

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
}
