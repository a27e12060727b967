//! What is checked in every half-step: step size, the partner's frame, the balance of the half-step before.

use super::half_step::Runner;
use crate::coupling::exchange::Frame;
use crate::coupling::ledger::{balance_breaches, imbalance};
use crate::coupling::solver::{Divergence, Fault, Solver};
use crate::coupling::stage::{StageTime, StepStage};
use crate::setup::{BreachAction, StepPolicy};

crate::constants! {
    /// Three times what a case may begin with at its own risk.
    pub(crate) const LARGEST_STEP_OVER_LIMIT: f64 = 30.0, "time_step.largest_over_limit",
        "fixed step over the reported limit that ends a run [-]";
}

impl<S: Solver + ?Sized> Runner<'_, S> {
    /// Whether a fixed step is still one, by the own `limit` \[s\]; an adaptive one follows its limit by itself.
    pub(super) fn check_step(&self, time: &StageTime, limit: f64) -> Result<(), Fault> {
        let StepPolicy::Fixed { .. } = self.setup.time.step else { return Ok(()) };
        if time.time_step <= LARGEST_STEP_OVER_LIMIT * limit {
            return Ok(());
        }
        let offending = self.solver.limiting_particle();
        Err(Fault::Diverged(Divergence {
            at: time.at,
            particle: offending.as_ref().map(|(id, _)| *id),
            position: offending.map(|(_, position)| position),
            quantity: "time step over its stability limit [-]".into(),
            value: time.time_step / limit,
            allowed: format!("at most {LARGEST_STEP_OVER_LIMIT}; the limit has become {limit:.3e} s"),
            hint: "speeds, accelerations or contacts have grown far beyond those of the start: use a smaller step, or an \
                   adaptive one"
                .into(),
        }))
    }

    /// Whether the partner's forces belong to the coupling points that were sent.
    pub(super) fn check_forces(&self, at: StepStage) -> Result<(), Fault> {
        let (own, partner) = (&self.own, &self.partner);
        if (partner.set_version, partner.forces.len()) == (own.set_version, own.states.len()) {
            return Ok(());
        }
        let message = format!(
            "the frame of {at} has {} forces for set {}, {} coupling points of set {} were sent",
            partner.forces.len(),
            partner.set_version,
            own.states.len(),
            own.set_version
        );
        Err(Fault::Peer { at, message })
    }

    /// Whether the partner's frame is that of the half-step of `time`, by the same clock.
    pub(super) fn check_clock(&self, time: &StageTime) -> Result<(), Fault> {
        let (at, partner) = (time.at, &self.partner);
        if partner.time.at != at {
            let message = format!("expected a frame of {at}, got one of {}", partner.time.at);
            return Err(Fault::Peer { at, message });
        }
        for (name, ours, theirs) in [
            ("start of step [s]", time.step_start, partner.time.step_start),
            ("time step [s]", time.time_step, partner.time.time_step),
        ] {
            if ours.to_bits() != theirs.to_bits() {
                let difference = format!("{name} is {ours:?} here and {theirs:?} at the partner");
                return Err(Fault::Clock { at, difference });
            }
        }
        Ok(())
    }

    /// Whether the partner's frame is of the `iteration` that is due in the half-step `at`.
    pub(super) fn check_iteration(&self, at: StepStage, iteration: u32) -> Result<(), Fault> {
        let partner = &self.partner;
        let word = if partner.acceptance.is_some() { "the acceptance of " } else { "" };
        if partner.iteration == iteration && partner.acceptance.is_none() {
            return Ok(());
        }
        let message =
            format!("expected iteration {iteration} of {at}, got {word}iteration {}", partner.iteration);
        Err(Fault::Peer { at, message })
    }

    /// Whether the partner sent all that own particles can interact with; it chose by the extent of an earlier frame.
    pub(super) fn check_cover(&self, at: StepStage) -> Result<(), Fault> {
        let known = self.partner.partner_extent_version;
        let Some(extent) = self.known_extents.iter().find(|extent| extent.version == known) else {
            let message = format!("the frame of {at} refers to extent {known}, which was not sent lately");
            return Err(Fault::Peer { at, message });
        };
        self.solver
            .covered_by(extent, self.partner.reach)
            .map_err(|shortfall| Fault::Coverage { at, shortfall })
    }

    /// Compares the partner's report of the half-step before with the own sums.
    pub(super) fn check_before(&mut self, at: StepStage) -> Result<(), Fault> {
        let (Some(ours), theirs) = (&self.before, self.partner.previous.as_ref()) else {
            return Ok(());
        };
        let Some(theirs) = theirs.filter(|t| t.at == ours.at) else {
            let message = format!("the frame of {at} lacks the sums of {}", ours.at);
            return Err(Fault::Peer { at, message });
        };
        let mut faults = Vec::new();
        if theirs.used_digest != ours.digests.sent {
            faults.push(Fault::StaleFrame { at: ours.at, sent: ours.digests.sent, used: theirs.used_digest });
        }
        let imbalance = imbalance(&ours.sums, &theirs.sums, self.torque);
        faults
            .extend(balance_breaches(ours.at, &imbalance, &self.setup.ledger).into_iter().map(Fault::Ledger));
        self.follow_policy(faults)
    }

    /// Whether the partner's frames agree with its set-up and its reports.
    pub(super) fn check_audit(&mut self) -> Result<(), Fault> {
        let Some(audit) = &mut self.audit else { return Ok(()) };
        let Frame { time, states, previous, .. } = &self.partner;
        let report = previous.as_ref().and_then(|previous| previous.momentum.as_ref());
        let found = audit.observe(time, states, report);
        let fault = found.err().map(|message| Fault::Contradiction {
            at: time.at,
            message: format!("the {} contradicts itself: {message}", self.solver.role().partner()),
        });
        self.follow_policy(fault.into_iter().collect())
    }

    /// Counts `faults` of the audit and ends the run by the first of them where the case says so.
    fn follow_policy(&mut self, faults: Vec<Fault>) -> Result<(), Fault> {
        self.breaches += faults.len() as u64;
        match (self.setup.ledger.action, faults.into_iter().next()) {
            (BreachAction::Stop, Some(fault)) => Err(fault),
            // These are known to one side alone: both cannot stop at one boundary.
            (
                BreachAction::StopAndCheckpoint,
                Some(fault @ (Fault::StaleFrame { .. } | Fault::Contradiction { .. })),
            ) => Err(fault),
            (BreachAction::StopAndCheckpoint, Some(_)) => {
                self.stop_wanted = true;
                Ok(())
            }
            _ => Ok(()),
        }
    }
}
