//! The flow of a stage, in a workspace that may be dropped at any step boundary.

use sph::coupling::exchange::StateColumns;
use sph::coupling::ledger::Energies;
use sph::coupling::solver::Divergence;
use sph::coupling::stage::{Stage, StageTime, StepStage};
use sph::lanes::{LanePass, Lanes, WIDTH};
use sph::space::geometry::{Geometry, Open, Periodic};
use sph::sums::ExactSums;
use sph::tasks::PerTask;

use super::checks::{LaneScanFindings, Motion, ScanFindings};
use super::compression_budget::CompressionBudget;
use super::momentum_budget::MomentumBudget;
use super::state_scan::StateScan;
use crate::boundary::wall_states::WallStates;
use crate::interface::fluid_interface::FluidInterface;
use crate::neighbours::lists::{Lists, Moves};
use crate::neighbours::placement::Needs;
use crate::neighbours::scene::Scene;
use crate::parts::halo::{Halo, put as put_in};
use crate::parts::reach::Reach;
use crate::rates::energy::EnergyInput;
use crate::rates::gradients::{Gradients, Partner};
use crate::rates::particle_rates::{ExternalForces, Rates, StagePart};
use crate::rates::stage_fields::StageFields;
use crate::rates::volume_reading::{self, VolumeReading};
use crate::system::lane_arrays::{numbers, put, vectors};
use crate::system::model::FluidModel;
use crate::system::packed_particle::{FluidSpace, Packed};
use crate::system::state::{FluidState, StepStart};
use crate::system::tasks::{for_each_task, per_task};

/// Everything that follows from model and state.
#[derive(Debug, Default)]
pub struct Workspace<S: FluidSpace> {
    /// State at the start of the step.
    pub base: StepStart<S>,
    /// Neighbours.
    pub lists: Lists<S>,
    /// Fluid as pair sums read it.
    pub fluid: Vec<S::Particle>,
    /// Whether `fluid` and `findings` are those of the present state.
    pub current: bool,
    /// Which copies of particles of other parts are under way.
    awaited: Option<Reach>,
    /// Walls as pair sums read them.
    pub walls: WallStates<S>,
    /// Whether those near copies are still those of the stage before.
    owes_walls: bool,
    /// Results of the gradient pass.
    pub gradients: Gradients<S>,
    /// The volume that the particles claim, with the volume correction.
    pub volume: VolumeReading,
    /// Whether this stage computes them, or keeps those of the stage before.
    computes_gradients: bool,
    /// Time of the step boundary, as bits, whose walls and own gradient sums an output has asked for, while they hold.
    evaluated_boundary: Option<u64>,
    /// Part of the rates that this stage computes.
    pub part: StagePart,
    /// Rates of the stage.
    pub rates: Vec<Rates<S>>,
    /// The part of the density rates by continuity, Eq. (17), where a stage computes all rates \[kg/(m³ s)\].
    pub continuity: Vec<f64>,
    /// External forces, by group.
    pub external: Vec<ExternalForces<S>>,
    /// Momentum budget of the stage, by group.
    pub budget: Vec<MomentumBudget<S>>,
    /// Sums of the momentum budget and of the external forces; memory.
    pub sums: [ExactSums; 2],
    /// Power of solids on the fluid in the corrector, and that of the compression by their approach \[W/m\].
    pub interface_powers: [f64; 2],
    /// What the predictor of leapfrog did to the compression of the fluid.
    pub predicted: CompressionBudget,
    /// Findings of the last scan of the particles, by task or group.
    pub findings_by_task: Vec<ScanFindings>,
    /// The same of the particles of all parts.
    pub findings: ScanFindings,
    /// Energies of the state that ended the last step \[J/m\], unless it has changed since.
    pub energies: Option<Energies>,
    /// Largest speed of the stage state \[m/s\].
    pub largest_speed: f64,
    /// The fluid's side of the interface, with a partner.
    pub interface: Option<FluidInterface<S>>,
}

