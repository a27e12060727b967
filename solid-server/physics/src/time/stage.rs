//! The flow of a stage: preparation, completion, movement and acceptance.

use sph::coupling::solver::Divergence;
use sph::coupling::stage::{Stage, StageTime};
use sph::setup::SolidStepping;
use sph::sums::ordered_sum;

use crate::particles::forces::ParticleTorques;
use crate::system::model::SolidModel;
use crate::system::state::{SolidState, StageMaxima};
use crate::system::workspace::Workspace;
use crate::time::advance::move_bodies;
use crate::time::checks::check;
use crate::time::evaluate::{add_torques, refresh_lists, sum_forces, total_forces, update_stress};
use crate::time::substeps::move_by_substeps;

fn complete_rates(model: &SolidModel, workspace: &mut Workspace) {
    let Workspace { stage, sums, rates, .. } = workspace;
    for body in &model.bodies {
        let range = &body.range;
        body.formulation.complete(&stage.view(range), &sums[range.clone()], rates.view_mut(range));
    }
}

/// Forces and rates of the stage, once those of the fluid are known.
pub fn complete_stage(model: &SolidModel, workspace: &mut Workspace, time: &StageTime) {
    if model.stepping == SolidStepping::StageRule {
        sum_forces(model, workspace, time, time.state_time());
        let Workspace { stage, forces, mean_forces, mean_torques, fluid_force, total_force, .. } = workspace;
        total_forces(forces, fluid_force, total_force);
        mean_forces.clone_from(forces);
        if let Some(origin) = model.torque_origin() {
            mean_torques.fill(ParticleTorques::default());
            add_torques(mean_torques, 1.0, origin, &stage.position, forces);
        }
        complete_rates(model, workspace);
    }
}

/// Prepares the stage state: walls, stress, lists and the extent at the interface.
pub fn enter_stage(model: &SolidModel, workspace: &mut Workspace, time: &StageTime) {
    // A pass of sub-steps leaves the corrector all that belongs to its state.
    if time.at.stage == Stage::Predictor || model.stepping == SolidStepping::StageRule {
        model.walls.move_to(time.state_time(), &mut workspace.walls);
        update_stress(model, workspace);
        refresh_lists(model, workspace, time);
    }
    if let Some(link) = &mut workspace.fluid {
        link.track(&workspace.stage.position);
    }
}

/// Moves all bodies from the start of the step to `workspace.next`, checked.
pub fn move_stage(
    model: &SolidModel,
    state: &SolidState,
    workspace: &mut Workspace,
    time: &StageTime,
) -> Result<(), Divergence> {
    match model.stepping {
        SolidStepping::StageRule => move_bodies(model, state, workspace, time),
        SolidStepping::Substeps(count) => {
            move_by_substeps(model, state, workspace, time, count);
        }
    }
    check(model, &workspace.next, time.at).map_err(|divergence| *divergence)
}

/// Takes the predictor's result as the stage state of the corrector.
pub fn take_prediction(workspace: &mut Workspace) {
    let Workspace { stage, stage_rigid, next, next_rigid, .. } = workspace;
    std::mem::swap(stage, next);
    std::mem::swap(stage_rigid, next_rigid);
}

/// Takes the corrector's result as the state at the new step boundary, `duration` \[s\] after the last.
pub fn accept(
    model: &SolidModel,
    state: &mut SolidState,
    workspace: &mut Workspace,
    maxima: StageMaxima,
    duration: f64,
) {
    std::mem::swap(&mut state.particles, &mut workspace.next);
    std::mem::swap(&mut state.rigid, &mut workspace.next_rigid);
    state.springs.clone_from(&workspace.springs);
    let last = &mut state.last;
    last.maxima = maxima;
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
pub fn wrap(model: &SolidModel, state: &mut SolidState) {
    let domain = &model.domain;
    if !domain.is_periodic() {
        return;
    }
    for (x, image_count) in state.particles.position.iter_mut().zip(&mut state.image_counts) {
        let wrapped = domain.wrapped(x);
        for axis in 0..image_count.len() {
            let turns = (x[axis] - wrapped[axis]) / domain.size()[axis];
            // A saturating conversion of a small whole number.
            image_count[axis] += turns.round() as i32;
        }
        *x = wrapped;
    }
}
