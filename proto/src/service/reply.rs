//! Replies of the service: streams, refusals, panics of a solver.

use std::any::Any;
use std::pin::Pin;

use tokio_stream::Stream;
use tonic::Status;

use crate::convert::WireError;
use crate::error::status_text;

/// A stream of replies.
pub(super) type Reply<T> = Pin<Box<dyn Stream<Item = Result<T, Status>> + Send>>;

/// Refuses a message for a value in it.
pub(super) fn invalid(error: &WireError) -> Status {
    Status::invalid_argument(status_text(error.to_string()))
}

/// Text of a panic.
pub(super) fn panic_text(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(ToString::to_string);
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "a defect without text".into())
}
