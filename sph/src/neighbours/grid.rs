//! Sources binned into cells.

use std::ops::Range;

use super::cells::{Cell, Cells, Ranges, Span};
use super::list::NeighbourList;
use crate::space::domain::Domain;
use crate::space::tensors::SpaceVector;
use crate::space::{Plane, Space};
use crate::tasks::{PerTask, for_each, for_each_task, per_task, reduce};

/// Targets per task of a list build.
const TASK: usize = 512;

/// Sources binned into cells of an edge at least the search radius.
#[derive(Clone, Debug)]
pub struct CellGrid<S: Space = Plane> {
    shape: Cells<S>,
    starts: Vec<u32>,
    entries: Vec<u32>,
    /// Cell of each source.
    cells: Vec<u32>,
}

impl<S: Space> Default for CellGrid<S> {
    fn default() -> Self {
        Self { shape: Cells::default(), starts: Vec::new(), entries: Vec::new(), cells: Vec::new() }
    }
}

impl<S: Space> CellGrid<S> {
    /// Bins `sources` for searches within `radius` \[m\].
    ///
    /// A periodic direction must measure at least 2·`radius`, so that a pair meets through one image only.
    pub fn new(domain: &Domain<S>, sources: &[S::Vector], radius: f64) -> Self {
        let mut grid = Self::default();
        grid.renew(domain, sources, radius);
        grid
    }

    /// Bins `sources` again as [`CellGrid::new`] does, in the same memory.
    pub fn renew(&mut self, domain: &Domain<S>, sources: &[S::Vector], radius: f64) {
        self.renew_in(Cells::new(domain, bounds::<S>(sources), sources.len(), radius), domain, sources);
    }

    /// Bins `sources` again, into the cells of `shape`.
    pub fn renew_in(&mut self, shape: Cells<S>, domain: &Domain<S>, sources: &[S::Vector]) {
        self.shape = shape;
        self.bin(domain, sources);
    }

    /// The cells.
    pub fn shape(&self) -> &Cells<S> {
        &self.shape
    }

    /// Cell of each source.
    pub fn cells(&self) -> &[u32] {
        &self.cells
    }

    /// Counting sort by cell; within a cell sources keep their order.
    fn bin(&mut self, domain: &Domain<S>, sources: &[S::Vector]) {
        let mut cells = std::mem::take(&mut self.cells);
        cells.resize(sources.len(), 0);
        for_each(&mut cells[..], TASK, |k, cell| *cell = self.shape.index(domain, &sources[k]));
        self.cells = cells;
        self.starts.clear();
        self.starts.resize(self.shape.number() + 1, 0);
        for cell in &self.cells {
            self.starts[*cell as usize + 1] += 1;
        }
        for k in 1..self.starts.len() {
            self.starts[k] += self.starts[k - 1];
        }
        self.entries.resize(sources.len(), 0);
        for (source, cell) in (0u32..).zip(&self.cells) {
            let slot = &mut self.starts[*cell as usize];
            self.entries[*slot as usize] = source;
            *slot += 1;
        }
        // Each start has moved to its cell's end, where the next one starts.
        let last = self.starts.len() - 1;
        self.starts.copy_within(..last, 1);
        self.starts[0] = 0;
    }

    /// Source indices sorted by cell: cells follow each other along x, then along each further axis.
    pub fn order(&self) -> &[u32] {
        &self.entries
    }

    /// Lower corner of the first cell \[m\].
    pub fn lower(&self) -> S::Vector {
        self.shape.lower
    }

    /// Edge of the cells along `axis` \[m\]; the last one may be up to twice as long.
    pub fn edge(&self, axis: usize) -> f64 {
        1.0 / self.shape.inverse_edge[axis]
    }

    /// Number of cells along each axis; cell k is in row k / columns.
    pub fn counts(&self) -> S::Of<usize> {
        self.shape.counts
    }

    /// Range of [`CellGrid::order`] that holds the sources in cell `k`.
    #[inline]
    pub fn of_cell(&self, k: usize) -> Range<usize> {
        self.starts[k] as usize..self.starts[k + 1] as usize
    }

    /// [`CellGrid::order`], and memory for as many numbers that is free until the next sources.
    pub fn order_and_spare(&mut self) -> (&[u32], &mut Vec<u32>) {
        (&self.entries, &mut self.cells)
    }

    /// The cell of `x`, a position inside the box along periodic directions; elsewhere it may lie outside the grid.
    #[inline(always)]
    pub fn cell(&self, x: &S::Vector) -> Cell<S> {
        // Saturating conversions: a target may lie far outside the sources. They round toward zero.
        Cell(S::axes(|axis| {
            let position = (x[axis] - self.shape.lower[axis]) * self.shape.inverse_edge[axis];
            let toward_zero = position as i32;
            if f64::from(toward_zero) > position { toward_zero.saturating_sub(1) } else { toward_zero }
        }))
    }

    /// Ranges of [`CellGrid::order`] that together hold all sources that can lie within the radius of positions in
    /// `cell`; some may be empty.
    pub fn ranges(&self, cell: Cell<S>) -> Ranges {
        let mut ranges = Ranges::default();
        if self.entries.is_empty() {
            return ranges;
        }
        let columns = self.span(cell, 0);
        for row in self.rows(cell) {
            // Cells of a row follow each other; a span beyond the last column continues at the first.
            let first = columns.first % columns.count;
            let wrapped = (first + columns.length).saturating_sub(columns.count);
            for cells in [first..first + columns.length - wrapped, 0..wrapped] {
                ranges.push(self.starts[row + cells.start] as usize..self.starts[row + cells.end] as usize);
            }
        }
        ranges
    }