impl<S: FluidSpace> Workspace<S> {
    /// A workspace for a run; it has an interface where the model has a coupling.
    pub fn new(model: &FluidModel<S>) -> Self {
        let interface = |coupling| FluidInterface::new(coupling, &model.domain, &model.body_force);
        Self { interface: model.coupling.as_ref().map(interface), ..Self::default() }
    }

    /// Bytes in use for particles, without those of a partner.
    pub fn bytes(&self) -> usize {
        self.base.bytes()
            + self.lists.bytes()
            + size_of::<S::Particle>() * self.fluid.capacity()
            + self.walls.bytes()
            + self.gradients.bytes()
            + self.volume.bytes()
            + size_of::<Rates<S>>() * self.rates.capacity()
            + size_of::<f64>() * self.continuity.capacity()
    }

    /// Checks the state, places the walls, rebuilds the lists where needed and computes pressures.
    ///
    /// # Errors
    /// When the state is not finite or breaks a limit.
    pub fn begin_stage(
        &mut self,
        model: &FluidModel<S>,
        state: &mut FluidState<S>,
        time: &StageTime,
    ) -> Result<(), Box<Divergence>> {
        self.part = StagePart::of(model, time.at.stage);
        let last = self.findings.largest_square_move.sqrt();
        self.lists.restore(model, state);
        if !std::mem::take(&mut self.current) {
            self.pack(model, state, time.time_step);
        }
        self.largest_speed = self.findings.verdict(model, state, time.at)?;
        self.walls.field.place(&model.walls, &model.domain, time.state_time());
        // Nodes take copies from farther away.
        let reach = if self.reads_volume(model, time) { Reach::Nodes } else { Reach::Walls };
        self.send_copies(model, reach);
        self.computes_gradients = self.part != StagePart::Momentum;
        // The corrector of leapfrog uses gradients in the order of the lists of the predictor.
        let ahead = if self.part == StagePart::Density { 0.5 * time.time_step } else { 0.0 };
        let moves = Moves { last, ahead, speed: self.largest_speed };
        let displacement = self.findings.largest_displacement();
        if self.are_lists_outdated(model, state, displacement, moves) {
            self.receive_copies(model);
            // The particles change their order.
            self.computes_gradients = true;
            self.evaluated_boundary = None;
            self.lists.rebuild(model, state, &mut self.base, time, moves);
            if let Some(interface) = &mut self.interface {
                interface.update_extent(&model.team, state);
            }
            self.pack(model, state, time.time_step);
            self.send_copies(model, reach);
        }
        Ok(())
    }

    /// Whether the stage at `time` reads the volume.
    fn reads_volume(&self, model: &FluidModel<S>, time: &StageTime) -> bool {
        model.corrects_volume() && volume_reading::is_read(time.at, self.part)
    }

    fn are_lists_outdated(
        &mut self,
        model: &FluidModel<S>,
        state: &FluidState<S>,
        displacement: f64,
        moves: Moves,
    ) -> bool {
        match self.lists.outdated(model, state, displacement, moves, &self.walls.field) {
            Some(is_known) => is_known,
            None => {
                self.receive_copies(model);
                self.lists.is_approached(model, state, &self.fluid, moves)
            }
        }
    }

    /// Packs every particle for the pair sums and checks it.
    ///
    /// With physical viscosity the corrector of leapfrog extrapolates velocities to the middle of the step, vⁿ + Δt/2 aⁿ⁻¹ᐟ².
    fn pack(&mut self, model: &FluidModel<S>, state: &FluidState<S>, time_step: f64) {
        let extrapolates = self.part == StagePart::Momentum && model.extrapolates_velocities();
        let ahead = extrapolates.then_some(0.5 * time_step);
        let Self { fluid, lists, findings_by_task, .. } = self;
        fluid.resize(lists.placement().places(state.len()), S::Particle::default());
        let scan = &StateScan::new(model, state.list_origin.as_ref());
        let results = (&mut fluid[..state.len()], per_task(findings_by_task, state.len()));
        for_each_task(state.len(), results, &|particles, (packed, PerTask(findings))| {
            findings[0] =
                model.arithmetic.run(PackPass { scan, state, ahead, first: particles.start, packed });
        });
        let own = ScanFindings::of_tasks(state, &self.findings_by_task);
        self.findings = model.team.join(own, ScanFindings::add);
    }

