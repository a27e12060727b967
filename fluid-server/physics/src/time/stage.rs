//! What can be thrown away at any step boundary, and one evaluation of the rates.

use sph::exchange::InterfaceStates;
use sph::geometry::{Geometry, Open, Periodic};
use sph::lanes::{Kernel, Lanes, WIDTH};
use sph::ledger::Energies;
use sph::solver::Divergence;
use sph::stage::StageTime;

use super::checks::{Findings, LaneFindings};
use super::momentum_budget::Books;
use super::state_scan::Look;
use crate::boundary::wall_states::WallStates;
use crate::interface::fluid_interface::Cross;
use crate::neighbours::lists::{Lists, Moves};
use crate::neighbours::scene::Scene;
use crate::rates::gradients::Gradients;
use crate::rates::particle_rates::{OuterForces, Part, Rates};
use crate::rates::rate_pass::StageFields;
use crate::system::lane_arrays::{numbers, put, vectors};
use crate::system::model::FluidModel;
use crate::system::packed_particle::Record;
use crate::system::state::{Base, FluidState};
use crate::system::tasks::{PerTask, for_each_task, per_task};

/// Everything that follows from model and state.
#[derive(Debug, Default)]
pub struct Workspace {
    /// State at the start of the step.
    pub base: Base,
    /// Neighbours.
    pub lists: Lists,
    /// Fluid as neighbours read it.
    pub fluid: Vec<Record>,
    /// Whether the last stage has left `fluid` and `findings` of its new state.
    pub current: bool,
    /// Walls as neighbours read them.
    pub walls: WallStates,
    /// Results of the gradient pass.
    pub gradients: Gradients,
    /// Whether this stage makes them, or goes on with those of the stage before.
    makes_gradients: bool,
    /// Which rates this stage computes.
    pub part: Part,
    /// Rates of the stage.
    pub rates: Vec<Rates>,
    /// Forces from outside, by task.
    pub outer: Vec<OuterForces>,
    /// What happened to the momentum in the stage, by task.
    pub books: Vec<Books>,
    /// Health of the particles, by task.
    pub findings: Vec<Findings>,
    /// Energies of the state that ended the last step \[J/m\], unless it has changed since.
    pub energies: Option<Energies>,
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

    /// Bytes in use for particles, without those of a partner.
    pub fn bytes(&self) -> usize {
        self.base.bytes()
            + self.lists.bytes()
            + size_of::<Record>() * self.fluid.capacity()
            + self.gradients.bytes()
            + size_of::<Rates>() * self.rates.capacity()
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
        self.part = Part::of(model, time.at.stage);
        let last = self.findings().largest_square_move.sqrt();
        if !std::mem::take(&mut self.current) {
            self.read(model, state, time.time_step);
        }
        let findings = self.findings();
        self.largest_speed = findings.verdict(model, state, time.at)?;
        self.walls.field.place(&model.walls, &model.domain, time.state_time());
        self.lists.restore(model, state);
        self.makes_gradients = self.part != Part::Momentum;
        // The corrector of leapfrog goes on with what belongs to the lists of the predictor.
        let ahead = if self.part == Part::Density { 0.5 * time.time_step } else { 0.0 };
        let moves = Moves { last, ahead, speed: self.largest_speed };
        if self.lists.outdated(model, state, findings.largest_displacement(), moves, &self.walls.field) {
            // The particles take another order.
            self.makes_gradients = true;
            self.lists.rebuild(model, state, &mut self.base, time, moves);
            if let Some(cross) = &mut self.cross {
                cross.update_extent(state);
            }
            self.read(model, state, time.time_step);
        }
        Ok(())
    }

    /// Fills the records of the fluid and looks at every particle.
    ///
    /// The corrector of leapfrog extrapolates velocities to the middle of the step, vⁿ + Δt/2 aⁿ⁻¹ᐟ².
    fn read(&mut self, model: &FluidModel, state: &FluidState, time_step: f64) {
        let ahead = (self.part == Part::Momentum).then_some(0.5 * time_step);
        self.fluid.resize(state.len(), Record::default());
        let look = &Look::new(model, state.list_origin.as_ref());
        let results = (&mut self.fluid[..], per_task(&mut self.findings, state.len()));
        for_each_task(state.len(), results, &|particles, (records, PerTask(findings))| {
            findings[0] = model.arithmetic.run(Read { look, state, ahead, first: particles.start, records });
        });
    }

