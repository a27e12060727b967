//! The protocol between coordinator and solvers: messages, checked conversions, services and clients.
//!
//! The .proto files of package `fsi.v2` are the protocol's definition; this crate is its one user in this workspace.
//! Generated types and the transport stay inside: the rest of the program speaks in types of `sph` and of
//! [`description`].
//!
//! ```text
//! coordinator -- client::ParticipantClient --> service (Participant) --> compute thread: sph::coupling::driver::run
//!                                              fluid: peer::GrpcPeer --> service (Peer) of the solid
//! ```

pub mod checkpoint;
pub mod client;
mod codec;
pub mod conform;
mod connection;
mod convert;
pub mod description;
mod error;
pub mod file_size;
pub mod handshake;
pub mod hostile;
pub mod limits;
pub mod node;
mod peer;
pub mod player;
pub mod proxy;
pub mod recording;
pub mod relay;
mod secrets;
pub mod security;
pub mod service;
mod token;
pub mod trace;
mod transport;
mod version1;

pub use convert::{Beat, Phase};
pub use error::{RpcCode, RpcError};

/// Generated messages and services.
pub(crate) mod wire {
    #![allow(missing_docs, clippy::all)]
    tonic::include_proto!("fsi.v2");

    /// All messages and services as a serialised descriptor set, for reflection.
    pub(crate) const DESCRIPTORS: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/fsi.v2.bin"));
}

#[cfg(test)]
mod tests;
