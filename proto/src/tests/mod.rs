//! Tests of the protocol: conversions, services and clients, with small solvers in place of the physics.

mod checkpoints;
mod connections;
mod descriptor;
mod endings;
mod fake;
mod frames;
mod handshake;
mod life_cycle;
mod properties;
mod refusals;
mod reports;
mod runs;
mod setups;
mod streams;
mod version1;
