//! Nodes of a regular grid over the fluid, on which particles are summed with cubic B-splines.
//!
//! The weights of a particle on the nodes sum to one, so that a sum over all nodes is that over all particles. Nodes are
//! kept along each axis only where there is fluid, so that one stray particle does not cost memory.

use std::ops::Range;

use sph::neighbours::CellGrid;
use sph::space::Space;
use sph::space::domain::Domain;

/// Nodes along each axis on which a particle has a weight.
const STENCIL: usize = 4;

/// Cells without fluid, next to those with fluid, whose nodes are kept: two hold all that has a weight on nodes on which
/// fluid has one.
const RINGS: usize = 2;

/// By how much the nodes move along the first axis from one placement to the next, in spacings of theirs.
const STEP: f64 = 0.01;

/// Nodes beyond the kept cells and beyond the box along a periodic axis: those of a stencil, one for particles that have
/// left the box since the lists were built, and one by which the nodes may have moved.
const MARGIN: usize = STENCIL + 1;

/// The nodes.
#[derive(Clone, Debug, Default)]
pub struct BackgroundGrid {
    axes: Vec<Axis>,
    /// Volume of the cell of a node, in the plane per depth \[m²\].
    node_volume: f64,
    /// Number of the placement.
    placement: u64,
    /// Fluid particles whose nodes do not overlap those of others in the same list.
    bands: [Vec<Band>; 2],
}

/// Nodes along one axis.
#[derive(Clone, Debug)]
struct Axis {
    /// Place of node 0 \[m\], whether it is kept or not.
    origin: f64,
    inverse_spacing: f64,
    /// Lower end of the first cell in `shifts` \[m\].
    lower: f64,
    inverse_edge: f64,
    /// Index of a kept node, less the number of the node, for each cell; `None` where no fluid is near.
    shifts: Vec<Option<i64>>,
    /// Number of kept nodes.
    count: usize,
    /// Distance between the indices of kept nodes that follow each other.
    stride: usize,
    /// Number of nodes in a period.
    period: Option<usize>,
}

/// Fluid particles of some rows of cells.
#[derive(Clone, Debug)]
struct Band {
    particles: Range<usize>,
    /// The nodes on which they have weights, and others.
    nodes: Range<usize>,
}

/// Weights of a particle.
#[derive(Clone, Copy, Debug)]
pub struct Stencil<S: Space> {
    /// The first of its nodes.
    first: usize,
    /// Weights along each axis.
    weights: S::Of<[f64; STENCIL]>,
}

impl BackgroundGrid {
    /// Places nodes of about `spacing` \[m\] for the fluid in `cells`, whose particles move by at most `farthest` \[m\]
    /// before they are placed again, for the time number `placement`.
    ///
    /// From one placement to the next the nodes move by a hundredth of their spacing: no row of particles keeps its
    /// place among them, and what they read changes as slowly as by the flow. Nodes that jump make noise.
    pub fn place<S: Space>(
        &mut self,
        domain: &Domain<S>,
        cells: &CellGrid<S>,
        spacing: f64,
        farthest: f64,
        placement: u64,
    ) {
        self.axes.clear();
        (self.node_volume, self.placement) = (1.0, placement);
        self.bands.iter_mut().for_each(Vec::clear);
        if cells.order().is_empty() {
            return;
        }
        let mut stride = 1;
        for axis in 0..S::DIMENSIONS {
            // The ratio of the steps along the axes is irrational: in time the nodes visit all places.
            let step = STEP * std::f64::consts::SQRT_2.powi(-(axis as i32));
            let origin = domain.lower[axis] - spacing * (step * (placement % (1 << 32)) as f64).fract();
            let placed = if domain.periodic[axis] {
                Axis::periodic(origin, domain.upper[axis] - domain.lower[axis], spacing, stride)
            } else {
                let (occupied, lower) = (occupied(cells, axis), cells.lower()[axis]);
                Axis::open(&occupied, [origin, lower], cells.edge(axis), spacing, stride)
            };
            stride *= placed.count;
            self.node_volume /= placed.inverse_spacing;
            self.axes.push(placed);
        }
        self.divide(cells, farthest);
    }

