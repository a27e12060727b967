//! Elastic and rigid bodies as particles.
//!
//! One [`SolidSolver`] owns several bodies. How a body turns its state into stress and internal forces is its
//! formulation, a trait with three implementers: the updated-Lagrangian one of the source document, the total-Lagrangian
//! one and the rigid body.
//! Supports, contact, walls and the interface with the fluid act on all bodies alike and are no part of it.
//!
//! ```text
//! formulation   what a body does by itself: stress, own-body sums, rates, advance
//! evaluate, advance, substeps   forces of a state, and the two ways to step on
//! loads         what is prescribed to act on bodies
//! contact_*     among bodies and toward walls         supports   held particles
//! coupling      interface with the fluid             probes, report   what is read off
//! model, state, workspace   constant, checkpointed, disposable
//! ```

mod advance;
mod build;
mod checks;
mod contact_friction;
mod contact_law;
mod contact_repulsion;
mod contact_sums;
mod coupling;
mod elasticity;
mod evaluate;
mod formulation;
mod hyperelastic;
mod lists;
mod loads;
mod material_point;
mod model;
mod pair_lanes;
mod pair_law;
mod particles;
mod probes;
mod reference;
mod report;
mod rigid;
mod saved;
mod solver;
mod stencil;
mod substeps;
mod supports;
mod total_lagrangian;
mod updated_lagrangian;
mod walls;
mod workspace;

#[cfg(test)]
mod tests;

pub use solver::SolidSolver;
