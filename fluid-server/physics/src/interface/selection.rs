//! Selection of the fluid particles that are sent to the partner.

use sph::coupling::exchange::Extent;
use sph::coupling::extent::{ExtentTracker, OccupiedCells, ReachMap};
use sph::interface::states::InterfaceStates;
use sph::space::domain::Domain;
use sph::tasks::for_each;

use crate::system::list_limits::farthest;
use crate::system::packed_particle::{FluidSpace, Packed};
use crate::system::state::FluidState;
use crate::team::Team;

/// Edge of the boxes that describe the fluid's extent, in support radii.
const EXTENT_CELL: f64 = 4.0;

/// In place of the index of a particle that another part owns.
const OF_OTHERS: u32 = u32::MAX;

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
    /// Index of the own particle behind each interface state, [`OF_OTHERS`] where it is another part's.
    members: Vec<u32>,
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

    /// Describes where the particles of all parts, own ones at `position` \[m\], can be until the next list build.
    pub fn update_extent(&mut self, team: &Team, position: &[S::Vector]) {
        // Lists are built before a particle has moved farther.
        let occupied = team.join(self.tracker.occupied(position), OccupiedCells::join);
        self.tracker.update(&occupied, self.farthest);
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
        team: &Team,
        state: &FluidState<S>,
        support: f64,
        extent: &Extent,
        reach: f64,
    ) -> Result<(), f64> {
        let own = self.tracker.shortfall(extent, &state.position, support, reach);
        let largest = team.largest(own.err().unwrap_or_default());
        if largest > 0.0 { Err(largest) } else { Ok(()) }
    }

    /// The own particles behind interface states: the index of the state, and that of the particle.
    pub fn members(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.members.iter().enumerate().filter(|(_, i)| **i != OF_OTHERS).map(|(k, i)| (k, *i as usize))
    }

    /// The own particle behind interface state `k`, unless it is another part's.
    pub fn member(&self, k: usize) -> Option<usize> {
        Some(self.members[k]).filter(|i| *i != OF_OTHERS).map(|i| i as usize)
    }

    /// Fills `states` with the particles of all parts within `reach` \[m\] of `partner`, ids ascending; returns the set's
    /// version. `fluid` are the own particles.
    pub fn select(
        &mut self,
        team: &Team,
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
        if !team.is_alone() {
            let (joined, origins) = InterfaceStates::joined(&team.all(std::mem::take(states)));
            let of_others = |(part, i): (usize, usize)| {
                if part == team.rank() { self.members[i] } else { OF_OTHERS }
            };
            self.members = origins.into_iter().map(of_others).collect();
            *states = joined;
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
