//! Values for outputs.

pub mod boundary_evaluation;
pub mod fields;
pub mod probes;
pub mod wall_forces;
