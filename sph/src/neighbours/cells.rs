//! Cells of a grid around one of them.

use std::ops::Range;

use crate::space::Space;

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
    pub fn iter(&self) -> impl Iterator<Item = usize> + '_ {
        (self.first..self.first + self.length).map(|k| k % self.count)
    }
}
