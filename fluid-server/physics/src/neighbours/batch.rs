//! A batch of neighbours, gathered from the packed particles.

use sph::lanes::{Lanes, WIDTH};
use sph::space::geometry::Geometry;

use crate::system::packed_particle::PackedParticle;

/// A batch of neighbours relative to particle i.
#[derive(Clone, Copy, Debug)]
pub struct NeighbourBatch<L> {
    /// x_ij \[m\].
    pub x: L,
    /// y_ij \[m\].
    pub y: L,
    /// r² \[m²\].
    pub square: L,
    /// Velocity v_ij \[m/s\].
    pub v_x: L,
    /// Velocity v_ij \[m/s\].
    pub v_y: L,
    /// Density of the neighbours \[kg/m³\].
    pub density: L,
    /// Pressure of the neighbours \[Pa\].
    pub pressure: L,
    /// Volume per depth of the neighbours \[m²\].
    pub volume: L,
}

impl<L: Lanes> NeighbourBatch<L> {
    /// The neighbours `indices` of `own` among `others`.
    #[inline(always)]
    pub fn gather<G: Geometry>(
        geometry: G,
        own: &[L; 4],
        others: &[PackedParticle],
        indices: [u32; WIDTH],
    ) -> Self {
        let [a, b, c, d] = indices.map(|j| &others[j as usize]);
        let [x_j, y_j, v_xj, v_yj] = L::columns([&a.motion, &b.motion, &c.motion, &d.motion]);
        let [density, pressure, volume, _] = L::columns([&a.matter, &b.matter, &c.matter, &d.matter]);
        let [x_i, y_i, v_xi, v_yi] = *own;
        let [x, y] = geometry.nearest([x_i - x_j, y_i - y_j]);
        let square = (x * x).plus_product(y, y);
        Self { x, y, square, v_x: v_xi - v_xj, v_y: v_yi - v_yj, density, pressure, volume }
    }
}

/// One number of each neighbour of a batch.
#[inline(always)]
pub fn gather<L: Lanes>(indices: [u32; WIDTH], values: &[f64]) -> L {
    L::from_array(indices.map(|j| values[j as usize]))
}

/// Four numbers of each neighbour of a batch.
#[inline(always)]
pub fn gather_columns<L: Lanes>(indices: [u32; WIDTH], values: &[[f64; 4]]) -> [L; 4] {
    let [a, b, c, d] = indices.map(|j| &values[j as usize]);
    L::columns([a, b, c, d])
}
