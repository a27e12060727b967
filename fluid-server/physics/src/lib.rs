//! The fluid: weakly compressible SPH with walls, Eq. (1)-(4), (17)-(24), (27)-(28).
//!
//! Rooms, each depending on those above it only:
//!
//! ```text
//! team/          the parts of a fluid that is computed in several: messages, and what they find together
//! system/        what exists: model, set-up, state, checkpoint form, walls, layout of particles
//! parts/         which particles a part owns, the copies of others that it holds
//! neighbours/    lists with a skin, rows, and the batches in which they are read
//! equations/     laws of a pair and of a particle: Eq. (4), (17)-(24), viscosity, corrections
//! boundary/      state of walls, Eq. (27)-(28), repulsion by walls, particles that leave
//! free_surface/  detection, particle regularisation
//! rates/         the two passes over neighbours: gradients, then rates
//! interface/     the solid partner
//! time/          the flow of a stage, movement, step limit, state scan, momentum budget
//! report/        probes, fields, wall forces
//! solver         the solver as a half-step driver sees it, of one part or of all fluid
//! lead           the parts as one solver
//! constants      coefficients that no case sets, listed
//! ```
//!
//! How the source paper is read, and its gaps filled:
//! - walls enter (17) and (23) with the velocity of Eq. (27), so that a slip wall does not drag;
//! - walls take the density gradient, L_i and viscous stress of the particle they act on, the last one mirrored
//!   where the wall slips;
//! - where a solid is the partner, `sph::interface` gives its dummy state and the pair forces, and the fluid adds it
//!   to continuity, diffusion and the gradient pass;
//! - with L_i, pairs inside the fluid and toward walls use it in (17) and (22); diffusion and artificial viscosity
//!   use the plain gradient.

mod boundary;
mod constants;
mod equations;
mod free_surface;
mod interface;
mod lead;
mod neighbours;
mod parts;
mod rates;
mod report;
mod solver;
mod system;
mod team;
mod time;

#[cfg(test)]
mod tests;

pub use constants::constants;
pub use lead::{first_part, in_threads, other_part};
pub use solver::{FluidSolver, plane_solver, spatial_solver};
pub use system::packed_particle::FluidSpace;
pub use team::transport::{Channel, Lost, Transport};
pub use team::{Team, Turn};
pub use time::step_limit::viscous_limit;