    /// The state has changed otherwise than by a stage: what was made of it is void.
    pub fn forget_state(&mut self) {
        (self.current, self.energies) = (false, None);
    }

    /// What the last look at every particle found.
    pub fn findings(&self) -> Findings {
        self.findings.iter().copied().fold(Findings::default(), Findings::with)
    }

    /// Walls, and the gradient pass over own particles where this stage makes it, at `time` \[s\].
    pub fn evaluate_own(&mut self, model: &FluidModel, time: f64) {
        if model.domain.is_periodic() {
            self.own(Periodic::new(&model.domain), model, time);
        } else {
            self.own(Open, model, time);
        }
    }

    fn own<G: Geometry>(&mut self, geometry: G, model: &FluidModel, time: f64) {
        let Self { lists, fluid, walls, gradients, makes_gradients, cross, rates, .. } = self;
        walls.extrapolate(geometry, model, &lists.fluid_of_walls, fluid, time);
        let scene = Scene { geometry, model, lists, fluid, walls: &walls.records };
        if *makes_gradients {
            gradients.accumulate(&scene, cross.is_some(), rates);
        } else {
            gradients.make_tensors(&scene);
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
        if model.domain.is_periodic() {
            self.cross(Periodic::new(&model.domain), model, state, time, [own, partner]);
        } else {
            self.cross(Open, model, state, time, [own, partner]);
        }
    }

    fn cross<G: Geometry>(
        &mut self,
        geometry: G,
        model: &FluidModel,
        state: &FluidState,
        time: f64,
        [own, partner]: [&InterfaceStates; 2],
    ) {
        let Self { lists, fluid, walls, gradients, makes_gradients, part, cross, rates, outer, .. } = self;
        let part = *part;
        let scene = Scene { geometry, model, lists, fluid, walls: &walls.records };
        if let Some(cross) = cross {
            cross.update(time, own, partner);
            if *makes_gradients {
                cross.add_moments(&scene, own, partner, gradients, rates);
            }
        }
        if *makes_gradients && part == Part::Momentum {
            gradients.make_tensors(&scene);
        }
        StageFields { scene, state, field: &walls.field, gradients, time, part }.rates(rates, outer);
        if let Some(cross) = cross {
            cross.add_rates(model, state, part, [own, partner], gradients, rates);
        }
    }

    /// Walls and gradients of the present state at a step boundary of `time` \[s\], for outputs.
    pub fn evaluate_outputs(&mut self, model: &FluidModel, time: f64) {
        self.evaluate_own(model, time);
        let Self { lists, fluid, walls, gradients, .. } = self;
        gradients.make_tensors(&Scene { geometry: Open, model, lists, fluid, walls: &walls.records });
    }
}

/// The pass over the particles of one task that makes their records.
struct Read<'a> {
    look: &'a Look<'a>,
    state: &'a FluidState,
    /// By how much velocities are extrapolated \[s\].
    ahead: Option<f64>,
    first: usize,
    records: &'a mut [Record],
}

impl Kernel for Read<'_> {
    type Output = Findings;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Findings {
        let Self { look, state: FluidState { position, velocity, density, mass, acceleration, .. }, .. } =
            self;
        let mut found = LaneFindings::<L>::none();
        for k in (0..self.records.len()).step_by(WIDTH) {
            let i = self.first + k;
            let (x, v, rho) = (vectors::<L>(position, i), vectors::<L>(velocity, i), numbers(density, i));
            let mut shown = None;
            if let Some(ahead) = self.ahead {
                let (ahead, [a_x, a_y]) = (L::splat(ahead), vectors::<L>(acceleration, i));
                shown = Some([v[0] + a_x * ahead, v[1] + a_y * ahead]);
            }
            put(self.records, k, look.at(i, (x, v, rho), numbers(mass, i), shown, &mut found));
        }
        found.total()
    }
}
