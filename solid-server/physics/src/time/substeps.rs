//! Velocity-Verlet sub-steps of the solids within a stage, under the frozen force of the fluid.

use sph::coupling::ledger::{EnergyAccount, EnergyValues};
use sph::coupling::stage::{Stage, StageTime};
use sph::setup::SubstepCount;
use sph::tasks::for_each;

use crate::formulations::formulation::{AngularImpulse, BodyDrift, BodyKick};
use crate::neighbours::lists::TASK;
use crate::particles::forces::{ParticleForces, ParticleTorques};
use crate::space::SolidSpace;
use crate::system::model::SolidModel;
use crate::system::state::SolidState;
use crate::system::workspace::Workspace;
use crate::time::advance::{HeldQuantity, impose_supports, take_reactions};
use crate::time::energy_budget::enter_kick;
use crate::time::evaluate::{
    add_film, add_torques, evaluate_pairs, refresh_lists, sum_forces, total_forces, update_stage,
};
use crate::time::limits::{automatic_substeps, rigid_contact_frequency, substep_limit};
use crate::time::stepping::Stepping;

/// Velocity-Verlet sub-steps of this number per step.
///
/// ```text
/// v½ = v + ½τ f(x, v)/m,  x' = x + τ v½,  v' = v½ + ½τ f(x', 2v½ − v)/m
/// ```
///
/// The force of the fluid is that of the stage, all others are evaluated in every sub-step; those at the start of the
/// step, `workspace.start_forces`, are given. Velocity-dependent forces see the extrapolated velocity, so that the rule
/// is of second order; without them it is symplectic. Density and stress that evolve follow the velocity gradient at
/// x + ½τ v½. A pass leaves the stress of the new state, and means of the forces over the stage.
pub struct Substeps(pub SubstepCount);

/// Sub-steps of the stage of `time`: half of those of the step in the predictor.
///
/// Both stages decide by the state at the start of the step, `start_forces` being the forces there.
fn stage_substeps<S: SolidSpace>(
    model: &SolidModel<S>,
    state: &SolidState<S>,
    start_forces: &[ParticleForces<S>],
    count: SubstepCount,
    time: &StageTime,
) -> u32 {
    let pairs = match count {
        SubstepCount::Fixed(count) => count / 2,
        SubstepCount::Automatic => {
            let rigid = 1.0 / rigid_contact_frequency(model, start_forces, time);
            automatic_substeps(time.time_step, substep_limit(model, state).min(rigid)) / 2
        }
    };
    match time.at.stage {
        Stage::Predictor => pairs,
        Stage::Corrector => 2 * pairs,
    }
}

/// A stage of sub-steps.
struct SubstepPass<'a, S: SolidSpace> {
    model: &'a SolidModel<S>,
    state: &'a SolidState<S>,
    time: &'a StageTime,
    /// Duration of a sub-step \[s\].
    duration: f64,
    /// Whether some body needs sums in the middle of a drift.
    evolves: bool,
}

impl<S: SolidSpace> Stepping<S> for Substeps {
    /// A pass of sub-steps leaves the corrector all that belongs to its state.
    fn prepare(&self, model: &SolidModel<S>, workspace: &mut Workspace<S>, time: &StageTime) {
        if time.at.stage == Stage::Predictor {
            update_stage(model, workspace, time, time.state_time());
        }
    }

    /// Both passes start from the forces at the start of the step.
    fn evaluate(&self, model: &SolidModel<S>, workspace: &mut Workspace<S>, time: &StageTime) {
        if time.at.stage == Stage::Predictor {
            evaluate_pairs(model, workspace, time.state_time());
            sum_forces(model, workspace, time, time.state_time());
            workspace.start_forces.clone_from(&workspace.forces);
            workspace.start_springs.copy_from(&workspace.springs);
        }
    }

    fn advance(
        &self,
        model: &SolidModel<S>,
        state: &SolidState<S>,
        workspace: &mut Workspace<S>,
        time: &StageTime,
    ) {
        let count = stage_substeps(model, state, &workspace.start_forces, self.0, time);
        workspace.substeps = count;
        let duration = time.duration() / f64::from(count);
        let evolves = model.bodies.iter().any(|body| body.formulation.evolves());
        let pass = SubstepPass { model, state, time, duration, evolves };
        workspace.next.copy_from(&state.particles);
        workspace.next_rigid.clone_from(&state.rigid);
        workspace.forces.clone_from(&workspace.start_forces);
        add_film(workspace);
        workspace.springs.copy_from(&workspace.start_springs);
        workspace.mean_forces.fill(ParticleForces::default());
        workspace.mean_torques.fill(ParticleTorques::default());
        workspace.angular_impulse = AngularImpulse::default();
        workspace.energy = EnergyValues::default();
        workspace.exchange_position.clone_from(&workspace.stage.position);
        let weight = 0.5 / f64::from(count);
        for k in 0..count {
            pass.first_half(workspace, k, weight);
            pass.second_half(workspace, k, weight);
        }
        workspace.energy.add(EnergyAccount::Supports, workspace.angular_impulse.work);
        let Workspace { stage, next, mean_forces, fluid_force, total_force, .. } = workspace;
        next.density.clone_from(&stage.density);
        next.deviatoric_stress.clone_from(&stage.deviatoric_stress);
        total_forces(mean_forces, fluid_force, total_force);
        take_reactions(model, state, workspace, time);
    }
}

