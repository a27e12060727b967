//! Elastic and rigid bodies as particles.
//!
//! One [`SolidSolver`] owns several bodies. A body's formulation, a trait with three implementers, turns its state into
//! stress and internal forces: updated-Lagrangian as in the source paper, total-Lagrangian, or rigid.
//! Supports, contact, walls and the interface with the fluid act on all bodies alike and are no part of it.
//!
//! Folders, each of which depends on those above it only:
//!
//! ```text
//! thresholds     coefficients that were measured in each space
//! space          what the solid needs of a space
//! particles/     variables, constants, stress and forces of each particle
//! materials/     stress laws: Hooke with the Jaumann rate, hyperelastic
//! neighbours/    lists in the current and in the reference configuration
//! boundary/      supports (held particles), walls, prescribed loads
//! formulations/  the trait, its three implementers and their pair sums
//! contact/       between bodies and with walls: repulsion with friction, or the sums of the source paper
//! interface/     the fluid partner
//! system/        model (constant), state (checkpointed), workspace (disposable)
//! report/        probes, particle fields, energies
//! time/          flow of a stage, evaluation of forces, the two ways to advance, step limits, checks, momentum budget
//! build, solver  makes all of it from a set-up; steps it
//! constants      coefficients that no case sets, listed
//! ```

pub mod space;
mod thresholds;

mod particles {
    pub mod constants;
    pub mod fields;
    pub mod forces;
    pub mod variables;
}

mod materials {
    pub mod hooke;
    pub mod hyperelastic;
}

mod neighbours {
    pub mod lists;
    pub mod material_point;
    pub mod reference;
    pub mod stencil;
}

mod boundary {
    pub mod loads;
    pub mod supports;
    pub mod walls;
}

mod formulations {
    pub mod body;
    pub mod bond_forces;
    pub mod formulation;
    pub mod pair_lanes;
    pub mod pair_law;
    pub mod reference_forces;
    pub mod rigid;
    pub mod total_lagrangian;
    pub mod updated_lagrangian;
}

mod contact {
    pub mod density_field;
    pub mod film;
    pub mod friction;
    pub mod repulsion;
    pub mod start;
    pub mod sums;
}

mod interface {
    pub mod solid_interface;
}

mod system {
    pub mod model;
    pub mod saved;
    pub mod state;
    pub mod workspace;
}

mod report {
    pub mod body_sums;
    pub mod fields;
    pub mod probes;
}

mod time {
    pub mod advance;
    pub mod checks;
    pub mod energy_budget;
    pub mod evaluate;
    pub mod limits;
    pub mod momentum_budget;
    pub mod stage;
    pub mod stage_rule;
    pub mod stepping;
    pub mod substeps;
}

mod build;
mod constants;
mod solver;

#[cfg(test)]
mod tests;

pub use constants::constants;
pub use formulations::bond_forces::TOTAL_LAGRANGIAN_LAMBDA;
pub use solver::{Built, SolidSolver, plane_solver, spatial_solver};
pub use time::limits;
