//! Whole-solver tests, each stepped through the `Solver` trait as the driver does it.

mod bodies;
mod contact;
mod coupling;
mod elastic;
mod energy;
mod film;
mod friction;
mod plane_stress;
mod scenes;
mod substeps;
mod supports;
mod total;
