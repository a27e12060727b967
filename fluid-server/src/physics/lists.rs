//! Neighbour lists with a skin, and the cell-sorted order of the fluid.

use sph::geometry::{Geometry, Open, Periodic};
use sph::neighbours::largest_displacement;
use sph::vector::Vector;

use super::leaving::PLANE_HALF_WIDTH;
use super::model::FluidModel;
use super::rows::{Order, Padding, Rows, Search, Sources};
use super::state::{Base, FluidState, ListOrigin, Scratch};
use super::walls::WallField;

/// Width of the skin around the support radius in particle spacings. The optimum is flat between 0.3 and 0.4.
const SKIN: f64 = 0.3;

/// Largest displacement since the lists were built for which [`Lists::near_walls`] hold, in particle spacings: half the
/// skin, and what a step may add.
const NEAR: f64 = 0.25;

/// Lists of all pairs closer than support radius plus skin.
#[derive(Debug)]
pub struct Lists {
    /// Fluid neighbours of each fluid particle.
    pub fluid: Rows,
    /// Wall neighbours of each fluid particle.
    pub walls: Rows,
    /// Fluid neighbours of each wall particle.
    pub fluid_of_walls: Rows,
    /// Fluid by cells.
    fluid_sources: Sources,
    /// Walls by cells.
    wall_sources: Sources,
    /// Memory for sorting.
    numbers: Vec<f64>,
    /// Positions of moving walls when the lists were built.
    wall_origin: WallField,
    /// Fluid particles that could pass a wall before they have moved by [`NEAR`]; only where no wall moves.
    near_walls: Vec<u32>,
    /// Whether the lists belong to the state's `list_origin`.
    current: bool,
}

impl Default for Lists {
    fn default() -> Self {
        Self {
            fluid: Rows::default(),
            walls: Rows::default(),
            fluid_of_walls: Rows::default(),
            fluid_sources: Sources::new(Order::ByCell),
            wall_sources: Sources::new(Order::AsGiven),
            numbers: Vec::new(),
            wall_origin: WallField::default(),
            near_walls: Vec::new(),
            current: false,
        }
    }
}

impl Lists {
    /// Skin \[m\] for particles of `spacing` \[m\].
    pub fn skin(spacing: f64) -> f64 {
        SKIN * spacing
    }

    /// Whether particles moved so far that the lists may miss a pair; `moved` is the fluid's largest displacement since
    /// they were built \[m\].
    ///
    /// Two particles approach by at most twice the largest displacement, hence half the skin each.
    pub fn outdated(&self, model: &FluidModel, moved: f64, walls: &WallField) -> bool {
        let limit = 0.5 * Self::skin(model.constants.particle_spacing);
        let walls_moved = || largest_displacement(&model.domain, &walls.position, &self.wall_origin.position);
        moved > limit || (model.walls.moves() && walls_moved() > limit)
    }

    /// Sorts the particles by cells and builds the lists for the present state at `time` \[s\].
    pub fn rebuild(&mut self, model: &FluidModel, state: &mut FluidState, base: &mut Base, time: f64) {
        state.wrap(base, &model.domain);
        self.fluid_sources.bin(&model.domain, &state.position, Self::radius(model));
        let (order, integers) = self.fluid_sources.order_and_spare();
        state.reorder(base, order, Scratch { integers, numbers: &mut self.numbers });
        let origin = state.list_origin.get_or_insert_default();
        origin.time = time;
        origin.position.clone_from(&state.position);
        state.list_builds += 1;
        self.build(model, &origin.position, origin.time);
    }

    /// Builds the lists that belong to the state's origin unless they are present, as after a restore.
    pub fn restore(&mut self, model: &FluidModel, state: &FluidState) {
        if let (false, Some(origin)) = (self.current, &state.list_origin) {
            self.fluid_sources.bin(&model.domain, &origin.position, Self::radius(model));
            let ListOrigin { time, position } = origin;
            self.build(model, position, *time);
        }
    }

    /// The only particles that can have passed a wall, when none has moved by more than the root of `square` \[m²\] since
    /// the lists were built; `None` when that is not known.
    pub fn near_walls(&self, model: &FluidModel, square: f64) -> Option<&[u32]> {
        let holds = !model.walls.moves() && square <= (NEAR * model.constants.particle_spacing).powi(2);
        holds.then_some(&self.near_walls[..])
    }

    /// Finds the particles that could be behind the plane of a wall particle, and within its width, after they have
    /// moved by [`NEAR`] from before it: by twice that at most behind it.
    fn find_near_walls(&mut self, model: &FluidModel, fluid: &[Vector]) {
        self.near_walls.clear();
        if model.walls.moves() {
            return;
        }
        let reach = (NEAR + PLANE_HALF_WIDTH.hypot(2.0 * NEAR)) * model.constants.particle_spacing;
        let is_near = |i: &u32| {
            let i = *i as usize;
            let distance = |w| model.domain.separation(&fluid[i], &self.wall_origin.position[w]);
            self.walls.neighbours(i).any(|w| distance(w).norm_squared() <= reach * reach)
        };
        let near = (0u32..).take(fluid.len()).filter(is_near);
        self.near_walls.extend(near);
    }

    /// Bytes in use.
    pub fn bytes(&self) -> usize {
        [&self.fluid, &self.walls, &self.fluid_of_walls].into_iter().map(Rows::bytes).sum::<usize>()
            + self.fluid_sources.bytes()
            + self.wall_sources.bytes()
            + 8 * self.numbers.capacity()
            + 4 * self.near_walls.capacity()
    }

    fn radius(model: &FluidModel) -> f64 {
        model.kernel.support_radius() + Self::skin(model.constants.particle_spacing)
    }

    /// Builds the lists of a fluid whose particles are sorted and binned, with walls as of `time` \[s\].
    fn build(&mut self, model: &FluidModel, fluid: &[Vector], time: f64) {
        let (domain, radius) = (&model.domain, Self::radius(model));
        if model.walls.moves() || !self.current {
            self.wall_origin.place(&model.walls, domain, time);
            self.wall_sources.bin(domain, &self.wall_origin.position, radius);
            self.wall_sources.place(domain, &self.wall_origin.position);
        }
        if domain.is_periodic() {
            self.fill(model, Periodic::new(domain), fluid);
        } else {
            self.fill(model, Open, fluid);
        }
        self.find_near_walls(model, fluid);
        self.current = true;
    }

    fn fill<G: Geometry>(&mut self, model: &FluidModel, geometry: G, fluid: &[Vector]) {
        let Self {
            fluid_sources: of_fluid,
            wall_sources: of_walls,
            wall_origin,
            fluid: fluid_rows,
            walls: wall_rows,
            fluid_of_walls,
            ..
        } = self;
        let search = Search {
            arithmetic: model.arithmetic,
            geometry,
            domain: &model.domain,
            radius: Self::radius(model),
        };
        let walls = &wall_origin.position;
        // The records of walls end with one that does not act.
        fluid_rows.build(&search, of_fluid, fluid, fluid, Padding::Target);
        wall_rows.build(&search, of_walls, walls, fluid, Padding::Index(walls.len() as u32));
        fluid_of_walls.build(&search, of_fluid, fluid, walls, Padding::Index(u32::MAX));
    }
}
