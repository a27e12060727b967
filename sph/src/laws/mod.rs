//! Laws that both sides of an interface evaluate.

pub mod acoustic_relaxation;
pub mod artificial_viscosity;
pub mod equation_of_state;
pub mod repulsion;
