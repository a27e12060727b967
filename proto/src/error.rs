//! Errors of the wire as the rest of the program sees them: no transport types.

use crate::limits::MAX_STATUS_BYTES;

/// Kind of a failed call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RpcCode {
    /// A message held a value that is not allowed.
    InvalidArgument,
    /// The call does not fit the state of the run; the message says what was expected.
    FailedPrecondition,
    /// Another run is held.
    Busy,
    /// Wrong or missing token.
    PermissionDenied,
    /// The server does not know the call, the protocol version or the capability.
    Unsupported,
    /// The server cannot be reached, was lost or shuts down.
    Unavailable,
    /// No answer or sign of life in time.
    DeadlineExceeded,
    /// A message above the size limit.
    TooLarge,
    /// A reply that breaks the protocol.
    Malformed,
    /// A defect of the server.
    Internal,
}

/// A failed call to a server, or a stream that broke.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{call}` at {address}: {message}")]
pub struct RpcError {
    /// Kind.
    pub code: RpcCode,
    /// Call that failed.
    pub call: &'static str,
    /// Address of the server.
    pub address: String,
    /// What happened.
    pub message: String,
}

impl RpcError {
    pub(crate) fn new(code: RpcCode, call: &'static str, address: &str, message: impl Into<String>) -> Self {
        Self { code, call, address: address.to_owned(), message: message.into() }
    }

    pub(crate) fn from_status(call: &'static str, address: &str, status: &tonic::Status) -> Self {
        Self::new(code_of(status), call, address, describe(status))
    }
}

fn code_of(status: &tonic::Status) -> RpcCode {
    use tonic::Code;
    match status.code() {
        Code::InvalidArgument => RpcCode::InvalidArgument,
        Code::FailedPrecondition | Code::Aborted | Code::NotFound | Code::AlreadyExists => {
            RpcCode::FailedPrecondition
        }
        Code::ResourceExhausted => RpcCode::Busy,
        Code::PermissionDenied | Code::Unauthenticated => RpcCode::PermissionDenied,
        Code::Unimplemented => RpcCode::Unsupported,
        Code::DeadlineExceeded => RpcCode::DeadlineExceeded,
        Code::OutOfRange => RpcCode::TooLarge,
        Code::DataLoss => RpcCode::Malformed,
        Code::Unavailable | Code::Cancelled => RpcCode::Unavailable,
        // The transport reports lost connections under these codes, with their cause as source.
        _ if std::error::Error::source(status).is_some() => RpcCode::Unavailable,
        _ => RpcCode::Internal,
    }
}

/// Text of a status with the causes that the transport adds.
pub(crate) fn describe(status: &tonic::Status) -> String {
    let mut text = if status.message().is_empty() {
        status.code().description().to_owned()
    } else {
        status.message().to_owned()
    };
    let mut source = std::error::Error::source(status);
    while let Some(cause) = source {
        let cause_text = cause.to_string();
        if !text.contains(&cause_text) {
            text.push_str(": ");
            text.push_str(&cause_text);
        }
        source = cause.source();
    }
    text
}

/// `text` cut to what a status may hold.
pub(crate) fn status_text(text: impl Into<String>) -> String {
    let mut text = text.into();
    if text.len() > MAX_STATUS_BYTES {
        let mut end = MAX_STATUS_BYTES;
        while !text.is_char_boundary(end) {
            end -= 1;
        }
        text.truncate(end);
        text.push_str(" ... (more left out)");
    }
    text
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_status_texts_are_cut_between_characters() {
        let text = status_text("ä".repeat(MAX_STATUS_BYTES));
        assert!(text.len() < MAX_STATUS_BYTES + 32);
        assert!(text.ends_with("left out)"));
        assert_eq!(status_text("short"), "short");
    }
}
