//! Walls, their forces, and particles that leave.

pub mod leaving;
pub mod repulsion;
pub mod wall_states;
