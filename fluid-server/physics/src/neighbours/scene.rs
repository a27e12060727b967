//! Input of a pass over neighbours.

use super::lists::Lists;
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
    /// Fluid as pair sums read it.
    pub fluid: &'a [S::Particle],
    /// Walls as pair sums read them, and one particle that does not act.
    pub walls: &'a [S::Particle],
}
