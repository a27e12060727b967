//! Free surface, and shifting of particles.

pub mod detection;
pub mod shifting;