    /// Divides the fluid into bands of rows of cells along the last axis, so high that every other one has nodes of
    /// its own.
    fn divide<S: Space>(&mut self, cells: &CellGrid<S>, farthest: f64) {
        let last = S::DIMENSIONS - 1;
        let (lower, edge, rows) = (cells.lower()[last], cells.edge(last), cells.counts()[last]);
        let axis = &self.axes[last];
        let row_cells = (0..last).map(|axis| cells.counts()[axis]).product::<usize>();
        let particles =
            |row: usize| cells.of_cell(row * row_cells).start..cells.of_cell((row + 1) * row_cells - 1).end;
        // A stencil reaches two spacings to either side; one more, as nodes are whole numbers.
        let apart = (STENCIL + 1) as f64 / axis.inverse_spacing + 2.0 * farthest;
        let height = (apart / edge).ceil() as usize;
        for (band, first) in (0..rows).step_by(height).enumerate() {
            let mut filled = (first..rows.min(first + height)).filter(|row| !particles(*row).is_empty());
            let Some(lowest) = filled.next() else { continue };
            let highest = filled.next_back().unwrap_or(lowest);
            // The last row is up to twice as high.
            let end = if highest + 1 == rows { rows + 1 } else { highest + 1 };
            let bottom = axis.node(lower + edge * lowest as f64 - farthest);
            let top = axis.node(lower + edge * end as f64 + farthest);
            let shift = |row: usize| axis.shift(lower + edge * (row as f64 + 0.5)).unwrap_or_default();
            let start = (bottom - 1 + shift(lowest)).max(0) as usize;
            let end = ((top + STENCIL as i64 - 1 + shift(highest)) as usize).min(axis.count);
            let nodes = start * axis.stride..end * axis.stride;
            self.bands[band % 2]
                .push(Band { particles: particles(lowest).start..particles(highest).end, nodes });
        }
    }

    /// Number of the placement: nodes of the same one have the same places.
    pub fn placement(&self) -> u64 {
        self.placement
    }

    /// Number of kept nodes.
    pub fn len(&self) -> usize {
        self.axes.last().map_or(0, |axis| axis.count * axis.stride)
    }

    /// Volume of the cell of a node, in the plane per depth \[m²\].
    pub fn node_volume(&self) -> f64 {
        self.node_volume
    }

    /// Bytes in use.
    pub fn bytes(&self) -> usize {
        let bands = self.bands.iter().map(Vec::capacity).sum::<usize>();
        let shifts = self.axes.iter().map(|axis| axis.shifts.capacity()).sum::<usize>();
        size_of::<Band>() * bands + size_of::<Option<i64>>() * shifts
    }

    /// Weights of a particle at `x` \[m\], inside the box along periodic axes; `None` where no fluid is near.
    #[inline(always)]
    pub fn stencil<S: Space>(&self, x: &S::Vector) -> Option<Stencil<S>> {
        let mut first = 0;
        // A loop: the closure of `S::axes` is not compiled into it.
        let mut weights = S::splat([0.0; STENCIL]);
        for axis in 0..S::DIMENSIONS {
            let nodes = &self.axes[axis];
            let position = (x[axis] - nodes.origin) * nodes.inverse_spacing;
            let below = floor(position);
            first += (below - 1 + nodes.shift(x[axis])?) as usize * nodes.stride;
            weights[axis] = cubic(position - below as f64);
        }
        Some(Stencil { first, weights })
    }

    /// Calls `row` with the first of [`STENCIL`] nodes that follow each other along the first axis, and the product of
    /// the weights along the others, for all nodes of `stencil`.
    #[inline(always)]
    fn for_each_row<S: Space>(&self, stencil: &Stencil<S>, mut row: impl FnMut(usize, f64)) {
        let mut strides = S::splat(0);
        for axis in 1..S::DIMENSIONS {
            strides[axis] = self.axes[axis].stride;
        }
        for k in 0..STENCIL.pow(S::DIMENSIONS as u32 - 1) {
            let (mut node, mut weight, mut rest) = (stencil.first, 1.0, k);
            for axis in 1..S::DIMENSIONS {
                let step = rest % STENCIL;
                rest /= STENCIL;
                node += step * strides[axis];
                weight *= stencil.weights[axis][step];
            }
            row(node, weight);
        }
    }

