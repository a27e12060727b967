//! The solid side of a run, stepped by the half-step driver.

use sph::exchange::{Extent, InterfaceStates};
use sph::lanes::Arithmetic;
use sph::ledger::{Energies, StageBooks};
use sph::saved::{RestoreError, SavedState};
use sph::setup::{SolidSetup, SolidStepping};
use sph::solver::{Counts, Divergence, NoLoads, NotRevised, ParticleFields, Role, Solver};
use sph::stage::{Stage, StageTime, StepStage};
use sph::sums::ordered_sum;
use sph::vector::{DIMENSIONS, Vector};

use crate::build::{build, build_workspace};
use crate::particles::forces::ParticleTorques;
use crate::report::body_sums::{best_fit_angle, energies};
use crate::report::fields::snapshot;
use crate::report::momentum_budget::{StageRecord, stage_record};
use crate::report::probes::probe_values;
use crate::system::model::SolidModel;
use crate::system::saved::HISTORY;
use crate::system::state::{BodyContact, SolidState};
use crate::system::workspace::Workspace;
use crate::time::advance::move_bodies;
use crate::time::checks::{check, check_domain};
use crate::time::evaluate::{
    add_torques, evaluate_pairs, refresh_lists, sum_forces, total_forces, update_stress,
};
use crate::time::limits::{acceleration_limit, particle_limit, step_limit};
use crate::time::substeps::move_by_substeps;

/// Several elastic or rigid bodies in one domain.
///
/// The stated limit of the time step is the smallest of: the limit of each body's waves under the stepping of the case,
/// 1/ω of the stiffest contact of the stage before, both times the number of sub-steps, and ¼ √(Δx/a) for the largest
/// acceleration a of that stage.
pub struct SolidSolver {
    pub(crate) model: SolidModel,
    pub(crate) state: SolidState,
    pub(crate) workspace: Workspace,
    /// Empty extent of a run without a partner.
    no_extent: Extent,
}

impl SolidSolver {
    /// Mass \[kg/m\] of each body as its equations use it, and of a rigid one its moment of inertia \[kg m\].
    pub fn masses(&self) -> impl Iterator<Item = (f64, Option<f64>)> + '_ {
        self.model.bodies.iter().map(|body| {
            let mass = &self.model.particles.mass[body.range.clone()];
            let inertia = body.formulation.inertia().map(|inertia| inertia.total);
            (ordered_sum(mass.len(), |i| mass[i]), inertia)
        })
    }

    /// A solver at the start of the run that `setup` describes.
    ///
    /// # Errors
    /// All that is wrong with the set-up: arrays that do not fit each other, expressions that do not parse, probes
    /// outside their body, laws that a body's formulation cannot serve, an initial state beyond the limits.
    pub fn new(setup: SolidSetup) -> Result<Self, Vec<String>> {
        Self::with_arithmetic(setup, Arithmetic::chosen())
    }

    /// The same with the given arithmetic instead of that of this process.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_arithmetic(setup: SolidSetup, arithmetic: Arithmetic) -> Result<Self, Vec<String>> {
        let coupling = setup.run.coupling;
        let (model, state) = build(setup, arithmetic)?;
        let workspace = build_workspace(&model, &state, coupling.as_ref());
        Ok(Self { model, state, workspace, no_extent: Extent::default() })
    }

    fn complete_rates(&mut self) {
        let Workspace { stage, sums, rates, .. } = &mut self.workspace;
        for body in &self.model.bodies {
            let range = &body.range;
            body.formulation.complete(&stage.view(range), &sums[range.clone()], rates.view_mut(range));
        }
    }

    /// Forces and rates of the stage, once those of the fluid are known.
    fn complete_stage(&mut self, time: &StageTime) {
        if self.model.stepping == SolidStepping::StageRule {
            sum_forces(&self.model, &mut self.workspace, time, time.state_time());
            let Workspace { stage, forces, mean_forces, mean_torques, fluid_force, total_force, .. } =
                &mut self.workspace;
            total_forces(forces, fluid_force, total_force);
            mean_forces.clone_from(forces);
            if let Some(origin) = self.model.torque_origin() {
                mean_torques.fill(ParticleTorques::default());
                add_torques(mean_torques, 1.0, origin, &stage.position, forces);
            }
            self.complete_rates();
        }
    }

    /// Prepares the stage state: walls, stress, lists and the extent at the interface.
    fn enter_stage(&mut self, time: &StageTime) {
        // A pass of sub-steps leaves the corrector all that belongs to its state.
        if time.at.stage == Stage::Predictor || self.model.stepping == SolidStepping::StageRule {
            self.model.walls.move_to(time.state_time(), &mut self.workspace.walls);
            update_stress(&self.model, &mut self.workspace);
            refresh_lists(&self.model, &mut self.workspace, time);
        }
        if let Some(link) = &mut self.workspace.fluid {
            link.track(&self.workspace.stage.position);
        }
    }

    /// Moves all bodies from the start of the step to `workspace.next`, checked.
    fn move_stage(&mut self, time: &StageTime) -> Result<(), Divergence> {
        match self.model.stepping {
            SolidStepping::StageRule => move_bodies(&self.model, &self.state, &mut self.workspace, time),
            SolidStepping::Substeps(count) => {
                move_by_substeps(&self.model, &self.state, &mut self.workspace, time, count);
            }
        }
        check(&self.model, &self.workspace.next, time.at).map_err(|divergence| *divergence)
    }

    /// Takes the predictor's result as the stage state of the corrector.
    fn take_prediction(&mut self) {
        let Workspace { stage, stage_rigid, next, next_rigid, .. } = &mut self.workspace;
        std::mem::swap(stage, next);
        std::mem::swap(stage_rigid, next_rigid);
    }

    /// Takes the corrector's result as the state at the new step boundary, `duration` \[s\] after the last.
    fn accept(&mut self, record: &StageRecord, duration: f64) {
        let Self { model, state, workspace, .. } = self;
        std::mem::swap(&mut state.particles, &mut workspace.next);
        std::mem::swap(&mut state.rigid, &mut workspace.next_rigid);
        state.springs.clone_from(&workspace.springs);
        let last = &mut state.last;
        last.largest_acceleration = record.largest_acceleration;
        last.contact_frequency = record.contact_frequency;
        last.tangent_stiffness_ratio = record.tangent_stiffness_ratio;
        last.substeps += u64::from(workspace.substeps);
        for (fluid_force, body) in last.fluid_force.iter_mut().zip(&model.bodies) {
            let forces = &workspace.fluid_force[body.range.clone()];
            *fluid_force = ordered_sum(forces.len(), |i| forces[i]);
        }
        for (contact, body) in last.contacts.iter_mut().zip(&model.bodies) {
            contact.follow(&workspace.mean_forces[body.range.clone()], duration);
        }
        for (accepted, reactions) in last.reactions.iter_mut().zip(&workspace.reactions) {
            accepted.copy_from_slice(reactions);
        }
    }

    /// Moves particles back into the box along periodic directions.
    fn wrap(&mut self) {
        let domain = &self.model.domain;
        if !domain.is_periodic() {
            return;
        }
        for (x, image_count) in self.state.particles.position.iter_mut().zip(&mut self.state.image_counts) {
            let wrapped = domain.wrapped(x);
            for axis in 0..image_count.len() {
                let turns = (x[axis] - wrapped[axis]) / domain.size()[axis];
                // A saturating conversion of a small whole number.
                image_count[axis] += turns.round() as i32;
            }
            *x = wrapped;
        }
    }
}

