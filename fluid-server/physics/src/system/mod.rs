//! What exists: constants, state, walls, and the layout of particles.

pub mod build;
pub mod lane_arrays;
pub mod list_limits;
pub mod model;
pub mod packed_particle;
pub mod saved;
pub mod setup_errors;
pub mod state;
pub mod tasks;
pub mod thresholds;
pub mod walls;
