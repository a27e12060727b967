//! Peers of protocol 1 are refused with both versions and what to do.

use std::future::{Ready, ready};

use sph::coupling::solver::Role;
use tokio::net::TcpListener;
use tokio_stream::wrappers::TcpListenerStream;
use tonic::body::Body;
use tonic::codegen::http::uri::PathAndQuery;
use tonic::codegen::{BoxFuture, Service, http};
use tonic::server::{NamedService, UnaryService};
use tonic::{Code, Request, Response, Status};

use super::fake::TestServer;
use crate::transport::channel;
use crate::transport::client::{Deadlines, ParticipantClient};
use crate::transport::codec::Bounded;
use crate::transport::security::ClientSecurity;
use crate::wire::DescribeRequest;

type Codec = Bounded<DescribeRequest, DescribeRequest>;

/// A server of protocol 1, as far as `Describe` goes.
#[derive(Clone)]
struct Version1;

impl NamedService for Version1 {
    const NAME: &'static str = "fsi.v1.Participant";
}

impl UnaryService<DescribeRequest> for Version1 {
    type Response = DescribeRequest;
    type Future = Ready<Result<Response<DescribeRequest>, Status>>;

    fn call(&mut self, _: Request<DescribeRequest>) -> Self::Future {
        ready(Ok(Response::new(DescribeRequest {})))
    }
}

impl Service<http::Request<Body>> for Version1 {
    type Response = http::Response<Body>;
    type Error = std::convert::Infallible;
    type Future = BoxFuture<Self::Response, Self::Error>;

    fn poll_ready(&mut self, _: &mut std::task::Context<'_>) -> std::task::Poll<Result<(), Self::Error>> {
        std::task::Poll::Ready(Ok(()))
    }

    fn call(&mut self, request: http::Request<Body>) -> Self::Future {
        Box::pin(async move { Ok(tonic::server::Grpc::new(Codec::default()).unary(Version1, request).await) })
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_server_of_protocol_1_is_named_as_such() {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let server = tonic::transport::Server::builder().add_service(Version1);
    tokio::spawn(server.serve_with_incoming(TcpListenerStream::new(listener)));
    let mut client = ParticipantClient::connect(&address, Deadlines::default()).await.unwrap();
    let text = client.describe().await.unwrap_err().to_string();
    assert!(text.contains("speaks protocol 1, this program needs 2: update the solver"), "{text}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_coordinator_of_protocol_1_is_told_the_version_that_is_needed() {
    let server = TestServer::start(Role::Solid);
    let security = ClientSecurity::default();
    let deadline = Deadlines::default().connect;
    let channel = channel::connect_secured(&server.address.to_string(), deadline, &security).await.unwrap();
    for call in ["Describe", "Open"] {
        let mut client = tonic::client::Grpc::new(channel.clone());
        client.ready().await.unwrap();
        let path = PathAndQuery::try_from(format!("/fsi.v1.Participant/{call}")).unwrap();
        let answer = client.unary(Request::new(DescribeRequest {}), path, Codec::default()).await;
        let status: Status = answer.map(drop).unwrap_err();
        assert_eq!(status.code(), Code::Unimplemented);
        let text = status.message();
        assert!(text.contains("protocol 1") && text.contains("speaks 2.0: update the coordinator"), "{text}");
    }
}
