//! Where particles are, coarsely: what decides who is sent to the partner.

use std::cmp::Ordering;

use serde::{Deserialize, Serialize};

use crate::coupling::exchange::{Column, Extent};
use crate::space::algebra::Algebra;
use crate::space::components::Components;
use crate::space::domain::Domain;
use crate::space::tensors::SpaceVector;
use crate::space::{Plane, Space};
use crate::tasks::{for_each, largest};

/// Keeps the extent of one side's particles, renewed with its neighbour lists.
#[derive(Clone, Debug)]
pub struct ExtentTracker<S: Space = Plane> {
    domain: Domain<S>,
    cell: f64,
    extent: Extent,
}

/// A block of cells: the first and the last along each axis.
type Block<S> = [Index<S>; 2];

/// Number of a cell along each axis.
type Index<S> = <S as Algebra>::Of<i64>;

impl<S: Space> ExtentTracker<S> {
    /// A tracker that describes particles by boxes made of cells of edge `cell` \[m\].
    pub fn new(domain: &Domain<S>, cell: f64) -> Self {
        Self { domain: *domain, cell, extent: Extent::default() }
    }

    /// Describes the particles in the cells `occupied`, as [`ExtentTracker::occupied`] returns them, each free to move
    /// by `slack` \[m\] until the next update.
    pub fn update(&mut self, occupied: &OccupiedCells, slack: f64) {
        let mut values = Vec::new();
        for [first, last] in merged_blocks::<S>(&occupied.sorted::<S>()) {
            let corner = |cells: S::Of<f64>| self.domain.lower + S::vector(cells) * self.cell;
            let (lower, upper) =
                (S::axes(|axis| first[axis] as f64), S::axes(|axis| (last[axis] + 1) as f64));
            let slack = S::Vector::repeat(slack);
            values.extend_from_slice((corner(lower) - slack).row().as_ref());
            values.extend_from_slice((corner(upper) + slack).row().as_ref());
        }
        let boxes = Column { components: 2 * S::DIMENSIONS, values };
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
        positions: &[S::Vector],
        support: f64,
        reach: f64,
    ) -> Result<(), f64> {
        let outside = if known.version == self.extent.version {
            // Nothing moves by more than the slack between updates.
            0.0
        } else {
            largest(positions.len(), 512, |i| gap(&self.domain, known, &positions[i]))
        };
        let missing = outside + support - reach;
        if missing > 0.0 { Err(missing) } else { Ok(()) }
    }

    /// The cells in which there are `positions` \[m\].
    pub fn occupied(&self, positions: &[S::Vector]) -> OccupiedCells {
        // Saturating conversions: positions are finite, and a stray one only makes a far box.
        let cell_of = |x: &S::Vector| {
            let k = (self.domain.wrapped(x) - self.domain.lower) / self.cell;
            S::axes(|axis| k[axis].floor() as i64)
        };
        let cells = sorted::<S>(positions.iter().map(cell_of).collect());
        OccupiedCells(cells.iter().flat_map(|cell| (0..S::DIMENSIONS).map(|axis| cell[axis])).collect())
    }
}

/// Cells in which there are particles: their numbers along each axis, cell by cell.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct OccupiedCells(Vec<i64>);

impl OccupiedCells {
    /// Adds those of other particles.
    pub fn join(&mut self, others: Self) {
        self.0.extend(others.0);
    }

    /// The cells by [`order`], each once.
    fn sorted<S: Space>(&self) -> Vec<Index<S>> {
        let cells = self.0.chunks_exact(S::DIMENSIONS);
        sorted::<S>(cells.map(|cell| S::axes(|axis| cell[axis])).collect())
    }
}

fn sorted<S: Space>(mut cells: Vec<Index<S>>) -> Vec<Index<S>> {
    cells.sort_unstable_by(order::<S>);
    cells.dedup_by(|a, b| order::<S>(a, b).is_eq());
    cells
}

