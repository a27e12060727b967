//! One step and its half-steps: who sends and computes what, and when.

use std::time::{Duration, Instant};

use tracing::trace_span;

use super::messages::{Checkpoint, Event, FailureReport, StepReport};
use super::{Link, TRACE, save};
use crate::coupling::audit::Audit;
use crate::coupling::exchange::{Exchange, Extent, Frame, PreviousStage};
use crate::coupling::fixed_point::FixedPoint;
use crate::coupling::ledger::{InterfaceSums, MomentumReport, StageBudget, TorqueCheck};
use crate::coupling::role::CouplingRole;
use crate::coupling::solver::{Fault, NoLoads, Role, Solver};
use crate::coupling::stage::{Clock, Stage, StageTime, StepStage};
use crate::setup::RunPlan;

/// Digests of the frames of one half-step: the one sent, and the partner's that was computed from.
#[derive(Clone, Copy)]
pub(super) struct Digests {
    pub(super) sent: u32,
    pub(super) used: u32,
}

/// A run being stepped.
pub(super) struct Runner<'a, S: Solver + ?Sized> {
    pub(super) solver: &'a mut S,
    pub(super) exchange: Option<Box<dyn Exchange>>,
    pub(super) setup: &'a RunPlan,
    pub(super) role: CouplingRole,
    pub(super) partner_extent: Extent,
    /// Own extents that the partner may still refer to, newest last.
    pub(super) known_extents: [Extent; 2],
    pub(super) own: Frame,
    pub(super) partner: Frame,
    /// Where the next frame comes while `partner` still counts.
    pub(super) coming: Frame,
    /// Fixed point of a solid with implicit coupling.
    pub(super) fixed_point: Option<FixedPoint>,
    /// Updates of the coupling points in the corrector so far, and whether they ended before convergence.
    pub(super) iterations: u32,
    pub(super) unconverged: bool,
    /// Sums and digests of the half-step before, for the check against the partner's report.
    pub(super) before: Option<Before>,
    pub(super) waited: Duration,
    pub(super) breaches: u64,
    pub(super) torque: TorqueCheck,
    /// Compares the partner's frames with its set-up and its reports.
    pub(super) audit: Option<Audit>,
    /// A breach asked to stop at the next boundary.
    pub(super) stop_wanted: bool,
}

/// What the half-step before left to check.
pub(super) struct Before {
    pub(super) at: StepStage,
    pub(super) sums: InterfaceSums,
    pub(super) digests: Digests,
    /// Own momentum, for a partner that audits it.
    pub(super) momentum: Option<MomentumReport>,
}

impl<'a, S: Solver + ?Sized> Runner<'a, S> {
    pub(super) fn new(
        solver: &'a mut S,
        setup: &'a RunPlan,
        link: &Link,
        exchange: Option<Box<dyn Exchange>>,
        clock: &Clock,
    ) -> Self {
        let empty = || Frame::empty(clock.stage(Stage::Predictor));
        let mut own = empty();
        own.extent.clone_from(solver.extent());
        let role = CouplingRole::of(solver.role(), exchange.is_some(), setup);
        own.content = role.content();
        Self {
            role,
            known_extents: [own.extent.clone(), own.extent.clone()],
            solver,
            exchange,
            partner_extent: link.partner_extent.clone(),
            own,
            partner: empty(),
            coming: empty(),
            fixed_point: role.fixed_point(setup),
            iterations: 0,
            unconverged: false,
            before: None,
            waited: Duration::ZERO,
            breaches: 0,
            torque: TorqueCheck::of(setup),
            audit: audit_of(setup, link),
            stop_wanted: false,
            setup,
        }
    }

    pub(super) fn failed(&mut self, fault: Fault, clock: &Clock) -> Event {
        Event::Failed(FailureReport {
            fault,
            step: clock.step(),
            time: clock.time(),
            counts: self.solver.counts(),
            state: self.solver.snapshot(clock.step(), clock.time()),
        })
    }

    pub(super) fn checkpoint(&self, clock: &Clock) -> Checkpoint {
        let _span = trace_span!(target: TRACE, "checkpoint", step = clock.step()).entered();
        save(&*self.solver, &clock.state())
    }

