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
    largest_distance(domain, now.len().min(then.len()), |i| (&now[i], &then[i]))
}

/// Largest distance \[m\] between the positions of each of `count` pairs; infinite if any is not finite.
pub fn largest_distance<'a, S: Space>(
    domain: &Domain<S>,
    count: usize,
    pair: impl Fn(usize) -> (&'a S::Vector, &'a S::Vector) + Sync,
) -> f64
where
    S::Vector: 'a,
{
    let squared = |k: usize| {
        let (a, b) = pair(k);
        let d = domain.separation(a, b).norm_squared();
        if d.is_nan() { f64::INFINITY } else { d }
    };
    largest(count, 2048, squared).sqrt()
}

#[cfg(test)]
mod tests;
