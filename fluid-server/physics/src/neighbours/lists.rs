//! Neighbour lists with a skin, and the cell-sorted order of the fluid.

use std::sync::Arc;

use sph::coupling::stage::StageTime;
use sph::neighbours::{Cells, bounds, largest_displacement};
use sph::space::geometry::{Geometry, Open, Periodic};
use sph::space::tensors::SpaceVector;
use sph::tasks::{for_each, map};

use super::background_grid::{BackgroundGrid, NodeSpacings};
use super::drift::Drift;
use super::placement::{PartRows, Placement};
use super::rows::{Order, Padding, Rows, Search, Sources, Targets};
use crate::parts::balance::WORK_OF_PARTICLE;
use crate::parts::reach::Reach;
use crate::system::list_limits::{
    LARGEST_STAGE_MOVE, PLANE_HALF_WIDTH, Skins, farthest, skin_balance, skins,
};
use crate::system::model::FluidModel;
use crate::system::packed_particle::{FluidSpace, Packed, PeriodicNodes};
use crate::system::state::{FluidState, ListOrigin, Scratch, StepStart};
use crate::system::tasks::TASK;
use crate::system::walls::{WallField, bytes_of_own, place};

/// Steps in which the nodes keep their places: about as long as lists last.
const BACKGROUND_STEPS: u64 = 16;

/// Lists of all pairs closer than support radius plus skin.
#[derive(Debug)]
pub struct Lists<S: FluidSpace> {
    /// Fluid neighbours of each fluid particle.
    pub fluid: Rows,
    /// Wall neighbours of each fluid particle.
    pub walls: Rows,
    /// Fluid neighbours of each wall particle.
    pub fluid_of_walls: Rows,
    /// Which particles this part has, and where its copies of others lie.
    placement: Placement<S>,
    /// Fluid by cells.
    fluid_sources: Sources<S>,
    /// Walls by cells.
    wall_sources: Sources<S>,
    /// Memory for sorting.
    numbers: Vec<f64>,
    /// Positions of moving walls when the lists were built.
    wall_origin: Arc<Vec<S::Vector>>,
    /// Fluid particles that could cross a wall before the next list build; only where no wall moves.
    near_walls: Vec<u32>,
    /// Whether each particle is one of them.
    is_near: Vec<bool>,
    /// Nodes over the fluid, with the volume correction.
    background: BackgroundGrid,
    /// The period of steps for which they are placed.
    background_period: Option<u64>,
    /// Displacements by cell.
    drift: Drift<S>,
    /// Lower bound of the unused part of the skin \[m\], where it is known.
    remaining_skin: Option<f64>,
    /// Whether the lists belong to the state's `list_origin`.
    current: bool,
}

impl<S: FluidSpace> Default for Lists<S> {
    fn default() -> Self {
        Self {
            fluid: Rows::default(),
            walls: Rows::default(),
            fluid_of_walls: Rows::default(),
            placement: Placement::default(),
            fluid_sources: Sources::new(Order::ByCell),
            wall_sources: Sources::new(Order::AsGiven),
            numbers: Vec::new(),
            wall_origin: Arc::default(),
            near_walls: Vec::new(),
            is_near: Vec::new(),
            background: BackgroundGrid::default(),
            background_period: None,
            drift: Drift::default(),
            remaining_skin: None,
            current: false,
        }
    }
}

impl<S: FluidSpace> Lists<S> {
    /// Whether particles moved so far that the lists may miss a pair, now or after the moves to come; `displacement`
    /// is the largest since the lists were built \[m\]. `None` where [`Lists::is_approached`] decides.
    ///
    /// Where particles have moved far, such as in a jet, their neighbours have moved alike: then relative displacements
    /// decide. They are evaluated only when the skin left at their last evaluation does not cover all moves since; the
    /// result does not depend on when that is.
    pub fn outdated(
        &mut self,
        model: &FluidModel<S>,
        state: &FluidState<S>,
        displacement: f64,
        moves: Moves,
        walls: &WallField<S>,
    ) -> Option<bool> {
        let (skin, domain) = (state.list_skin, &model.domain);
        if state.list_origin.is_none() || !self.current {
            return Some(true);
        }
        let displacement = displacement + moves.next();
        if model.walls.moves() || domain.is_periodic() {
            // Two particles approach by at most twice the largest displacement.
            let walls_moved = || largest_displacement(domain, &walls.position, &self.wall_origin);
            return Some(displacement > 0.5 * skin || (model.walls.moves() && walls_moved() > 0.5 * skin));
        }
        if displacement > farthest(model.constants.particle_spacing) {
            return Some(true);
        }
        let growth = Drift::<S>::growth(moves.last + moves.next());
        self.remaining_skin = self.remaining_skin.map(|skin| skin - growth);
        self.remaining_skin.is_some_and(|skin| skin >= 0.0).then_some(false)
    }

