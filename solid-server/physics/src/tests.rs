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
mod spatial;
mod spatial_beams;
mod spatial_contact;
mod spatial_coupling;
mod spatial_rigid;
mod spatial_updated;
mod substeps;
mod supports;
mod total;
