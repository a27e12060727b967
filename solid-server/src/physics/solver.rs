//! The solid side of a run, stepped by the half-step driver.

use rayon::prelude::*;

use sph::exchange::{Extent, InterfaceStates};
use sph::ledger::{Energies, StageBooks};
use sph::setup::SolidSetup;
use sph::solver::{Counts, Divergence, ParticleFields, Role, Solver};
use sph::stage::{Stage, StageTime};
use sph::sums::ordered_sum;
use sph::vector::Vector;

use super::advance::{move_bodies, record};
use super::build::{build, build_workspace};
use super::checks::{check, check_domain};
use super::contact_sums::SumStage;
use super::lists::{Rows, TASK};
use super::model::{ContactModel, SolidModel};
use super::probes::probe_values;
use super::report::{best_fit_angle, energies, snapshot};
use super::workspace::{SolidState, Workspace};

/// Several elastic or rigid bodies in one domain.
///
/// The stated limit of the time step is the smallest of: the limit of each body's waves (for the updated-Lagrangian
/// formulation CFL(A)·h/c_L with CFL = A^⅓ up to A = 1), 1/ω of the stiffest contact of the stage before, and
/// ¼ √(Δx/a) for the largest acceleration a of that stage.
pub struct SolidSolver {
    pub(super) model: SolidModel,
    pub(super) state: SolidState,
    pub(super) workspace: Workspace,
    /// Extent of a run without a partner: nothing.
    no_extent: Extent,
}

impl SolidSolver {
    /// A solver at the start of the run that `setup` describes.
    ///
    /// # Errors
    /// All that is wrong with the set-up: arrays that do not fit each other, expressions that do not parse, probes
    /// outside their body, laws that a body's formulation cannot serve, an initial state beyond the limits.
    pub fn new(setup: SolidSetup) -> Result<Self, Vec<String>> {
        let coupling = setup.run.coupling;
        let (model, state) = build(setup)?;
        let workspace = build_workspace(&model, &state, coupling.as_ref());
        Ok(Self { model, state, workspace, no_extent: Extent::default() })
    }

    /// Pressure and stress of the stage state.
    fn update_stress(&mut self) {
        let Workspace { stage, stress, .. } = &mut self.workspace;
        for body in &self.model.bodies {
            body.formulation.update_stress(&stage.view(&body.range), stress.view_mut(&body.range));
        }
    }

    fn refresh_lists(&mut self) {
        let Workspace { stage, own_lists, contact_lists, walls, list_builds, .. } = &mut self.workspace;
        let domain = &self.model.domain;
        for (body, lists) in self.model.bodies.iter().zip(own_lists) {
            if let Some(lists) = lists {
                *list_builds += u64::from(lists.refresh(domain, &stage.position[body.range.clone()]));
            }
        }
        let members = &self.model.particles.body;
        *list_builds += u64::from(contact_lists.refresh(domain, &stage.position, &walls.position, members));
    }

    /// Contact of bodies with each other and with walls.
    fn evaluate_contact(&mut self, time: &StageTime) {
        let Workspace { stage, stress, sums, contact, contact_lists, walls, wall_pressure, .. } =
            &mut self.workspace;
        let model = &self.model;
        match &model.contact {
            ContactModel::Repulsion(law) => {
                law.evaluate(model, time, stage, contact_lists, walls, contact);
            }
            ContactModel::Sums(law) => {
                let at = SumStage { model, time, stage, stress, lists: contact_lists, walls };
                law.evaluate(&at, wall_pressure, sums, contact);
            }
        }
    }

    /// Forces that need no neighbours, and the total of all.
    fn total_forces(&mut self, time: &StageTime) {
        let Workspace { stage, sums, contact, forces, total_force, .. } = &mut self.workspace;
        let model = &self.model;
        let (state_time, damping_rate) = (time.state_time(), model.damping_rate(time));
        forces.par_iter_mut().zip(total_force).with_min_len(8 * TASK).enumerate().for_each(
            |(i, (forces, total))| {
                let mass = model.particles.mass[i];
                forces.body_force = model.body_force.acceleration(&stage.position[i], state_time) * mass;
                // Damping acts on free particles; a support would only take it up again.
                forces.damping = if damping_rate == 0.0 || model.acting_support(i, time).is_some() {
                    Vector::zeros()
                } else {
                    stage.velocity[i] * (-damping_rate * mass)
                };
                *total = sums[i].force
                    + contact[i].bodies
                    + contact[i].walls
                    + forces.fluid
                    + forces.body_force
                    + forces.damping;
            },
        );
    }

