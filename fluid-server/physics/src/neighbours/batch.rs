//! A batch of neighbours, gathered from the packed particles.

use sph::lanes::{Lanes, WIDTH};
use sph::space::geometry::Geometry;

use crate::system::packed_particle::{FluidSpace, LaneMotion, LaneParticles, Packed};

/// A batch of neighbours relative to particle i.
#[derive(Clone, Copy, Debug)]
pub struct NeighbourBatch<S: FluidSpace, L: Lanes> {
    /// x_ij \[m\].
    pub x: S::Of<L>,
    /// r² \[m²\].
    pub square: L,
    /// Velocity v_ij \[m/s\].
    pub v: S::Of<L>,
    /// Density of the neighbours \[kg/m³\].
    pub density: L,
    /// Pressure of the neighbours \[Pa\].
    pub pressure: L,
    /// Volume of the neighbours, in the plane per depth \[m²\].
    pub volume: L,
}

impl<S: FluidSpace, L: Lanes> NeighbourBatch<S, L> {
    /// The neighbours `indices` of `own` among `others`.
    #[inline(always)]
    pub fn gather<G: Geometry<S>>(
        geometry: G,
        own: &LaneMotion<S, L>,
        others: &[S::Particle],
        indices: [u32; WIDTH],
    ) -> Self {
        let others = S::Particle::lanes::<L>(of_each(indices, others));
        let LaneParticles { motion: LaneMotion { x, v }, density, pressure, volume } = others;
        let x = geometry.nearest(S::minus(own.x, x));
        Self { x, square: S::dot(x, x), v: S::minus(own.v, v), density, pressure, volume }
    }
}

/// One number of each neighbour of a batch.
#[inline(always)]
pub fn gather<L: Lanes>(indices: [u32; WIDTH], values: &[f64]) -> L {
    let [a, b, c, d] = of_each(indices, values);
    L::from_array([*a, *b, *c, *d])
}

/// What belongs to each neighbour of a batch.
#[inline(always)]
pub fn of_each<T>([a, b, c, d]: [u32; WIDTH], values: &[T]) -> [&T; WIDTH] {
    [&values[a as usize], &values[b as usize], &values[c as usize], &values[d as usize]]
}

/// `value` of each neighbour of a batch. As `map` of arrays, which would be compiled for every pass that calls it.
#[inline(always)]
pub fn each<T>([a, b, c, d]: [u32; WIDTH], value: impl Fn(u32) -> T) -> [T; WIDTH] {
    [value(a), value(b), value(c), value(d)]
}
