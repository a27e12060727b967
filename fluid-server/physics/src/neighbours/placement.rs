//! Which particles a part has, where its copies of others lie, and what can be computed before these arrive.

use sph::neighbours::{CellGrid, Cells};
use sph::tasks::map;

use super::rows::Rows;
use crate::parts::balance::{Balance, Imbalance};
use crate::parts::bricks::Bricks;
use crate::parts::halo::Halo;
use crate::parts::lattice::Lattice;
use crate::parts::reach::Reach;
use crate::parts::redistribution::redistribute;
use crate::system::model::FluidModel;
use crate::system::packed_particle::FluidSpace;
use crate::system::state::{FluidState, ListOrigin, StepStart};
use crate::system::tasks::{Groups, TASK};

/// Wall particles per task.
const WALL_TASK: usize = 64;

/// What the sums of particles need beside own particles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Needs {
    /// Nothing: they can be computed while copies are under way.
    Nothing,
    /// Copies.
    Copies,
}

/// The place of a part among all, and the groups of its particles whose sums are made one after the other.
#[derive(Debug)]
pub struct Placement<S: FluidSpace> {
    groups: Groups,
    /// Tasks of wall particles.
    walls: Groups,
    /// `None` in a part that is alone.
    place: Option<Place<S>>,
    balance: Balance,
}

/// The place of a part beside others.
#[derive(Debug)]
struct Place<S: FluidSpace> {
    lattice: Lattice<S>,
    bricks: Bricks<S>,
    halo: Halo,
    /// Positions of own particles and copies when the lists were built \[m\].
    positions: Vec<S::Vector>,
    /// Own particles that have copies among their neighbours.
    border: Vec<u32>,
    /// Groups that need no copies, and those that do.
    groups: [Vec<u32>; 2],
    /// Whether own particles can meet each wall particle, before they are known to.
    near_walls: Vec<bool>,
    /// What each wall particle needs, `None` where no own particle meets it.
    walls: Vec<Option<Needs>>,
    /// Tasks of wall particles of which some need no copies, and of which some do.
    wall_tasks: [Vec<u32>; 2],
}

impl<S: FluidSpace> Default for Placement<S> {
    fn default() -> Self {
        Self { groups: Groups::default(), walls: Groups::default(), place: None, balance: Balance::default() }
    }
}

/// The lists of a part.
#[derive(Clone, Copy, Debug)]
pub struct PartRows<'a> {
    /// Fluid neighbours of each own particle.
    pub fluid: &'a Rows,
    /// Wall neighbours of each own particle.
    pub walls: &'a Rows,
    /// Fluid neighbours of each wall particle.
    pub fluid_of_walls: &'a Rows,
}

impl<S: FluidSpace> Placement<S> {
    /// Takes all particles, sorted by the cells in `grid`, as a part that is alone.
    pub fn alone(&mut self, model: &FluidModel<S>, grid: &CellGrid<S>) {
        let lattice = Lattice::new(*grid.shape(), model.constants.particle_spacing);
        self.groups = Groups::new(lattice.ends_in(grid));
        self.place = None;
    }

    /// Gives each part its share of the particles, own ones of which lie in the cells `of_particle` among `cells`; `weight`
    /// is the work of each, where lists say it.
    pub fn divide(
        &mut self,
        model: &FluidModel<S>,
        cells: Cells<S>,
        of_particle: Vec<u32>,
        weight: impl Fn(usize) -> f64,
        state: &mut FluidState<S>,
        base: &mut StepStart<S>,
    ) {
        let team = &model.team;
        let lattice = Lattice::new(cells, model.constants.particle_spacing);
        let computing = (!team.shares_cores()).then(|| team.clock().computing());
        let loads = team.all(self.balance.load(computing));
        let slowness = self.balance.slowness(&loads, team.rank());
        let kept = self.place.take().map(|place| place.bricks).filter(|_| !self.balance.is_lost());
        let bricks =
            kept.unwrap_or_else(|| Bricks::divided(team, &lattice, &of_particle, |i| slowness * weight(i)));
        let of_particle = redistribute(team, &lattice, &bricks, of_particle, state, base);
        self.settle(model, lattice, bricks, &of_particle, &state.position);
    }

