//! Cell-linked neighbour search, exact in periodic directions.

use std::ops::Range;

use rayon::prelude::*;

use crate::space::domain::Domain;
use crate::space::tensors::SpaceVector;
use crate::space::{Plane, Space};

/// Targets per task of a list build.
const TASK: usize = 512;

/// For each target the indices of its neighbours among the sources.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct NeighbourList {
    offsets: Vec<u32>,
    indices: Vec<u32>,
}

impl NeighbourList {
    /// A list of `targets` targets without neighbours.
    pub fn empty(targets: usize) -> Self {
        Self { offsets: vec![0; targets + 1], indices: Vec::new() }
    }

    /// Neighbours of target `i`.
    #[inline]
    pub fn of(&self, i: usize) -> &[u32] {
        &self.indices[self.offsets[i] as usize..self.offsets[i + 1] as usize]
    }

    /// Number of targets.
    pub fn targets(&self) -> usize {
        self.offsets.len().saturating_sub(1)
    }

    /// Number of pairs.
    pub fn pairs(&self) -> usize {
        self.indices.len()
    }

    fn from_rows(rows: &[(Vec<u32>, Vec<u32>)]) -> Self {
        let pairs = rows.iter().map(|(_, indices)| indices.len()).sum();
        let mut list = Self { offsets: vec![0], indices: Vec::with_capacity(pairs) };
        let mut end = 0;
        for (counts, indices) in rows {
            for count in counts {
                end += count;
                list.offsets.push(end);
            }
            list.indices.extend_from_slice(indices);
        }
        list
    }
}

/// Sources binned into cells of an edge at least the search radius.
#[derive(Clone, Debug)]
pub struct CellGrid<S: Space = Plane> {
    lower: S::Vector,
    inverse_edge: S::Vector,
    counts: S::Of<usize>,
    periodic: S::Of<bool>,
    starts: Vec<u32>,
    entries: Vec<u32>,
    /// Cell of each source.
    cells: Vec<u32>,
}

impl<S: Space> Default for CellGrid<S> {
    fn default() -> Self {
        Self {
            lower: S::Vector::zeros(),
            inverse_edge: S::Vector::zeros(),
            counts: S::splat(0),
            periodic: S::splat(false),
            starts: Vec::new(),
            entries: Vec::new(),
            cells: Vec::new(),
        }
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
        let (mut lower, mut upper) = bounds::<S>(sources);
        for axis in 0..S::DIMENSIONS {
            if domain.periodic[axis] {
                (lower[axis], upper[axis]) = (domain.lower[axis], domain.upper[axis]);
            }
        }
        // One stray particle must not cost memory: cells grow until they are not many more than the sources.
        let limit = 4 * sources.len() + 64;
        let mut edge = radius;
        let mut counts = cell_counts::<S>(&(upper - lower), edge);
        while number_of_cells::<S>(counts) > limit {
            edge *= 2.0;
            counts = cell_counts::<S>(&(upper - lower), edge);
        }
        for axis in 0..S::DIMENSIONS {
            let size = upper[axis] - lower[axis];
            self.inverse_edge[axis] =
                if domain.periodic[axis] { counts[axis] as f64 / size } else { 1.0 / edge };
        }
        (self.lower, self.counts, self.periodic) = (lower, counts, domain.periodic);
        self.bin(domain, sources);
    }