    /// Sends own particles to the parts that hold copies of them within `reach`.
    fn send_copies(&mut self, model: &FluidModel<S>, reach: Reach) {
        // Those of before, where nothing has needed them.
        self.receive_copies(model);
        let Self { fluid, lists, awaited, .. } = self;
        let Some(halo) = lists.placement().halo() else { return };
        halo.send(&model.team, reach, |i, message| {
            let particle = &fluid[i];
            put_in(message, particle.position());
            put_in(message, particle.velocity());
            put_in(message, [particle.density(), particle.pressure(), particle.volume()]);
        });
        *awaited = Some(reach);
    }

    /// Waits for the copies that are under way.
    fn receive_copies(&mut self, model: &FluidModel<S>) {
        let Self { fluid, lists, awaited, .. } = self;
        if let (Some(reach), Some(halo)) = (awaited.take(), lists.placement().halo()) {
            halo.receive(&model.team, reach, |place, message| {
                let (x, v) = (message.take(), message.take());
                let [density, pressure, volume] = message.take();
                fluid[place] = S::Particle::new(&x, &v, density, pressure, volume);
            });
        }
    }

    /// To be called where the state changes other than by a stage: drops what belongs to the old one.
    pub fn forget_state(&mut self) {
        (self.current, self.evaluated_boundary, self.energies) = (false, None, None);
        self.base = StepStart::default();
        self.lists.forget_particles();
    }

    /// Walls, and the gradient pass over own particles where this stage computes it, at `time` \[s\].
    pub fn evaluate_own(&mut self, model: &FluidModel<S>, time: f64) {
        if model.domain.is_periodic() {
            self.own(Periodic::new(&model.domain), model, time);
        } else {
            self.own(Open, model, time);
        }
    }

    fn own<G: Geometry<S>>(&mut self, geometry: G, model: &FluidModel<S>, time: f64) {
        if self.evaluated_boundary.take() == Some(time.to_bits()) {
            return;
        }
        self.extrapolate_walls(geometry, model, Needs::Nothing, time);
        self.owes_walls = true;
        if self.computes_gradients {
            self.accumulate(geometry, model, Needs::Nothing);
            self.complete_copies(geometry, model, time);
            self.accumulate(geometry, model, Needs::Copies);
        } else {
            let Self { lists, fluid, gradients, .. } = self;
            let own = 0..lists.placement().halo().map_or(fluid.len(), Halo::own);
            gradients.make_tensors(model, own, fluid);
        }
    }

    fn extrapolate_walls<G: Geometry<S>>(
        &mut self,
        geometry: G,
        model: &FluidModel<S>,
        needs: Needs,
        time: f64,
    ) {
        let Self { lists, fluid, walls, .. } = self;
        walls.extrapolate(geometry, model, lists, needs, fluid, time);
    }

    fn accumulate<G: Geometry<S>>(&mut self, geometry: G, model: &FluidModel<S>, needs: Needs) {
        let Self { lists, fluid, walls, gradients, interface, rates, .. } = self;
        let scene = Scene { geometry, model, lists, fluid, walls: &walls.particles };
        let partner = if interface.is_some() { Partner::Present } else { Partner::Absent };
        gradients.accumulate(&scene, needs, partner, rates);
    }

    /// Waits for copies, and extrapolates the walls near them.
    fn complete_copies<G: Geometry<S>>(&mut self, geometry: G, model: &FluidModel<S>, time: f64) {
        self.receive_copies(model);
        if std::mem::take(&mut self.owes_walls) {
            self.extrapolate_walls(geometry, model, Needs::Copies, time);
        }
    }

