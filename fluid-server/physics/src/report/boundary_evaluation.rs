//! What outputs at a step boundary show beyond the state: walls, gradients and wall forces, evaluated once for all of them.

use std::cell::RefCell;
use std::sync::Arc;

use sph::stage::{StageTime, StepStage};

use crate::system::model::FluidModel;
use crate::system::state::FluidState;
use crate::time::stage::Workspace;

/// State and workspace of an evaluation at a step boundary, apart from the run.
#[derive(Debug)]
pub struct Evaluated {
    /// Time of the boundary \[s\].
    time: f64,
    /// Nothing when the state can not be evaluated, as after a divergence.
    pub found: Option<(FluidState, Workspace)>,
}

impl Evaluated {
    /// Evaluates `state` at a boundary of `time` \[s\].
    ///
    /// The partner's particles are left out: they reach walls only through L_i.
    fn new(model: &FluidModel, state: &FluidState, time: f64) -> Self {
        let (mut state, mut workspace) = (state.clone(), Workspace::default());
        // The number of the step stands in a divergence only.
        let stage = StageTime { at: StepStage::FIRST, step_start: time, time_step: 0.0 };
        let begun = workspace.begin_stage(model, &mut state, &stage);
        let found = begun.ok().map(|()| {
            workspace.evaluate_outputs(model, time);
            (state, workspace)
        });
        Self { time, found }
    }
}

/// The evaluation of the present boundary, once an output has asked for it.
#[derive(Debug, Default)]
pub struct Boundary(RefCell<Option<Arc<Evaluated>>>);

impl Boundary {
    /// The evaluation of `state` at `time` \[s\], made at the first call since [`Boundary::leave`].
    pub fn evaluated(&self, model: &FluidModel, state: &FluidState, time: f64) -> Arc<Evaluated> {
        let mut kept = self.0.borrow_mut();
        match &*kept {
            Some(evaluated) if evaluated.time.to_bits() == time.to_bits() => evaluated.clone(),
            _ => kept.insert(Arc::new(Evaluated::new(model, state, time))).clone(),
        }
    }

    /// The state changes: what was evaluated is void.
    pub fn leave(&mut self) {
        *self.0.get_mut() = None;
    }
}
