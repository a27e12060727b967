//! Walls, their forces, and particles that leave.

pub mod departures;
pub mod repulsion;
pub mod wall_states;
