//! The solid side of a run, stepped by the half-step driver.

use sph::coupling::exchange::{Column, Extent, StateColumns};
use sph::coupling::ledger::{EnergyReport, StageBudget};
use sph::coupling::saved::{RestoreError, SavedState};
use sph::coupling::solver::{Counts, Divergence, NoLoads, NotUpdated, ParticleFields, Role, Solver};
use sph::coupling::stage::{Stage, StageTime, StepStage};
use sph::lanes::Arithmetic;
use sph::setup::{SolidSetup, SolidStepping};
use sph::space::components::Components;
use sph::space::{Plane, Spatial};
use sph::sums::ordered_sum;

use crate::build::{build, build_workspace};
use crate::contact::film::FilmStage;
use crate::contact::start::remarks;
use crate::report::body_sums::best_fit_rotation;
use crate::report::fields::snapshot;
use crate::report::probes::probe_values;
use crate::space::SolidSpace;
use crate::system::model::SolidModel;
use crate::system::saved::HISTORY;
use crate::system::state::{BodyContact, SolidState};
use crate::system::workspace::Workspace;
use crate::time::checks::{check, check_domain};
use crate::time::energy_budget;
use crate::time::evaluate::total_forces;
use crate::time::limits::{acceleration_limit, particle_limit, rigid_travel_limit, step_limit};
use crate::time::momentum_budget::momentum_budget;
use crate::time::stage::{accept, take_prediction, wrap};
use crate::time::stage_rule::StageRule;
use crate::time::stepping::Stepping;
use crate::time::substeps::Substeps;

/// Several elastic or rigid bodies in one domain.
///
/// The stated limit of the time step is the smallest of: the limit of each body's waves under the stepping of the case,
/// 1/ω of the stiffest contact of the stage before, both times the number of sub-steps, ¼ √(Δx/a) for the largest
/// acceleration a of that stage, and ¼ Δx/v for the largest speed v where rigid bodies may meet something.
pub struct SolidSolver<S: SolidSpace> {
    pub(crate) model: SolidModel<S>,
    pub(crate) state: SolidState<S>,
    pub(crate) workspace: Workspace<S>,
    stepping: Box<dyn Stepping<S>>,
    /// Empty extent of a run without a partner.
    no_extent: Extent,
}

impl<S: SolidSpace> SolidSolver<S> {
    /// Mass of each body as its equations use it, and of a rigid one its moment of inertia about its centre of mass at the
    /// start \[kg\], \[kg m²\], in the plane per depth.
    pub fn masses(&self) -> impl Iterator<Item = (f64, Option<S::Inertia>)> + '_ {
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
    pub fn new(setup: SolidSetup<S>) -> Result<Self, Vec<String>> {
        Self::with_arithmetic(setup, Arithmetic::chosen())
    }

    /// The same with the given arithmetic instead of that of this process.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_arithmetic(setup: SolidSetup<S>, arithmetic: Arithmetic) -> Result<Self, Vec<String>> {
        let coupling = setup.run.coupling;
        let (model, state) = build(setup, arithmetic)?;
        let workspace = build_workspace(&model, &state, coupling.as_ref());
        let stepping: Box<dyn Stepping<S>> = match model.stepping {
            SolidStepping::StageRule => Box::new(StageRule),
            SolidStepping::Substeps(count) => Box::new(Substeps(count)),
        };
        Ok(Self { model, state, workspace, stepping, no_extent: Extent::default() })
    }
}

/// A solver for a run, with what moves its bodies.
pub struct Built<S: SolidSpace> {
    /// The solver.
    pub solver: Box<dyn Solver>,
    /// As [`SolidSolver::masses`].
    pub masses: Vec<(f64, Option<S::Inertia>)>,
}

/// A solver in the plane at the start of the run that `setup` describes, with the arithmetic of this process.
///
/// Its passes are compiled in this crate, as one unit, which makes them faster than where they are used.
///
/// # Errors
/// As [`SolidSolver::new`].
pub fn plane_solver(setup: SolidSetup<Plane>) -> Result<Built<Plane>, Vec<String>> {
    built(setup)
}

/// The same in space.
///
/// # Errors
/// As [`SolidSolver::new`].
pub fn spatial_solver(setup: SolidSetup<Spatial>) -> Result<Built<Spatial>, Vec<String>> {
    built(setup)
}

fn built<S: SolidSpace>(setup: SolidSetup<S>) -> Result<Built<S>, Vec<String>> {
    let solver = SolidSolver::new(setup)?;
    let masses = solver.masses().collect();
    Ok(Built { solver: Box::new(solver), masses })
}

impl<S: SolidSpace> SolidSolver<S> {
    fn enter_stage(&mut self, time: &StageTime) {
        self.stepping.prepare(&self.model, &mut self.workspace, time);
        if let Some(link) = &mut self.workspace.fluid {
            link.track(&self.workspace.stage.position);
        }
    }

    /// Moves all bodies from the start of the step to `workspace.next`, checked.
    fn move_stage(&mut self, time: &StageTime) -> Result<(), Divergence> {
        self.stepping.advance(&self.model, &self.state, &mut self.workspace, time);
        check(&self.model, &self.workspace.next, time.at).map_err(|divergence| *divergence)
    }
}

impl<S: SolidSpace> Solver for SolidSolver<S> {
    fn role(&self) -> Role {
        Role::Solid
    }

    fn begin_stage(&mut self, time: &StageTime) -> Result<(), Divergence> {
        if time.at.stage == Stage::Predictor {
            self.workspace.stage.copy_from(&self.state.particles);
            self.workspace.stage_rigid.clone_from(&self.state.rigid);
            self.workspace.springs.copy_from(&self.state.springs);
        }
        self.enter_stage(time);
        Ok(())
    }