/// Distance \[m\] from `x` to the nearest box of `extent`; zero inside, infinite without boxes.
fn gap<S: Space>(domain: &Domain<S>, extent: &Extent, x: &S::Vector) -> f64 {
    corners::<S>(extent)
        .map(|(lower, upper)| box_gap(domain, &lower, &upper, x))
        .fold(f64::INFINITY, f64::min)
}

/// Lower and upper corner of each box of `extent`.
fn corners<S: Space>(extent: &Extent) -> impl Iterator<Item = (S::Vector, S::Vector)> {
    extent.boxes.rows().filter_map(|row| {
        let (lower, upper) = row.split_at_checked(S::DIMENSIONS)?;
        Some((S::Vector::of_row(lower)?, S::Vector::of_row(upper)?))
    })
}

fn box_gap<S: Space>(domain: &Domain<S>, lower: &S::Vector, upper: &S::Vector, x: &S::Vector) -> f64 {
    let mut gap = domain.separation(x, &((*lower + *upper) * 0.5));
    for axis in 0..S::DIMENSIONS {
        gap[axis] = (gap[axis].abs() - 0.5 * (upper[axis] - lower[axis])).max(0.0);
    }
    gap.norm()
}

/// Order of cells: along x, then along each further axis.
fn order<S: Space>(a: &Index<S>, b: &Index<S>) -> Ordering {
    (0..S::DIMENSIONS).rev().fold(Ordering::Equal, |order, axis| order.then(a[axis].cmp(&b[axis])))
}

/// `cells` joined to blocks: along x, then blocks of equal sides along each further axis; by the order of their last
/// cells.
fn merged_blocks<S: Space>(cells: &[Index<S>]) -> Vec<Block<S>> {
    let mut blocks: Vec<Block<S>> = cells.iter().map(|cell| [*cell, *cell]).collect();
    for along in 0..S::DIMENSIONS {
        let across = |a: &Block<S>, b: &Block<S>| {
            let sides = (0..S::DIMENSIONS).rev().filter(|axis| *axis != along);
            sides.fold(Ordering::Equal, |order, axis| {
                order.then(a[0][axis].cmp(&b[0][axis])).then(a[1][axis].cmp(&b[1][axis]))
            })
        };
        blocks.sort_unstable_by(|a, b| across(a, b).then(a[0][along].cmp(&b[0][along])));
        blocks.dedup_by(|next, block| {
            let joined = across(next, block).is_eq() && next[0][along] == block[1][along] + 1;
            if joined {
                block[1] = next[1];
            }
            joined
        });
    }
    blocks.sort_unstable_by(|a, b| order::<S>(&a[1], &b[1]));
    blocks
}