    /// First cell of each row of cells that can hold neighbours of a particle in `cell`.
    fn rows(&self, cell: Cell<S>) -> impl Iterator<Item = usize> {
        let (spans, counts) = (S::axes(|axis| self.span(cell, axis)), self.shape.counts);
        let rows = (1..S::DIMENSIONS).map(|axis| spans[axis].length).product();
        (0..rows).map(move |mut rest| {
            let (mut row, mut stride) = (0, counts[0]);
            for axis in 1..S::DIMENSIONS {
                let Span { first, length, count } = spans[axis];
                row += (first + rest % length) % count * stride;
                rest /= length;
                stride *= count;
            }
            row
        })
    }

    /// All sources closer than `radius` \[m\] to each target.
    ///
    /// `radius` must not exceed the one the grid was made for. The order of a target's neighbours is by cell, then
    /// by source index, and does not depend on the number of threads.
    pub fn list(
        &self,
        domain: &Domain<S>,
        targets: &[S::Vector],
        sources: &[S::Vector],
        radius: f64,
    ) -> NeighbourList {
        self.list_without(domain, targets, sources, radius, |_| None)
    }

    /// [`CellGrid::list`] of the sources themselves, none of which is a neighbour of itself.
    pub fn list_among(&self, domain: &Domain<S>, sources: &[S::Vector], radius: f64) -> NeighbourList {
        self.list_without(domain, sources, sources, radius, Some)
    }

    /// [`CellGrid::list`] that leaves out one source for each target.
    fn list_without(
        &self,
        domain: &Domain<S>,
        targets: &[S::Vector],
        sources: &[S::Vector],
        radius: f64,
        left_out: impl Fn(usize) -> Option<usize> + Sync,
    ) -> NeighbourList {
        let mut rows = Vec::new();
        for_each_task(
            targets.len(),
            TASK,
            per_task(&mut rows, targets.len(), TASK),
            &|items, PerTask(row)| {
                let (counts, indices): &mut (Vec<u32>, Vec<u32>) = &mut row[0];
                counts.reserve(items.len());
                indices.reserve(items.len() * 24);
                for i in items {
                    let before = indices.len();
                    self.collect(domain, &targets[i], sources, radius, left_out(i), indices);
                    counts.push((indices.len() - before) as u32);
                }
            },
        );
        NeighbourList::from_rows(&rows)
    }

    fn collect(
        &self,
        domain: &Domain<S>,
        x: &S::Vector,
        sources: &[S::Vector],
        radius: f64,
        own: Option<usize>,
        found: &mut Vec<u32>,
    ) {
        if sources.is_empty() {
            return;
        }
        let radius_squared = radius * radius;
        let x = &domain.wrapped(x);
        for cell in self.cells_around(x) {
            for &j in &self.entries[self.of_cell(cell)] {
                let x_ij = domain.separation(x, &sources[j as usize]);
                if x_ij.norm_squared() < radius_squared && own != Some(j as usize) {
                    found.push(j);
                }
            }
        }
    }

    /// Cells that hold all sources that can lie within the radius of `x`, a position inside the box along periodic directions.
    pub(super) fn cells_around(&self, x: &S::Vector) -> impl Iterator<Item = usize> {
        let cell = self.cell(x);
        let columns = self.span(cell, 0);
        self.rows(cell).flat_map(move |row| columns.iter().map(move |column| row + column))
    }

    /// Cells along `axis` that can hold neighbours of a particle in `cell`.
    fn span(&self, cell: Cell<S>, axis: usize) -> Span {
        let (count, cell) = (self.shape.counts[axis], cell.0[axis]);
        let inside = |k: i32| usize::try_from(k).unwrap_or(0).min(count - 1);
        if self.shape.periodic[axis] {
            if count <= 3 {
                return Span { first: 0, length: count, count };
            }
            return Span { first: inside(cell) + count - 1, length: 3, count };
        }
        let (low, high) = (cell.saturating_sub(1), cell.saturating_add(1));
        // The last cell reaches beyond `count`: sources past the whole number of cells are binned there.
        if high < 0 || usize::try_from(low).is_ok_and(|low| low > count) {
            return Span { first: 0, length: 0, count };
        }
        let (low, high) = (inside(low), inside(high));
        Span { first: low, length: high + 1 - low, count }
    }
}

/// Lowest and highest coordinate of `positions` \[m\] along each axis; infinite, and the lowest above the highest, without any.
pub fn bounds<S: Space>(positions: &[S::Vector]) -> [S::Vector; 2] {
    let none = || [S::Vector::repeat(f64::INFINITY), S::Vector::repeat(f64::NEG_INFINITY)];
    let of_task = |items: Range<usize>| {
        positions[items].iter().fold(none(), |[lower, upper], x| [lower.inf(x), upper.sup(x)])
    };
    let of_both = |a: Option<[S::Vector; 2]>, b: Option<[S::Vector; 2]>| {
        a.zip(b).map(|([lower, upper], [x, y])| [lower.inf(&x), upper.sup(&y)])
    };
    reduce(positions.len(), 2048, &|items| Some(of_task(items)), of_both).unwrap_or_else(none)
}
