//! What becomes of a stage's result.

use sph::sums::ordered_sum;

use crate::space::SolidSpace;
use crate::system::model::SolidModel;
use crate::system::state::{SolidState, StageMaxima};
use crate::system::workspace::Workspace;

/// Takes the predictor's result as the stage state of the corrector.
pub fn take_prediction<S: SolidSpace>(workspace: &mut Workspace<S>) {
    let Workspace { stage, stage_rigid, next, next_rigid, .. } = workspace;
    std::mem::swap(stage, next);
    std::mem::swap(stage_rigid, next_rigid);
}

/// Takes the corrector's result as the state at the new step boundary, `duration` \[s\] after the last.
pub fn accept<S: SolidSpace>(
    model: &SolidModel<S>,
    state: &mut SolidState<S>,
    workspace: &mut Workspace<S>,
    maxima: StageMaxima,
    duration: f64,
) {
    std::mem::swap(&mut state.particles, &mut workspace.next);
    std::mem::swap(&mut state.rigid, &mut workspace.next_rigid);
    state.springs.copy_from(&workspace.springs);
    state.energy.flows += workspace.energy;
    let last = &mut state.last;
    last.maxima = maxima;
    last.substeps += u64::from(workspace.substeps);
    for (fluid_force, body) in last.fluid_force.iter_mut().zip(&model.bodies) {
        let (forces, others) =
            (&workspace.fluid_force[body.range.clone()], &workspace.mean_forces[body.range.clone()]);
        *fluid_force = ordered_sum(forces.len(), |i| {
            let [bodies, walls] = others[i].film;
            forces[i] + (bodies + walls)
        });
    }
    for (contact, body) in last.contacts.iter_mut().zip(&model.bodies) {
        contact.follow(&workspace.mean_forces[body.range.clone()], duration);
    }
    for (accepted, reactions) in last.reactions.iter_mut().zip(&workspace.reactions) {
        accepted.copy_from_slice(reactions);
    }
}

/// Moves particles back into the box along periodic directions.
pub fn wrap<S: SolidSpace>(model: &SolidModel<S>, state: &mut SolidState<S>) {
    let domain = &model.domain;
    if !domain.is_periodic() {
        return;
    }
    for (x, image_count) in state.particles.position.iter_mut().zip(&mut state.image_counts) {
        let wrapped = domain.wrapped(x);
        for axis in 0..S::DIMENSIONS {
            let turns = (x[axis] - wrapped[axis]) / domain.size()[axis];
            // A saturating conversion of a small whole number.
            image_count[axis] += turns.round() as i32;
        }
        *x = wrapped;
    }
}
