//! Neighbour lists with a skin, and the batches in which pair sums read them.

pub mod background_grid;
pub mod batch;
pub mod drift;
pub mod lists;
pub mod placement;
pub mod rows;
pub mod scene;
