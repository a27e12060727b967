//! The solver as a half-step driver sees it.

use sph::coupling::exchange::{Column, Extent, StateColumns};
use sph::coupling::ledger::{EnergyReport, StageBudget};
use sph::coupling::saved::{RestoreError, SavedState};
use sph::coupling::solver::{
    Counts, Divergence, NoLoads, PartCount, PartCounts, ParticleFields, Role, Solver,
};
use sph::coupling::stage::{StageTime, StepStage};
use sph::lanes::Arithmetic;
use sph::setup::FluidSetup;
use sph::space::components::Components;
use sph::space::tensors::SpaceVector;
use sph::space::{Plane, Spatial};

use crate::boundary::departures::{EndedStep, remove_departed};
use crate::parts::halo::Halo;
use crate::parts::redistribution::share;
use crate::report::boundary_evaluation::BoundaryEvaluation;
use crate::report::wall_forces::wall_forces;
use crate::report::{fields, probes};
use crate::system::build::build;
use crate::system::model::FluidModel;
use crate::system::packed_particle::{FluidSpace, Packed};
use crate::system::saved;
use crate::system::state::FluidState;
use crate::team::Team;
use crate::team::transport::Channel;
use crate::time::stage::Workspace;
use crate::time::step_limit::time_step_limit;
use crate::time::{advance, checks, energy_budget};

/// The fluid solver of one run.
#[derive(Debug)]
pub struct FluidSolver<S: FluidSpace = Plane> {
    pub(crate) model: FluidModel<S>,
    pub(crate) state: FluidState<S>,
    pub(crate) workspace: Workspace<S>,
    /// Evaluation for outputs at the present boundary.
    boundary: BoundaryEvaluation<S>,
    /// The extent of a fluid without partner.
    no_extent: Extent,
}

impl<S: FluidSpace> FluidSolver<S> {
    /// A solver at the start of the run that `setup` describes, with the arithmetic of this process.
    ///
    /// # Errors
    /// Everything in the set-up that can not be run.
    pub fn new(setup: FluidSetup<S>) -> Result<Self, Vec<String>> {
        Self::with_arithmetic(setup, Arithmetic::chosen())
    }

    /// A solver at the start of the run that `setup` describes.
    ///
    /// # Errors
    /// Everything in the set-up that can not be run.
    pub fn with_arithmetic(setup: FluidSetup<S>, arithmetic: Arithmetic) -> Result<Self, Vec<String>> {
        Self::part(setup, arithmetic, Team::default())
    }

    /// The part of a solver that is one of `team`, whose members all call this at the same time.
    ///
    /// # Errors
    /// Everything in the set-up that can not be run; all members get the same.
    pub fn part(setup: FluidSetup<S>, arithmetic: Arithmetic, team: Team) -> Result<Self, Vec<String>> {
        let (model, mut state) = build(setup, arithmetic, team)?;
        if !model.team.is_alone() {
            state = state.part(share(state.len(), model.team.rank(), model.team.size()));
        }
        state.energy.start = energy_budget::stores(&probes::energies(&model, &state));
        let mut workspace = Workspace::new(&model);
        if let Some(interface) = &mut workspace.interface {
            interface.update_extent(&model.team, &state);
        }
        workspace.largest_speed = checks::check_state(&model, &state, StepStage::FIRST)
            .map_err(|divergence| vec![format!("the first state can not be run: {divergence}")])?;
        Ok(Self {
            model,
            state,
            workspace,
            boundary: BoundaryEvaluation::default(),
            no_extent: Extent::default(),
        })
    }
}

impl<S: FluidSpace> FluidSolver<S> {
    /// Memory that grows with the particles, in use by state and workspace \[bytes\].
    pub fn memory(&self) -> usize {
        self.state.bytes() + self.workspace.bytes()
    }
}

/// A solver in the plane at the start of the run that `setup` describes, with the arithmetic of this process.
///
/// Its passes are compiled in this crate, as one unit, which makes them faster than where they are used.
///
/// # Errors
/// Everything in the set-up that can not be run.
pub fn plane_solver(setup: FluidSetup<Plane>) -> Result<Box<dyn Solver>, Vec<String>> {
    Ok(Box::new(FluidSolver::new(setup)?))
}

/// The same in space.
///
/// # Errors
/// Everything in the set-up that can not be run.
pub fn spatial_solver(setup: FluidSetup<Spatial>) -> Result<Box<dyn Solver>, Vec<String>> {
    Ok(Box::new(FluidSolver::new(setup)?))
}

/// Calls `work` with the state of all parts, at the first of them.
fn with_all<S: FluidSpace>(model: &FluidModel<S>, state: &FluidState<S>, work: impl FnOnce(&FluidState<S>)) {
    if model.team.is_alone() {
        return work(state);
    }
    let all = model.team.join_at_first(state.clone(), FluidState::extend);
    if model.team.rank() == 0 {
        work(&all.in_order());
    }
}

