//! One fluid in several parts, each with its own particles, that give the bits of one fluid.
//!
//! The particles of all parts have one order, that of the cells of a grid over all of them, and a part owns a run of whole
//! tasks of it. Around its own particles it holds copies of those of other parts, its halo, also in that order:
//! neighbours follow each other as they do in one fluid, and every particle gathers the same sums. Sums over all
//! particles add those of tasks in pairs. What is decided for all, such as whether to build lists, follows from numbers
//! that all parts agree on.
//!
//! ```text
//! partition       which particles a part owns, and which it holds copies of
//! halo            the copies
//! redistribution  particles change their owner when lists are built
//! ```

pub mod halo;
pub mod partition;
pub mod redistribution;