    fn complete_rates(&mut self) {
        let Workspace { stage, sums, rates, .. } = &mut self.workspace;
        for body in &self.model.bodies {
            let range = &body.range;
            body.formulation.complete(&stage.view(range), &sums[range.clone()], rates.view_mut(range));
        }
    }

    /// Takes the corrector's result as the state at the new step boundary.
    fn accept(&mut self, largest_acceleration: f64, contact_frequency: f64) {
        let Self { model, state, workspace, .. } = self;
        std::mem::swap(&mut state.particles, &mut workspace.next);
        std::mem::swap(&mut state.rigid, &mut workspace.next_rigid);
        let last = &mut state.last;
        last.largest_acceleration = largest_acceleration;
        last.contact_frequency = contact_frequency;
        for (fluid_force, body) in last.fluid_force.iter_mut().zip(&model.bodies) {
            let forces = &workspace.forces[body.range.clone()];
            *fluid_force = ordered_sum(forces.len(), |i| forces[i].fluid);
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
        for (x, winding) in self.state.particles.position.iter_mut().zip(&mut self.state.windings) {
            let wrapped = domain.wrapped(x);
            for axis in 0..winding.len() {
                let turns = (x[axis] - wrapped[axis]) / domain.size()[axis];
                // A saturating conversion of a small whole number.
                winding[axis] += turns.round() as i32;
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
        }
        self.model.walls.move_to(time.state_time(), &mut self.workspace.walls);
        self.update_stress();
        self.refresh_lists();
        if let Some(link) = &mut self.workspace.fluid {
            link.track(&self.workspace.stage.position);
        }
        Ok(())
    }

    fn time_step_limit(&self) -> f64 {
        let last = &self.state.last;
        let waves = self.model.bodies.iter().map(|body| body.formulation.time_step_limit());
        let force = 0.25 * (self.model.spacing / last.largest_acceleration).sqrt();
        waves.fold(force.min(1.0 / last.contact_frequency), f64::min)
    }

    fn extent(&self) -> &Extent {
        self.workspace.fluid.as_ref().map_or(&self.no_extent, |link| link.extent())
    }

    fn interface(&mut self, partner: &Extent, reach: f64, states: &mut InterfaceStates) -> u64 {
        let Workspace { stage, stress, fluid, .. } = &mut self.workspace;
        match fluid {
            Some(link) => link.select(&self.model, stage, stress, partner, reach, states),
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
        let Workspace { stage, stress, sums, own_lists, .. } = &mut self.workspace;
        let none = Rows::default();
        for (body, lists) in self.model.bodies.iter().zip(own_lists) {
            let range = &body.range;
            body.formulation.evaluate(
                &self.model.constants(body),
                &stage.view(range),
                &stress.view(range),
                lists.as_ref().map_or(&none, |lists| &lists.rows),
                &mut sums[range.clone()],
            );
        }
        self.evaluate_contact(time);
    }

    fn evaluate_cross(&mut self, time: &StageTime, own: &InterfaceStates, partner: &InterfaceStates) {
        let Workspace { fluid, sums, forces, interface_sums, .. } = &mut self.workspace;
        if let Some(link) = fluid {
            *interface_sums = link.evaluate(time.state_time(), own, partner, sums, forces);
        }
        self.total_forces(time);
        self.complete_rates();
    }

    fn advance(&mut self, time: &StageTime) -> Result<StageBooks, Divergence> {
        move_bodies(&self.model, &self.state, &mut self.workspace, time);
        check(&self.model, &self.workspace.next, time.at).map_err(|divergence| *divergence)?;
        let record = record(&self.model, &self.state, &self.workspace, time);
        match time.at.stage {
            Stage::Predictor => {
                std::mem::swap(&mut self.workspace.stage, &mut self.workspace.next);
                std::mem::swap(&mut self.workspace.stage_rigid, &mut self.workspace.next_rigid);
            }
            Stage::Corrector => self.accept(record.largest_acceleration, record.contact_frequency),
        }
        Ok(record.books)
    }

    fn end_step(&mut self, time: &StageTime) -> Result<(), Divergence> {
        self.wrap();
        self.state.last.outside =
            check_domain(&self.model, &self.state.particles, time).map_err(|divergence| *divergence)?;
        let SolidState { particles, windings, angles, .. } = &mut self.state;
        for (body, angle) in self.model.bodies.iter().zip(angles).filter(|(body, _)| body.tracks_angle) {
            *angle = best_fit_angle(&self.model, body, particles, windings, *angle);
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
        }
    }
}
