//! Cell-linked neighbour search, exact in periodic directions.

mod bodies;
mod cells;
mod grid;
mod list;

use crate::space::Space;
use crate::space::domain::Domain;
use crate::space::tensors::SpaceVector;
use crate::tasks::largest;

pub use bodies::largest_body;
pub use cells::{Cell, Cells, Ranges};
pub use grid::{CellGrid, bounds};
pub use list::NeighbourList;

/// Largest distance \[m\] between corresponding positions, as many as both have; infinite if any is not finite.
pub fn largest_displacement<S: Space>(domain: &Domain<S>, now: &[S::Vector], then: &[S::Vector]) -> f64 {
    let squared = |i: usize| {
        let d = domain.separation(&now[i], &then[i]).norm_squared();
        if d.is_nan() { f64::INFINITY } else { d }
    };
    largest(now.len().min(then.len()), 2048, squared).sqrt()
}

#[cfg(test)]
mod tests;