impl Solver for SolidSolver {
    fn role(&self) -> Role {
        Role::Solid
    }

    fn begin_stage(&mut self, time: &StageTime) -> Result<(), Divergence> {
        if time.at.stage == Stage::Predictor {
            self.workspace.stage.copy_from(&self.state.particles);
            self.workspace.stage_rigid.clone_from(&self.state.rigid);
            self.workspace.springs.clone_from(&self.state.springs);
        }
        self.enter_stage(time);
        Ok(())
    }

    fn time_step_limit(&self) -> f64 {
        acceleration_limit(self.model.spacing, self.state.last.largest_acceleration)
            .min(step_limit(&self.model, &self.state))
    }

    fn limiting_particle(&self) -> Option<(u32, [f64; DIMENSIONS])> {
        let Self { model, workspace, .. } = self;
        let limit = |i: usize| particle_limit(model, workspace, i);
        let i = (0..model.len()).min_by(|i, j| limit(*i).total_cmp(&limit(*j)))?;
        Some((model.particles.id[i], workspace.stage.position[i].into()))
    }

    fn extent(&self) -> &Extent {
        self.workspace.fluid.as_ref().map_or(&self.no_extent, |link| link.extent())
    }

    fn interface(&mut self, partner: &Extent, reach: f64, states: &mut InterfaceStates) -> u64 {
        let Workspace { stage, stress, fluid, .. } = &mut self.workspace;
        match fluid {
            Some(link) => link.select(&self.model.particles, stage, stress, partner, reach, states),
            None => {
                states.clear();
                0
            }
        }
    }

    fn covered_by(&self, extent: &Extent, reach: f64) -> Result<(), f64> {
        let positions = &self.workspace.stage.position;
        self.workspace.fluid.as_ref().map_or(Ok(()), |link| link.covered_by(extent, reach, positions))
    }

