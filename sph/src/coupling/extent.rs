//! Where particles are, coarsely: what decides who is sent to the partner.

use rayon::prelude::*;

use crate::coupling::exchange::Extent;
use crate::space::domain::Domain;
use crate::space::{DIMENSIONS, Vector};

/// Keeps the extent of one side's particles, renewed with its neighbour lists.
#[derive(Clone, Debug)]
pub struct ExtentTracker {
    domain: Domain,
    cell: f64,
    extent: Extent,
}

impl ExtentTracker {
    /// A tracker that describes particles by boxes made of cells of edge `cell` \[m\].
    pub fn new(domain: &Domain, cell: f64) -> Self {
        Self { domain: *domain, cell, extent: Extent::default() }
    }

    /// Describes `positions`, each free to move by `slack` \[m\] until the next update.
    pub fn update(&mut self, positions: &[Vector], slack: f64) {
        let corners = merged_boxes(&self.occupied(positions), &self.domain.lower, self.cell, slack);
        let boxes = corners.iter().map(|(lower, upper)| [lower.x, lower.y, upper.x, upper.y]).collect();
        if boxes != self.extent.boxes {
            self.extent = Extent { version: self.extent.version + 1, boxes };
        }
    }

    /// The extent as of the last update.
    pub fn extent(&self) -> &Extent {
        &self.extent
    }

    /// Whether particles sent for being within `reach` \[m\] of the `known` extent include all within `support`
    /// \[m\] of any of `positions`.
    ///
    /// # Errors
    /// The missing reach \[m\].
    pub fn shortfall(
        &self,
        known: &Extent,
        positions: &[Vector],
        support: f64,
        reach: f64,
    ) -> Result<(), f64> {
        let outside = if known.version == self.extent.version {
            // Nothing moves by more than the slack between updates.
            0.0
        } else {
            positions
                .par_iter()
                .with_min_len(512)
                .map(|x| gap(&self.domain, known, x))
                .reduce(|| 0.0, f64::max)
        };
        let missing = outside + support - reach;
        if missing > 0.0 { Err(missing) } else { Ok(()) }
    }

    /// Occupied cells as (row, column), sorted.
    fn occupied(&self, positions: &[Vector]) -> Vec<(i64, i64)> {
        // Saturating conversions: positions are finite, and a stray one only makes a far box.
        let cell_of = |x: &Vector| {
            let k = (self.domain.wrapped(x) - self.domain.lower) / self.cell;
            (k.y.floor() as i64, k.x.floor() as i64)
        };
        let mut cells: Vec<(i64, i64)> = positions.iter().map(cell_of).collect();
        cells.sort_unstable();
        cells.dedup();
        cells
    }
}

/// Distance \[m\] from `x` to the nearest box of `extent`; zero inside, infinite without boxes.
fn gap(domain: &Domain, extent: &Extent, x: &Vector) -> f64 {
    corners(extent).map(|(lower, upper)| box_gap(domain, &lower, &upper, x)).fold(f64::INFINITY, f64::min)
}

/// Lower and upper corner of each box of `extent`.
fn corners(extent: &Extent) -> impl Iterator<Item = (Vector, Vector)> {
    extent.boxes.quantities::<[f64; 4]>().map(|[x0, y0, x1, y1]| (Vector::new(x0, y0), Vector::new(x1, y1)))
}

fn box_gap(domain: &Domain, lower: &Vector, upper: &Vector, x: &Vector) -> f64 {
    let from_centre = domain.separation(x, &(0.5 * (lower + upper))).abs();
    (from_centre - 0.5 * (upper - lower)).sup(&Vector::zeros()).norm()
}

