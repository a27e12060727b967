//! The thinnest part of a surface.

use crate::tasks;
use nalgebra::Vector3;

use super::Surface;

/// Facets from which thickness is measured, at most.
const MEASURED: usize = 20_000;

/// Cosine of the angle of the normals of two faces beyond which they are no opposite faces, but meet at an edge.
const OPPOSITE: f64 = -0.5;

/// Where a surface is thinnest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thinnest {
    /// Distance of the opposite face \[m\].
    pub thickness: f64,
    /// Where \[m\].
    pub place: Vector3<f64>,
}

impl Surface {
    /// The thinnest part between opposite faces, measured straight inward from the middles of facets, at most 20000 of them,
    /// evenly chosen. The edge of a wedge of less than 60° counts. `None` if no facet is opposite to another.
    pub fn thinnest(&self) -> Option<Thinnest> {
        let stride = self.facets().div_ceil(MEASURED).max(1);
        let chosen: Vec<usize> = (0..self.facets()).step_by(stride).collect();
        let found = tasks::flat_map(chosen.len(), 16, |k| self.thickness_at(chosen[k]));
        found.into_iter().reduce(|a, b| if b.thickness < a.thickness { b } else { a })
    }

    fn thickness_at(&self, facet: usize) -> Option<Thinnest> {
        let [a, b, c] = self.corners(facet);
        let (place, normal) = ((a + b + c) / 3.0, self.normals[facet]);
        if normal == Vector3::zeros() {
            return None;
        }
        let (thickness, other) = self.tree.first_along(&place, &-normal, 1e-9 * self.size())?;
        (self.normals[other as usize].dot(&normal) < OPPOSITE).then_some(Thinnest { thickness, place })
    }
}
