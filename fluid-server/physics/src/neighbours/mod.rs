//! Neighbour lists with a skin, and the batches in which pair sums read them.

pub mod batch;
pub mod drift;
pub mod lists;
pub mod rows;
pub mod scene;