impl<S: SolidSpace> SubstepPass<'_, S> {
    /// Time `parts` sub-steps after the start of the step \[s\].
    fn time_at(&self, parts: f64) -> f64 {
        self.time.step_start + parts * self.duration
    }

    /// From the start of sub-step `k` to its end, velocities half a sub-step behind.
    fn first_half(&self, workspace: &mut Workspace<S>, k: u32, weight: f64) {
        let k = f64::from(k);
        workspace.velocity_gain.clone_from(&workspace.next.velocity);
        self.kick(workspace, self.time_at(k + 0.5), weight);
        let Workspace { next, velocity_gain, .. } = workspace;
        for (gain, velocity) in velocity_gain.iter_mut().zip(&next.velocity) {
            *gain = *velocity - *gain;
        }
        if self.evolves {
            self.sum_in_the_middle(workspace, self.time_at(k + 0.5));
        }
        self.drift(workspace, self.time_at(k + 1.0));
    }

    /// Forces at the end of sub-step `k`, and the rest of its velocities.
    fn second_half(&self, workspace: &mut Workspace<S>, k: u32, weight: f64) {
        let end = self.time_at(f64::from(k) + 1.0);
        let Workspace { stage, next, velocity_gain, .. } = workspace;
        stage.copy_from(next);
        for (velocity, gain) in stage.velocity.iter_mut().zip(velocity_gain) {
            *velocity += *gain;
        }
        update_stage(self.model, workspace, self.time, end);
        evaluate_pairs(self.model, workspace, end);
        sum_forces(self.model, workspace, self.time, end);
        add_film(workspace);
        self.kick(workspace, end, weight);
    }

    /// Half a sub-step of all velocities; adds the forces to their means with `weight`.
    fn kick(&self, workspace: &mut Workspace<S>, target: f64, weight: f64) {
        // The predictor's pass is only a guess at the middle of the step.
        let counts = self.time.at.stage == Stage::Corrector;
        if counts {
            workspace.kicked_from.clone_from(&workspace.next.velocity);
        }
        let Workspace {
            next,
            next_rigid,
            forces,
            mean_forces,
            fluid_force,
            total_force,
            angular_impulse,
            ..
        } = workspace;
        for_each((&mut total_force[..], &mut mean_forces[..]), 8 * TASK, |i, (total, mean)| {
            *total = forces[i].total + fluid_force[i];
            mean.add(weight, &forces[i]);
        });
        if let Some(origin) = self.model.torque_origin() {
            let (torques, at) = (&mut workspace.mean_torques, &workspace.exchange_position);
            add_torques(torques, weight, origin, &next.position, forces);
            for (i, torques) in torques.iter_mut().enumerate() {
                torques.displaced += S::cross(&(next.position[i] - at[i]), &fluid_force[i]) * weight;
            }
        }
        for (k, body) in self.model.bodies.iter().enumerate() {
            let kick = BodyKick {
                constants: self.model.constants(body),
                time: self.time,
                duration: 0.5 * self.duration,
                target,
                force: &total_force[body.range.clone()],
                base_rigid: &self.state.rigid[k],
                image_counts: &self.state.image_counts[body.range.clone()],
            };
            *angular_impulse += body.formulation.kick(&kick, next.view_mut(&body.range), &mut next_rigid[k]);
        }
        angular_impulse.supports +=
            impose_supports(self.model, self.state, self.time, target, HeldQuantity::Velocities, next);
        if counts {
            enter_kick(self.model, workspace, self.time, 0.5 * self.duration);
        }
    }

    /// Velocity gradients half a drift on.
    fn sum_in_the_middle(&self, workspace: &mut Workspace<S>, middle: f64) {
        let Workspace { stage, next, walls, .. } = workspace;
        stage.copy_from(next);
        for (x, v) in stage.position.iter_mut().zip(&next.velocity) {
            *x += *v * (0.5 * self.duration);
        }
        self.model.walls.move_to(middle, walls);
        refresh_lists(self.model, workspace, self.time);
        evaluate_pairs(self.model, workspace, middle);
    }

    fn drift(&self, workspace: &mut Workspace<S>, target: f64) {
        let Workspace { next, next_rigid, sums, angular_impulse, .. } = workspace;
        for (k, body) in self.model.bodies.iter().enumerate() {
            let drift = BodyDrift {
                constants: self.model.constants(body),
                time: self.time,
                duration: self.duration,
                target,
                sums: &sums[body.range.clone()],
                base_rigid: &self.state.rigid[k],
                image_counts: &self.state.image_counts[body.range.clone()],
            };
            *angular_impulse +=
                body.formulation.drift(&drift, next.view_mut(&body.range), &mut next_rigid[k]);
        }
        angular_impulse.scheme +=
            impose_supports(self.model, self.state, self.time, target, HeldQuantity::Positions, next);
    }
}