    fn time_step_limit(&self) -> f64 {
        acceleration_limit::<S>(self.model.spacing, self.state.last.maxima.largest_acceleration)
            .min(step_limit(&self.model, &self.state))
            .min(rigid_travel_limit(&self.model, &self.state, &self.workspace.walls))
    }

    fn limiting_particle(&self) -> Option<(u32, Vec<f64>)> {
        let Self { model, workspace, .. } = self;
        let limit = |i: usize| particle_limit(model, workspace, i);
        let i = (0..model.len()).min_by(|i, j| limit(*i).total_cmp(&limit(*j)))?;
        Some((model.particles.id[i], workspace.stage.position[i].row().as_ref().to_vec()))
    }

    fn remarks(&self) -> Vec<String> {
        remarks(&self.model)
    }

    fn extent(&self) -> &Extent {
        self.workspace.fluid.as_ref().map_or(&self.no_extent, |link| link.extent())
    }

    fn interface(&mut self, partner: &Extent, reach: f64, states: &mut StateColumns) -> u64 {
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
        self.stepping.evaluate(&self.model, &mut self.workspace, time);
    }

    fn evaluate_cross(&mut self, time: &StageTime, own: &StateColumns, partner: &StateColumns) {
        let Workspace { fluid, sums, fluid_force, interface_sums, film, stage, contact_lists, walls, .. } =
            &mut self.workspace;
        if let Some(link) = fluid {
            *interface_sums = link.evaluate(time.state_time(), own, partner, sums, fluid_force);
            if let Some(film) = film {
                let (model, pairs) = (&self.model, link.pairs());
                film.evaluate(&FilmStage {
                    domain: &model.domain,
                    constants: &model.particles,
                    body_force: model.body_force.at(time.state_time()),
                    stage,
                    lists: &contact_lists.candidates,
                    walls,
                    pairs,
                    self_distance: film.self_distance(),
                });
            }
        }
        self.stepping.complete(&self.model, &mut self.workspace, time);
    }

    fn evaluate_loads(
        &mut self,
        time: &StageTime,
        own: &StateColumns,
        forces: &Column,
    ) -> Result<(), NoLoads> {
        let Workspace { fluid, fluid_force, interface_sums, .. } = &mut self.workspace;
        let link = fluid.as_mut().ok_or(NoLoads)?;
        *interface_sums = link.apply(own, forces, fluid_force);
        self.stepping.complete(&self.model, &mut self.workspace, time);
        Ok(())
    }

    fn update_stage(
        &mut self,
        time: &StageTime,
        own: &StateColumns,
        forces: &Column,
    ) -> Result<(), NotUpdated> {
        let Workspace { fluid, fluid_force, forces: others, total_force, .. } = &mut self.workspace;
        let link = fluid.as_mut().ok_or(NotUpdated::NotOffered)?;
        link.apply(own, forces, fluid_force);
        // Sub-steps add up their own.
        total_forces(others, fluid_force, total_force);
        let predictor = StepStage { stage: Stage::Predictor, ..time.at };
        self.move_stage(&StageTime { at: predictor, ..*time })
            .map_err(|divergence| NotUpdated::Diverged(Divergence { at: time.at, ..divergence }))?;
        take_prediction(&mut self.workspace);
        self.enter_stage(time);
        Ok(())
    }

    /// With sub-steps, forces of the solids on themselves are evaluated within.
    fn advance(&mut self, time: &StageTime) -> Result<StageBudget, Divergence> {
        self.move_stage(time)?;
        let (budget, maxima) = momentum_budget(&self.model, &self.state, &self.workspace, time);
        match time.at.stage {
            Stage::Predictor => take_prediction(&mut self.workspace),
            Stage::Corrector => {
                accept(&self.model, &mut self.state, &mut self.workspace, maxima, time.duration());
            }
        }
        Ok(budget)
    }

    fn end_step(&mut self, time: &StageTime) -> Result<(), Divergence> {
        wrap(&self.model, &mut self.state);
        self.state.last.outside =
            check_domain(&self.model, &self.state.particles, time).map_err(|divergence| *divergence)?;
        let SolidState { particles, image_counts, rotations, .. } = &mut self.state;
        for (body, rotation) in
            self.model.bodies.iter().zip(rotations).filter(|(body, _)| body.tracks_rotation)
        {
            *rotation = best_fit_rotation(&self.model, body, particles, image_counts, *rotation);
        }
        Ok(())
    }

    fn energies(&self) -> EnergyReport {
        energy_budget::report(&self.model, &self.state)
    }

    fn probes(&mut self, time: f64, values: &mut Vec<f64>) {
        probe_values(&self.model, &self.state, time, values);
    }

    fn snapshot(&mut self, step: u64, time: f64) -> ParticleFields {
        snapshot(&self.model, &self.state, step, time)
    }

    fn counts(&self) -> Counts {
        Counts {
            particles: self.model.len() as u64,
            wall_particles: self.model.walls.len() as u64,
            list_builds: self.workspace.list_builds,
            escaped: self.state.last.outside,
            outflow: 0,
            largest_interface: self.workspace.fluid.as_ref().map_or(0, |link| link.largest_set),
            deepest_contact_m: BodyContact::all(&self.state.last.contacts).deepest,
            contact_impulse_n_s: BodyContact::all(&self.state.last.contacts).impulse,
            substeps: self.state.last.substeps,
            ..Counts::default()
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
