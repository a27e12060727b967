//! Limits of a server: connections, calls at work on one of them, and how long one may say nothing.

use std::time::Duration;

use sph::coupling::solver::Role;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio_stream::wrappers::ReceiverStream;
use tonic::codegen::http::uri::PathAndQuery;

use super::fake::{TestServer, soon};
use crate::limits::{FIRST_CALL, MAX_CONNECTIONS, MAX_STREAMS};
use crate::transport::channel;
use crate::transport::codec::Bounded;
use crate::wire;
use crate::wire::participant_client::ParticipantClient;

/// Waits for the end of a connection that brings no call; how long it took since `started`, which must lie before the
/// connection: on a busy machine the server's clock runs before this function does.
async fn closed(mut stream: TcpStream, started: tokio::time::Instant) -> Duration {
    let mut bytes = [0; 1024];
    // What the server says first does not matter, and a reset is an end too.
    while stream.read(&mut bytes).await.is_ok_and(|count| count > 0) {}
    started.elapsed()
}

#[tokio::test(flavor = "multi_thread")]
async fn a_connection_that_brings_no_call_is_closed_and_one_that_called_stays() {
    let server = TestServer::start(Role::Solid);
    let mut client = server.client().await;
    client.describe().await.unwrap();
    let started = tokio::time::Instant::now();
    let silent = TcpStream::connect(server.address).await.unwrap();
    let mut greeting = TcpStream::connect(server.address).await.unwrap();
    // The preface of HTTP/2 and empty settings, and then nothing.
    greeting.write_all(b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n\0\0\0\x04\0\0\0\0\0").await.unwrap();
    let (silent, greeting) =
        soon("the end", async { tokio::join!(closed(silent, started), closed(greeting, started)) }).await;
    for elapsed in [silent, greeting] {
        let over = elapsed.checked_sub(FIRST_CALL).expect("not before its time");
        assert!(over < Duration::from_secs(4), "{elapsed:?}");
    }
    client.describe().await.unwrap();
    server.end().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn callers_that_say_nothing_do_not_keep_others_out() {
    let server = TestServer::start(Role::Solid);
    let mut first = server.client().await;
    first.describe().await.unwrap();
    let mut silent = Vec::new();
    for _ in 0..2 * MAX_CONNECTIONS {
        silent.push(TcpStream::connect(server.address).await.unwrap());
    }
    // Well before their time is over.
    let soon_enough = FIRST_CALL / 2;
    let mut second = server.client().await;
    tokio::time::timeout(soon_enough, second.describe()).await.expect("a place").unwrap();
    // The oldest made room, and they only.
    let oldest =
        tokio::time::timeout(soon_enough, closed(silent.remove(0), tokio::time::Instant::now())).await;
    assert!(oldest.is_ok(), "the oldest connection without a call is still there");
    let newest = tokio::time::timeout(
        Duration::from_millis(200),
        closed(silent.pop().unwrap(), tokio::time::Instant::now()),
    )
    .await;
    assert!(newest.is_err(), "the newest connection was closed");
    first.describe().await.unwrap();
    server.end().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn calls_that_never_end_are_few_on_a_connection() {
    let server = TestServer::start(Role::Solid);
    let address = server.address.to_string();
    let channel =
        channel::connect_secured(&address, Duration::from_secs(5), &Default::default()).await.unwrap();
    let mut calls = Vec::new();
    for _ in 0..MAX_STREAMS {
        let mut client = tonic::client::Grpc::new(channel.clone());
        client.ready().await.unwrap();
        calls.push(tokio::spawn(async move {
            // An `Open` whose message never comes.
            let (_message, stream) = tokio::sync::mpsc::channel::<wire::OpenRequest>(1);
            let path = PathAndQuery::from_static("/fsi.v2.Participant/Open");
            let codec = Bounded::<wire::OpenRequest, wire::OpenReply>::default();
            let request = tonic::Request::new(ReceiverStream::new(stream));
            drop(client.client_streaming(request, path, codec).await);
            _message.closed().await;
        }));
    }
    tokio::time::sleep(Duration::from_millis(300)).await;
    let mut further = ParticipantClient::new(channel);
    let waiting =
        tokio::time::timeout(Duration::from_millis(500), further.describe(wire::DescribeRequest {})).await;
    assert!(waiting.is_err(), "one more call is at work on the connection: {waiting:?}");
    // Others have connections of their own.
    server.client().await.describe().await.unwrap();
    calls.iter().for_each(tokio::task::JoinHandle::abort);
    soon("the call", further.describe(wire::DescribeRequest {})).await.unwrap();
    server.end().await;
}
