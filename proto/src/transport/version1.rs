//! Protocol 1, which this program no longer speaks: clear refusals on either side.

use std::convert::Infallible;
use std::future::{Ready, ready};
use std::task::{Context, Poll};

use tonic::Status;
use tonic::body::Body;
use tonic::codegen::http::uri::PathAndQuery;
use tonic::codegen::{Service, StdError, http};
use tonic::server::NamedService;

use crate::description::PROTOCOL;
use crate::transport::codec::Bounded;
use crate::wire::DescribeRequest;

/// Answers every call of a coordinator of protocol 1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RefuseVersion1;

impl NamedService for RefuseVersion1 {
    const NAME: &'static str = "fsi.v1.Participant";
}

impl<B> Service<http::Request<B>> for RefuseVersion1 {
    type Response = http::Response<Body>;
    type Error = Infallible;
    type Future = Ready<Result<Self::Response, Infallible>>;

    fn poll_ready(&mut self, _: &mut Context<'_>) -> Poll<Result<(), Infallible>> {
        Poll::Ready(Ok(()))
    }

    fn call(&mut self, _: http::Request<B>) -> Self::Future {
        let text =
            format!("the call is of protocol 1, this server speaks {PROTOCOL}: update the coordinator");
        ready(Ok(Status::unimplemented(text).into_http()))
    }
}

/// Whether the server behind `service` answers `Describe` of protocol 1.
pub(crate) async fn is_spoken_by<S>(service: S) -> bool
where
    S: tonic::client::GrpcService<Body>,
    S::ResponseBody: tonic::codegen::Body<Data = bytes::Bytes> + Send + 'static,
    <S::ResponseBody as tonic::codegen::Body>::Error: Into<StdError> + Send,
{
    let mut client = tonic::client::Grpc::new(service);
    if client.ready().await.is_err() {
        return false;
    }
    let path = PathAndQuery::from_static("/fsi.v1.Participant/Describe");
    // An empty message either way: unknown fields are ignored.
    let codec = Bounded::<DescribeRequest, DescribeRequest>::default();
    client.unary(tonic::Request::new(DescribeRequest {}), path, codec).await.is_ok()
}