    /// One step: predictor and corrector.
    pub(super) fn step(&mut self, clock: &mut Clock) -> Result<StepReport, Fault> {
        let _span = trace_span!(target: TRACE, "step", step = clock.step()).entered();
        let started = Instant::now();
        let waited_before = self.waited;
        let breaches_before = self.breaches;
        let time_step = clock.time_step();
        let mut report = StepReport { step: clock.step(), time_step, ..StepReport::default() };
        let mut limit = f64::INFINITY;
        (self.iterations, self.unconverged) = (0, false);
        for (k, stage) in Stage::BOTH.into_iter().enumerate() {
            let time = clock.stage(stage);
            (report.budgets[k], limit) = self.half_step(&time)?;
        }
        trace_span!(target: TRACE, "end of step")
            .in_scope(|| self.solver.end_step(&clock.stage(Stage::Corrector)))
            .map_err(Fault::Diverged)?;
        clock.advance(limit);
        report.end_time = clock.time();
        report.energies = self.solver.energies();
        report.interface_particles = [self.own.states.len() as u64, self.partner.states.len() as u64];
        report.elapsed = started.elapsed().as_secs_f64();
        report.waited = (self.waited - waited_before).as_secs_f64();
        report.breaches = self.breaches - breaches_before;
        (report.iterations, report.unconverged) = (self.iterations, self.unconverged);
        Ok(report)
    }

    /// One half-step; returns its momentum budget and the smaller of both sides' limits for the next step \[s\].
    fn half_step(&mut self, time: &StageTime) -> Result<(StageBudget, f64), Fault> {
        let _span = trace_span!(target: TRACE, "stage", at = %time.at).entered();
        trace_span!(target: TRACE, "begin stage")
            .in_scope(|| self.solver.begin_stage(time))
            .map_err(Fault::Diverged)?;
        let own_limit = self.solver.time_step_limit();
        self.check_step(time, own_limit)?;
        let digests = self.evaluate(time, own_limit)?;
        let budget = trace_span!(target: TRACE, "advance")
            .in_scope(|| self.solver.advance(time))
            .map_err(Fault::Diverged)?;
        let momentum = (self.solver.role() == Role::Solid).then(|| MomentumReport::from(&budget));
        self.before =
            digests.map(|digests| Before { at: time.at, sums: budget.interface, digests, momentum });
        let limit = if digests.is_some() { own_limit.min(self.partner.time_step_limit) } else { own_limit };
        Ok((budget, limit))
    }

    /// Exchange and rates of one half-step: the one place where the kinds of coupling differ.
    ///
    /// With force coupling the partner's work depends on this side's, so that the fluid answers before its own sums.
    fn evaluate(&mut self, time: &StageTime, limit: f64) -> Result<Option<Digests>, Fault> {
        let at = time.at;
        let digests = match self.role {
            CouplingRole::Alone => {
                self.evaluate_own(time);
                self.evaluate_cross(time);
                return Ok(None);
            }
            CouplingRole::States => {
                self.prepare(time, limit, 0)?;
                let sent = self.send(at)?;
                self.evaluate_own(time);
                let used = self.receive(time, 0)?;
                self.evaluate_cross(time);
                Digests { sent, used }
            }
            CouplingRole::GivesLoads => {
                let used = self.receive(time, 0)?;
                let sent = self.answer(time, limit, 0)?;
                self.evaluate_own(time);
                let digests = self.answer_updates(time, limit, Digests { sent, used })?;
                self.evaluate_cross(time);
                digests
            }
            CouplingRole::TakesLoads => {
                let digests = match self.iterated(at) {
                    Some(plan) => self.converge(time, limit, &plan)?,
                    None => self.load_once(time, limit)?,
                };
                trace_span!(target: TRACE, "cross sums")
                    .in_scope(|| self.solver.evaluate_loads(time, &self.own.states, &self.partner.forces))
                    .map_err(|error| not_offered(at, error))?;
                digests
            }
        };
        Ok(Some(digests))
    }

    /// Sends the coupling points and receives the force on each, once.
    fn load_once(&mut self, time: &StageTime, limit: f64) -> Result<Digests, Fault> {
        let at = time.at;
        self.prepare(time, limit, 0)?;
        let sent = self.send(at)?;
        self.evaluate_own(time);
        let used = self.receive(time, 0)?;
        self.check_forces(at)?;
        if let Some(fixed_point) = &mut self.fixed_point {
            // The predictor: its forces are the first guess of the corrector's.
            fixed_point.begin(&self.own.states, &self.partner.forces);
        }
        Ok(Digests { sent, used })
    }

