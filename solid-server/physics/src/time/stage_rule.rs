//! The stage rule, Eq. (30)-(31): each stage evaluates all forces once and moves the bodies by them.

use sph::coupling::stage::StageTime;

use crate::particles::forces::ParticleTorques;
use crate::space::SolidSpace;
use crate::system::model::SolidModel;
use crate::system::state::SolidState;
use crate::system::workspace::Workspace;
use crate::time::advance::move_bodies;
use crate::time::evaluate::{add_film, add_torques, evaluate_pairs, sum_forces, total_forces, update_stage};
use crate::time::stepping::Stepping;

/// The stage rule.
pub struct StageRule;

impl<S: SolidSpace> Stepping<S> for StageRule {
    fn prepare(&self, model: &SolidModel<S>, workspace: &mut Workspace<S>, time: &StageTime) {
        update_stage(model, workspace, time, time.state_time());
    }

    fn evaluate(&self, model: &SolidModel<S>, workspace: &mut Workspace<S>, time: &StageTime) {
        evaluate_pairs(model, workspace, time.state_time());
    }

    fn complete(&self, model: &SolidModel<S>, workspace: &mut Workspace<S>, time: &StageTime) {
        sum_forces(model, workspace, time, time.state_time());
        add_film(workspace);
        let Workspace {
            stage, sums, rates, forces, mean_forces, mean_torques, fluid_force, total_force, ..
        } = workspace;
        total_forces(forces, fluid_force, total_force);
        mean_forces.clone_from(forces);
        if let Some(origin) = model.torque_origin() {
            mean_torques.fill(ParticleTorques::default());
            add_torques(mean_torques, 1.0, origin, &stage.position, forces);
        }
        for body in &model.bodies {
            let range = &body.range;
            body.formulation.complete(&stage.view(range), &sums[range.clone()], rates.view_mut(range));
        }
    }

    fn advance(
        &self,
        model: &SolidModel<S>,
        state: &SolidState<S>,
        workspace: &mut Workspace<S>,
        time: &StageTime,
    ) {
        move_bodies(model, state, workspace, time);
    }
}
