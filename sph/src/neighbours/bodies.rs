//! Bodies of connected particles.

use super::grid::CellGrid;
use crate::space::Space;
use crate::space::domain::Domain;
use crate::space::tensors::SpaceVector;

/// Indices of the largest set of `positions` that links shorter than `link` \[m\] connect, in no particular order; of equal sets
/// that of the lowest index.
///
/// A periodic direction must measure at least 2·`link`.
pub fn largest_body<S: Space>(domain: &Domain<S>, positions: &[S::Vector], link: f64) -> Vec<u32> {
    let grid = CellGrid::new(domain, positions, link);
    let mut free = Free::new(&grid);
    let mut largest = Vec::new();
    for (seed, cell) in (0u32..).zip(grid.cells()) {
        let mut body = Vec::new();
        free.take(*cell as usize, |j| j == seed, &mut body);
        let mut next = 0;
        while let Some(&i) = body.get(next) {
            next += 1;
            let x = domain.wrapped(&positions[i as usize]);
            let linked = |j: u32| domain.separation(&x, &positions[j as usize]).norm_squared() < link * link;
            for cell in grid.cells_around(&x) {
                free.take(cell, linked, &mut body);
            }
        }
        if body.len() > largest.len() {
            largest = body;
        }
    }
    largest
}

/// Particles that belong to no body yet.
struct Free<'a, S: Space> {
    grid: &'a CellGrid<S>,
    /// Particles by cell; the free ones of a cell come first.
    order: Vec<u32>,
    /// Number of free particles of each cell.
    counts: Vec<usize>,
}

impl<'a, S: Space> Free<'a, S> {
    fn new(grid: &'a CellGrid<S>) -> Self {
        let counts = (0..grid.shape().number()).map(|k| grid.of_cell(k).len()).collect();
        Self { grid, order: grid.order().to_vec(), counts }
    }

    /// Moves the free particles of `cell` that are `wanted` to `body`.
    fn take(&mut self, cell: usize, wanted: impl Fn(u32) -> bool, body: &mut Vec<u32>) {
        let (start, count) = (self.grid.of_cell(cell).start, &mut self.counts[cell]);
        let mut k = 0;
        while k < *count {
            let j = self.order[start + k];
            if wanted(j) {
                *count -= 1;
                self.order.swap(start + k, start + *count);
                body.push(j);
            } else {
                k += 1;
            }
        }
    }
}
