//! Implicit coupling: a corrector whose coupling points are updated until they agree with the forces on them.

use tracing::trace_span;

use super::TRACE;
use super::half_step::{Digests, Runner};
use crate::coupling::exchange::{Acceptance, Frame};
use crate::coupling::solver::{Divergence, Fault, NotUpdated, Solver};
use crate::coupling::stage::{Stage, StageTime, StepStage};
use crate::setup::{CouplingKind, ImplicitCoupling, NonConvergence, Relaxation};

impl<S: Solver + ?Sized> Runner<'_, S> {
    /// How the half-step `at` is iterated; `None` with explicit coupling.
    ///
    /// Only the corrector is: the state at n, where the predictor evaluates, is given.
    pub(super) fn iterated(&self, at: StepStage) -> Option<ImplicitCoupling> {
        let coupling = self.setup.coupling.filter(|coupling| coupling.kind == CouplingKind::Loads)?;
        coupling.implicit.filter(|_| at.stage == Stage::Corrector)
    }

    /// The solid's side: sends coupling points and updates them by the returned forces until both agree, then accepts.
    pub(super) fn converge(
        &mut self,
        time: &StageTime,
        limit: f64,
        plan: &ImplicitCoupling,
    ) -> Result<Digests, Fault> {
        let at = time.at;
        loop {
            self.prepare(time, limit, self.iterations)?;
            let sent = self.send(at)?;
            let used = self.receive(time, self.iterations)?;
            self.check_forces(at)?;
            let (points, forces) = (&self.own.states, &self.partner.forces);
            // Present wherever a solid with force coupling has a plan.
            let Some(fixed_point) = &mut self.fixed_point else { return Ok(Digests { sent, used }) };
            let residual = fixed_point.compare(points, forces);
            let converged = fixed_point.converged(residual);
            if !converged && self.iterations < plan.limit {
                let relaxed = fixed_point.relaxed(points);
                trace_span!(target: TRACE, "update stage")
                    .in_scope(|| self.solver.update_stage(time, points, relaxed))
                    .map_err(|error| not_updated(at, error))?;
                self.iterations += 1;
                continue;
            }
            if !converged && plan.non_convergence == NonConvergence::Stop {
                return Err(Fault::Diverged(not_converged(at, residual, plan)));
            }
            self.unconverged = !converged;
            self.accept(time, Acceptance { converged, residual })?;
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

    /// The fluid's side, after its first answer: answers each update until the solid accepts one. Returns the digests of
    /// that one; with explicit coupling those of the `first`.
    pub(super) fn answer_updates(
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
                self.unconverged = !acceptance.converged;
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

fn not_updated(at: StepStage, error: NotUpdated) -> Fault {
    match error {
        NotUpdated::NotOffered => {
            let message =
                "this solver does not offer implicit coupling; leave out `interface.iterate` of the case";
            Fault::Peer { at, message: message.into() }
        }
        NotUpdated::Diverged(divergence) => Fault::Diverged(divergence),
    }
}

fn not_converged(at: StepStage, residual: f64, plan: &ImplicitCoupling) -> Divergence {
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
