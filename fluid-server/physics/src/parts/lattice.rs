//! Cells, and the runs of cells whose particles are summed together and have one owner.

use std::ops::Range;

use sph::neighbours::{CellGrid, Cells};
use sph::space::Space;
use sph::space::tensors::SpaceVector;

use crate::system::tasks::TASK;

/// Most particles of a run, at the spacing of a lattice: half a task, so that parts can be cut along x too.
const RUN: usize = TASK / 2;

/// The cells of a grid over all particles, divided along x into runs of about half a task. Units are runs along x, and cells
/// along other axes.
#[derive(Clone, Copy, Debug)]
pub struct Lattice<S: Space> {
    cells: Cells<S>,
    /// Runs in a row of cells.
    runs: usize,
}

impl<S: Space> Lattice<S> {
    /// The runs of `cells` that hold particles of `spacing` \[m\].
    pub fn new(cells: Cells<S>, spacing: f64) -> Self {
        let particles: f64 = (0..S::DIMENSIONS).map(|axis| cells.edge(axis) / spacing).product();
        let columns = cells.counts()[0].max(1);
        // Both are small.
        let run = ((RUN as f64 / particles) as usize).clamp(1, columns);
        Self { cells, runs: columns.div_ceil(run) }
    }

    /// The cells.
    pub fn cells(&self) -> &Cells<S> {
        &self.cells
    }

    /// Number of cells along each axis that is periodic.
    pub fn periods(&self) -> S::Of<Option<usize>> {
        S::axes(|axis| self.cells.periodic()[axis].then_some(self.cells.counts()[axis]))
    }

    /// Number of units along `axis`.
    pub fn units(&self, axis: usize) -> usize {
        if axis == 0 { self.runs } else { self.cells.counts()[axis] }
    }

    /// The unit along `axis` with the cells at `place` along it.
    pub fn unit(&self, axis: usize, place: usize) -> usize {
        if axis == 0 { place * self.runs / self.cells.counts()[0] } else { place }
    }

    /// Places of the cells of unit `unit` along `axis`.
    pub fn places(&self, axis: usize, unit: usize) -> Range<usize> {
        if axis > 0 {
            return unit..unit + 1;
        }
        let columns = self.cells.counts()[0];
        (unit * columns).div_ceil(self.runs)..((unit + 1) * columns).div_ceil(self.runs)
    }

    /// Middle of unit `unit` along `axis` \[m\].
    pub fn middle(&self, axis: usize, unit: usize) -> f64 {
        let places = self.places(axis, unit);
        self.cells.lower()[axis] + self.cells.edge(axis) * 0.5 * (places.start + places.end) as f64
    }

    /// Middle of the units of `cell` \[m\].
    pub fn middle_of(&self, cell: u32) -> S::Vector {
        let place = self.cells.place(cell);
        let mut middle = S::Vector::zeros();
        for axis in 0..S::DIMENSIONS {
            middle[axis] = self.middle(axis, self.unit(axis, place[axis]));
        }
        middle
    }

    /// Whether two cells, the second not before the first, are of one run.
    pub fn are_of_one_run(&self, first: u32, second: u32) -> bool {
        let columns = self.cells.counts()[0];
        let (first, second) = (first as usize, second as usize);
        first / columns == second / columns && self.unit(0, first % columns) == self.unit(0, second % columns)
    }

    /// The ends of the runs of particles that `grid` has sorted into the cells.
    pub fn ends_in(&self, grid: &CellGrid<S>) -> Vec<u32> {
        let columns = self.cells.counts()[0];
        let (mut ends, mut last) = (Vec::new(), 0);
        if grid.order().is_empty() {
            return ends;
        }
        for row in (0..self.cells.number()).step_by(columns) {
            for run in 0..self.runs {
                let end = grid.of_cell(row + self.places(0, run).end - 1).end;
                if end > last {
                    // Indices of particles are of 32 bits.
                    ends.push(end as u32);
                    last = end;
                }
            }
        }
        ends
    }

    /// The ends of the runs of particles whose cells are `cells`, in ascending order.
    pub fn ends(&self, cells: &[u32]) -> Vec<u32> {
        let runs = cells.chunk_by(|first, second| first == second || self.are_of_one_run(*first, *second));
        let ends = runs.scan(0, |end, run| {
            *end += run.len() as u32;
            Some(*end)
        });
        ends.collect()
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;
    use sph::space::Plane;
    use sph::space::domain::Domain;

    use super::*;

    #[test]
    fn runs_divide_each_row_and_hold_half_a_task_at_most() {
        let domain =
            Domain::<Plane> { lower: Vector2::zeros(), upper: Vector2::new(30.5, 7.0), periodic: [false; 2] };
        // Cells of 3 x 3 particles: ten columns and two rows.
        let cells = Cells::new(&domain, [domain.lower, domain.upper], 10_000, 3.0);
        let lattice = Lattice::new(cells, 0.25);
        // 144 particles in a cell: runs of one. At 1 m they are 9: all columns.
        assert_eq!([lattice.units(0), lattice.units(1)], [10, 2]);
        assert_eq!(Lattice::new(cells, 1.0).units(0), 1);
        let lattice = Lattice::new(cells, 0.85);
        // 12 in a cell: 10 columns fit, in one run.
        assert_eq!(lattice.units(0), 1);
        let lattice = Lattice::new(cells, 0.55);
        // 30 in a cell: runs of four at most, of which there are three.
        assert_eq!(lattice.units(0), 3);
        let columns: Vec<_> = (0..3).flat_map(|unit| lattice.places(0, unit)).collect();
        assert_eq!(columns, (0..10).collect::<Vec<_>>());
        for unit in 0..3 {
            assert!(lattice.places(0, unit).all(|place| lattice.unit(0, place) == unit));
        }
        // Columns 0-3, 4-6, 7-9 of the first row, then the second row.
        assert_eq!(lattice.ends(&[0, 0, 3, 4, 9, 10, 19]), [3, 4, 5, 6, 7]);
    }
}