impl<S: FluidSpace> Solver for FluidSolver<S> {
    fn role(&self) -> Role {
        Role::Fluid
    }

    fn begin_stage(&mut self, time: &StageTime) -> Result<(), Divergence> {
        self.boundary.invalidate();
        self.workspace.begin_stage(&self.model, &mut self.state, time).map_err(|divergence| *divergence)
    }

    fn time_step_limit(&self) -> f64 {
        let Self { model, state, workspace, .. } = self;
        state.control.share() * time_step_limit(model, workspace.largest_speed, state.largest_acceleration)
    }

    fn limiting_particle(&self) -> Option<(u32, Vec<f64>)> {
        let Self { model, state, workspace, .. } = self;
        // Accelerations stay with leapfrog alone; elsewhere speeds decide. Pair sums may read extrapolated velocities.
        let limit = |i: usize| {
            let acceleration = state.acceleration.get(i).map_or(0.0, S::Vector::norm);
            let packed = workspace.fluid.get(i).filter(|_| workspace.current);
            let velocity = packed.map_or(state.velocity[i], Packed::velocity);
            time_step_limit(model, velocity.norm(), acceleration)
        };
        let i = (0..state.len()).min_by(|i, j| limit(*i).total_cmp(&limit(*j)));
        let own =
            i.map(|i| ((limit(i), state.place(i)), (state.id[i], state.position[i].row().as_ref().to_vec())));
        let first = model.team.join(own, |first, other| {
            let before = |((limit, place), _): &(_, _), (other, other_place): (f64, u64)| {
                f64::total_cmp(limit, &other).then(u64::cmp(place, &other_place)).is_le()
            };
            if let Some((key, _)) = &other
                && !first.as_ref().is_some_and(|first| before(first, *key))
            {
                *first = other;
            }
        });
        first.map(|(_, particle)| particle)
    }

    fn extent(&self) -> &Extent {
        self.workspace.interface.as_ref().map_or(&self.no_extent, |interface| interface.extent())
    }

    fn interface(&mut self, partner: &Extent, reach: f64, states: &mut StateColumns) -> u64 {
        let Workspace { interface, fluid, .. } = &mut self.workspace;
        let own = &fluid[..self.state.len()];
        match interface {
            Some(interface) => interface.select(&self.model.team, &self.state, own, partner, reach, states),
            None => {
                states.clear();
                0
            }
        }
    }

    fn covered_by(&self, extent: &Extent, reach: f64) -> Result<(), f64> {
        self.workspace
            .interface
            .as_ref()
            .map_or(Ok(()), |interface| interface.covered_by(&self.model.team, &self.state, extent, reach))
    }

    fn evaluate_own(&mut self, time: &StageTime) {
        self.workspace.evaluate_own(&self.model, time.state_time());
    }

    fn evaluate_cross(&mut self, time: &StageTime, own: &StateColumns, partner: &StateColumns) {
        self.workspace.evaluate_cross(&self.model, &mut self.state, time, own, partner);
    }

    fn reactions(
        &mut self,
        time: &StageTime,
        own: &StateColumns,
        points: &StateColumns,
        forces: &mut Column,
    ) -> Result<(), NoLoads> {
        let interface = self.workspace.interface.as_mut().ok_or(NoLoads)?;
        interface.reactions(time.state_time(), own, points, forces);
        Ok(())
    }

    fn advance(&mut self, time: &StageTime) -> Result<StageBudget, Divergence> {
        self.boundary.invalidate();
        // The findings in the new state are judged at the end of the step, or when the next stage begins.
        Ok(advance::advance(&self.model, &mut self.state, &mut self.workspace, time))
    }

    fn end_step(&mut self, time: &StageTime) -> Result<(), Divergence> {
        self.boundary.invalidate();
        let Self { model, state, workspace, .. } = self;
        if let Some(energies) = &workspace.energies {
            state.control.take(&energy_budget::report(&model.energy_accounts, &state.energy, energies));
        }
        let findings = workspace.findings;
        findings.verdict(model, state, time.at).map_err(|divergence| *divergence)?;
        let step = EndedStep {
            time,
            lists: &workspace.lists,
            largest_square_move: findings.largest_square_move,
            outside: findings.outside,
            start: |state: &FluidState<_>, i| advance::start_of_step(state, workspace, time.time_step, i),
        };
        if remove_departed(model, state, &step).map_err(|divergence| *divergence)? {
            workspace.forget_state();
        }
        Ok(())
    }

    fn energies(&self) -> EnergyReport {
        let energies = self.workspace.energies.unwrap_or_else(|| probes::energies(&self.model, &self.state));
        energy_budget::report(&self.model.energy_accounts, &self.state.energy, &energies)
    }