    /// Completes the gradients by the partner's particles and computes all rates at `time` \[s\].
    ///
    /// Own sums in list order, then the partner's in id order, added once: the same bits in one process or two.
    pub fn evaluate_cross(
        &mut self,
        model: &FluidModel<S>,
        state: &mut FluidState<S>,
        time: &StageTime,
        own: &StateColumns,
        partner: &StateColumns,
    ) {
        if model.domain.is_periodic() {
            self.complete(Periodic::new(&model.domain), model, state, time, [own, partner]);
        } else {
            self.complete(Open, model, state, time, [own, partner]);
        }
    }

    fn complete<G: Geometry<S>>(
        &mut self,
        geometry: G,
        model: &FluidModel<S>,
        state: &mut FluidState<S>,
        stage: &StageTime,
        [own, partner]: [&StateColumns; 2],
    ) {
        let (part, time) = (self.part, stage.state_time());
        let reads_volume = self.reads_volume(model, stage);
        if reads_volume {
            self.lists.place_background(model, stage.at.step);
            // The nodes take all of them.
            self.complete_copies(geometry, model, time);
        }
        let Self { lists, fluid, walls, gradients, volume, interface, rates, .. } = self;
        let scene = Scene { geometry, model, lists, fluid, walls: &walls.particles };
        if let Some(interface) = interface {
            interface.update(time, own, partner);
            if self.computes_gradients {
                interface.add_neighbour_sums(&scene, gradients, rates);
            }
        }
        if self.computes_gradients && part == StagePart::Momentum {
            gradients.make_tensors(model, scene.own(), fluid);
        }
        if part != StagePart::Density {
            gradients.find_near_surface(&scene);
            if reads_volume {
                gradients.exchange_surface(&scene);
                let (interface, at_surface) = (interface.as_ref(), |i| gradients.is_at_surface(i));
                volume.read(&scene, &walls.field, time, interface, at_surface, &mut state.volume_excess);
            }
            gradients.send_copies(&scene);
        }
        self.add_rates(geometry, model, state, stage, Needs::Nothing);
        self.complete_copies(geometry, model, time);
        let Self { lists, fluid, walls, gradients, .. } = self;
        let scene = Scene { geometry, model, lists, fluid, walls: &walls.particles };
        if part != StagePart::Density {
            gradients.receive_copies(&scene);
            gradients.find_near_surface_copies(&scene);
        }
        self.add_rates(geometry, model, state, stage, Needs::Copies);
        let Self { lists, fluid, walls, gradients, interface, rates, continuity, base, .. } = self;
        let scene = Scene { geometry, model, lists, fluid, walls: &walls.particles };
        if let Some(interface) = interface {
            interface.add_rates(&scene, state, part, gradients, (rates, continuity));
            if stage.at.stage == Stage::Corrector {
                let start_velocity = start_velocity(part, base, state);
                self.interface_powers =
                    interface.powers(&model.team, start_velocity, 0.5 * stage.time_step, rates);
            }
        }
    }

    /// Rates of own particles with such `needs`, without those by the partner.
    fn add_rates<G: Geometry<S>>(
        &mut self,
        geometry: G,
        model: &FluidModel<S>,
        state: &FluidState<S>,
        stage: &StageTime,
        needs: Needs,
    ) {
        let Self {
            lists, fluid, walls, gradients, part, interface, rates, continuity, external, base, ..
        } = self;
        let (part, time) = (*part, stage.state_time());
        let scene = Scene { geometry, model, lists, fluid, walls: &walls.particles };
        if needs == Needs::Copies && lists.placement().groups_with(needs).is_empty() {
            return;
        }
        let motions = model.walls.motions_at(time);
        let energy = (stage.at.stage == Stage::Corrector).then(|| EnergyInput {
            start_velocity: start_velocity(part, base, state),
            half: 0.5 * stage.time_step,
            by_solids: interface.as_mut().map_or(&[], |interface| interface.accelerations(state)),
            falling: model.falling,
            motions: &motions,
        });
        StageFields { scene, state, field: &walls.field, gradients, time, part, energy }
            .rates(needs, rates, continuity, external);
    }

