//! How the solvers that are started here share the cores of this machine.

use sph::coupling::solver::Role;

use crate::case::Case;

/// Compute threads of each solver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Threads {
    fluid: usize,
    solid: usize,
    fluid_parts: usize,
}

impl Threads {
    /// `wanted` threads for each, or all cores shared by the particles of `case`.
    pub fn of(case: &Case, wanted: Option<u16>) -> Self {
        if let Some(wanted) = wanted {
            return Self::each(usize::from(wanted));
        }
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let [fluid, solid] = case.particles();
        Self::shared(cores, fluid, solid)
    }

    /// `threads` for each solver.
    pub fn each(threads: usize) -> Self {
        Self { fluid: threads, solid: threads, fluid_parts: 1 }
    }

    /// Shares of `cores` by numbers of particles, rounded up: threads of a small solver would spin on cores that the
    /// large one needs, and one that waits leaves its core to the other.
    fn shared(cores: usize, fluid: usize, solid: usize) -> Self {
        let share = |particles: usize| (cores * particles).div_ceil((fluid + solid).max(1)).max(1);
        Self { fluid: share(fluid), solid: share(solid), fluid_parts: 1 }
    }

    /// The same with a fluid in `parts`, see [`fluid_server::FluidFactory::in_threads`].
    pub fn with_fluid_parts(self, parts: usize) -> Self {
        Self { fluid_parts: parts, ..self }
    }

    /// Parts of the fluid.
    pub fn fluid_parts(self) -> usize {
        self.fluid_parts
    }

    /// Threads of the solver of `role`.
    pub fn for_role(self, role: Role) -> usize {
        match role {
            Role::Fluid => self.fluid,
            Role::Solid => self.solid,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cores_are_shared_by_particles() {
        let shared = |cores, fluid, solid| {
            let threads = Threads::shared(cores, fluid, solid);
            (threads.for_role(Role::Fluid), threads.for_role(Role::Solid))
        };
        assert_eq!(shared(2, 11_510, 564), (2, 1));
        assert_eq!(shared(16, 11_510, 564), (16, 1));
        assert_eq!(shared(8, 5_000, 5_000), (4, 4));
        assert_eq!(shared(4, 300, 9_000), (1, 4));
        // A side that has no particles starts no solver.
        assert_eq!(shared(4, 9_000, 0), (4, 1));
        assert_eq!(shared(1, 10, 10), (1, 1));
    }
}