    fn probes(&mut self, time: f64, values: &mut Vec<f64>) {
        let Self { model, state, workspace, boundary, .. } = self;
        let immersed = workspace.interface.as_ref().map_or(0, |interface| interface.immersed());
        let mut forces = Vec::new();
        let read = probes::walls_with_forces(model);
        if read.contains(&true) {
            forces = match boundary.evaluated(model, state, workspace, time) {
                Some((state, workspace)) => wall_forces(model, state, workspace, time, &read),
                None => vec![S::Vector::repeat(f64::NAN); read.len()],
            };
        }
        with_all(model, state, |state| probes::values(model, state, time, &forces, immersed, values));
    }

    fn snapshot(&mut self, step: u64, time: f64) -> ParticleFields {
        let Self { model, state, workspace, boundary, .. } = self;
        if model.walls.len() > 0 {
            // Where it fails, walls are as the last stage saw them.
            boundary.evaluated(model, state, workspace, time);
        }
        let (walls, lists) = boundary.walls(workspace);
        let mut field = walls.field.clone();
        field.place(&model.walls, &model.domain, time);
        let particles = walls.of_all_parts(model, lists);
        let mut fields = ParticleFields::default();
        with_all(model, state, |state| {
            fields = fields::particle_fields(model, state, &field, &particles, step, time);
        });
        fields
    }

    fn counts(&self) -> Counts {
        Counts {
            particles: self.state.total() as u64,
            wall_particles: self.model.walls.len() as u64,
            list_builds: self.state.list_builds,
            escaped: self.state.escaped,
            outflow: self.state.outflow,
            largest_interface: self.workspace.interface.as_ref().map_or(0, |interface| interface.largest()),
            parts: self.part_counts(),
            ..Counts::default()
        }
    }

    fn save(&self, saved: &mut SavedState) {
        with_all(&self.model, &self.state, |state| state.save(saved));
        let interface = self.workspace.interface.as_ref();
        saved.put_u64(saved::INTERFACE, interface.map_or([0; 2], |interface| interface.history()));
    }

    fn restore(&mut self, saved: &SavedState) -> Result<(), RestoreError> {
        let (state, history) = self.restored(saved)?;
        self.take_over(state, history)
    }
}

impl<S: FluidSpace> FluidSolver<S> {
    fn part_counts(&self) -> Option<PartCounts> {
        let team = &self.model.team;
        if team.is_alone() {
            return None;
        }
        let (placement, clock) = (self.workspace.lists.placement(), team.clock());
        let (copies, calls) = (clock.sent(Channel::Copies), clock.sent(Channel::Calls));
        let agreement = clock.sent(Channel::Agreement);
        let imbalance = placement.imbalance();
        Some(PartCounts {
            each: team.all(PartCount {
                particles: self.state.len() as u64,
                copies: placement.halo().map_or(0, Halo::copies) as u64,
                computing_seconds: clock.computing().as_secs_f64(),
                waited_for_copies_seconds: clock.waiting(Channel::Copies).as_secs_f64(),
                waited_for_agreement_seconds: clock.waiting(Channel::Agreement).as_secs_f64(),
                copy_messages: copies.messages,
                copy_bytes: copies.bytes,
                other_messages: agreement.messages + calls.messages,
                other_bytes: agreement.bytes + calls.bytes,
            }),
            mean_imbalance: imbalance.mean(),
            largest_imbalance: imbalance.largest(),
        })
    }

    /// The state of all parts that was saved, and the history of the interface.
    ///
    /// # Errors
    /// When arrays do not fit each other or the model.
    pub fn restored(&self, saved: &SavedState) -> Result<(FluidState<S>, [u64; 2]), RestoreError> {
        Ok((FluidState::restored(&self.model, saved)?, saved.u64s(saved::INTERFACE)?))
    }

    /// Takes over a state of all parts, which the first of them has, with the history of the interface.
    ///
    /// # Errors
    /// When it breaks a limit.
    pub fn take_over(&mut self, all: FluidState<S>, history: [u64; 2]) -> Result<(), RestoreError> {
        let team = &self.model.team;
        let of_part = |part: usize| (all.part(share(all.len(), part, team.size())), history);
        let (state, history) = if team.is_alone() {
            (all, history)
        } else if team.rank() > 0 {
            team.receive_value(0)
        } else {
            (1..team.size()).for_each(|part| team.send_value(part, &of_part(part)));
            of_part(0)
        };
        let mut workspace = Workspace::new(&self.model);
        if let Some(interface) = &mut workspace.interface {
            interface.restore(&self.model.team, &state, history);
        }
        workspace.largest_speed = checks::check_state(&self.model, &state, StepStage::FIRST)
            .map_err(|divergence| RestoreError::new("state", divergence.to_string()))?;
        self.boundary.invalidate();
        (self.state, self.workspace) = (state, workspace);
        Ok(())
    }
}
