//! A way to advance the solids within a step of the run.

use sph::coupling::stage::StageTime;

use crate::space::SolidSpace;
use crate::system::model::SolidModel;
use crate::system::state::SolidState;
use crate::system::workspace::Workspace;

/// A way to advance the solids: its calls in each stage, in order.
pub trait Stepping<S: SolidSpace>: Send + Sync {
    /// Walls, stress and neighbour lists of the stage state, before the interface particles are sent.
    fn prepare(&self, model: &SolidModel<S>, workspace: &mut Workspace<S>, time: &StageTime);

    /// Sums over pairs of the solids, while the fluid's particles are on their way.
    fn evaluate(&self, model: &SolidModel<S>, workspace: &mut Workspace<S>, time: &StageTime);

    /// Sums that include the force of the fluid. Sub-steps form their own.
    fn complete(&self, _model: &SolidModel<S>, _workspace: &mut Workspace<S>, _time: &StageTime) {}

    /// Moves all bodies from φⁿ in `state` to `workspace.next`.
    fn advance(
        &self,
        model: &SolidModel<S>,
        state: &SolidState<S>,
        workspace: &mut Workspace<S>,
        time: &StageTime,
    );
}
