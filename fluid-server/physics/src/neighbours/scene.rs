//! Input of a pass over neighbours.

use std::ops::Range;

use sph::lanes::WIDTH;

use super::lists::Lists;
use crate::parts::halo::Halo;
use crate::system::model::FluidModel;
use crate::system::packed_particle::FluidSpace;

/// The fluid and its surroundings in one stage.
#[derive(Clone, Copy)]
pub struct Scene<'a, G, S: FluidSpace> {
    /// Nearest images.
    pub geometry: G,
    /// Constants.
    pub model: &'a FluidModel<S>,
    /// Neighbours.
    pub lists: &'a Lists<S>,
    /// Fluid as pair sums read it: the own particles, then copies of those of other parts.
    pub fluid: &'a [S::Particle],
    /// Walls as pair sums read them, and one particle that does not act.
    pub walls: &'a [S::Particle],
}

impl<G, S: FluidSpace> Scene<'_, G, S> {
    /// Places of the own particles.
    pub fn own(&self) -> Range<usize> {
        0..self.lists.placement().halo().map_or(self.fluid.len(), Halo::own)
    }

    /// Fluid neighbours of own particle `i`.
    #[inline(always)]
    pub fn fluid_row(&self, i: usize) -> &[[u32; WIDTH]] {
        self.lists.fluid.of(i)
    }

    /// The same one by one.
    pub fn fluid_neighbours(&self, i: usize) -> impl Iterator<Item = usize> + '_ {
        self.lists.fluid.neighbours(i)
    }

    /// Wall neighbours of own particle `i`.
    #[inline(always)]
    pub fn wall_row(&self, i: usize) -> &[[u32; WIDTH]] {
        self.lists.walls.of(i)
    }

    /// The same one by one.
    pub fn wall_neighbours(&self, i: usize) -> impl Iterator<Item = usize> + '_ {
        self.lists.walls.neighbours(i)
    }
}
