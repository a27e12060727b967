//! Positions that keep their distance.

use std::collections::HashMap;

use crate::space::Space;
use crate::space::tensors::SpaceVector;

/// A place in a grid of cells.
type Place = [i64; 3];

/// Cell of a grid with cells of `size` \[m\].
pub(super) fn cell<S: Space>(x: &S::Vector, size: f64) -> Place {
    let mut place = [0; 3];
    for (axis, index) in place.iter_mut().enumerate().take(S::DIMENSIONS) {
        // A whole number of an f64 saturates; scenes are far smaller than 2^63 cells.
        *index = (x[axis] / size).floor() as i64;
    }
    place
}

/// A cell and those around it, along x first and y next.
pub(super) fn around<S: Space>([x, y, z]: Place) -> impl Iterator<Item = Place> {
    let beside = if S::DIMENSIONS > 2 { 1 } else { 0 };
    let planes = (-beside..=beside).map(move |k| z + k);
    planes.flat_map(move |z| (-1..=1).flat_map(move |i| (-1..=1).map(move |j| [x + i, y + j, z])))
}

/// Positions that keep their distance.
pub(crate) struct Crowd<S: Space> {
    distance: f64,
    cells: HashMap<Place, Vec<S::Vector>>,
}

impl<S: Space> Crowd<S> {
    /// None yet; they stay `distance` \[m\] apart.
    pub fn new(distance: f64) -> Self {
        Self { distance, cells: HashMap::new() }
    }

    /// Takes `x` in unless it is too close to one that is in.
    pub fn admit(&mut self, x: &S::Vector) -> bool {
        let own = cell::<S>(x, self.distance);
        let mut near = around::<S>(own).filter_map(|c| self.cells.get(&c)).flatten();
        let free = near.all(|y| (*x - *y).norm() >= self.distance);
        if free {
            self.cells.entry(own).or_default().push(*x);
        }
        free
    }
}