    /// Whether two particles may have approached each other by more than the skin, now or after the moves to come. `fluid`
    /// are the particles as pair sums read them, with copies.
    pub fn is_approached(
        &mut self,
        model: &FluidModel<S>,
        state: &FluidState<S>,
        fluid: &[S::Particle],
        moves: Moves,
    ) -> bool {
        let FluidState { position, velocity, list_origin, .. } = state;
        let Some(origin) = list_origin else { return true };
        let Self { fluid_sources, placement, drift, .. } = self;
        let (cells, ahead) = (fluid_sources.grid(), moves.ahead);
        let approach = if placement.halo().is_none() {
            drift.approach(cells, |i| Some([position[i] - origin.position[i], velocity[i] * ahead]))
        } else {
            // Of copies only the velocity that pair sums read is known: where moves are to come, it is their own.
            let origin = placement.positions();
            let own = drift.approach(cells, |place| {
                let i = fluid_sources.given(place);
                let [x, v] = [fluid[i].position(), fluid[i].velocity()];
                placement.is_within(Reach::Walls, i).then(|| [x - origin[i], v * ahead])
            });
            model.team.largest(own)
        };
        self.remaining_skin = Some(state.list_skin - approach);
        approach > state.list_skin
    }

    /// Sorts the particles by cells and builds the lists for the present state and for `moves` to come.
    pub fn rebuild(
        &mut self,
        model: &FluidModel<S>,
        state: &mut FluidState<S>,
        base: &mut StepStart<S>,
        time: &StageTime,
        moves: Moves,
    ) {
        state.list_skin = next_skin(model, state, time);
        state.wrap(base, &model.domain);
        let radius = radius(model, state.list_skin);
        if model.team.is_alone() {
            self.fluid_sources.bin(&model.domain, &state.position, radius);
            let (order, integers) = self.fluid_sources.order_and_spare();
            state.reorder(base, order, Scratch { integers, numbers: &mut self.numbers });
            self.placement.alone(model, self.fluid_sources.grid());
        } else {
            let cells = self.cells(model, &state.position, state.total(), radius);
            let of_particle = map(state.len(), TASK, |i| cells.index(&model.domain, &state.position[i]));
            // The lists are those of these particles, unless some have left: of others, then, which cost about the same.
            // Pairs with walls count twice, for the states of walls too.
            let weight = |i: usize| self.fluid.work(i) + 2.0 * self.walls.work(i) + WORK_OF_PARTICLE as f64;
            self.placement.divide(model, cells, of_particle, weight, state, base);
            self.bin_copies(model, cells);
        }
        let origin = state.list_origin.get_or_insert_default();
        origin.time = time.state_time();
        origin.position.clone_from(&state.position);
        state.list_builds += 1;
        self.build(model, origin, state.list_skin);
        self.remaining_skin = Some(state.list_skin - Drift::<S>::growth(moves.next()));
    }

    /// Builds the lists that belong to the state's origin unless they are present, as after a restore.
    pub fn restore(&mut self, model: &FluidModel<S>, state: &mut FluidState<S>) {
        let (false, Some(origin)) = (self.current, &state.list_origin) else { return };
        let radius = radius(model, state.list_skin);
        if model.team.is_alone() {
            self.fluid_sources.bin(&model.domain, &origin.position, radius);
            self.placement.alone(model, self.fluid_sources.grid());
        } else {
            let cells = self.cells(model, &origin.position, state.total(), radius);
            let of_particle = map(state.len(), TASK, |i| cells.index(&model.domain, &origin.position[i]));
            self.placement.restore(model, cells, of_particle, state);
            self.bin_copies(model, cells);
        }
        if let Some(origin) = &state.list_origin {
            self.build(model, origin, state.list_skin);
        }
    }

    /// To be called where the particles of this part are not those for which the lists were built.
    pub fn forget_particles(&mut self) {
        self.placement.forget_particles();
    }