    fn evaluate_own(&mut self, time: &StageTime) {
        let at = time.state_time();
        match (self.model.stepping, time.at.stage) {
            (SolidStepping::StageRule, _) => evaluate_pairs(&self.model, &mut self.workspace, at),
            // Both passes of sub-steps start from the forces at the start of the step.
            (SolidStepping::Substeps(_), Stage::Predictor) => {
                evaluate_pairs(&self.model, &mut self.workspace, at);
                sum_forces(&self.model, &mut self.workspace, time, at);
                self.workspace.start_forces.clone_from(&self.workspace.forces);
                self.workspace.start_springs.clone_from(&self.workspace.springs);
            }
            (SolidStepping::Substeps(_), Stage::Corrector) => {}
        }
    }

    fn evaluate_cross(&mut self, time: &StageTime, own: &InterfaceStates, partner: &InterfaceStates) {
        let Workspace { fluid, sums, fluid_force, interface_sums, .. } = &mut self.workspace;
        if let Some(link) = fluid {
            *interface_sums = link.evaluate(time.state_time(), own, partner, sums, fluid_force);
        }
        self.complete_stage(time);
    }

    fn evaluate_loads(
        &mut self,
        time: &StageTime,
        own: &InterfaceStates,
        forces: &[Vector],
    ) -> Result<(), NoLoads> {
        let Workspace { fluid, fluid_force, interface_sums, .. } = &mut self.workspace;
        let link = fluid.as_ref().ok_or(NoLoads)?;
        *interface_sums = link.apply(own, forces, fluid_force);
        self.complete_stage(time);
        Ok(())
    }

    fn revise(
        &mut self,
        time: &StageTime,
        own: &InterfaceStates,
        forces: &[Vector],
    ) -> Result<(), NotRevised> {
        let Workspace { fluid, fluid_force, forces: others, total_force, .. } = &mut self.workspace;
        let link = fluid.as_ref().ok_or(NotRevised::NotOffered)?;
        link.apply(own, forces, fluid_force);
        // Sub-steps add up their own.
        total_forces(others, fluid_force, total_force);
        let predictor = StepStage { stage: Stage::Predictor, ..time.at };
        self.move_stage(&StageTime { at: predictor, ..*time })
            .map_err(|divergence| NotRevised::Diverged(Divergence { at: time.at, ..divergence }))?;
        self.take_prediction();
        self.enter_stage(time);
        Ok(())
    }

    /// With sub-steps, forces of the solids on themselves are evaluated within.
    fn advance(&mut self, time: &StageTime) -> Result<StageBooks, Divergence> {
        self.move_stage(time)?;
        let record = stage_record(&self.model, &self.state, &self.workspace, time);
        match time.at.stage {
            Stage::Predictor => self.take_prediction(),
            Stage::Corrector => self.accept(&record, time.duration()),
        }
        Ok(record.budget)
    }

    fn end_step(&mut self, time: &StageTime) -> Result<(), Divergence> {
        self.wrap();
        self.state.last.outside =
            check_domain(&self.model, &self.state.particles, time).map_err(|divergence| *divergence)?;
        let SolidState { particles, image_counts, angles, .. } = &mut self.state;
        for (body, angle) in self.model.bodies.iter().zip(angles).filter(|(body, _)| body.tracks_angle) {
            *angle = best_fit_angle(&self.model, body, particles, image_counts, *angle);
        }
        Ok(())
    }

    fn energies(&self) -> Energies {
        energies(&self.model, &self.state, &(0..self.model.len()))
    }

    fn probes(&self, time: f64, values: &mut Vec<f64>) {
        probe_values(&self.model, &self.state, time, values);
    }

    fn snapshot(&self, step: u64, time: f64) -> ParticleFields {
        snapshot(&self.model, &self.state, step, time)
    }

    fn counts(&self) -> Counts {
        Counts {
            particles: self.model.len() as u64,
            wall_particles: self.model.walls.len() as u64,
            list_builds: self.workspace.list_builds,
            lost: self.state.last.outside,
            outflow: 0,
            largest_interface: self.workspace.fluid.as_ref().map_or(0, |link| link.largest_set),
            deepest_contact_m: BodyContact::all(&self.state.last.contacts).deepest,
            contact_impulse_n_s_per_m: BodyContact::all(&self.state.last.contacts).impulse,
            substeps: self.state.last.substeps,
        }
    }

    fn save(&self, saved: &mut SavedState) {
        self.state.save(saved);
        let counts = self.counts();
        saved.put_u64(HISTORY, [counts.list_builds, counts.largest_interface]);
    }

    fn restore(&mut self, saved: &SavedState) -> Result<(), RestoreError> {
        let state = SolidState::restored(&self.model, &self.state, saved)?;
        check(&self.model, &state.particles, StepStage::FIRST)
            .map_err(|divergence| RestoreError::new("state", divergence.to_string()))?;
        let [list_builds, largest_set] = saved.u64s(HISTORY)?;
        self.workspace.list_builds = list_builds;
        if let Some(link) = &mut self.workspace.fluid {
            link.restore(&state.particles.position, largest_set);
        }
        self.state = state;
        Ok(())
    }
}