    /// Counting sort by cell; within a cell sources keep their order.
    fn bin(&mut self, domain: &Domain<S>, sources: &[S::Vector]) {
        let mut cells = std::mem::take(&mut self.cells);
        cells.resize(sources.len(), 0);
        let each = cells.par_iter_mut().zip(sources).with_min_len(TASK);
        each.for_each(|(cell, x)| *cell = self.cell_index(domain, x));
        self.cells = cells;
        self.starts.clear();
        self.starts.resize(number_of_cells::<S>(self.counts) + 1, 0);
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

    /// Number of cells along each axis; cell k is in row k / columns.
    pub fn counts(&self) -> S::Of<usize> {
        self.counts
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
            let position = (x[axis] - self.lower[axis]) * self.inverse_edge[axis];
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
                ranges.ranges[ranges.count] =
                    self.starts[row + cells.start] as usize..self.starts[row + cells.end] as usize;
                ranges.count += 1;
            }
        }
        ranges
    }

    /// First cell of each row of cells that can hold neighbours of a particle in `cell`.
    fn rows(&self, cell: Cell<S>) -> impl Iterator<Item = usize> {
        let (spans, counts) = (S::axes(|axis| self.span(cell, axis)), self.counts);
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
        let rows: Vec<(Vec<u32>, Vec<u32>)> = targets
            .par_chunks(TASK)
            .enumerate()
            .map(|(task, chunk)| {
                let mut counts = Vec::with_capacity(chunk.len());
                let mut indices = Vec::with_capacity(chunk.len() * 24);
                for (k, x) in chunk.iter().enumerate() {
                    let own = left_out(task * TASK + k);
                    let before = indices.len();
                    self.collect(domain, x, sources, radius, own, &mut indices);
                    counts.push((indices.len() - before) as u32);
                }
                (counts, indices)
            })
            .collect();
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
        let cell = self.cell(x);
        let columns = self.span(cell, 0);
        for row in self.rows(cell) {
            for column in columns.iter() {
                let cell = row + column;
                for &j in &self.entries[self.starts[cell] as usize..self.starts[cell + 1] as usize] {
                    let x_ij = domain.separation(x, &sources[j as usize]);
                    if x_ij.norm_squared() < radius_squared && own != Some(j as usize) {
                        found.push(j);
                    }
                }
            }
        }
    }

    /// Cells along `axis` that can hold neighbours of a particle in `cell`.
    fn span(&self, cell: Cell<S>, axis: usize) -> Span {
        let (count, cell) = (self.counts[axis], cell.0[axis]);
        let inside = |k: i32| usize::try_from(k).unwrap_or(0).min(count - 1);
        if self.periodic[axis] {
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

    fn cell_index(&self, domain: &Domain<S>, x: &S::Vector) -> u32 {
        let x = domain.wrapped(x);
        let index = (0..S::DIMENSIONS).rev().fold(0, |index, axis| {
            let position = (x[axis] - self.lower[axis]) * self.inverse_edge[axis];
            index * self.counts[axis] + (position.max(0.0) as usize).min(self.counts[axis] - 1)
        });
        index as u32
    }
}

/// Most ranges of a neighbourhood: two for each row of cells, of which there are nine in three dimensions.
const MOST_RANGES: usize = 18;

/// Ranges of [`CellGrid::order`].
#[derive(Clone, Debug, Default)]
pub struct Ranges {
    ranges: [Range<usize>; MOST_RANGES],
    count: usize,
}

impl Ranges {
    /// Each of them.
    #[inline]
    pub fn iter(&self) -> std::slice::Iter<'_, Range<usize>> {
        self.ranges[..self.count].iter()
    }
}

/// Place of a cell of a [`CellGrid`] along each axis.
#[derive(Clone, Copy, Debug)]
pub struct Cell<S: Space>(S::Of<i32>);

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
struct Span {
    first: usize,
    length: usize,
    count: usize,
}

impl Span {
    fn iter(&self) -> impl Iterator<Item = usize> + '_ {
        (self.first..self.first + self.length).map(|k| k % self.count)
    }
}

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

fn bounds<S: Space>(positions: &[S::Vector]) -> (S::Vector, S::Vector) {
    if positions.is_empty() {
        return (S::Vector::zeros(), S::Vector::zeros());
    }
    let none = || (S::Vector::repeat(f64::INFINITY), S::Vector::repeat(f64::NEG_INFINITY));
    positions
        .par_iter()
        .with_min_len(2048)
        .fold(none, |(lower, upper): (S::Vector, S::Vector), x| (lower.inf(x), upper.sup(x)))
        .reduce(none, |a, b| (a.0.inf(&b.0), a.1.sup(&b.1)))
}

/// Cells of edge at least `edge` over `size`; at least one along each axis.
fn cell_counts<S: Space>(size: &S::Vector, edge: f64) -> S::Of<usize> {
    // Float-to-integer conversion saturates; the caller bounds the product.
    S::axes(|axis| ((size[axis] / edge).floor() as usize).max(1))
}