    /// Sends the force on each of the partner's coupling points; returns the digest of that frame.
    pub(super) fn answer(&mut self, time: &StageTime, limit: f64, iteration: u32) -> Result<u32, Fault> {
        self.prepare(time, limit, iteration)?;
        let (own, points) = (&mut self.own, &self.partner.states);
        trace_span!(target: TRACE, "reactions")
            .in_scope(|| self.solver.reactions(time, &own.states, points, &mut own.forces))
            .map_err(|error| not_offered(time.at, error))?;
        own.set_version = self.partner.set_version;
        self.send(time.at)
    }

    pub(super) fn evaluate_own(&mut self, time: &StageTime) {
        let _span = trace_span!(target: TRACE, "own sums").entered();
        self.solver.evaluate_own(time);
    }

    fn evaluate_cross(&mut self, time: &StageTime) {
        let _span = trace_span!(target: TRACE, "cross sums").entered();
        self.solver.evaluate_cross(time, &self.own.states, &self.partner.states);
    }

    /// Fills the own frame.
    pub(super) fn prepare(&mut self, time: &StageTime, limit: f64, iteration: u32) -> Result<(), Fault> {
        let _span = trace_span!(target: TRACE, "interface").entered();
        let Some(coupling) = &self.setup.coupling else {
            return Err(Fault::Peer { at: time.at, message: "the set-up has no coupling".into() });
        };
        let reach = 2.0 * coupling.fluid.smoothing_length() + coupling.margin;
        let own = &mut self.own;
        own.time = *time;
        own.iteration = iteration;
        own.set_version = self.solver.interface(&self.partner_extent, reach, &mut own.states);
        own.partner_extent_version = self.partner_extent.version;
        own.reach = reach;
        own.time_step_limit = limit;
        let extent = self.solver.extent();
        if extent.version != own.extent.version {
            own.extent.clone_from(extent);
            self.known_extents.rotate_left(1);
            self.known_extents[1].clone_from(extent);
        }
        own.previous = self.before.as_ref().map(|b| PreviousStage {
            at: b.at,
            sums: b.sums,
            used_digest: b.digests.used,
            momentum: b.momentum,
        });
        Ok(())
    }

    /// Sends the own frame and returns its digest.
    pub(super) fn send(&mut self, at: StepStage) -> Result<u32, Fault> {
        let _span = trace_span!(target: TRACE, "send").entered();
        let digest = self.own.digest();
        if let Some(exchange) = self.exchange.as_mut() {
            exchange.send(&self.own).map_err(|e| Fault::of_peer(at, e))?;
        }
        Ok(digest)
    }

    /// Takes the partner's frame of `iteration` and returns its digest.
    pub(super) fn receive(&mut self, time: &StageTime, iteration: u32) -> Result<u32, Fault> {
        self.next_frame(time)?;
        self.take_frame(time.at, iteration)
    }

    /// Waits for the partner's next frame.
    pub(super) fn next_frame(&mut self, time: &StageTime) -> Result<(), Fault> {
        let at = time.at;
        if let Some(exchange) = self.exchange.as_mut() {
            let _span = trace_span!(target: TRACE, "wait for partner").entered();
            let started = Instant::now();
            exchange.receive(at, &mut self.partner).map_err(|e| Fault::of_peer(at, e))?;
            self.waited += started.elapsed();
        }
        self.check_clock(time)
    }

    /// Checks the frame that came and takes over its extent; returns its digest.
    pub(super) fn take_frame(&mut self, at: StepStage, iteration: u32) -> Result<u32, Fault> {
        self.check_iteration(at, iteration)?;
        if iteration == 0 {
            self.check_before(at)?;
            self.check_audit()?;
        } else if let Some(audit) = &mut self.audit {
            audit.update(&self.partner.states);
        }
        self.check_cover(at)?;
        if self.partner.extent.version != self.partner_extent.version {
            self.partner_extent.clone_from(&self.partner.extent);
        }
        Ok(self.partner.digest())
    }
}

/// The audit of the partner that `link` describes, if it does.
fn audit_of(setup: &RunPlan, link: &Link) -> Option<Audit> {
    let (particles, coupling) = (link.partner_particles.clone()?, setup.coupling.as_ref()?);
    let scales = [coupling.solid_spacing, setup.ledger.momentum_tolerance];
    Some(Audit::new(particles, &setup.domain, coupling.kind, scales, link.resume.is_none()))
}

fn not_offered(at: StepStage, error: NoLoads) -> Fault {
    Fault::Peer { at, message: error.to_string() }
}
