//! Laws that both sides of an interface evaluate.

pub mod equation_of_state;
pub mod repulsion;
