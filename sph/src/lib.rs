//! Numerics that both solvers of a coupled run need.
//!
//! No I/O, no async, no protobuf. Throughout, `i` is the particle that receives, `j` its neighbour, and
//! x_ij = x_i − x_j, v_ij = v_i − v_j. Units are SI; in two dimensions extensive quantities are per metre of depth.
//! `Eq. (n)` are the equations of the source document as read in `docs/method.md`.

pub mod audit;
pub mod body_force;
pub mod domain;
pub mod driver;
pub mod equation_of_state;
pub mod exchange;
pub mod expression;
pub mod extent;
pub mod geometry;
pub mod interface;
mod iteration;
pub mod kernel;
pub mod lanes;
pub mod ledger;
mod meeting;
pub mod motion;
pub mod neighbours;
pub mod repulsion;
pub mod saved;
pub mod setup;
pub mod shapes;
pub mod solver;
pub mod stage;
pub mod sums;
pub mod vector;
