//! How messages travel: connections, security, and both ends of the services.
//!
//! ```text
//! channel    settings of connections        connection   what a server admits       codec     lists are counted first
//! security   TLS, access tokens             secrets      files that hold them       token     the token of a run
//! client     a server as its coordinator sees it         peer, relay                the frames between two solvers
//! node       a server program: its options and signals   version1                   refusals of protocol 1
//! ```

pub(crate) mod channel;
pub mod client;
pub(crate) mod codec;
pub(crate) mod connection;
pub mod node;
pub(crate) mod peer;
pub mod relay;
pub(crate) mod secrets;
pub mod security;
pub(crate) mod token;
pub(crate) mod version1;