/// Cells joined to runs along x, runs of equal columns joined along y, each grown by `slack`.
fn merged_boxes(cells: &[(i64, i64)], origin: &Vector, cell: f64, slack: f64) -> Vec<(Vector, Vector)> {
    // (first row, last row, first column, last column)
    let mut blocks: Vec<(i64, i64, i64, i64)> = Vec::new();
    let mut row_start = 0;
    let mut above = 0;
    let mut k = 0;
    while k < cells.len() {
        let (row, first) = cells[k];
        let mut last = first;
        while k + 1 < cells.len() && cells[k + 1] == (row, last + 1) {
            last += 1;
            k += 1;
        }
        k += 1;
        if blocks.get(row_start).is_some_and(|block| block.1 != row) {
            above = row_start;
            row_start = blocks.len();
        }
        let matching = blocks[above..row_start]
            .iter()
            .position(|b| b.1 == row - 1 && (b.2, b.3) == (first, last))
            .map(|position| above + position);
        match matching {
            // The grown block takes the place of the run, so that later rows see it beside this row's runs.
            Some(position) => {
                let grown = blocks.remove(position);
                row_start -= 1;
                blocks.push((grown.0, row, first, last));
            }
            None => blocks.push((row, row, first, last)),
        }
    }
    let corner = |row: i64, column: i64| origin + Vector::new(column as f64, row as f64) * cell;
    let slack = Vector::repeat(slack);
    blocks
        .into_iter()
        .map(|(row, last_row, column, last_column)| {
            (corner(row, column) - slack, corner(last_row + 1, last_column + 1) + slack)
        })
        .collect()
}

/// Answers quickly whether a position lies within reach of the partner's extent.
#[derive(Clone, Debug)]
pub struct ReachMap {
    domain: Domain,
    extent: Extent,
    reach: f64,
    lower: Vector,
    cell: f64,
    counts: [usize; DIMENSIONS],
    marks: Vec<Mark>,
    /// Corners of a box outside which nothing is within reach; without bound along periodic directions.
    bounds: (Vector, Vector),
}

/// Which positions of a cell are within reach.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Mark {
    None,
    Some,
    All,
}

/// Cells of the map at most: 1 MiB.
const LARGEST_MAP: usize = 1 << 20;

impl ReachMap {
    /// A map over `domain` with cells of edge about `cell` \[m\].
    pub fn new(domain: &Domain, cell: f64) -> Self {
        let size = domain.size();
        let mut cell = cell;
        let count = |axis: usize, cell: f64| ((size[axis] / cell).ceil() as usize).max(1);
        while count(0, cell).saturating_mul(count(1, cell)) > LARGEST_MAP {
            cell *= 2.0;
        }
        let counts = [count(0, cell), count(1, cell)];
        Self {
            domain: *domain,
            extent: Extent::default(),
            reach: -1.0,
            lower: domain.lower,
            cell,
            counts,
            marks: vec![Mark::None; counts[0] * counts[1]],
            bounds: (Vector::repeat(f64::NEG_INFINITY), Vector::repeat(f64::INFINITY)),
        }
    }

    /// Marks what lies within `reach` \[m\] of `extent`; does nothing, and says so, when both are unchanged.
    pub fn update(&mut self, extent: &Extent, reach: f64) -> bool {
        if *extent == self.extent && reach == self.reach {
            return false;
        }
        self.extent.clone_from(extent);
        self.reach = reach;
        self.bounds = bounds_of(extent, reach, &self.domain);
        let half_diagonal = self.cell * std::f64::consts::FRAC_1_SQRT_2;
        let (domain, lower, cell, columns) = (&self.domain, &self.lower, self.cell, self.counts[0]);
        self.marks.par_iter_mut().with_min_len(1024).enumerate().for_each(|(k, mark)| {
            let (row, column) = (k / columns, k % columns);
            let centre = lower + Vector::new(column as f64 + 0.5, row as f64 + 0.5) * cell;
            let gap = gap(domain, extent, &centre);
            *mark = if gap > reach + half_diagonal {
                Mark::None
            } else if gap < reach - half_diagonal {
                Mark::All
            } else {
                Mark::Some
            };
        });
        true
    }

    /// Whether `x` lies within reach.
    #[inline]
    pub fn contains(&self, x: &Vector) -> bool {
        let (lower, upper) = &self.bounds;
        // Most of a large fluid is far from a small solid.
        (0..DIMENSIONS).all(|axis| lower[axis] <= x[axis] && x[axis] <= upper[axis]) && self.looked_up(x)
    }

    fn looked_up(&self, x: &Vector) -> bool {
        let x = self.domain.wrapped(x);
        let k = (x - self.lower) / self.cell;
        let inside = (0..DIMENSIONS).all(|axis| k[axis] >= 0.0 && k[axis] < self.counts[axis] as f64);
        let mark = if inside { self.marks[k.y as usize * self.counts[0] + k.x as usize] } else { Mark::Some };
        match mark {
            Mark::None => false,
            Mark::Some => gap(&self.domain, &self.extent, &x) <= self.reach,
            Mark::All => true,
        }
    }
}

