//! solid-server

pub mod physics;
