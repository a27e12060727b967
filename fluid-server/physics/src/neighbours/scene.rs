//! Input of a pass over neighbours.

use super::lists::Lists;
use crate::system::model::FluidModel;
use crate::system::packed_particle::PackedParticle;

/// The fluid and its surroundings in one stage.
#[derive(Clone, Copy)]
pub struct Scene<'a, G> {
    /// Nearest images.
    pub geometry: G,
    /// Constants.
    pub model: &'a FluidModel,
    /// Neighbours.
    pub lists: &'a Lists,
    /// Fluid as pair sums read it.
    pub fluid: &'a [PackedParticle],
    /// Walls as pair sums read them, and one particle that does not act.
    pub walls: &'a [PackedParticle],
}
