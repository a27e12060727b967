//! The scan of a new state: packs its particles for the next pair sums and checks them.

use std::ops::Range;

use sph::lanes::{Lanes, WIDTH};
use sph::laws::equation_of_state::Tait;
use sph::space::geometry::{Geometry, Periodic};

use super::checks::{LaneScanFindings, Motion, StateLimits};
use crate::system::lane_arrays::vectors;
use crate::system::model::FluidModel;
use crate::system::packed_particle::{FluidSpace, LaneMotion, LaneParticles, Packed};
use crate::system::state::ListOrigin;

/// The scan of one state.
#[derive(Clone, Copy, Debug)]
pub struct StateScan<'a, S: FluidSpace> {
    equation_of_state: Tait,
    limits: StateLimits<S>,
    periodic: Option<Periodic<S>>,
    origin: Option<&'a [S::Vector]>,
    /// The first particle of the scan.
    first: usize,
}

impl<'a, S: FluidSpace> StateScan<'a, S> {
    /// The scan of a state whose lists were built from `origin`, if there are any.
    pub fn new(model: &FluidModel<S>, origin: Option<&'a ListOrigin<S>>) -> Self {
        Self {
            equation_of_state: model.equation_of_state,
            limits: StateLimits::of(model),
            periodic: model.domain.is_periodic().then(|| Periodic::new(&model.domain)),
            origin: origin.map(|origin| &origin.position[..]),
            first: 0,
        }
    }

    /// The scan of the particles in `range` of these.
    pub fn within(&self, range: Range<usize>) -> Self {
        let first = self.first + range.start;
        Self { origin: self.origin.map(|origin| &origin[range]), first, ..*self }
    }

    /// Packs the particles from number `first` of the scan on, of `mass` per depth \[kg/m\], and adds what is found of them to `findings`.
    ///
    /// Pair sums read `velocity` \[m/s\], or by default their own, and `pressure` \[Pa\], with that of the acoustic
    /// relaxation. No product is fused with a sum: the state has the same bits on each path.
    #[inline(always)]
    pub fn pack<L: Lanes>(
        &self,
        first: usize,
        motion: &Motion<S, L>,
        mass: L,
        velocity: Option<S::Of<L>>,
        pressure: L,
        findings: &mut LaneScanFindings<L>,
    ) -> [S::Particle; WIDTH] {
        let Motion { x, v: own_velocity, rho: density } = *motion;
        findings.add(&self.limits, self.first + first, motion, self.displacement(first, x));
        let v = match velocity {
            Some(velocity) => velocity,
            None => own_velocity,
        };
        let motion = LaneMotion { x, v };
        S::Particle::pack(LaneParticles { motion, density, pressure, volume: mass / density })
    }

    /// Eq. (3) \[Pa\] of densities \[kg/m³\].
    #[inline(always)]
    pub fn pressures<L: Lanes>(&self, density: L) -> L {
        self.equation_of_state.pressures(density)
    }

    /// Displacement of particles since the lists were built \[m\].
    #[inline(always)]
    fn displacement<L: Lanes>(&self, first: usize, x: S::Of<L>) -> Option<S::Of<L>> {
        let origin = match self.origin {
            Some(origin) => vectors::<S, L>(origin, first),
            None => return None,
        };
        let moved = S::minus(x, origin);
        Some(match self.periodic {
            Some(geometry) => geometry.nearest(moved),
            None => moved,
        })
    }
}
