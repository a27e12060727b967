//! Nodes of a regular grid over the fluid, on which particles are summed with cubic B-splines.
//!
//! The weights of a particle on the nodes sum to one, so that a sum over all nodes is that over all particles. Nodes are
//! kept along each axis only where there is fluid, so that one stray particle does not cost memory.

mod transfer;

use std::ops::Range;

use sph::lanes::WIDTH;
use sph::neighbours::CellGrid;
use sph::space::Space;
use sph::space::domain::Domain;
use sph::tasks::join;

/// Nodes along each axis on which a particle has a weight: those of a row fill the lanes.
const STENCIL: usize = WIDTH;

/// By how much the nodes move along the first axis from one period to the next, in spacings of theirs.
const STEP: f64 = 0.01;

/// Nodes beyond the box along a periodic axis: those of a stencil, one for particles that have left the box since the lists
/// were built, and one by which the nodes may have moved.
const MARGIN: usize = STENCIL + 1;

/// Nodes beyond the kept cells: those of a stencil to one side, and one by which the nodes may have moved.
const OPEN_MARGIN: i64 = STENCIL as i64 / 2 + 1;

/// The nodes.
#[derive(Clone, Debug, Default)]
pub struct BackgroundGrid {
    axes: Vec<Axis>,
    /// Volume of the cell of a node, in the plane per depth \[m²\].
    node_volume: f64,
    /// Times that the nodes were placed.
    placements: u64,
    /// Fluid particles whose nodes do not overlap those of others in the same list.
    bands: [Vec<Band>; 2],
}

/// About the distance between nodes \[m\].
#[derive(Clone, Copy, Debug)]
pub struct NodeSpacings {
    /// Along an axis that is not periodic.
    pub open: f64,
    /// Along a periodic axis, whose period is a whole number of distances.
    pub periodic: f64,
}

impl NodeSpacings {
    fn along<S: Space>(self, domain: &Domain<S>, axis: usize) -> f64 {
        if domain.periodic[axis] { self.periodic } else { self.open }
    }
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
    /// Index of a kept node, less the number of the node, for each cell; `None` where no fluid is near. What has a weight
    /// on nodes on which fluid has one is near.
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

impl BackgroundGrid {
    /// Places nodes of about `spacings` for the fluid in `cells`, whose particles move by at most `farthest` \[m\]
    /// before they are placed again, in the period number `period`.
    ///
    /// From one period to the next the nodes move by a hundredth of their spacing: no row of particles keeps its
    /// place among them, and what they read changes as slowly as by the flow. Nodes that jump make noise.
    pub fn place<S: Space>(
        &mut self,
        domain: &Domain<S>,
        cells: &CellGrid<S>,
        spacings: NodeSpacings,
        farthest: f64,
        period: u64,
    ) {
        self.axes.clear();
        (self.node_volume, self.placements) = (1.0, self.placements + 1);
        self.bands.iter_mut().for_each(Vec::clear);
        if cells.order().is_empty() {
            return;
        }
        let mut stride = 1;
        for axis in 0..S::DIMENSIONS {
            let spacing = spacings.along(domain, axis);
            let origin = origin(domain, axis, spacing, period);
            let placed = if domain.periodic[axis] {
                Axis::periodic(origin, domain.upper[axis] - domain.lower[axis], spacing, stride)
            } else {
                let (occupied, lower, edge) = (occupied(cells, axis), cells.lower()[axis], cells.edge(axis));
                let rings = ((STENCIL as f64 * spacing + farthest) / edge).ceil() as usize;
                Axis::open(&occupied, rings, [origin, lower], edge, spacing, stride)
            };
            stride *= placed.count;
            self.node_volume /= placed.inverse_spacing;
            self.axes.push(placed);
        }
        self.divide(cells, farthest);
    }

