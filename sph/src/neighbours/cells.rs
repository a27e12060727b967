//! Cells of a grid, and those around one of them.

use std::ops::Range;

use crate::space::domain::Domain;
use crate::space::tensors::SpaceVector;
use crate::space::{Plane, Space};

/// Most ranges of a neighbourhood: two for each row of cells, of which there are nine in three dimensions.
const MOST_RANGES: usize = 18;

/// Ranges of [`super::CellGrid::order`].
#[derive(Clone, Debug, Default)]
pub struct Ranges {
    ranges: [Range<usize>; MOST_RANGES],
    count: usize,
}

impl Ranges {
    /// Adds `range`, one of at most [`MOST_RANGES`].
    #[inline]
    pub(super) fn push(&mut self, range: Range<usize>) {
        self.ranges[self.count] = range;
        self.count += 1;
    }

    /// Each of them.
    #[inline]
    pub fn iter(&self) -> std::slice::Iter<'_, Range<usize>> {
        self.ranges[..self.count].iter()
    }
}

/// Place of a cell of a [`super::CellGrid`] along each axis.
#[derive(Clone, Copy, Debug)]
pub struct Cell<S: Space>(pub(super) S::Of<i32>);

impl<S: Space> PartialEq for Cell<S> {
    fn eq(&self, other: &Self) -> bool {
        (0..S::DIMENSIONS).all(|axis| self.0[axis] == other.0[axis])
    }
}

impl<S: Space> Cell<S> {
    /// Place along each axis.
    pub fn place(self) -> S::Of<i32> {
        self.0
    }
}

/// A run of cells along one axis, wrapping at `count`.
#[derive(Clone, Copy, Debug)]
pub struct Span {
    /// The first cell, not wrapped yet.
    pub first: usize,
    /// Number of cells in the run.
    pub length: usize,
    /// Number of cells along the axis.
    pub count: usize,
}

impl Span {
    /// Each cell of the run.
    #[inline]
    pub fn iter(self) -> impl Iterator<Item = usize> {
        (self.first..self.first + self.length).map(move |k| k % self.count)
    }
}

/// A box divided into cells of an edge at least the search radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cells<S: Space = Plane> {
    pub(super) lower: S::Vector,
    pub(super) inverse_edge: S::Vector,
    pub(super) counts: S::Of<usize>,
    pub(super) periodic: S::Of<bool>,
}

impl<S: Space> Default for Cells<S> {
    fn default() -> Self {
        Self {
            lower: S::Vector::zeros(),
            inverse_edge: S::Vector::zeros(),
            counts: S::splat(0),
            periodic: S::splat(false),
        }
    }
}

impl<S: Space> Cells<S> {
    /// Cells around `number` sources with the `bounds` \[m\] of [`super::bounds`], for searches within `radius` \[m\].
    ///
    /// A periodic direction must measure at least 2·`radius`, so that a pair meets through one image only.
    pub fn new(domain: &Domain<S>, bounds: [S::Vector; 2], number: usize, radius: f64) -> Self {
        let [mut lower, mut upper] = bounds;
        if number == 0 {
            (lower, upper) = (S::Vector::zeros(), S::Vector::zeros());
        }
        for axis in 0..S::DIMENSIONS {
            if domain.periodic[axis] {
                (lower[axis], upper[axis]) = (domain.lower[axis], domain.upper[axis]);
            }
        }
        // One stray particle must not cost memory: cells grow until they are not many more than the sources.
        let limit = 4 * number + 64;
        let mut edge = radius;
        let mut counts = cell_counts::<S>(&(upper - lower), edge);
        while number_of_cells::<S>(counts) > limit {
            edge *= 2.0;
            counts = cell_counts::<S>(&(upper - lower), edge);
        }
        let mut inverse_edge = S::Vector::zeros();
        for axis in 0..S::DIMENSIONS {
            let size = upper[axis] - lower[axis];
            inverse_edge[axis] = if domain.periodic[axis] { counts[axis] as f64 / size } else { 1.0 / edge };
        }
        Self { lower, inverse_edge, counts, periodic: domain.periodic }
    }

    /// Number of cells along each axis; they follow each other along x, then along each further axis.
    pub fn counts(&self) -> S::Of<usize> {
        self.counts
    }

    /// Lower corner of the first cell \[m\].
    pub fn lower(&self) -> S::Vector {
        self.lower
    }

    /// Edge of the cells along `axis` \[m\]; the last one may be up to twice as long.
    pub fn edge(&self, axis: usize) -> f64 {
        1.0 / self.inverse_edge[axis]
    }

    /// Place of cell `index` along each axis.
    pub fn place(&self, index: u32) -> S::Of<usize> {
        let mut rest = index as usize;
        S::axes(|axis| {
            let place = rest % self.counts[axis];
            rest /= self.counts[axis];
            place
        })
    }

    /// Along which axes the first cell is next to the last.
    pub fn periodic(&self) -> S::Of<bool> {
        self.periodic
    }

    /// Number of all cells.
    pub fn number(&self) -> usize {
        number_of_cells::<S>(self.counts)
    }

    /// The cell of the source at `x` \[m\]; one outside belongs to the nearest.
    pub fn index(&self, domain: &Domain<S>, x: &S::Vector) -> u32 {
        let x = domain.wrapped(x);
        let index = (0..S::DIMENSIONS).rev().fold(0, |index, axis| {
            let position = (x[axis] - self.lower[axis]) * self.inverse_edge[axis];
            index * self.counts[axis] + (position.max(0.0) as usize).min(self.counts[axis] - 1)
        });
        index as u32
    }
}

/// Cells of edge at least `edge` over `size`; at least one along each axis.
fn cell_counts<S: Space>(size: &S::Vector, edge: f64) -> S::Of<usize> {
    // Float-to-integer conversion saturates; the caller bounds the product.
    S::axes(|axis| ((size[axis] / edge).floor() as usize).max(1))
}

fn number_of_cells<S: Space>(counts: S::Of<usize>) -> usize {
    (0..S::DIMENSIONS).fold(1, |number, axis| number.saturating_mul(counts[axis]))
}
