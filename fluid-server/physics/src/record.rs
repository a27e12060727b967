//! What a pair sum reads of a particle.

use sph::geometry::Geometry;
use sph::lanes::{Lanes, WIDTH};
use sph::vector::Vector;

use super::four::rows;

/// State of a particle as its neighbours read it: one cache line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(align(64))]
pub struct Record {
    /// x, y \[m\], v_x, v_y \[m/s\].
    pub motion: [f64; 4],
    /// Density ρ \[kg/m³\], pressure p \[Pa\], volume per depth V = m/ρ \[m²\], unused.
    pub matter: [f64; 4],
}

impl Record {
    /// A particle; one of zero `volume` does not act.
    #[inline(always)]
    pub fn new(position: &Vector, velocity: &Vector, density: f64, pressure: f64, volume: f64) -> Self {
        Self {
            motion: [position.x, position.y, velocity.x, velocity.y],
            matter: [density, pressure, volume, 0.0],
        }
    }

    /// Four particles, from the numbers of [`Record::motion`] and from density, pressure and volume.
    #[inline(always)]
    pub fn four<L: Lanes>(motion: [L; 4], [density, pressure, volume]: [L; 3]) -> [Self; WIDTH] {
        let [a, b, c, d] = rows(motion);
        let [m_a, m_b, m_c, m_d] = rows([density, pressure, volume, L::zero()]);
        let record = |motion, matter| Self { motion, matter };
        [record(a, m_a), record(b, m_b), record(c, m_c), record(d, m_d)]
    }

    /// Position \[m\].
    #[inline(always)]
    pub fn position(&self) -> Vector {
        Vector::new(self.motion[0], self.motion[1])
    }

    /// Velocity \[m/s\].
    #[inline(always)]
    pub fn velocity(&self) -> Vector {
        Vector::new(self.motion[2], self.motion[3])
    }

    /// Density ρ \[kg/m³\].
    #[inline(always)]
    pub fn density(&self) -> f64 {
        self.matter[0]
    }

    /// Pressure p \[Pa\], without damper.
    #[inline(always)]
    pub fn pressure(&self) -> f64 {
        self.matter[1]
    }

    /// Volume per depth V = m/ρ \[m²\]; zero for a particle that does not act.
    #[inline(always)]
    pub fn volume(&self) -> f64 {
        self.matter[2]
    }
}

/// A batch of neighbours as particle i meets them.
#[derive(Clone, Copy, Debug)]
pub struct Batch<L> {
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

impl<L: Lanes> Batch<L> {
    /// The neighbours `indices` of `own` among `others`.
    #[inline(always)]
    pub fn gather<G: Geometry>(geometry: G, own: &[L; 4], others: &[Record], indices: [u32; WIDTH]) -> Self {
        let [a, b, c, d] = indices.map(|j| &others[j as usize]);
        let [x_j, y_j, v_xj, v_yj] = L::columns([&a.motion, &b.motion, &c.motion, &d.motion]);
        let [density, pressure, volume, _] = L::columns([&a.matter, &b.matter, &c.matter, &d.matter]);
        let [x_i, y_i, v_xi, v_yi] = *own;
        let (x, y) = (geometry.nearest(x_i - x_j, 0), geometry.nearest(y_i - y_j, 1));
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
