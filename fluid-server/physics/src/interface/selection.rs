//! Selection of the fluid particles that are sent to the partner.

use sph::coupling::exchange::Extent;
use sph::coupling::extent::{ExtentTracker, ReachMap};
use sph::interface::states::InterfaceStates;
use sph::space::domain::Domain;
use sph::tasks::for_each;

use crate::system::list_limits::farthest;
use crate::system::packed_particle::{FluidSpace, Packed};
use crate::system::state::FluidState;

/// Edge of the boxes that describe the fluid's extent, in support radii.
const EXTENT_CELL: f64 = 4.0;

/// Particles per task.
const TASK: usize = 1024;

/// Extent of the fluid, and the particles within reach of the partner.
#[derive(Debug)]
pub struct InterfaceSelection<S: FluidSpace> {
    /// Largest displacement of a particle between list builds \[m\].
    farthest: f64,
    tracker: ExtentTracker<S>,
    reach: ReachMap<S>,
    /// Region from which particles may come within reach before the next list build.
    vicinity: ReachMap<S>,
    /// The fluid particles there.
    candidates: Candidates,
    /// Whether each fluid particle is there.
    inside: Vec<bool>,
    /// Index of the fluid particle behind each interface state.
    pub members: Vec<u32>,
    known_ids: Vec<u32>,
    set_version: u64,
}

/// Fluid particles in the vicinity of the partner.
#[derive(Debug, Default)]
struct Candidates {
    /// Their indices, ids ascending.
    particles: Vec<u32>,
    /// Whether they are those of the present lists.
    current: bool,
}

impl<S: FluidSpace> InterfaceSelection<S> {
    /// A selection among particles of `spacing` \[m\] whose kernel reaches to `support` \[m\].
    pub fn new(domain: &Domain<S>, support: f64, spacing: f64) -> Self {
        Self {
            farthest: farthest(spacing),
            tracker: ExtentTracker::new(domain, EXTENT_CELL * support),
            reach: ReachMap::new(domain, support),
            vicinity: ReachMap::new(domain, support),
            candidates: Candidates::default(),
            inside: Vec::new(),
            members: Vec::new(),
            known_ids: Vec::new(),
            set_version: 0,
        }
    }

    /// Describes where the particles at `position` \[m\] can be until the next list build.
    pub fn update_extent(&mut self, position: &[S::Vector]) {
        // Lists are built before a particle has moved farther.
        self.tracker.update(position, self.farthest);
        self.candidates.current = false;
    }

    /// Where the fluid is.
    pub fn extent(&self) -> &Extent {
        self.tracker.extent()
    }

    /// See [`sph::coupling::solver::Solver::covered_by`].
    ///
    /// # Errors
    /// The shortfall \[m\].
    pub fn covered_by(
        &self,
        state: &FluidState<S>,
        support: f64,
        extent: &Extent,
        reach: f64,
    ) -> Result<(), f64> {
        self.tracker.shortfall(extent, &state.position, support, reach)
    }

    /// Fills `states` with the particles within `reach` \[m\] of `partner`, ids ascending; returns the set's version.
    pub fn select(
        &mut self,
        state: &FluidState<S>,
        fluid: &[S::Particle],
        partner: &Extent,
        reach: f64,
        states: &mut InterfaceStates<S>,
    ) -> u64 {
        self.reach.update(partner, reach);
        // Candidates may be sought later than lists are built: a particle may then cross the whole range of
        // displacements.
        let changed = self.vicinity.update(partner, reach + 2.0 * self.farthest);
        if changed || !self.candidates.current {
            self.find_candidates(state);
        }
        let within = |i: &u32| self.reach.contains(&state.position[*i as usize]);
        self.members.clear();
        self.members.extend(self.candidates.particles.iter().copied().filter(within));
        states.clear();
        for &i in &self.members {
            let i = i as usize;
            states.id.push(state.id[i]);
            states.group.push(state.region[i]);
            states.mass.push(state.mass[i]);
            states.position.push(state.position[i]);
            states.velocity.push(fluid[i].velocity());
            states.density.push(state.density[i]);
            states.pressure.push(fluid[i].pressure());
        }
        if states.id != self.known_ids {
            self.known_ids.clone_from(&states.id);
            self.set_version += 1;
        }
        self.set_version
    }

    /// Finds the particles in the vicinity of the partner.
    fn find_candidates(&mut self, state: &FluidState<S>) {
        let Self { vicinity, candidates: Candidates { particles, current }, inside, .. } = self;
        inside.resize(state.len(), false);
        for_each(&mut inside[..], TASK, |i, inside| *inside = vicinity.contains(&state.position[i]));
        particles.clear();
        particles.extend((0u32..).zip(&*inside).filter(|(_, inside)| **inside).map(|(i, _)| i));
        particles.sort_unstable_by_key(|i| state.id[*i as usize]);
        *current = true;
    }
}