    /// Walls and gradients of `state` at a step boundary of `time` \[s\], for outputs; the predictor of the next step, which needs
    /// the same, keeps them.
    ///
    /// The partner's particles are left out: they reach walls only through L_i. Answers whether the lists hold for
    /// `state`; where they do not, nothing is evaluated.
    ///
    /// # Errors
    /// When the state is not finite or breaks a limit.
    pub fn evaluate_boundary(
        &mut self,
        model: &FluidModel<S>,
        state: &mut FluidState<S>,
        time: f64,
    ) -> Result<bool, Box<Divergence>> {
        let last = self.findings.largest_square_move.sqrt();
        self.part = StagePart::of(model, Stage::Predictor);
        self.lists.restore(model, state);
        self.pack(model, state, 0.0);
        // The number of the step appears in a divergence only.
        let speed = self.findings.verdict(model, state, StepStage::FIRST)?;
        self.walls.field.place(&model.walls, &model.domain, time);
        self.send_copies(model, Reach::Walls);
        let moves = Moves { last, ahead: 0.0, speed };
        let displacement = self.findings.largest_displacement();
        if self.are_lists_outdated(model, state, displacement, moves) {
            self.receive_copies(model);
            return Ok(false);
        }
        self.computes_gradients = true;
        self.evaluated_boundary = None;
        self.evaluate_own(model, time);
        self.gradients.make_tensors(model, 0..state.len(), &self.fluid);
        self.evaluated_boundary = Some(time.to_bits());
        Ok(true)
    }

    /// Gives back the memory of lists and gradients, which the next stage makes again.
    pub fn release(&mut self) {
        self.lists.release();
        self.gradients = Gradients::default();
        self.evaluated_boundary = None;
    }
}

/// Velocities at the start of the step: leapfrog has not moved them since.
fn start_velocity<'a, S: FluidSpace>(
    part: StagePart,
    base: &'a StepStart<S>,
    state: &'a FluidState<S>,
) -> &'a [S::Vector] {
    if part == StagePart::Whole { &base.velocity } else { &state.velocity }
}

/// The pass over the particles of one task that packs them.
struct PackPass<'a, S: FluidSpace> {
    scan: &'a StateScan<'a, S>,
    state: &'a FluidState<S>,
    /// By how much velocities are extrapolated \[s\].
    ahead: Option<f64>,
    first: usize,
    packed: &'a mut [S::Particle],
}

impl<S: FluidSpace> LanePass for PackPass<'_, S> {
    type Output = ScanFindings;

    #[inline(always)]
    fn run<L: Lanes>(self) -> ScanFindings {
        let Self { scan, state, .. } = self;
        let scan = scan.within(self.first..self.first + self.packed.len());
        let FluidState { position, velocity, density, mass, acceleration, relaxation, .. } = state;
        let mut findings = LaneScanFindings::<L>::none();
        for k in (0..self.packed.len()).step_by(WIDTH) {
            let i = self.first + k;
            let motion = Motion::<S, L> {
                x: vectors::<S, L>(position, i),
                v: vectors::<S, L>(velocity, i),
                rho: numbers(density, i),
            };
            let mut extrapolated = None;
            if let Some(ahead) = self.ahead {
                let gained = S::scaled(vectors::<S, L>(acceleration, i), L::splat(ahead));
                extrapolated = Some(S::plus(motion.v, gained));
            }
            let q = if relaxation.is_empty() { None } else { Some(numbers(relaxation, i)) };
            let mut pressure = scan.pressures(motion.rho);
            if let Some(q) = q {
                pressure = pressure + q;
            }
            put(
                self.packed,
                k,
                scan.pack(k, &motion, numbers(mass, i), extrapolated, pressure, &mut findings),
            );
        }
        findings.total()
    }
}