    /// Gives each part its share of the particles with the `origin` of lists that are to be built again.
    pub fn restore(
        &mut self,
        model: &FluidModel<S>,
        cells: Cells<S>,
        of_particle: Vec<u32>,
        state: &mut FluidState<S>,
    ) {
        let team = &model.team;
        let lattice = Lattice::new(cells, model.constants.particle_spacing);
        let bricks = self.place.take().map(|place| place.bricks);
        let bricks = bricks.unwrap_or_else(|| Bricks::divided(team, &lattice, &of_particle, |_| 1.0));
        // The origin goes with the particles.
        let ListOrigin { time, position } = state.list_origin.take().unwrap_or_default();
        let mut with = StepStart { position, ..StepStart::default() };
        let of_particle = redistribute(team, &lattice, &bricks, of_particle, state, &mut with);
        self.settle(model, lattice, bricks, &of_particle, &with.position);
        state.list_origin = Some(ListOrigin { time, position: with.position });
    }

    fn settle(
        &mut self,
        model: &FluidModel<S>,
        lattice: Lattice<S>,
        bricks: Bricks<S>,
        of_particle: &[u32],
        position: &[S::Vector],
    ) {
        self.groups = Groups::new(lattice.ends(of_particle));
        let halo = Halo::new(&model.team, &lattice, &bricks, of_particle);
        self.place = Some(Place {
            positions: halo.with_copies(&model.team, position),
            lattice,
            bricks,
            halo,
            border: Vec::new(),
            groups: Default::default(),
            near_walls: Vec::new(),
            walls: Vec::new(),
            wall_tasks: Default::default(),
        });
    }

    /// Finds which of the wall particles at `walls` \[m\] own particles can meet, which lie in the cells of `grid` as copies do.
    pub fn find_walls(&mut self, model: &FluidModel<S>, grid: &CellGrid<S>, walls: &[S::Vector]) {
        let tasks =
            (0..walls.len()).step_by(WALL_TASK).map(|first| walls.len().min(first + WALL_TASK) as u32);
        self.walls = Groups::new(tasks.collect());
        let Some(place) = &mut self.place else { return };
        let (counts, own) = (grid.counts(), place.bricks.cells(&place.lattice, model.team.rank()));
        place.near_walls = map(walls.len(), WALL_TASK, |w| {
            let cell = grid.cell(&model.domain.wrapped(&walls[w])).place();
            // The last cell is up to twice as long.
            let is_beyond = |axis: usize| cell[axis] < -1 || cell[axis] > counts[axis] as i32 + 1;
            let nearest = S::axes(|axis| (cell[axis].max(0) as usize).min(counts[axis] - 1));
            let distance = own.distance_to_cell(nearest);
            distance.is_some_and(|distance| distance <= Reach::Neighbours.rings())
                && !(0..S::DIMENSIONS).any(is_beyond)
        });
    }

    /// Whether own particles can meet each wall particle; `None` in a part that is alone.
    pub fn near_walls(&self) -> Option<&[bool]> {
        self.place.as_ref().map(|place| &place.near_walls[..])
    }

    /// Finds in the lists of own particles what they need, with the wall particles at `walls` \[m\].
    pub fn find_needs(&mut self, model: &FluidModel<S>, rows: PartRows<'_>, wall_position: &[S::Vector]) {
        let Self { groups, place, balance, .. } = self;
        let Some(place) = place else { return };
        let own = place.halo.own();
        let at_border = map(own, TASK, |i| rows.fluid.has_from(i, own));
        place.border.clear();
        place.border.extend((0u32..).zip(&at_border).filter(|(_, is)| **is).map(|(i, _)| i));
        // Outputs ask the part that answers for them; where those that move are by then is not known.
        let is_asked_for = |x| model.walls.moves() || place.answers_for(model, x);
        let near = wall_position.iter().zip(&place.near_walls);
        let mut walls: Vec<_> =
            near.map(|(x, near)| (*near && is_asked_for(x)).then_some(Needs::Nothing)).collect();
        (0..own).flat_map(|i| rows.walls.neighbours(i)).for_each(|w| walls[w] = Some(Needs::Nothing));
        for (w, needs) in walls.iter_mut().enumerate().filter(|(_, needs)| needs.is_some()) {
            if rows.fluid_of_walls.has_from(w, own) {
                *needs = Some(Needs::Copies);
            }
        }
        let meets_border = |i: usize| rows.walls.neighbours(i).any(|w| walls[w] == Some(Needs::Copies));
        let mut border = place.border.iter().map(|i| *i as usize).peekable();
        place.groups = Default::default();
        for group in groups.all() {
            let particles = groups.particles(*group);
            let mut waits = false;
            while border.next_if(|i| *i < particles.end).is_some() {
                waits = true;
            }
            let waits = waits || particles.clone().any(meets_border);
            place.groups[usize::from(waits)].push(*group);
        }
        let with = |needs: Needs| {
            let has_some = |task: &u32| self.walls.particles(*task).any(|w| walls[w] == Some(needs));
            self.walls.all().iter().copied().filter(has_some).collect()
        };
        place.wall_tasks = [Needs::Nothing, Needs::Copies].map(with);
        place.walls = walls;
        let batches = rows.fluid.batches() + rows.walls.batches() + rows.fluid_of_walls.batches();
        balance.built(own, batches, model.team.clock().computing());
    }

