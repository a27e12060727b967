//! What is made of the particles of a new state at once, while they are at hand: records and whether they are healthy.

use sph::equation_of_state::Tait;
use sph::geometry::{Geometry, Periodic};
use sph::lanes::{Lanes, WIDTH};
use sph::vector::Vector;

use super::checks::{LaneFindings, LaneValues, Limits};
use crate::system::lane_arrays::vectors;
use crate::system::model::FluidModel;
use crate::system::packed_particle::Record;
use crate::system::state::ListOrigin;

/// A look at the particles of one state.
#[derive(Clone, Copy, Debug)]
pub struct Look<'a> {
    equation_of_state: Tait,
    limits: Limits,
    periodic: Option<Periodic>,
    origin: Option<&'a [Vector]>,
}

impl<'a> Look<'a> {
    /// A look at a state whose lists were built from `origin`, if there are any.
    pub fn new(model: &FluidModel, origin: Option<&'a ListOrigin>) -> Self {
        Self {
            equation_of_state: model.equation_of_state,
            limits: Limits::of(model),
            periodic: model.domain.is_periodic().then(|| Periodic::new(&model.domain)),
            origin: origin.map(|origin| &origin.position[..]),
        }
    }

    /// The records of the particles from `first` on, of `mass` per depth \[kg/m\], with what is found of them added to
    /// `found`.
    ///
    /// They show `velocity` \[m/s\] to their neighbours, or else their own. No product is fused with a sum: the state
    /// has the same bits on each path.
    #[inline(always)]
    pub fn at<L: Lanes>(
        &self,
        first: usize,
        values: LaneValues<L>,
        mass: L,
        velocity: Option<[L; 2]>,
        found: &mut LaneFindings<L>,
    ) -> [Record; WIDTH] {
        let ([x, y], own_velocity, density) = values;
        found.add(&self.limits, first, values, self.displacement(first, [x, y]));
        let [v_x, v_y] = match velocity {
            Some(velocity) => velocity,
            None => own_velocity,
        };
        let pressure = self.equation_of_state.pressures(density);
        Record::four([x, y, v_x, v_y], [density, pressure, mass / density])
    }

    /// How far particles are from where they were when the lists were built \[m\].
    #[inline(always)]
    fn displacement<L: Lanes>(&self, first: usize, [x, y]: [L; 2]) -> Option<[L; 2]> {
        let [x_0, y_0] = match self.origin {
            Some(origin) => vectors::<L>(origin, first),
            None => return None,
        };
        let (x, y) = (x - x_0, y - y_0);
        Some(match self.periodic {
            Some(geometry) => [geometry.nearest(x, 0), geometry.nearest(y, 1)],
            None => [x, y],
        })
    }
}
