//! The two passes over neighbours: gradients, then rates.

pub mod energy;
pub mod gradient_pass;
pub mod gradients;
pub mod particle_rates;
pub mod power_sums;
pub mod rate_pass;
pub mod stage_fields;
pub mod volume_reading;
pub mod wall_pass;
