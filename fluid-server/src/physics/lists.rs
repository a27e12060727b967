//! Neighbour lists with a skin, and the cell-sorted order of the fluid.

use sph::neighbours::{CellGrid, NeighbourList, cell_order, largest_displacement};

use super::model::FluidModel;
use super::state::{Base, FluidState, ListOrigin};
use super::walls::WallField;

/// Width of the skin around the support radius in particle spacings. The optimum is flat between 0.1 and 0.3.
const SKIN: f64 = 0.2;

/// Lists of all pairs closer than support radius plus skin.
#[derive(Debug, Default)]
pub struct Lists {
    /// Fluid neighbours of each fluid particle.
    pub fluid: NeighbourList,
    /// Wall neighbours of each fluid particle.
    pub walls: NeighbourList,
    /// Fluid neighbours of each wall particle.
    pub fluid_of_walls: NeighbourList,
    /// Positions of moving walls when the lists were built.
    wall_origin: WallField,
    /// Whether the lists belong to the state's `list_origin`.
    current: bool,
}

impl Lists {
    /// Skin \[m\] for particles of `spacing` \[m\].
    pub fn skin(spacing: f64) -> f64 {
        SKIN * spacing
    }

    /// Whether a particle moved so far that the lists may miss a pair.
    ///
    /// Two particles approach by at most twice the largest displacement, hence half the skin each.
    pub fn outdated(&self, model: &FluidModel, state: &FluidState, walls: &WallField) -> bool {
        let Some(origin) = &state.list_origin else { return true };
        let limit = 0.5 * Self::skin(model.constants.particle_spacing);
        let moved = |now, then| largest_displacement(&model.domain, now, then) > limit;
        moved(&state.position, &origin.position)
            || (model.walls.moves() && moved(&walls.position, &self.wall_origin.position))
    }

    /// Sorts the particles by cells and builds the lists for the present state at `time` \[s\].
    pub fn rebuild(&mut self, model: &FluidModel, state: &mut FluidState, base: &mut Base, time: f64) {
        state.wrap(base, &model.domain);
        let order = cell_order(&model.domain, &state.position, self.radius(model));
        state.reorder(base, &order);
        let origin = state.list_origin.get_or_insert_default();
        origin.time = time;
        origin.position.clone_from(&state.position);
        state.list_builds += 1;
        self.build(model, origin);
    }

    /// Builds the lists that belong to `origin` unless they are present, as after a restore.
    pub fn restore(&mut self, model: &FluidModel, state: &FluidState) {
        if let (false, Some(origin)) = (self.current, &state.list_origin) {
            self.build(model, origin);
        }
    }

    fn radius(&self, model: &FluidModel) -> f64 {
        model.kernel.support_radius() + Self::skin(model.constants.particle_spacing)
    }

    fn build(&mut self, model: &FluidModel, origin: &ListOrigin) {
        let (domain, radius) = (&model.domain, self.radius(model));
        self.wall_origin.place(&model.walls, domain, origin.time);
        let (fluid, walls) = (&origin.position, &self.wall_origin.position);
        let grid = CellGrid::new(domain, fluid, radius);
        self.fluid = grid.list(domain, fluid, fluid, radius, true);
        self.fluid_of_walls = grid.list(domain, walls, fluid, radius, false);
        self.walls = CellGrid::new(domain, walls, radius).list(domain, fluid, walls, radius, false);
        self.current = true;
    }
}
