//! Evaluation at a step boundary for outputs: walls, gradients and wall forces, once for all of them.

use sph::coupling::stage::{StageTime, StepStage};

use crate::boundary::wall_states::WallStates;
use crate::neighbours::lists::Lists;
use crate::system::model::FluidModel;
use crate::system::packed_particle::FluidSpace;
use crate::system::state::FluidState;
use crate::time::stage::Workspace;

/// The evaluation of the present boundary, made when an output asks for it.
#[derive(Debug)]
pub struct BoundaryEvaluation<S: FluidSpace>(Option<Kept<S>>);

#[derive(Debug)]
struct Kept<S: FluidSpace> {
    /// Time of the boundary \[s\].
    time: f64,
    place: Place<S>,
}

/// Where an evaluation is.
#[derive(Debug)]
enum Place<S: FluidSpace> {
    /// In the workspace of the run, whose lists hold for the state.
    Workspace,
    /// Apart from it, in the order of other lists.
    Apart(Box<(FluidState<S>, Workspace<S>)>),
    /// The state can not be evaluated, as after a divergence.
    Nowhere,
}

impl<S: FluidSpace> Default for BoundaryEvaluation<S> {
    fn default() -> Self {
        Self(None)
    }
}

impl<S: FluidSpace> BoundaryEvaluation<S> {
    /// State and workspace of the evaluation of `state` at `time` \[s\], made in the first call since
    /// [`BoundaryEvaluation::invalidate`]; `None` where the state can not be evaluated.
    pub fn evaluated<'a>(
        &'a mut self,
        model: &FluidModel<S>,
        state: &'a mut FluidState<S>,
        workspace: &'a mut Workspace<S>,
        time: f64,
    ) -> Option<(&'a FluidState<S>, &'a Workspace<S>)> {
        if self.0.as_ref().is_none_or(|kept| kept.time.to_bits() != time.to_bits()) {
            // Its memory is free before the next one takes some.
            self.0 = None;
            self.0 = Some(Kept { time, place: evaluate(model, state, workspace, time) });
        }
        match &self.0.as_ref()?.place {
            Place::Workspace => Some((state, workspace)),
            Place::Apart(apart) => Some((&apart.0, &apart.1)),
            Place::Nowhere => None,
        }
    }

    /// Walls of the last evaluation, or as the last stage in `workspace` left them, and the lists of the fluid they meet.
    pub fn walls<'a>(&'a self, workspace: &'a Workspace<S>) -> (&'a WallStates<S>, &'a Lists<S>) {
        let workspace = match &self.0 {
            Some(Kept { place: Place::Apart(apart), .. }) => &apart.1,
            _ => workspace,
        };
        (&workspace.walls, &workspace.lists)
    }

    /// To be called where the state changes: drops the evaluation.
    pub fn invalidate(&mut self) {
        self.0 = None;
    }
}

/// Evaluates `state` at a boundary of `time` \[s\] in `workspace`, or where its lists do not hold, with lists of its own,
/// for which those of `workspace` make room.
fn evaluate<S: FluidSpace>(
    model: &FluidModel<S>,
    state: &mut FluidState<S>,
    workspace: &mut Workspace<S>,
    time: f64,
) -> Place<S> {
    match workspace.evaluate_boundary(model, state, time) {
        Ok(true) => return Place::Workspace,
        Ok(false) => workspace.release(),
        Err(_) => return Place::Nowhere,
    }
    let (mut state, mut workspace) = (state.clone(), Workspace::default());
    let stage = StageTime { at: StepStage::FIRST, step_start: time, time_step: 0.0 };
    // The lists are made for this state.
    let evaluated = workspace
        .begin_stage(model, &mut state, &stage)
        .and_then(|()| workspace.evaluate_boundary(model, &mut state, time));
    if evaluated.is_ok_and(|holds| holds) {
        Place::Apart(Box::new((state, workspace)))
    } else {
        Place::Nowhere
    }
}
