//! Detection of the free surface, and particle regularisation.

pub mod detection;
pub mod shifting;
