//! The fluid solver: physics, and the service around it.

pub mod physics;