    /// Adds `value` of a particle to `nodes`, of which the first has the index `origin`.
    #[inline(always)]
    pub fn add<S: Space>(&self, stencil: &Stencil<S>, value: f64, nodes: &mut [f64], origin: usize) {
        self.for_each_row(stencil, |first, weight| {
            let along = &mut nodes[first - origin..][..STENCIL];
            let value = value * weight;
            for (node, weight) in along.iter_mut().zip(&stencil.weights[0]) {
                *node += value * weight;
            }
        });
    }

    /// Sets all nodes on which a particle has a weight to `value`.
    pub fn set<S: Space>(&self, stencil: &Stencil<S>, value: f64, nodes: &mut [f64], origin: usize) {
        self.for_each_row(stencil, |first, _| nodes[first - origin..][..STENCIL].fill(value));
    }

    /// The mean of `nodes` by the weights of a particle.
    #[inline(always)]
    pub fn mean<S: Space>(&self, stencil: &Stencil<S>, nodes: &[f64]) -> f64 {
        let mut along = [0.0; STENCIL];
        self.for_each_row(stencil, |first, weight| {
            for (sum, node) in along.iter_mut().zip(&nodes[first..][..STENCIL]) {
                *sum += weight * node;
            }
        });
        along.iter().zip(&stencil.weights[0]).map(|(sum, weight)| sum * weight).sum()
    }

    /// Calls `work` with ranges of fluid particles that together are all, and with the nodes on which they have
    /// weights, the first of which has the index that is given beside them. The sums on a node do not depend on the
    /// number of threads.
    pub fn for_each_band(&self, nodes: &mut [f64], work: &(impl Fn(Range<usize>, &mut [f64], usize) + Sync)) {
        for bands in &self.bands {
            each_band(bands, nodes, 0, work);
        }
    }

    /// Adds up the nodes that are images of each other.
    pub fn fold(&self, nodes: &mut [f64]) {
        for axis in &self.axes {
            let Some(period) = axis.period else { continue };
            // All nodes at one place along the axis, for each of its repetitions along the later ones.
            for block in nodes.chunks_mut(axis.stride * axis.count) {
                for image in (0..MARGIN).chain(MARGIN + period..axis.count) {
                    let own = if image < MARGIN { image + period } else { image - period };
                    for k in 0..axis.stride {
                        block[own * axis.stride + k] += block[image * axis.stride + k];
                    }
                }
                for image in (0..MARGIN).chain(MARGIN + period..axis.count) {
                    let own = if image < MARGIN { image + period } else { image - period };
                    block.copy_within(own * axis.stride..(own + 1) * axis.stride, image * axis.stride);
                }
            }
        }
    }
}

impl Axis {
    /// Nodes of a periodic axis of `length` \[m\].
    fn periodic(origin: f64, length: f64, spacing: f64, stride: usize) -> Self {
        let period = (length / spacing).round().max(1.0);
        let spacing = length / period;
        Self {
            origin,
            inverse_spacing: 1.0 / spacing,
            // One cell, and one to either side for particles that have left the box since the lists were built.
            lower: origin - length,
            inverse_edge: 1.0 / length,
            shifts: vec![Some(MARGIN as i64); 3],
            count: period as usize + 2 * MARGIN,
            stride,
            period: Some(period as usize),
        }
    }