    /// Moves nodes that were placed since the lists were built to their places in another `period`.
    pub fn shift<S: Space>(
        &mut self,
        domain: &Domain<S>,
        cells: &CellGrid<S>,
        spacings: NodeSpacings,
        farthest: f64,
        period: u64,
    ) {
        for (axis, nodes) in self.axes.iter_mut().enumerate() {
            nodes.origin = origin(domain, axis, spacings.along(domain, axis), period);
        }
        self.placements += 1;
        self.bands.iter_mut().for_each(Vec::clear);
        if !self.axes.is_empty() {
            self.divide(cells, farthest);
        }
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

    /// Gives back the memory; placements are counted on, so that what was summed before is known to be old.
    pub fn release(&mut self) {
        *self = Self { placements: self.placements, ..Self::default() };
    }

    /// Times that the nodes were placed: in between they keep their places.
    pub fn placements(&self) -> u64 {
        self.placements
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

    /// Calls `work` with ranges of fluid particles that together are all, and with the nodes on which they have
    /// weights, the first of which has the index that is given beside them. The sums on a node do not depend on the
    /// number of threads.
    pub fn for_each_band<T: Send>(
        &self,
        nodes: &mut [T],
        work: &(impl Fn(Range<usize>, &mut [T], usize) + Sync),
    ) {
        for bands in &self.bands {
            each_band(bands, nodes, 0, work);
        }
    }

    /// Gives nodes that are images of each other the `sum` of their values.
    pub fn fold<T: Copy>(&self, nodes: &mut [T], sum: impl Fn(T, T) -> T) {
        for axis in &self.axes {
            let Some(period) = axis.period else { continue };
            // All nodes at one place along the axis, for each of its repetitions along the later ones.
            for block in nodes.chunks_mut(axis.stride * axis.count) {
                for image in (0..MARGIN).chain(MARGIN + period..axis.count) {
                    let own = if image < MARGIN { image + period } else { image - period };
                    for k in 0..axis.stride {
                        let value = block[image * axis.stride + k];
                        let own = &mut block[own * axis.stride + k];
                        *own = sum(*own, value);
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

    /// Nodes of the `occupied` cells of `edge` \[m\], the first of which begins at `lower` \[m\], and of `rings` more to
    /// either side.
    fn open(
        occupied: &[bool],
        rings: usize,
        [origin, lower]: [f64; 2],
        edge: f64,
        spacing: f64,
        stride: usize,
    ) -> Self {
        let mut axis = Self {
            origin,
            inverse_spacing: 1.0 / spacing,
            lower: lower - rings as f64 * edge,
            inverse_edge: 1.0 / edge,
            shifts: vec![None; occupied.len() + 2 * rings],
            count: 0,
            stride,
            period: None,
        };
        // Cell `cell` has the entry `cell + rings`.
        let is_near = |entry: usize| {
            occupied[entry.saturating_sub(2 * rings)..occupied.len().min(entry + 1)].contains(&true)
        };
        let mut entry = 0;
        while entry < axis.shifts.len() {
            let end = (entry..axis.shifts.len()).find(|entry| !is_near(*entry)).unwrap_or(axis.shifts.len());
            if end > entry {
                let first = axis.node(axis.lower + edge * entry as f64) - OPEN_MARGIN;
                let last = axis.node(axis.lower + edge * end as f64) + OPEN_MARGIN;
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

/// Place of node 0 along `axis` in a period \[m\].
fn origin<S: Space>(domain: &Domain<S>, axis: usize, spacing: f64, period: u64) -> f64 {
    // The ratio of the steps along the axes is irrational: in time the nodes visit all places.
    let step = STEP * std::f64::consts::SQRT_2.powi(-(axis as i32));
    domain.lower[axis] - spacing * (step * (period % (1 << 32)) as f64).fract()
}

/// The largest whole number that is not above `x`; `f64::floor` is a call without the instructions of later processors.
#[inline(always)]
fn floor(x: f64) -> i64 {
    let toward_zero = x as i64;
    if toward_zero as f64 > x { toward_zero - 1 } else { toward_zero }
}

/// Whether there are particles at each place of `cells` along `axis`; the last, which may be up to twice as long, counts as
/// two.
fn occupied<S: Space>(cells: &CellGrid<S>, axis: usize) -> Vec<bool> {
    let counts = cells.counts();
    let before = (0..axis).map(|axis| counts[axis]).product::<usize>();
    let all = (0..S::DIMENSIONS).map(|axis| counts[axis]).product();
    let mut occupied = vec![false; counts[axis]];
    for cell in 0..all {
        occupied[cell / before % counts[axis]] |= !cells.of_cell(cell).is_empty();
    }
    occupied.extend_from_within(counts[axis] - 1..);
    occupied
}

fn each_band<T: Send>(
    bands: &[Band],
    nodes: &mut [T],
    origin: usize,
    work: &(impl Fn(Range<usize>, &mut [T], usize) + Sync),
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
            join(|| each_band(some, below, origin, work), || each_band(rest, above, middle, work));
        }
    }
}

#[cfg(test)]
mod tests;
