//! Who is near whom: lists with a skin, and the batches in which they are read.

pub mod batch;
pub mod drift;
pub mod lists;
pub mod rows;
pub mod scene;
