//! Sizes and times that both ends keep to; the .proto files name the same numbers.

use std::time::Duration;

/// Largest message of the control plane \[bytes\]: a set-up of some four million particles.
pub const MAX_MESSAGE_BYTES: usize = 256 << 20;

/// Largest half-step frame \[bytes\]: some 700,000 interface particles.
pub const MAX_FRAME_BYTES: usize = 64 << 20;

/// Largest piece of a snapshot or checkpoint \[bytes\].
pub const CHUNK_BYTES: usize = 1 << 20;

/// Bytes that are set aside for a stream of chunks before they have arrived.
pub(crate) const EAGER_BYTES: usize = 64 << 20;
/// Most arrays of a checkpoint.
pub(crate) const MAX_ARRAYS: usize = 4096;

/// Largest HTTP/2 frame \[bytes\]: a half-step frame goes out in one write, and wakes its reader once.
pub(crate) const HTTP2_FRAME_BYTES: u32 = 1 << 20;

/// HTTP/2 flow-control windows \[bytes\]: several frames and chunks in flight.
pub(crate) const STREAM_WINDOW_BYTES: u32 = 8 << 20;
pub(crate) const CONNECTION_WINDOW_BYTES: u32 = 16 << 20;

/// Most particles of a kind in one message.
pub(crate) const MAX_PARTICLES: usize = 1 << 26;
/// Most boxes of an extent.
pub(crate) const MAX_BOXES: usize = 1 << 20;
/// Most entries of any other list; of one field of a message, those in all its parts together.
pub(crate) const MAX_LIST: usize = 1 << 16;
/// Most events in one message: each takes more than a kilobyte once it is decoded.
pub(crate) const MAX_EVENTS: usize = 1 << 12;
/// Most accounts of a momentum budget, with room for more of them.
pub(crate) const MAX_ACCOUNTS: usize = 16;
/// Most accounts of an energy budget, with room for more of them.
pub(crate) const MAX_ENERGIES: usize = 64;
/// Most remarks about a start that are read.
pub(crate) const MAX_REMARKS: usize = 16;
/// Deepest nesting of messages that is walked; the decoder gives up before.
pub(crate) const MAX_DEPTH: usize = 128;
/// Longest name, run id or holder \[bytes\].
pub(crate) const MAX_NAME_BYTES: usize = 256;
/// Longest expression or message text \[bytes\].
pub(crate) const MAX_TEXT_BYTES: usize = 4096;
/// Shortest token \[bytes\].
pub(crate) const MIN_TOKEN_BYTES: usize = 16;

/// Longest text of a gRPC status \[bytes\]: it travels in a header, and long headers break connections.
pub(crate) const MAX_STATUS_BYTES: usize = 3500;

/// Most connections of a server at a time: a run needs two.
pub(crate) const MAX_CONNECTIONS: usize = 256;
/// Most calls at work on one connection at a time: a run needs three.
pub(crate) const MAX_STREAMS: u32 = 64;
/// A connection that has brought no call by then is closed.
pub(crate) const FIRST_CALL: Duration = Duration::from_secs(10);

/// HTTP/2 ping: a partner whose process is frozen or whose cable is cut is lost after both.
pub(crate) const KEEPALIVE_INTERVAL: Duration = Duration::from_secs(10);
pub(crate) const KEEPALIVE_TIMEOUT: Duration = Duration::from_secs(20);

/// A sign of life at least this often on the Run stream.
pub(crate) const BEAT_INTERVAL: Duration = Duration::from_secs(1);
