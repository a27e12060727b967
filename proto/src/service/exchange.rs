//! The data plane's one call: joins the partner's stream to the run that awaits it.

use std::pin::Pin;

use tokio_stream::wrappers::ReceiverStream;
use tokio_stream::{Stream, StreamExt};
use tonic::{Request, Response, Status, Streaming};

use super::session::{Skin, State};
use crate::transport::connection::Caller;
use crate::wire;

#[tonic::async_trait]
impl wire::peer_server::Peer for Skin {
    type ExchangeStream = Pin<Box<dyn Stream<Item = Result<wire::Frame, Status>> + Send>>;

    async fn exchange(
        &self,
        request: Request<Streaming<wire::Frame>>,
    ) -> Result<Response<Self::ExchangeStream>, Status> {
        let slot = {
            let mut slot = self.0.slot();
            // Whoever does not know the token learns nothing, not even whether there is a run.
            let Some(session) = slot.as_mut().filter(|session| session.token.admits(request.metadata()))
            else {
                return Err(Status::permission_denied("not allowed"));
            };
            if let Some(caller) = Caller::of(request.extensions()) {
                caller.admitted();
            }
            match (&session.state, session.peer_slot.take()) {
                (State::Linked(_) | State::Running, Some(peer_slot)) => peer_slot,
                (State::Linked(_) | State::Running, None) => {
                    return Err(session.refused("Exchange", "a run linked to listen, one stream only"));
                }
                _ => return Err(session.refused("Exchange", "LINKED or RUNNING")),
            }
        };
        // A run that ended meanwhile takes nothing; the stream then ends at once.
        drop(slot.inbound.send(Ok(request.into_inner())));
        Ok(Response::new(Box::pin(ReceiverStream::new(slot.outbound).map(Ok))))
    }
}
