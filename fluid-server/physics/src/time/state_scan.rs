//! The scan of a new state: packs its particles for the next pair sums and checks them.

use sph::lanes::{Lanes, WIDTH};
use sph::laws::equation_of_state::Tait;
use sph::space::geometry::{Geometry, Periodic};
use sph::space::{Plane, Vector};

use super::checks::{LaneScanFindings, Motion, StateLimits};
use crate::system::lane_arrays::vectors;
use crate::system::model::FluidModel;
use crate::system::packed_particle::{LaneMotion, LaneParticles, Packed, PackedParticle};
use crate::system::state::ListOrigin;

/// The scan of one state.
#[derive(Clone, Copy, Debug)]
pub struct StateScan<'a> {
    equation_of_state: Tait,
    limits: StateLimits,
    periodic: Option<Periodic>,
    origin: Option<&'a [Vector]>,
}

impl<'a> StateScan<'a> {
    /// The scan of a state whose lists were built from `origin`, if there are any.
    pub fn new(model: &FluidModel, origin: Option<&'a ListOrigin>) -> Self {
        Self {
            equation_of_state: model.equation_of_state,
            limits: StateLimits::of(model),
            periodic: model.domain.is_periodic().then(|| Periodic::new(&model.domain)),
            origin: origin.map(|origin| &origin.position[..]),
        }
    }

    /// Packs the particles from `first` on, of `mass` per depth \[kg/m\], and adds what is found of them to `findings`.
    ///
    /// Pair sums read `velocity` \[m/s\], or by default their own. No product is fused with a sum: the state has the
    /// same bits on each path.
    #[inline(always)]
    pub fn pack<L: Lanes>(
        &self,
        first: usize,
        motion: &Motion<L>,
        mass: L,
        velocity: Option<[L; 2]>,
        findings: &mut LaneScanFindings<L>,
    ) -> [PackedParticle; WIDTH] {
        let Motion { x: [x, y], v: own_velocity, rho: density } = *motion;
        findings.add(&self.limits, first, motion, self.displacement(first, [x, y]));
        let v = match velocity {
            Some(velocity) => velocity,
            None => own_velocity,
        };
        let pressure = self.equation_of_state.pressures(density);
        let motion = LaneMotion { x: [x, y], v };
        PackedParticle::pack(LaneParticles { motion, density, pressure, volume: mass / density })
    }

    /// Displacement of particles since the lists were built \[m\].
    #[inline(always)]
    fn displacement<L: Lanes>(&self, first: usize, [x, y]: [L; 2]) -> Option<[L; 2]> {
        let [x_0, y_0] = match self.origin {
            Some(origin) => vectors::<Plane, L>(origin, first),
            None => return None,
        };
        let (x, y) = (x - x_0, y - y_0);
        Some(match self.periodic {
            Some(geometry) => geometry.nearest([x, y]),
            None => [x, y],
        })
    }
}
