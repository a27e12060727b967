//! Lifetime of neighbour lists: until two particles may have approached each other by more than the skin.

use sph::neighbours::CellGrid;
use sph::space::Space;
use sph::space::tensors::SpaceVector;
use sph::tasks::{for_each, largest};

/// Cells of a row of the grid that lie between particles without a bound on their distance beyond a cell: themselves,
/// their neighbours and the next.
const RINGS: isize = 2;

/// The same next to walls, which may lie beyond the grid, whose last cells are up to two cells wide.
const WALL_RINGS: isize = RINGS + 1;

/// Cells per task.
const TASK: usize = 128;

/// Displacements of the particles of each cell since the lists were built; buffers are reused.
#[derive(Debug)]
pub struct Drift<S: Space> {
    /// Number of cells along each axis.
    counts: S::Of<usize>,
    /// Whether a wall particle is in the cell or within [`WALL_RINGS`] of it.
    near_wall: Vec<bool>,
    /// Memory for [`Drift::place_walls`].
    seen: Vec<bool>,
    /// Box of the displacements in each cell \[m\]; inverted where it is empty.
    boxes: Vec<Span<S>>,
}

/// A box of displacements \[m\].
#[derive(Clone, Copy, Debug)]
struct Span<S: Space> {
    lower: S::Vector,
    upper: S::Vector,
}

impl<S: Space> Span<S> {
    fn empty() -> Self {
        Self { lower: S::Vector::repeat(f64::INFINITY), upper: S::Vector::repeat(f64::NEG_INFINITY) }
    }

    fn add(&mut self, u: &S::Vector) {
        self.lower = self.lower.inf(u);
        self.upper = self.upper.sup(u);
    }

    fn is_empty(&self) -> bool {
        self.lower[0] > self.upper[0]
    }

    /// Square of the largest difference between a displacement of this box and one of the other \[m²\].
    fn largest_square_difference(&self, other: &Self) -> f64 {
        (self.upper - other.lower).sup(&(other.upper - self.lower)).norm_squared()
    }

    /// Square of the largest displacement \[m²\].
    fn largest_square(&self) -> f64 {
        self.upper.sup(&-self.lower).norm_squared()
    }
}

impl<S: Space> Default for Drift<S> {
    fn default() -> Self {
        Self { counts: S::splat(0), near_wall: Vec::new(), seen: Vec::new(), boxes: Vec::new() }
    }
}

/// Cells at most `rings` from the one at `place` along each axis, as far as they belong to `part`.
fn around<S: Space>(
    counts: S::Of<usize>,
    place: S::Of<isize>,
    rings: isize,
    part: Part,
) -> impl Iterator<Item = usize> {
    let width = 2 * rings + 1;
    let all = width.pow(S::DIMENSIONS as u32);
    let first = match part {
        Part::All => 0,
        Part::Following => all / 2 + 1,
    };
    (first..all).filter_map(move |mut rest| {
        let (mut cell, mut stride) = (0, 1);
        for axis in 0..S::DIMENSIONS {
            let (k, count) = (place[axis] + rest % width - rings, counts[axis].cast_signed());
            if k < 0 || k >= count {
                return None;
            }
            cell += k * stride;
            rest /= width;
            stride *= count;
        }
        Some(cell.cast_unsigned())
    })
}

/// A part of the cells around one.
#[derive(Clone, Copy, Debug)]
enum Part {
    /// All of them.
    All,
    /// Those of a larger index: each pair of cells once.
    Following,
}

impl<S: Space> Drift<S> {
    /// Marks the cells of `grid` near the `walls` \[m\], which do not move.
    pub fn place_walls(&mut self, grid: &CellGrid<S>, walls: &[S::Vector]) {
        self.counts = grid.counts();
        self.near_wall.clear();
        self.near_wall.resize((0..S::DIMENSIONS).map(|axis| self.counts[axis]).product(), false);
        // Cells that count, and for each whether it has been seen; those farther out are near none of the grid.
        let seen_counts = S::axes(|axis| self.counts[axis] + 2 * WALL_RINGS.cast_unsigned());
        self.seen.clear();
        self.seen.resize((0..S::DIMENSIONS).map(|axis| seen_counts[axis]).product(), false);
        let mut last = None;
        for x in walls {
            let cell = grid.cell(x);
            // Wall particles stand in rows: most have the cell of the one before.
            if last.replace(cell) == Some(cell) {
                continue;
            }
            let place = S::axes(|axis| cell.place()[axis] as isize);
            let index = (0..S::DIMENSIONS).rev().try_fold(0, |index, axis| {
                let k = usize::try_from(place[axis] + WALL_RINGS).ok()?;
                (k < seen_counts[axis]).then_some(index * seen_counts[axis] + k)
            });
            let Some(index) = index else { continue };
            if !std::mem::replace(&mut self.seen[index], true) {
                for near in around::<S>(self.counts, place, WALL_RINGS, Part::All) {
                    self.near_wall[near] = true;
                }
            }
        }
    }

    /// By how much [`Drift::approach`] grows at most when no particle moves farther than `way` \[m\]: along each axis by twice the
    /// way. With less, the lists of a run that is restored would last shorter than those of one that was not.
    pub fn growth(way: f64) -> f64 {
        (S::DIMENSIONS as f64).sqrt() * 2.0 * way
    }

    /// Upper bound \[m\] of the approach, since `grid` was built, of two particles that are not in each other's lists.
    ///
    /// Cells are at least as wide as the lists' radius, which is the support and the skin. Two particles that are not
    /// in each other's lists were farther apart than that; they come within support only when their displacements
    /// differ by more than the skin. With three cells or more between them they would have to differ by more than a
    /// cell and the skin, which is for the caller to exclude.
    ///
    /// `moved` is the displacement of each particle since then, by its place in the order of cells, and the one to come
    /// \[m\]; `None` for one that does not count.
    pub fn approach(
        &mut self,
        grid: &CellGrid<S>,
        moved: impl Fn(usize) -> Option<[S::Vector; 2]> + Sync,
    ) -> f64 {
        let Self { counts, near_wall, boxes, .. } = self;
        boxes.resize(near_wall.len(), Span::empty());
        for_each(&mut boxes[..], TASK, |cell, span| {
            *span = Span::empty();
            for [u, to_come] in grid.of_cell(cell).filter_map(&moved) {
                span.add(&u);
                span.add(&(u + to_come));
            }
        });
        let (boxes, counts) = (&*boxes, *counts);
        let square = largest(boxes.len(), TASK, |cell| {
            let span = &boxes[cell];
            if span.is_empty() {
                return 0.0;
            }
            let toward_walls = if near_wall[cell] { span.largest_square() } else { 0.0 };
            let within = span.largest_square_difference(span).max(toward_walls);
            let mut rest = cell;
            let place = S::axes(|axis| {
                let k = rest % counts[axis];
                rest /= counts[axis];
                k.cast_signed()
            });
            // Each pair once.
            let others = around::<S>(counts, place, RINGS, Part::Following).map(|near| &boxes[near]);
            let others = others.filter(|other| !other.is_empty());
            others.map(|other| span.largest_square_difference(other)).fold(within, f64::max)
        });
        square.sqrt()
    }

    /// Bytes in use.
    pub fn bytes(&self) -> usize {
        self.near_wall.capacity() + self.seen.capacity() + size_of::<Span<S>>() * self.boxes.capacity()
    }
}