    /// Gives back the memory. What is known of the parts stays, since the particles keep their places.
    pub fn release(&mut self) {
        self.placement.release();
        self.background.release();
        let (placement, background) =
            (std::mem::take(&mut self.placement), std::mem::take(&mut self.background));
        *self = Self { placement, background, ..Self::default() };
    }

    /// The cells around the `total` particles of all parts, of which own ones are at `position` \[m\].
    fn cells(&self, model: &FluidModel<S>, position: &[S::Vector], total: usize, radius: f64) -> Cells<S> {
        let bounds = model.team.join(bounds::<S>(position), |[lower, upper], [low, high]| {
            (*lower, *upper) = (lower.inf(&low), upper.sup(&high));
        });
        Cells::new(&model.domain, bounds, total, radius)
    }

    /// Bins own particles and copies into `cells`.
    fn bin_copies(&mut self, model: &FluidModel<S>, cells: Cells<S>) {
        let Self { fluid_sources, placement, .. } = self;
        fluid_sources.keep(Order::AsGiven);
        fluid_sources.bin_in(cells, &model.domain, placement.positions());
        fluid_sources.place(&model.domain, placement.positions());
        fluid_sources.find_places();
    }

    /// Index of the particle at `place` in the order of cells.
    #[inline(always)]
    pub fn in_cell_order(&self, place: usize) -> usize {
        self.fluid_sources.given(place)
    }

    /// Which particles this part has, and where its copies of others lie.
    #[inline(always)]
    pub fn placement(&self) -> &Placement<S> {
        &self.placement
    }

    /// The only particles that can have passed a wall, when none has moved by more than the root of `square` \[m²\]
    /// in a stage; `None` when that is not known.
    pub fn near_walls(&self, model: &FluidModel<S>, square: f64) -> Option<&[u32]> {
        let holds =
            !model.walls.moves() && square <= (LARGEST_STAGE_MOVE * model.constants.particle_spacing).powi(2);
        holds.then_some(&self.near_walls[..])
    }

    /// Finds the particles that could be behind the plane of a wall particle, and within its width, after they have
    /// moved by `skin` \[m\], the most that lists bear there, and a stage from before it: by twice that at most
    /// behind it.
    fn find_near_walls(&mut self, model: &FluidModel<S>, fluid: &[S::Vector], skin: f64) {
        self.near_walls.clear();
        if model.walls.moves() {
            return;
        }
        let spacing = model.constants.particle_spacing;
        let near = skin + LARGEST_STAGE_MOVE * spacing;
        let reach = near + (PLANE_HALF_WIDTH * spacing).hypot(2.0 * near);
        let Self { walls, wall_origin, is_near, near_walls, .. } = self;
        let is_near_wall = |i: usize, is_near: &mut bool| {
            let distance = |w| model.domain.separation(&fluid[i], &wall_origin[w]);
            *is_near = !walls.of(i).is_empty()
                && walls.neighbours(i).any(|w| distance(w).norm_squared() <= reach * reach);
        };
        is_near.resize(fluid.len(), false);
        for_each(&mut is_near[..], TASK, is_near_wall);
        near_walls.extend((0u32..).zip(&*is_near).filter(|(_, near)| **near).map(|(i, _)| i));
    }

    /// Bytes in use.
    pub fn bytes(&self) -> usize {
        [&self.fluid, &self.walls, &self.fluid_of_walls].into_iter().map(Rows::bytes).sum::<usize>()
            + self.fluid_sources.bytes()
            + self.wall_sources.bytes()
            + bytes_of_own::<S>(&self.wall_origin)
            + 8 * self.numbers.capacity()
            + 4 * self.near_walls.capacity()
            + self.is_near.capacity()
            + self.background.bytes()
            + self.drift.bytes()
            + self.placement.bytes()
    }

    /// Places the nodes over the fluid for `step`. They move with the number of the step and not with the builds of lists,
    /// which depend on disconnected water elsewhere.
    pub fn place_background(&mut self, model: &FluidModel<S>, step: u64) {
        let period = step / BACKGROUND_STEPS;
        if self.background_period != Some(period) {
            let farthest = farthest(model.constants.particle_spacing);
            let (cells, open) = (self.fluid_sources.grid(), model.constants.smoothing_length());
            let periodic = match S::PERIODIC_NODES {
                PeriodicNodes::Lattice => model.constants.particle_spacing,
                PeriodicNodes::AsOther => open,
            };
            let spacings = NodeSpacings { open, periodic };
            let (domain, background) = (&model.domain, &mut self.background);
            match self.background_period {
                None => background.place(domain, cells, spacings, farthest, period),
                Some(_) => background.shift(domain, cells, spacings, farthest, period),
            }
            self.background_period = Some(period);
        }
    }

