//! The flow of a stage, and what moves the state.

pub mod advance;
pub mod checks;
pub mod compression_budget;
pub mod energy_budget;
mod lane_rates;
pub mod momentum_budget;
pub mod movement;
pub mod stage;
mod stage_relaxation;
pub mod state_scan;
pub mod step_control;
pub mod step_limit;