fn number_of_cells<S: Space>(counts: S::Of<usize>) -> usize {
    (0..S::DIMENSIONS).fold(1, |number, axis| number.saturating_mul(counts[axis]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::Vector;

    #[test]
    fn targets_beyond_the_sources_find_those_in_the_last_cell() {
        let domain: Domain =
            Domain { lower: Vector::zeros(), upper: Vector::repeat(1.0), periodic: [false; 2] };
        // 2.9 radii long: the last source lies past two whole cells and is binned in the second.
        let sources = [Vector::zeros(), Vector::new(0.29, 0.0)];
        let targets = [Vector::new(0.385, 0.0)];
        let grid = CellGrid::new(&domain, &sources, 0.1);
        assert_eq!(grid.list(&domain, &targets, &sources, 0.1).of(0), &[1]);
    }

    /// Pseudo-random positions over the box, some exactly on cell borders.
    fn scatter(domain: &Domain, n: usize, seed: u64) -> Vec<Vector> {
        let mut state = seed;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let size = domain.size();
        (0..n)
            .map(|k| {
                let (u, v) = (next(), next());
                let snap = |u: f64| if k % 3 == 0 { (u * 10.0).floor() / 10.0 } else { u };
                domain.lower + Vector::new(snap(u) * size.x, snap(v) * size.y)
            })
            .collect()
    }

    fn brute_force(
        domain: &Domain,
        targets: &[Vector],
        sources: &[Vector],
        radius: f64,
        own: bool,
    ) -> Vec<Vec<u32>> {
        targets
            .iter()
            .enumerate()
            .map(|(i, x)| {
                (0..sources.len())
                    .filter(|j| !(own && *j == i))
                    .filter(|j| domain.separation(x, &sources[*j]).norm_squared() < radius * radius)
                    .map(|j| j as u32)
                    .collect()
            })
            .collect()
    }

    fn sorted_rows(list: &NeighbourList) -> Vec<Vec<u32>> {
        (0..list.targets())
            .map(|i| {
                let mut row = list.of(i).to_vec();
                row.sort_unstable();
                row
            })
            .collect()
    }

    #[test]
    fn lists_equal_brute_force_also_on_cell_borders_and_across_periodic_sides() {
        for periodic in [[false, false], [true, false], [false, true], [true, true]] {
            let domain: Domain =
                Domain { lower: Vector::new(-0.3, 0.2), upper: Vector::new(0.7, 1.2), periodic };
            for (seed, radius) in [(1, 0.1), (2, 0.23), (3, 0.49), (4, 0.03)] {
                let positions = scatter(&domain, 300, seed);
                let others = scatter(&domain, 150, seed + 100);
                let grid = CellGrid::new(&domain, &positions, radius);
                let list = grid.list_among(&domain, &positions, radius);
                assert_eq!(sorted_rows(&list), brute_force(&domain, &positions, &positions, radius, true));
                let list = grid.list(&domain, &others, &positions, radius);
                assert_eq!(sorted_rows(&list), brute_force(&domain, &others, &positions, radius, false));
            }
        }
    }

    #[test]
    fn targets_outside_the_sources_are_found() {
        let domain: Domain =
            Domain { lower: Vector::zeros(), upper: Vector::new(1.0, 1.0), periodic: [false; 2] };
        let sources = [Vector::new(0.5, 0.5), Vector::new(0.55, 0.5)];
        let targets =
            [Vector::new(0.41, 0.5), Vector::new(0.64, 0.5), Vector::new(-9.0, 0.5), Vector::new(0.5, 7.0)];
        let grid = CellGrid::new(&domain, &sources, 0.1);
        let list = grid.list(&domain, &targets, &sources, 0.1);
        assert_eq!(sorted_rows(&list), brute_force(&domain, &targets, &sources, 0.1, false));
        assert_eq!(list.of(0), [0]);
    }

    #[test]
    fn a_stray_particle_does_not_cost_memory() {
        let domain: Domain =
            Domain { lower: Vector::zeros(), upper: Vector::new(1.0, 1.0), periodic: [false; 2] };
        let mut positions = scatter(&domain, 100, 9);
        positions.push(Vector::new(1e12, -1e9));
        let grid = CellGrid::new(&domain, &positions, 0.05);
        assert!(grid.starts.len() < 1000);
        let list = grid.list_among(&domain, &positions, 0.05);
        assert_eq!(sorted_rows(&list), brute_force(&domain, &positions, &positions, 0.05, true));
    }

    #[test]
    fn lists_have_the_same_order_on_any_number_of_threads() {
        let domain: Domain =
            Domain { lower: Vector::zeros(), upper: Vector::new(1.0, 1.0), periodic: [true, false] };
        let positions = scatter(&domain, 3000, 5);
        let build = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| CellGrid::new(&domain, &positions, 0.05).list_among(&domain, &positions, 0.05))
        };
        assert_eq!(build(1), build(4));
    }

    #[test]
    fn cell_order_is_a_permutation_that_keeps_rows_together() {
        let domain: Domain =
            Domain { lower: Vector::zeros(), upper: Vector::new(1.0, 1.0), periodic: [false; 2] };
        let positions = scatter(&domain, 500, 6);
        let order = CellGrid::new(&domain, &positions, 0.2).order().to_vec();
        let mut seen = order.clone();
        seen.sort_unstable();
        assert_eq!(seen, (0..500).collect::<Vec<_>>());
        let lower = bounds::<Plane>(&positions).0.y;
        let rows: Vec<i64> = order
            .iter()
            .map(|k| ((positions[*k as usize].y - lower) * (1.0 / 0.2)).floor().min(3.0) as i64)
            .collect();
        assert!(rows.is_sorted());
    }
}
