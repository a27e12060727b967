//! The protocol between coordinator and solvers: messages, checked conversions, services and clients.
//!
//! The .proto files of package `fsi.v2` are the protocol's definition; this crate is its one user in this workspace.
//! Their code is checked in (`src/generated`): `cargo run -p proto-generator` writes it.
//! Generated types and the transport stay inside: the rest of the program speaks in types of `sph` and of
//! [`description`].
//!
//! ```text
//! coordinator -- transport::client --> service (Participant) --> compute thread: sph::coupling::driver::run
//!                                      fluid: transport::peer --> service (Peer) of the solid
//!
//! convert      messages to types of the program and back        limits        sizes and times of the protocol
//! description, handshake   what participants declare, and what does not fit together
//! transport    connections, security, client, peer, relay       service       a server around a solver
//! recording    frames in a file: record, compare, play          checkpoint    a state as bytes
//! conform      examines a solver from outside                   testing       made-up input, a faulty proxy
//! trace        when a run does what                             error, file_size
//! ```

pub mod checkpoint;
pub mod conform;
mod convert;
pub mod description;
mod error;
pub mod file_size;
pub mod handshake;
pub mod hex;
pub mod limits;
pub mod recording;
pub mod service;
pub mod testing;
pub mod trace;
pub mod transport;

pub use convert::{Beat, Phase, decoded_setup, encoded_setup};
pub use error::{RpcCode, RpcError};

/// Generated messages and services; `cargo run -p proto-generator` writes them again.
pub(crate) mod wire {
    #![allow(missing_docs, clippy::all)]
    include!("generated/fsi.v2.rs");

    /// All messages and services as a serialised descriptor set, for reflection.
    pub(crate) const DESCRIPTORS: &[u8] = include_bytes!("generated/fsi.v2.bin");
}

#[cfg(test)]
mod tests;
