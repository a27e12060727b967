//! What can be thrown away at any step boundary, and one evaluation of the rates.

use rayon::prelude::*;
use sph::exchange::InterfaceStates;
use sph::solver::Divergence;
use sph::stage::StageTime;
use sph::vector::Vector;

use super::checks::check_state;
use super::cross::Cross;
use super::gradients::Gradients;
use super::lists::Lists;
use super::model::FluidModel;
use super::pair::{Open, Periodic, Record};
use super::rates::{Rates, StageFields, TASK};
use super::shifting::Order;
use super::state::{Base, FluidState};
use super::walls::WallStates;

/// Everything that follows from model and state.
#[derive(Debug, Default)]
pub struct Workspace {
    /// State at the start of the step.
    pub base: Base,
    /// Neighbours.
    pub lists: Lists,
    /// Fluid as neighbours read it.
    pub fluid: Vec<Record>,
    /// Walls as neighbours read them.
    pub walls: WallStates,
    /// Results of the gradient pass.
    pub gradients: Gradients,
    /// Shifting and tensile control.
    pub order: Order,
    /// Rates of the stage.
    pub rates: Vec<Rates>,
    /// Largest speed of the stage state \[m/s\].
    pub largest_speed: f64,
    /// The fluid's side of the interface, with a partner.
    pub cross: Option<Cross>,
}

impl Workspace {
    /// A workspace for a run; it has an interface where the model has a coupling.
    pub fn new(model: &FluidModel) -> Self {
        let cross = |coupling| Cross::new(coupling, &model.domain, &model.body_force);
        Self { cross: model.coupling.as_ref().map(cross), ..Self::default() }
    }

    /// Checks the state, places the walls, renews the lists where needed and computes pressures.
    ///
    /// # Errors
    /// When the state is not finite or breaks a limit.
    pub fn begin_stage(
        &mut self,
        model: &FluidModel,
        state: &mut FluidState,
        time: &StageTime,
    ) -> Result<(), Box<Divergence>> {
        self.largest_speed = check_state(model, state, time.at)?;
        self.walls.field.place(&model.walls, &model.domain, time.state_time());
        self.lists.restore(model, state);
        if self.lists.outdated(model, state, &self.walls.field) {
            self.lists.rebuild(model, state, &mut self.base, time.state_time());
            if let Some(cross) = &mut self.cross {
                cross.update_extent(state);
            }
        }
        self.fluid.resize(state.len(), Record::default());
        self.fluid.par_iter_mut().with_min_len(4 * TASK).enumerate().for_each(|(i, record)| {
            let (x, v, density) = (&state.position[i], &state.velocity[i], state.density[i]);
            *record = Record {
                x: x.x,
                y: x.y,
                v_x: v.x,
                v_y: v.y,
                density,
                pressure: model.equation_of_state.pressure(density),
                volume: state.mass[i] / density,
            };
        });
        Ok(())
    }

    /// Walls, and the sums of the gradient pass over own particles, at `time` \[s\].
    pub fn evaluate_own(&mut self, model: &FluidModel, time: f64) {
        let Self { lists, fluid, walls, gradients, order, .. } = self;
        if model.domain.is_periodic() {
            let geometry = Periodic::new(&model.domain);
            walls.extrapolate(geometry, model, lists, fluid, time);
            gradients.accumulate(geometry, model, lists, fluid, &walls.records);
            order.accumulate(geometry, model, lists, fluid, &walls.records);
        } else {
            walls.extrapolate(Open, model, lists, fluid, time);
            gradients.accumulate(Open, model, lists, fluid, &walls.records);
            order.accumulate(Open, model, lists, fluid, &walls.records);
        }
    }

    /// Completes the gradients by the partner's particles and computes all rates at `time` \[s\].
    ///
    /// Own sums in list order, then the partner's in id order, added once: the same bits whoever runs the partner.
    pub fn evaluate_cross(
        &mut self,
        model: &FluidModel,
        state: &FluidState,
        time: f64,
        own: &InterfaceStates,
        partner: &InterfaceStates,
    ) {
        let mut cross = self.cross.take();
        if let Some(cross) = &mut cross {
            cross.update(time, own, partner);
            if !cross.density_meets() {
                self.gradients.finish_density(model);
            }
            cross.add_moments(model, own, partner, &mut self.gradients);
            cross.add_order(model, own, partner, &mut self.order);
        }
        if cross.as_ref().is_none_or(Cross::density_meets) {
            self.gradients.finish_density(model);
        }
        self.gradients.add_damper(model, &mut self.fluid);
        self.gradients.finish_tensors(model, &self.fluid);
        self.gradients.finish_viscosity(model);
        self.finish_order(model);
        let mut rates = std::mem::take(&mut self.rates);
        let fields = self.fields(model, state, time);
        if model.domain.is_periodic() {
            fields.rates(Periodic::new(&model.domain), &mut rates);
        } else {
            fields.rates(Open, &mut rates);
        }
        if let Some(cross) = &mut cross {
            cross.add_rates(model, state, own, partner, &self.gradients, &mut rates);
        }
        self.order.add_to(model, &mut rates);
        self.rates = rates;
        self.cross = cross;
    }

    fn finish_order(&mut self, model: &FluidModel) {
        let Self { lists, fluid, walls, order, .. } = self;
        let walls = &walls.records;
        if model.domain.is_periodic() {
            order.finish(Periodic::new(&model.domain), model, lists, fluid, walls);
        } else {
            order.finish(Open, model, lists, fluid, walls);
        }
    }

    /// Force of the fluid on each wall \[N/m\] as of the last evaluation, at `time` \[s\].
    pub fn wall_forces(&self, model: &FluidModel, state: &FluidState, time: f64) -> Vec<Vector> {
        let fields = self.fields(model, state, time);
        (0u32..)
            .take(model.walls.names.len())
            .map(|wall| {
                if model.domain.is_periodic() {
                    fields.wall_force(Periodic::new(&model.domain), wall)
                } else {
                    fields.wall_force(Open, wall)
                }
            })
            .collect()
    }

    fn fields<'a>(&'a self, model: &'a FluidModel, state: &'a FluidState, time: f64) -> StageFields<'a> {
        StageFields {
            model,
            state,
            lists: &self.lists,
            fluid: &self.fluid,
            walls: &self.walls,
            gradients: &self.gradients,
            time,
        }
    }
}
