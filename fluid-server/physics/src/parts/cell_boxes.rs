//! Boxes of cells, and how far apart they are.

use sph::space::Space;

/// The cells that a part owns: disjoint boxes of them.
#[derive(Clone, Debug)]
pub struct CellBoxes<S: Space> {
    boxes: Vec<CellBox<S>>,
    /// Number of cells along each axis that is periodic.
    periods: S::Of<Option<usize>>,
}

/// A box of cells.
#[derive(Clone, Copy, Debug)]
pub struct CellBox<S: Space> {
    /// Its first place along each axis.
    pub start: S::Of<usize>,
    /// The place after its last.
    pub end: S::Of<usize>,
}

impl<S: Space> CellBoxes<S> {
    /// Those of `boxes` that have cells, of a grid with so many along each axis that is periodic.
    pub fn new(boxes: impl Iterator<Item = CellBox<S>>, periods: S::Of<Option<usize>>) -> Self {
        let has_cells =
            |cells: &CellBox<S>| (0..S::DIMENSIONS).all(|axis| cells.start[axis] < cells.end[axis]);
        Self { boxes: boxes.filter(has_cells).collect(), periods }
    }

    /// Cells from these to the one at `place`: 0 for one of them, 1 for its neighbours; `None` where there are none.
    pub fn distance_to_cell(&self, place: S::Of<usize>) -> Option<usize> {
        let cell = CellBox { start: place, end: S::axes(|axis| place[axis] + 1) };
        self.boxes.iter().map(|own| own.distance(&cell, self.periods)).min()
    }

    /// Cells from these to others; `None` where there are none of either.
    pub fn distance(&self, others: &Self) -> Option<usize> {
        let pairs = self.boxes.iter().flat_map(|own| others.boxes.iter().map(move |other| (own, other)));
        pairs.map(|(own, other)| own.distance(other, self.periods)).min()
    }
}

impl<S: Space> CellBox<S> {
    fn distance(&self, other: &Self, periods: S::Of<Option<usize>>) -> usize {
        let along = |axis: usize| {
            let apart = |shift: usize, own_shift: usize| {
                let [start, end] = [other.start, other.end].map(|place| place[axis] + shift);
                let [own_start, own_end] = [self.start, self.end].map(|place| place[axis] + own_shift);
                (own_start + 1).saturating_sub(end).max((start + 1).saturating_sub(own_end))
            };
            match periods[axis] {
                None => apart(0, 0),
                Some(count) => apart(0, 0).min(apart(count, 0)).min(apart(0, count)),
            }
        };
        (0..S::DIMENSIONS).map(along).max().unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use sph::space::Plane;

    use super::*;

    fn boxes(periods: [Option<usize>; 2], boxes: &[[[usize; 2]; 2]]) -> CellBoxes<Plane> {
        CellBoxes::new(boxes.iter().map(|[start, end]| CellBox { start: *start, end: *end }), periods)
    }

    #[test]
    fn distances_are_those_of_the_nearest_box_and_image() {
        let distance = |x: usize, y: usize, periods: [Option<usize>; 2]| {
            boxes(periods, &[[[2, 0], [4, 1]], [[2, 7], [3, 8]], [[0, 3], [5, 3]]]).distance_to_cell([x, y])
        };
        let open = [None; 2];
        assert_eq!([distance(2, 0, open), distance(3, 0, open), distance(4, 0, open)], [0, 0, 1].map(Some));
        assert_eq!([distance(1, 0, open), distance(0, 0, open), distance(0, 3, open)], [1, 2, 3].map(Some));
        // Of the second box, on the way from the first.
        assert_eq!([distance(0, 5, open), distance(2, 9, open)], [2, 2].map(Some));
        assert_eq!(distance(9, 0, open), Some(6));
        assert_eq!(distance(9, 0, [Some(10), None]), Some(3));
        assert_eq!(distance(3, 11, [None, Some(12)]), Some(1));
    }

    #[test]
    fn distances_between_boxes_do_not_depend_on_which_is_first() {
        let own = boxes([Some(20), None], &[[[2, 0], [4, 1]], [[9, 9], [10, 10]]]);
        let others = boxes([Some(20), None], &[[[17, 0], [19, 2]], [[12, 4], [13, 8]]]);
        assert_eq!([own.distance(&others), others.distance(&own)], [Some(3), Some(3)]);
        let none = boxes([None; 2], &[[[3, 3], [3, 9]]]);
        assert_eq!([none.distance(&own), own.distance(&none), none.distance_to_cell([0, 0])], [None; 3]);
    }
}