    /// Nodes near the `occupied` cells of `edge` \[m\], the first of which begins at `lower` \[m\].
    fn open(occupied: &[bool], [origin, lower]: [f64; 2], edge: f64, spacing: f64, stride: usize) -> Self {
        let mut axis = Self {
            origin,
            inverse_spacing: 1.0 / spacing,
            lower: lower - RINGS as f64 * edge,
            inverse_edge: 1.0 / edge,
            shifts: vec![None; occupied.len() + 2 * RINGS],
            count: 0,
            stride,
            period: None,
        };
        // Cell `cell` has the entry `cell + RINGS`.
        let is_near = |entry: usize| {
            occupied[entry.saturating_sub(2 * RINGS)..occupied.len().min(entry + 1)].contains(&true)
        };
        let mut entry = 0;
        while entry < axis.shifts.len() {
            let end = (entry..axis.shifts.len()).find(|entry| !is_near(*entry)).unwrap_or(axis.shifts.len());
            if end > entry {
                let first = axis.node(axis.lower + edge * entry as f64) - MARGIN as i64;
                let last = axis.node(axis.lower + edge * end as f64) + MARGIN as i64;
                axis.shifts[entry..end].fill(Some(axis.count as i64 - first));
                axis.count += (last - first + 1) as usize;
            }
            entry = end + 1;
        }
        axis
    }

    /// Number of the last node that is not beyond `x` \[m\].
    fn node(&self, x: f64) -> i64 {
        floor((x - self.origin) * self.inverse_spacing)
    }

    /// Index less number of the nodes near `x` \[m\].
    #[inline(always)]
    fn shift(&self, x: f64) -> Option<i64> {
        // Below zero the conversion gives the first cell: it is next to the box or holds no fluid.
        let cell = ((x - self.lower) * self.inverse_edge).max(-1.0);
        if cell < 0.0 { None } else { self.shifts.get(cell as usize).copied().flatten() }
    }
}

/// The largest whole number that is not above `x`; `f64::floor` is a call without the instructions of later processors.
#[inline(always)]
fn floor(x: f64) -> i64 {
    let toward_zero = x as i64;
    if toward_zero as f64 > x { toward_zero - 1 } else { toward_zero }
}

/// Whether there are particles at each place of `cells` along `axis`.
fn occupied<S: Space>(cells: &CellGrid<S>, axis: usize) -> Vec<bool> {
    let counts = cells.counts();
    let before = (0..axis).map(|axis| counts[axis]).product::<usize>();
    let all = (0..S::DIMENSIONS).map(|axis| counts[axis]).product();
    let mut occupied = vec![false; counts[axis]];
    for cell in 0..all {
        occupied[cell / before % counts[axis]] |= !cells.of_cell(cell).is_empty();
    }
    occupied
}

/// Weights on four nodes of a particle that lies the fraction `t` of the spacing behind the second: the cubic B-spline.
#[inline(always)]
fn cubic(t: f64) -> [f64; STENCIL] {
    let (u, square) = (1.0 - t, t * t);
    [
        u * u * u / 6.0,
        (4.0 - 6.0 * square + 3.0 * square * t) / 6.0,
        (1.0 + 3.0 * (t + square - square * t)) / 6.0,
        square * t / 6.0,
    ]
}

fn each_band(
    bands: &[Band],
    nodes: &mut [f64],
    origin: usize,
    work: &(impl Fn(Range<usize>, &mut [f64], usize) + Sync),
) {
    match bands {
        [] => {}
        [Band { particles, nodes: own }] => {
            work(particles.clone(), &mut nodes[own.start - origin..own.end - origin], own.start);
        }
        _ => {
            let (some, rest) = bands.split_at(bands.len() / 2);
            let middle = rest[0].nodes.start;
            let (below, above) = nodes.split_at_mut(middle - origin);
            rayon::join(|| each_band(some, below, origin, work), || each_band(rest, above, middle, work));
        }
    }
}

#[cfg(test)]
mod tests {
    use sph::space::{Plane, Vector};

    use super::*;

    fn scattered(count: usize, lower: Vector, size: Vector) -> Vec<Vector> {
        // The fractions of multiples of two irrational numbers.
        let place = |k: usize, a: f64| (k as f64 * a).fract();
        (0..count)
            .map(|k| lower + Vector::new(place(k, 0.754_878), place(k, 0.569_840)).component_mul(&size))
            .collect()
    }

