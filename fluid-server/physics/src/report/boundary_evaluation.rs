//! Evaluation at a step boundary for outputs: walls, gradients and wall forces, once for all of them.

use std::cell::RefCell;
use std::sync::Arc;

use sph::coupling::stage::{StageTime, StepStage};

use crate::system::model::FluidModel;
use crate::system::packed_particle::FluidSpace;
use crate::system::state::FluidState;
use crate::time::stage::Workspace;

/// State and workspace of an evaluation at a step boundary, separate from those of the run.
#[derive(Debug)]
pub struct EvaluatedState<S: FluidSpace> {
    /// Time of the boundary \[s\].
    time: f64,
    /// `None` where the state can not be evaluated, as after a divergence.
    pub evaluated: Option<(FluidState<S>, Workspace<S>)>,
}

impl<S: FluidSpace> EvaluatedState<S> {
    /// Evaluates `state` at a boundary of `time` \[s\].
    ///
    /// The partner's particles are left out: they reach walls only through L_i.
    fn new(model: &FluidModel<S>, state: &FluidState<S>, time: f64) -> Self {
        let (mut state, mut workspace) = (state.clone(), Workspace::default());
        // The number of the step appears in a divergence only.
        let stage = StageTime { at: StepStage::FIRST, step_start: time, time_step: 0.0 };
        let begun = workspace.begin_stage(model, &mut state, &stage);
        let evaluated = begun.ok().map(|()| {
            workspace.evaluate_outputs(model, time);
            (state, workspace)
        });
        Self { time, evaluated }
    }
}

/// The evaluation of the present boundary, made when an output asks for it.
#[derive(Debug, Default)]
pub struct BoundaryEvaluation<S: FluidSpace>(RefCell<Option<Arc<EvaluatedState<S>>>>);

impl<S: FluidSpace> BoundaryEvaluation<S> {
    /// The evaluation of `state` at `time` \[s\], computed in the first call since [`BoundaryEvaluation::invalidate`].
    pub fn evaluated(
        &self,
        model: &FluidModel<S>,
        state: &FluidState<S>,
        time: f64,
    ) -> Arc<EvaluatedState<S>> {
        let mut kept = self.0.borrow_mut();
        match &*kept {
            Some(evaluated) if evaluated.time.to_bits() == time.to_bits() => evaluated.clone(),
            _ => kept.insert(Arc::new(EvaluatedState::new(model, state, time))).clone(),
        }
    }

    /// To be called where the state changes: drops the evaluation.
    pub fn invalidate(&mut self) {
        *self.0.get_mut() = None;
    }
}