/// Box around all that lies within `reach` of `extent`, without bound along periodic directions.
fn bounds_of(extent: &Extent, reach: f64, domain: &Domain) -> (Vector, Vector) {
    let mut bounds = (Vector::repeat(f64::INFINITY), Vector::repeat(f64::NEG_INFINITY));
    for (lower, upper) in corners(extent) {
        // A little more than the reach: distances are rounded.
        bounds.0 = bounds.0.inf(&lower.add_scalar(-1.001 * reach));
        bounds.1 = bounds.1.sup(&upper.add_scalar(1.001 * reach));
    }
    for axis in (0..DIMENSIONS).filter(|axis| domain.periodic[*axis]) {
        (bounds.0[axis], bounds.1[axis]) = (f64::NEG_INFINITY, f64::INFINITY);
    }
    bounds
}

#[cfg(test)]
mod tests {
    use super::*;

    fn domain(periodic: [bool; 2]) -> Domain {
        Domain { lower: Vector::zeros(), upper: Vector::new(2.0, 1.0), periodic }
    }

    fn block(lower: Vector, columns: usize, rows: usize, spacing: f64) -> Vec<Vector> {
        (0..columns * rows)
            .map(|k| lower + Vector::new((k % columns) as f64 + 0.5, (k / columns) as f64 + 0.5) * spacing)
            .collect()
    }

    #[test]
    fn a_solid_block_becomes_one_box_and_two_blocks_two() {
        let mut tracker = ExtentTracker::new(&domain([false; 2]), 0.1);
        let mut positions = block(Vector::new(0.2, 0.3), 10, 8, 0.05);
        tracker.update(&positions, 0.01);
        assert_eq!(tracker.extent().boxes.len(), 1);
        let (lower, upper) = corners(tracker.extent()).next().unwrap();
        assert!((lower - Vector::new(0.19, 0.29)).norm() < 1e-12);
        assert!((upper - Vector::new(0.71, 0.71)).norm() < 1e-12);
        positions.extend(block(Vector::new(1.5, 0.0), 2, 20, 0.05));
        tracker.update(&positions, 0.01);
        assert_eq!(tracker.extent().version, 2);
        let inside = positions.iter().all(|x| gap(&domain([false; 2]), tracker.extent(), x) == 0.0);
        assert!(inside);
        let area: f64 = corners(tracker.extent())
            .map(|(lower, upper)| (upper.x - lower.x - 0.02) * (upper.y - lower.y - 0.02))
            .sum();
        // 5 x 4 cells and 1 x 10 cells of 0.01 m²: nothing doubled, nothing lost.
        assert!((area - 0.30).abs() < 1e-9, "{area}");
    }

    #[test]
    fn the_map_agrees_with_distances_also_across_periodic_sides() {
        for periodic in [[false, false], [true, false]] {
            let domain = domain(periodic);
            let mut tracker = ExtentTracker::new(&domain, 0.1);
            tracker.update(&block(Vector::new(0.0, 0.4), 2, 2, 0.05), 0.0);
            let mut map = ReachMap::new(&domain, 0.07);
            map.update(tracker.extent(), 0.25);
            let mut found = 0;
            for k in 0..2000 {
                let x = Vector::new(f64::from(k % 50) * 0.04 + 0.003, f64::from(k / 50) * 0.025 + 0.001);
                let expected = gap(&domain, tracker.extent(), &x) <= 0.25;
                assert_eq!(map.contains(&x), expected, "{x}");
                found += usize::from(expected);
            }
            assert!(found > 50);
            assert_eq!(map.contains(&Vector::new(1.95, 0.45)), periodic[0]);
        }
    }

    #[test]
    fn a_particle_beyond_the_known_extent_is_a_shortfall() {
        let domain = domain([false; 2]);
        let mut tracker = ExtentTracker::new(&domain, 0.1);
        let mut positions = block(Vector::new(0.5, 0.5), 4, 4, 0.05);
        tracker.update(&positions, 0.0);
        let known = tracker.extent().clone();
        assert_eq!(tracker.shortfall(&known, &positions, 0.1, 0.12), Ok(()));
        assert!(tracker.shortfall(&known, &positions, 0.13, 0.12).is_err());
        positions.push(Vector::new(0.75, 0.55));
        tracker.update(&positions, 0.0);
        let missing = tracker.shortfall(&known, &positions, 0.1, 0.12).unwrap_err();
        assert!((missing - 0.03).abs() < 1e-12, "{missing}");
    }
}