    /// Nodes over the fluid; none without the volume correction.
    pub fn background(&self) -> &BackgroundGrid {
        &self.background
    }

    /// Builds the lists of a fluid whose particles are sorted and binned, with walls as of the time of `origin`.
    fn build(&mut self, model: &FluidModel<S>, origin: &ListOrigin<S>, skin: f64) {
        let (domain, fluid) = (&model.domain, &origin.position[..]);
        if model.walls.moves() || !self.current {
            let Skins { thickest, .. } = skins::<S>(model.constants.particle_spacing);
            place(&mut self.wall_origin, &model.walls, domain, origin.time);
            self.wall_sources.bin(domain, &self.wall_origin, radius(model, thickest));
            self.wall_sources.place(domain, &self.wall_origin);
        }
        self.placement.find_walls(model, self.fluid_sources.grid(), &self.wall_origin);
        if domain.is_periodic() {
            self.fill(model, Periodic::new(domain), fluid, radius(model, skin));
        } else {
            self.fill(model, Open, fluid, radius(model, skin));
        }
        let Self { fluid: of_fluid, walls, fluid_of_walls, wall_origin, placement, .. } = self;
        placement.find_needs(model, PartRows { fluid: of_fluid, walls, fluid_of_walls }, wall_origin);
        self.remaining_skin = None;
        self.find_near_walls(model, fluid, skin);
        self.background_period = None;
        self.drift.place_walls(self.fluid_sources.grid(), &self.wall_origin);
        self.current = true;
    }

    fn fill<G: Geometry<S>>(&mut self, model: &FluidModel<S>, geometry: G, fluid: &[S::Vector], radius: f64) {
        let Self {
            fluid_sources: of_fluid,
            wall_sources: of_walls,
            wall_origin,
            fluid: fluid_rows,
            walls: wall_rows,
            fluid_of_walls,
            ..
        } = self;
        let search = Search { arithmetic: model.arithmetic, geometry, domain: &model.domain, radius };
        let walls = &wall_origin[..];
        let sources = if model.team.is_alone() { fluid } else { self.placement.positions() };
        // The last wall particle does not act. Indices are of 32 bits.
        let own = Targets { position: fluid, asked: None };
        fluid_rows.build(&search, of_fluid, sources, own, Padding::Target);
        wall_rows.build(&search, of_walls, walls, own, Padding::Index(walls.len() as u32));
        let walls = Targets { position: walls, asked: self.placement.near_walls() };
        fluid_of_walls.build(&search, of_fluid, sources, walls, Padding::Index(u32::MAX));
    }
}

/// Moves of the fluid since [`Lists::outdated`] was asked last, and to come before it is asked again.
#[derive(Clone, Copy, Debug)]
pub struct Moves {
    /// The largest move that was not announced as one to come \[m\].
    pub last: f64,
    /// Time of the moves to come \[s\].
    pub ahead: f64,
    /// Largest speed of the moves to come \[m/s\].
    pub speed: f64,
}

impl Moves {
    /// The largest move to come \[m\].
    fn next(self) -> f64 {
        self.ahead * self.speed
    }
}

/// Radius of the lists with `skin` \[m\].
fn radius<S: FluidSpace>(model: &FluidModel<S>, skin: f64) -> f64 {
    model.kernel.support_radius() + skin
}

/// Skin \[m\] for lists that are built at `time`, by how long the last ones of `state` have lasted.
fn next_skin<S: FluidSpace>(model: &FluidModel<S>, state: &FluidState<S>, time: &StageTime) -> f64 {
    let lasted = state.list_origin.as_ref().map(|origin| time.state_time() - origin.time);
    // Outputs are evaluated in a step of zero length.
    let Some(lasted) = lasted.filter(|_| time.time_step > 0.0) else { return state.list_skin };
    let spacing = model.constants.particle_spacing;
    let steps = (lasted / time.time_step).max(1.0);
    let Skins { thinnest, thickest, .. } = skins::<S>(spacing);
    (skin_balance::<S>() * spacing * state.list_skin / steps).sqrt().clamp(thinnest, thickest)
}
