//! Numerics that both solvers of a coupled run need.
//!
//! No I/O, no async, no protobuf. Throughout, `i` is the particle that receives, `j` its neighbour, and
//! x_ij = x_i − x_j, v_ij = v_i − v_j. Units are SI; in two dimensions extensive quantities are per metre of depth.
//! `Eq. (n)` are the equations of the source paper as read in `docs/method.md`.
//!
//! ```text
//! space         vectors, tensors, the domain               kernel       the smoothing kernel
//! lanes         four particles at a time                   neighbours   cells and lists
//! sums          sums that do not depend on threads         expression   formulas of a case
//! shapes        regions and their particles                prescribed   body forces, motions
//! setup         what a run is built from                   laws         laws that both sides evaluate
//! interface     the pair law between fluid and solid       coupling     solver, driver, exchange, ledger
//! constants     coefficients that no case sets          fixed_constants   their list
//! tasks         parallel work on particles              random       numbers that look random
//! ```

pub mod constants;
pub mod coupling;
pub mod expression;
pub mod fixed_constants;
pub mod interface;
pub mod kernel;
pub mod lanes;
pub mod laws;
pub mod neighbours;
pub mod prescribed;
pub mod random;
pub mod setup;
pub mod shapes;
pub mod space;
pub mod sums;
pub mod tasks;