/// Answers quickly whether a position lies within reach of the partner's extent.
#[derive(Clone, Debug)]
pub struct ReachMap<S: Space = Plane> {
    domain: Domain<S>,
    extent: Extent,
    reach: f64,
    lower: S::Vector,
    cell: f64,
    counts: S::Of<usize>,
    marks: Vec<Mark>,
    /// Corners of a box outside which nothing is within reach; without bound along periodic directions.
    bounds: (S::Vector, S::Vector),
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

impl<S: Space> ReachMap<S> {
    /// A map over `domain` with cells of edge about `cell` \[m\].
    pub fn new(domain: &Domain<S>, cell: f64) -> Self {
        let size = domain.size();
        let mut cell = cell;
        let counts = |cell: f64| S::axes(|axis| ((size[axis] / cell).ceil() as usize).max(1));
        let total = |counts: S::Of<usize>| {
            (0..S::DIMENSIONS).fold(1, |n: usize, axis| n.saturating_mul(counts[axis]))
        };
        while total(counts(cell)) > LARGEST_MAP {
            cell *= 2.0;
        }
        let counts = counts(cell);
        Self {
            domain: *domain,
            extent: Extent::default(),
            reach: -1.0,
            lower: domain.lower,
            cell,
            counts,
            marks: vec![Mark::None; total(counts)],
            bounds: (S::Vector::repeat(f64::NEG_INFINITY), S::Vector::repeat(f64::INFINITY)),
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
        let half_diagonal = self.cell * (0.5 * (S::DIMENSIONS as f64).sqrt());
        let (domain, lower, cell, counts) = (&self.domain, &self.lower, self.cell, self.counts);
        for_each(&mut self.marks[..], 1024, |mut k, mark| {
            let place = S::axes(|axis| {
                let along = k % counts[axis];
                k /= counts[axis];
                along as f64 + 0.5
            });
            let centre = *lower + S::vector(place) * cell;
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
    pub fn contains(&self, x: &S::Vector) -> bool {
        let (lower, upper) = &self.bounds;
        // Most of a large fluid is far from a small solid.
        (0..S::DIMENSIONS).all(|axis| lower[axis] <= x[axis] && x[axis] <= upper[axis]) && self.looked_up(x)
    }

    fn looked_up(&self, x: &S::Vector) -> bool {
        let x = self.domain.wrapped(x);
        let k = (x - self.lower) / self.cell;
        let inside = (0..S::DIMENSIONS).all(|axis| k[axis] >= 0.0 && k[axis] < self.counts[axis] as f64);
        let index = || (0..S::DIMENSIONS).rev().fold(0, |n, axis| n * self.counts[axis] + k[axis] as usize);
        let mark = if inside { self.marks[index()] } else { Mark::Some };
        match mark {
            Mark::None => false,
            Mark::Some => gap(&self.domain, &self.extent, &x) <= self.reach,
            Mark::All => true,
        }
    }
}

/// Box around all that lies within `reach` of `extent`, without bound along periodic directions.
fn bounds_of<S: Space>(extent: &Extent, reach: f64, domain: &Domain<S>) -> (S::Vector, S::Vector) {
    let mut bounds = (S::Vector::repeat(f64::INFINITY), S::Vector::repeat(f64::NEG_INFINITY));
    // A little more than the reach: distances are rounded.
    let margin = S::Vector::repeat(1.001 * reach);
    for (lower, upper) in corners::<S>(extent) {
        bounds.0 = bounds.0.inf(&(lower - margin));
        bounds.1 = bounds.1.sup(&(upper + margin));
    }
    for axis in (0..S::DIMENSIONS).filter(|axis| domain.periodic[*axis]) {
        (bounds.0[axis], bounds.1[axis]) = (f64::NEG_INFINITY, f64::INFINITY);
    }
    bounds
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::Vector;

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
        tracker.update(&tracker.occupied(&positions), 0.01);
        assert_eq!(tracker.extent().boxes.len(), 1);
        let (lower, upper) = corners::<Plane>(tracker.extent()).next().unwrap();
        assert!((lower - Vector::new(0.19, 0.29)).norm() < 1e-12);
        assert!((upper - Vector::new(0.71, 0.71)).norm() < 1e-12);
        positions.extend(block(Vector::new(1.5, 0.0), 2, 20, 0.05));
        tracker.update(&tracker.occupied(&positions), 0.01);
        assert_eq!(tracker.extent().version, 2);
        let inside = positions.iter().all(|x| gap(&domain([false; 2]), tracker.extent(), x) == 0.0);
        assert!(inside);
        let area: f64 = corners::<Plane>(tracker.extent())
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
            tracker.update(&tracker.occupied(&block(Vector::new(0.0, 0.4), 2, 2, 0.05)), 0.0);
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
        tracker.update(&tracker.occupied(&positions), 0.0);
        let known = tracker.extent().clone();
        assert_eq!(tracker.shortfall(&known, &positions, 0.1, 0.12), Ok(()));
        assert!(tracker.shortfall(&known, &positions, 0.13, 0.12).is_err());
        positions.push(Vector::new(0.75, 0.55));
        tracker.update(&tracker.occupied(&positions), 0.0);
        let missing = tracker.shortfall(&known, &positions, 0.1, 0.12).unwrap_err();
        assert!((missing - 0.03).abs() < 1e-12, "{missing}");
    }
}
