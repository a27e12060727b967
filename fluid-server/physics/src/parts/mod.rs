//! One fluid in several parts, each with its own particles, that give the bits of one fluid.
//!
//! The particles of all parts have one order, that of the cells of a grid over all of them. A part owns those of whole runs
//! of cells, in a box with a step where it was cut, and holds copies of those of other parts around it. Its neighbour lists follow that order: every
//! particle gathers the same sums as in one fluid. Sums over all particles are made of those of runs, and add them exactly,
//! so that it does not matter which part has them. What is decided for all, such as whether to build lists, follows from
//! numbers that all parts agree on.
//!
//! ```text
//! lattice         cells, and the runs of them that have one owner
//! cell_boxes      boxes of them, and how far apart they are
//! reach           how far from its own cells a part holds copies
//! cuts            where space is cut in two
//! bricks          which part owns what is where
//! balance         what the particles of each part cost
//! redistribution  particles change their owner when lists are built
//! halo            the copies
//! ```

pub mod balance;
pub mod bricks;
pub mod cell_boxes;
pub mod cuts;
pub mod halo;
pub mod lattice;
pub mod reach;
pub mod redistribution;
