//! Lifetime of neighbour lists: until two particles may have approached each other by more than the skin.

use rayon::prelude::*;
use sph::neighbours::CellGrid;
use sph::space::Vector;

/// Cells of a row of the grid that lie between particles without a bound on their distance beyond a cell: themselves,
/// their neighbours and the next.
const RINGS: isize = 2;

/// The same next to walls, which may lie beyond the grid, whose last cells are up to two cells wide.
const WALL_RINGS: isize = RINGS + 1;

/// Cells per task.
const TASK: usize = 128;

/// Displacements of the particles of each cell since the lists were built; buffers are reused.
#[derive(Debug, Default)]
pub struct Drift {
    /// Columns and rows of cells.
    counts: [usize; 2],
    /// Whether a wall particle is in the cell or within [`WALL_RINGS`] of it.
    near_wall: Vec<bool>,
    /// Box of the displacements in each cell \[m\]; inverted where it is empty.
    boxes: Vec<Span>,
}

/// A box of displacements \[m\].
#[derive(Clone, Copy, Debug)]
struct Span {
    lower: Vector,
    upper: Vector,
}

impl Span {
    fn empty() -> Self {
        Self { lower: Vector::repeat(f64::INFINITY), upper: Vector::repeat(f64::NEG_INFINITY) }
    }

    fn add(&mut self, u: &Vector) {
        self.lower = self.lower.inf(u);
        self.upper = self.upper.sup(u);
    }

    fn is_empty(&self) -> bool {
        self.lower.x > self.upper.x
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

/// Input of [`Drift::approach`].
#[derive(Clone, Copy, Debug)]
pub struct Moved<'a> {
    /// Positions \[m\], sorted by cells.
    pub position: &'a [Vector],
    /// Those when the lists were built \[m\].
    pub origin: &'a [Vector],
    /// Velocities \[m/s\].
    pub velocity: &'a [Vector],
    /// Time for which the particles keep these velocities \[s\].
    pub ahead: f64,
}

impl Drift {
    /// Marks the cells of `grid` near the `walls` \[m\], which do not move.
    pub fn place_walls(&mut self, grid: &CellGrid, walls: &[Vector]) {
        self.counts = grid.counts();
        let [columns, rows] = self.counts.map(usize::cast_signed);
        self.near_wall.clear();
        self.near_wall.resize(self.counts[0] * self.counts[1], false);
        let mut last = None;
        for x in walls {
            let [column, row] = grid.cell(x).place().map(|k| k as isize);
            // Wall particles stand in rows: most have the cell of the one before.
            if last.replace((column, row)) == Some((column, row)) {
                continue;
            }
            for y in (row - WALL_RINGS).max(0)..=(row + WALL_RINGS).min(rows - 1) {
                for x in (column - WALL_RINGS).max(0)..=(column + WALL_RINGS).min(columns - 1) {
                    self.near_wall[(y * columns + x).cast_unsigned()] = true;
                }
            }
        }
    }

    /// Upper bound \[m\] of the approach, since `grid` was built, of two particles that are not in each other's lists.
    ///
    /// Cells are at least as wide as the lists' radius, which is the support and the skin. Two particles that are not
    /// in each other's lists were farther apart than that; they come within support only when their displacements
    /// differ by more than the skin. With three cells or more between them they would have to differ by more than a
    /// cell and the skin, which is for the caller to exclude.
    pub fn approach(&mut self, grid: &CellGrid, moved: Moved<'_>) -> f64 {
        let Self { counts, near_wall, boxes } = self;
        boxes.resize(near_wall.len(), Span::empty());
        let cells = boxes.par_iter_mut().with_min_len(TASK).enumerate();
        let within_cells = cells.map(|(cell, span)| {
            *span = Span::empty();
            for i in grid.of_cell(cell) {
                let u = moved.position[i] - moved.origin[i];
                span.add(&u);
                span.add(&(u + moved.velocity[i] * moved.ahead));
            }
            if span.is_empty() {
                return 0.0;
            }
            let toward_walls = if near_wall[cell] { span.largest_square() } else { 0.0 };
            span.largest_square_difference(span).max(toward_walls)
        });
        let within_cells = within_cells.reduce(|| 0.0, f64::max);
        let [columns, rows] = counts.map(usize::cast_signed);
        let boxes = &*boxes;
        let between_cells = (0..rows * columns).into_par_iter().with_min_len(TASK).map(|cell| {
            let span = &boxes[cell.cast_unsigned()];
            if span.is_empty() {
                return 0.0;
            }
            let (row, column) = (cell / columns, cell % columns);
            // Each pair once: to the right in the same row, and all of the rows above.
            let right = (column + 1..=(column + RINGS).min(columns - 1)).map(|x| (row, x));
            let above = (row + 1..=(row + RINGS).min(rows - 1)).flat_map(|y| {
                ((column - RINGS).max(0)..=(column + RINGS).min(columns - 1)).map(move |x| (y, x))
            });
            let others = right.chain(above).map(|(y, x)| &boxes[(y * columns + x).cast_unsigned()]);
            let others = others.filter(|other| !other.is_empty());
            others.map(|other| span.largest_square_difference(other)).fold(0.0, f64::max)
        });
        between_cells.reduce(|| within_cells, f64::max).sqrt()
    }

    /// Bytes in use.
    pub fn bytes(&self) -> usize {
        self.near_wall.capacity() + size_of::<Span>() * self.boxes.capacity()
    }
}
