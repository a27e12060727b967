//! Cell-linked neighbour search, exact in periodic directions.

mod cells;
mod grid;
mod list;

use rayon::prelude::*;

use crate::space::Space;
use crate::space::domain::Domain;
use crate::space::tensors::SpaceVector;

pub use cells::{Cell, Ranges};
pub use grid::CellGrid;
pub use list::NeighbourList;

/// Largest distance \[m\] between corresponding positions; infinite if any is not finite.
pub fn largest_displacement<S: Space>(domain: &Domain<S>, now: &[S::Vector], then: &[S::Vector]) -> f64 {
    let squared = now
        .par_iter()
        .with_min_len(2048)
        .zip(then)
        .map(|(a, b)| {
            let d = domain.separation(a, b).norm_squared();
            if d.is_nan() { f64::INFINITY } else { d }
        })
        .reduce(|| 0.0, f64::max);
    squared.sqrt()
}

#[cfg(test)]
mod tests;