    fn sorted(domain: &Domain, positions: &[Vector]) -> (CellGrid, Vec<Vector>) {
        let cells = CellGrid::new(domain, positions, 0.026);
        let sorted = cells.order().iter().map(|k| positions[*k as usize]).collect();
        (cells, sorted)
    }

    fn grid(domain: &Domain, cells: &CellGrid) -> BackgroundGrid {
        let mut grid = BackgroundGrid::default();
        grid.place::<Plane>(domain, cells, 0.013, 0.005, 77);
        grid
    }

    #[test]
    fn weights_sum_to_one_and_have_the_place_of_the_particle_as_their_mean() {
        for t in [0.0, 0.25, 0.7, 0.999] {
            let weights = cubic(t);
            let mean: f64 = weights.iter().zip(-1..).map(|(weight, k)| weight * f64::from(k)).sum();
            assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-15 && (mean - t).abs() < 1e-15, "{t}");
        }
    }

    #[test]
    fn bands_sum_what_one_particle_after_the_other_sums() {
        for periodic in [[false, false], [true, false], [false, true], [true, true]] {
            let domain = Domain { lower: Vector::new(-0.2, 0.1), upper: Vector::new(0.3, 0.8), periodic };
            let (cells, mut positions) = sorted(&domain, &scattered(700, domain.lower, domain.size()));
            let grid = grid(&domain, &cells);
            // Particles move by at most 0.005 m before the lists are rebuilt.
            for (k, x) in positions.iter_mut().enumerate() {
                let angle = k as f64;
                *x += Vector::new(angle.cos(), angle.sin()) * 0.0049;
            }
            let stencil = |i: usize| grid.stencil::<Plane>(&positions[i]).unwrap();
            let mut nodes = vec![0.0; grid.len()];
            grid.for_each_band(&mut nodes, &|particles, nodes, origin| {
                particles.for_each(|i| grid.add(&stencil(i), 1.0 + i as f64, nodes, origin));
            });
            let mut expected = vec![0.0; grid.len()];
            (0..positions.len()).for_each(|i| grid.add(&stencil(i), 1.0 + i as f64, &mut expected, 0));
            let total: f64 = nodes.iter().sum();
            assert!((total / (350.5 * 700.0) - 1.0).abs() < 1e-12, "{periodic:?}: {total}");
            let largest = nodes.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(largest < 1e-11, "{periodic:?}: {largest}");
        }
    }

    #[test]
    fn images_of_a_node_have_the_same_sum() {
        let domain = Domain { lower: Vector::zeros(), upper: Vector::new(0.5, 0.4), periodic: [true, true] };
        let (cells, positions) = sorted(&domain, &scattered(500, domain.lower, domain.size()));
        let grid = grid(&domain, &cells);
        let mut nodes = vec![0.0; grid.len()];
        for x in &positions {
            grid.add(&grid.stencil::<Plane>(x).unwrap(), 1.0, &mut nodes, 0);
        }
        grid.fold(&mut nodes);
        // Each particle reads the same sums through the opposite side.
        for x in &positions[..20] {
            let read = |x: Vector| grid.mean(&grid.stencil::<Plane>(&x).unwrap(), &nodes);
            let near = Vector::new(x.x * 0.01, x.y);
            let image = near + Vector::new(0.5, 0.0);
            assert!((read(near) / read(image) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_stray_particle_costs_no_memory() {
        let domain =
            Domain { lower: Vector::repeat(-1e4), upper: Vector::repeat(1e4), periodic: [false, false] };
        let mut positions = scattered(2000, Vector::zeros(), Vector::new(0.5, 0.4));
        let (cells, _) = sorted(&domain, &positions);
        let few = grid(&domain, &cells).len();
        positions.push(Vector::new(40.0, 0.7));
        let (cells, sorted) = sorted(&domain, &positions);
        let grid = grid(&domain, &cells);
        // Nodes for all of the box of the particles would be sixty times as many.
        assert!(grid.len() < 8 * few, "{} {few}", grid.len());
        assert!(sorted.iter().all(|x| grid.stencil::<Plane>(x).is_some()));
        assert!(grid.stencil::<Plane>(&Vector::new(20.0, 0.2)).is_none());
    }
}