    /// Where copies of particles of other parts lie; `None` in a part that is alone.
    #[inline(always)]
    pub fn halo(&self) -> Option<&Halo> {
        self.place.as_ref().map(|place| &place.halo)
    }

    /// Number of places for `own` particles and the copies.
    pub fn places(&self, own: usize) -> usize {
        own + self.halo().map_or(0, Halo::copies)
    }

    /// Whether the particle at `place` is an own one or a copy within `reach`.
    #[inline(always)]
    pub fn is_within(&self, reach: Reach, place: usize) -> bool {
        self.halo().is_none_or(|halo| halo.is_within(reach, place))
    }

    /// Positions of own particles and copies when the lists were built \[m\]; empty in a part that is alone.
    pub fn positions(&self) -> &[S::Vector] {
        self.place.as_ref().map_or(&[], |place| &place.positions)
    }

    /// Own particles that have copies among their neighbours.
    pub fn border(&self) -> &[u32] {
        self.place.as_ref().map_or(&[], |place| &place.border)
    }

    /// Groups of own particles whose sums are made one after the other.
    pub fn groups(&self) -> &Groups {
        &self.groups
    }

    /// The groups with such `needs`.
    pub fn groups_with(&self, needs: Needs) -> &[u32] {
        match (&self.place, needs) {
            (Some(place), _) => &place.groups[needs as usize],
            (None, Needs::Nothing) => self.groups.all(),
            (None, Needs::Copies) => &[],
        }
    }

    /// Wall particles whose states are found one after the other.
    pub fn wall_groups(&self) -> &Groups {
        &self.walls
    }

    /// The groups of wall particles of which some have such `needs`.
    pub fn wall_groups_with(&self, needs: Needs) -> &[u32] {
        match (&self.place, needs) {
            (Some(place), _) => &place.wall_tasks[needs as usize],
            (None, Needs::Nothing) => self.walls.all(),
            (None, Needs::Copies) => &[],
        }
    }

    /// What wall particle `w` needs; `None` where no own particle meets it.
    #[inline(always)]
    pub fn of_wall(&self, w: usize) -> Option<Needs> {
        match &self.place {
            Some(place) => place.walls.get(w).copied().flatten(),
            None => Some(Needs::Nothing),
        }
    }

    /// Whether this part holds all particles near `x` \[m\] and is the one that answers for what is there.
    pub fn answers_for(&self, model: &FluidModel<S>, x: &S::Vector) -> bool {
        self.place.as_ref().is_none_or(|place| place.answers_for(model, x))
    }

    /// How unequal the work of the parts was.
    pub fn imbalance(&self) -> Imbalance {
        self.balance.imbalance()
    }

    /// To be called where the particles of this part are not those for which the lists were built.
    pub fn forget_particles(&mut self) {
        self.groups = Groups::default();
        if let Some(place) = &mut self.place {
            place.halo = Halo::default();
        }
    }

    /// Gives back the memory that belongs to lists. The particles keep their places.
    pub fn release(&mut self) {
        if let Some(place) = &mut self.place {
            (place.positions, place.border) = (Vec::new(), Vec::new());
            (place.near_walls, place.walls) = (Vec::new(), Vec::new());
        }
    }

    /// Bytes in use for particles.
    pub fn bytes(&self) -> usize {
        let of_place = |place: &Place<S>| {
            place.halo.bytes()
                + size_of::<S::Vector>() * place.positions.capacity()
                + 4 * place.border.capacity()
                + place.near_walls.capacity()
                + size_of::<Option<Needs>>() * place.walls.capacity()
        };
        self.groups.bytes() + self.walls.bytes() + self.place.as_ref().map_or(0, of_place)
    }
}

impl<S: FluidSpace> Place<S> {
    fn answers_for(&self, model: &FluidModel<S>, x: &S::Vector) -> bool {
        let cell = self.lattice.cells().index(&model.domain, x);
        self.bricks.owner(&self.lattice.middle_of(cell)) == model.team.rank()
    }
}
