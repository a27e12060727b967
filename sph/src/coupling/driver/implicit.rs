//! The iterated half-step: a corrector whose samples are revised until they fit the forces that they feel.

use tracing::trace_span;

use super::TRACE;
use super::half_step::{Digests, Runner};
use crate::coupling::exchange::{Acceptance, Frame};
use crate::coupling::solver::{Divergence, Fault, NotRevised, Solver};
use crate::coupling::stage::{Stage, StageTime, StepStage};
use crate::setup::{CouplingKind, Iterate, Relaxation, Unsettled};

impl<S: Solver + ?Sized> Runner<'_, S> {
    /// How the half-step `at` is iterated, if it is.
    ///
    /// Only the corrector is: the state at n, where the predictor evaluates, is given.
    pub(super) fn iterated(&self, at: StepStage) -> Option<Iterate> {
        let coupling = self.setup.coupling.filter(|coupling| coupling.kind == CouplingKind::Loads)?;
        coupling.iterate.filter(|_| at.stage == Stage::Corrector)
    }

    /// The solid's side: sends samples and revises them by the forces that come until both fit, then says so.
    pub(super) fn settle(&mut self, time: &StageTime, limit: f64, plan: &Iterate) -> Result<Digests, Fault> {
        let at = time.at;
        loop {
            self.prepare(time, limit, self.iterations)?;
            let sent = self.send(at)?;
            let used = self.receive(time, self.iterations)?;
            self.check_forces(at)?;
            let (samples, forces) = (&self.own.states, &self.partner.forces);
            // There is one wherever a solid takes loads by a plan.
            let Some(fixed_point) = &mut self.fixed_point else { return Ok(Digests { sent, used }) };
            let residual = fixed_point.compare(samples, forces);
            let settled = fixed_point.settled(residual);
            if !settled && self.iterations < plan.limit {
                let relaxed = fixed_point.relaxed(samples);
                trace_span!(target: TRACE, "revise")
                    .in_scope(|| self.solver.revise(time, samples, relaxed))
                    .map_err(|error| not_revised(at, error))?;
                self.iterations += 1;
                continue;
            }
            if !settled && plan.unsettled == Unsettled::Stop {
                return Err(Fault::Diverged(unsettled(at, residual, plan)));
            }
            self.unsettled = !settled;
            self.accept(time, Acceptance { settled, residual })?;
            return Ok(Digests { sent, used });
        }
    }

    fn accept(&mut self, time: &StageTime, acceptance: Acceptance) -> Result<(), Fault> {
        let word = Frame { iteration: self.iterations, acceptance: Some(acceptance), ..Frame::empty(*time) };
        match self.exchange.as_mut() {
            Some(exchange) => exchange.send(&word).map_err(|e| Fault::of_peer(time.at, e)),
            None => Ok(()),
        }
    }

    /// The fluid's side, after its first answer: answers each revision until the solid accepts one. Returns the digests of
    /// that one; those of the `first` in a half-step that is not iterated.
    pub(super) fn answer_revisions(
        &mut self,
        time: &StageTime,
        limit: f64,
        first: Digests,
    ) -> Result<Digests, Fault> {
        let (at, mut digests) = (time.at, first);
        let Some(plan) = self.iterated(at) else { return Ok(digests) };
        loop {
            std::mem::swap(&mut self.partner, &mut self.coming);
            self.next_frame(time)?;
            if let (Some(acceptance), true) =
                (self.partner.acceptance, self.partner.iteration == self.iterations)
            {
                self.unsettled = !acceptance.settled;
                std::mem::swap(&mut self.partner, &mut self.coming);
                return Ok(digests);
            }
            if self.iterations == plan.limit {
                let message = format!(
                    "expected the acceptance of iteration {} of {at}, the last that `limit` allows, got iteration {}",
                    plan.limit, self.partner.iteration
                );
                return Err(Fault::Peer { at, message });
            }
            self.iterations += 1;
            let used = self.take_frame(at, self.iterations)?;
            let sent = self.answer(time, limit, self.iterations)?;
            digests = Digests { sent, used };
        }
    }
}

fn not_revised(at: StepStage, error: NotRevised) -> Fault {
    match error {
        NotRevised::NotOffered => {
            let message =
                "this solver does not iterate half-steps; leave out `interface.iterate` of the case";
            Fault::Peer { at, message: message.into() }
        }
        NotRevised::Diverged(divergence) => Fault::Diverged(divergence),
    }
}

fn unsettled(at: StepStage, residual: f64, plan: &Iterate) -> Divergence {
    let advice = match plan.relaxation {
        Relaxation::Fixed(_) => "a smaller relaxation or \"aitken\", ",
        Relaxation::Aitken => "",
    };
    Divergence {
        at,
        particle: None,
        position: None,
        quantity: format!("residual of the forces after {} iterations of the half-step [-]", plan.limit),
        value: residual,
        allowed: format!("at most {:e}, the tolerance of `interface.iterate`", plan.tolerance),
        hint: format!(
            "use {advice}a smaller time step, a higher limit or tolerance, or `unsettled = \"accept\"` to continue and count such half-steps"
        ),
    }
}
