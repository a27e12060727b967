//! Laws of a pair and of a particle.

pub mod anti_pairing;
pub mod artificial_pressure;
pub mod continuity;
pub mod correction;
pub mod damper;
pub mod diffusion;
pub mod neighbour_sums;
pub mod pair;
pub mod residual_approach;
pub mod stress;
pub mod terms;
pub mod viscosity;
pub mod voids;
pub mod volume;
