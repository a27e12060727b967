//! The half-step driver: the same loop steps a solver inside a server and inside one process.

use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use tracing::trace_span;

use crate::exchange::{Exchange, Extent, Frame, FrameContent, InterfaceStates, PeerError, PreviousStage};
use crate::ledger::{Energies, InterfaceSums, StageBooks, TorqueCheck, balance_breaches, imbalance};
use crate::meeting::Meeting;
use crate::saved::{RestoreError, SavedState};
use crate::setup::{BreachAction, RunSetup, StepPolicy};
use crate::solver::{Counts, Divergence, Fault, NoLoads, ParticleFields, Solver};
use crate::stage::{Clock, ClockState, Stage, StageTime, StepStage};

/// A fixed step beyond this multiple of its limit ends a run: three times what a case may begin with at its own risk.
const LARGEST_STEP_OVER_LIMIT: f64 = 30.0;

/// Target of the spans that tell where the time of a run goes; they cost nothing unless somebody records them.
pub const TRACE: &str = "tidelock::trace";

/// What the coordinator tells a participant during a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Step until this many steps are completed; never lowers an earlier grant.
    GrantThrough(u64),
    /// Finish at the end of the granted steps, with outputs complete.
    Stop,
    /// Give up at once.
    Abort,
    /// Save the state at the boundary where the participant waits; changes nothing.
    Checkpoint,
    /// At the end time wait for [`Command::Stop`], so that a checkpoint can be taken there.
    Hold,
}

/// What a participant tells the coordinator during a run.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// A step is complete.
    Step(StepReport),
    /// Probe values at a step boundary.
    Probes(ProbeValues),
    /// Particle fields at a step boundary.
    Snapshot(ParticleFields),
    /// The answer to [`Command::Checkpoint`].
    Checkpoint(Box<Checkpoint>),
    /// No further step is taken until the participant is told to stop: at the end time after [`Command::Hold`], or
    /// after a breach under [`BreachAction::StopAndCheckpoint`].
    Held(Held),
    /// The run ended in order; the last event.
    Finished(FinalReport),
    /// The run ended out of order; the last event.
    Failed(FailureReport),
}

/// Where a participant waits to be told to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Held {
    /// Completed steps.
    pub step: u64,
    /// Time \[s\].
    pub time: f64,
}

/// The complete state of one side at a step boundary, before the outputs that are due there.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint {
    /// Completed steps.
    pub step: u64,
    /// Time \[s\].
    pub time: f64,
    /// Size of the next step \[s\].
    pub time_step: f64,
    /// Clock and solver.
    pub state: SavedState,
}

/// Probe values at a step boundary, in the order of the set-up.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ProbeValues {
    /// Completed steps.
    pub step: u64,
    /// Time \[s\].
    pub time: f64,
    /// Values.
    pub values: Vec<f64>,
}

/// One completed step of one side.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StepReport {
    /// Completed steps before this one.
    pub step: u64,
    /// Time at its end \[s\].
    pub end_time: f64,
    /// Its size \[s\].
    pub time_step: f64,
    /// Books of predictor and corrector.
    pub books: [StageBooks; 2],
    /// Energies at its end.
    pub energies: Energies,
    /// Own and partner particles in the last frames.
    pub interface_particles: [u64; 2],
    /// Wall time of the step \[s\].
    pub elapsed: f64,
    /// Part of it spent waiting for the partner \[s\].
    pub waited: f64,
    /// Breaches that the policy lets pass.
    pub breaches: u64,
}

/// How a run ended in order.
#[derive(Clone, Debug, PartialEq)]
pub struct FinalReport {
    /// Completed steps.
    pub step: u64,
    /// Time \[s\].
    pub time: f64,
    /// Whether the end time was reached; otherwise the run was stopped from outside.
    pub reached_end: bool,
    /// Facts of the run.
    pub counts: Counts,
    /// All particles with full precision.
    pub state: ParticleFields,
}

/// How a run ended out of order.
#[derive(Clone, Debug, PartialEq)]
pub struct FailureReport {
    /// Why.
    pub fault: Fault,
    /// Completed steps.
    pub step: u64,
    /// Time \[s\].
    pub time: f64,
    /// Facts of the run.
    pub counts: Counts,
    /// All particles as they were when it happened.
    pub state: ParticleFields,
}

/// What both sides know before the first frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// The partner's extent at the start.
    pub partner_extent: Extent,
    /// Smaller of both sides' limits for the first step \[s\].
    pub first_limit: f64,
    /// Where a restored run goes on, see [`restore`].
    pub resume: Option<ClockState>,
}

/// Digests of the frames of one half-step: the one sent, and the partner's that was computed from.
#[derive(Clone, Copy)]
struct Digests {
    sent: u32,
    used: u32,
}

/// A run being stepped.
struct Runner<'a, S: Solver + ?Sized> {
    solver: &'a mut S,
    exchange: Option<Box<dyn Exchange>>,
    setup: &'a RunSetup,
    meeting: Meeting,
    partner_extent: Extent,
    /// Own extents that the partner may still refer to, newest last.
    known_extents: [Extent; 2],
    own: Frame,
    partner: Frame,
    /// Sums and digests of the half-step before, for the check against the partner's report.
    before: Option<Before>,
    waited: Duration,
    breaches: u64,
    torque: TorqueCheck,
    /// A breach asked to stop at the next boundary.
    stop_wanted: bool,
}

/// What the half-step before left to check.
struct Before {
    at: StepStage,
    sums: InterfaceSums,
    digests: Digests,
}

/// Runs `solver` to its end under `commands`, reporting through `report`.
///
/// Without an exchange the solver has no partner. Every event is reported in order, `Finished` or `Failed` last.
pub fn run<S: Solver + ?Sized>(
    solver: &mut S,
    setup: &RunSetup,
    link: &Link,
    exchange: Option<Box<dyn Exchange>>,
    commands: &Receiver<Command>,
    report: &mut dyn FnMut(Event),
) {
    let mut clock = match &link.resume {
        Some(state) => Clock::resumed(setup.time, setup.outputs, state),
        None => Clock::new(setup.time, setup.outputs, link.first_limit),
    };
    let mut runner = Runner::new(solver, setup, link, exchange, &clock);
    let mut granted = 0;
    let mut stopping = false;
    let (mut holds_at_end, mut held) = (false, false);
    loop {
        let due = clock.outputs_due();
        if due.probes {
            let _span = trace_span!(target: TRACE, "probes").entered();
            let mut values = Vec::new();
            runner.solver.probes(clock.time(), &mut values);
            report(Event::Probes(ProbeValues { step: clock.step(), time: clock.time(), values }));
        }
        if due.snapshot {
            let _span = trace_span!(target: TRACE, "snapshot").entered();
            report(Event::Snapshot(runner.solver.snapshot(clock.step(), clock.time())));
        }
        loop {
            if (runner.stop_wanted || clock.finished() && holds_at_end) && !held {
                held = true;
                report(Event::Held(Held { step: clock.step(), time: clock.time() }));
            }
            let waits = held || clock.finished() || clock.step() >= granted;
            if waits && stopping || clock.finished() && !holds_at_end {
                break;
            }
            let command = if waits {
                let _span = trace_span!(target: TRACE, "wait for grant").entered();
                commands.recv().ok()
            } else {
                commands.try_recv().ok()
            };
            match command {
                Some(Command::GrantThrough(step)) => granted = granted.max(step),
                Some(Command::Stop) => stopping = true,
                Some(Command::Hold) => holds_at_end = true,
                Some(Command::Checkpoint) => report(Event::Checkpoint(Box::new(runner.checkpoint(&clock)))),
                Some(Command::Abort) => {
                    let at = clock.stage(Stage::Predictor).at;
                    report(runner.failed(Fault::Aborted { at }, &clock));
                    return;
                }
                None if !waits => break,
                // The coordinator's end of the channel is gone.
                None => {
                    let at = clock.stage(Stage::Predictor).at;
                    report(runner.failed(Fault::Aborted { at }, &clock));
                    return;
                }
            }
        }
        if held || clock.finished() || clock.step() >= granted {
            break;
        }
        match runner.step(&mut clock) {
            Ok(step) => report(Event::Step(step)),
            Err(fault) => {
                report(runner.failed(fault, &clock));
                return;
            }
        }
    }
    // A stop from outside ends between outputs: the last boundary is always written.
    if !clock.finished() {
        let mut values = Vec::new();
        runner.solver.probes(clock.time(), &mut values);
        report(Event::Probes(ProbeValues { step: clock.step(), time: clock.time(), values }));
    }
    report(Event::Finished(FinalReport {
        step: clock.step(),
        time: clock.time(),
        reached_end: clock.finished(),
        counts: runner.solver.counts(),
        state: runner.solver.snapshot(clock.step(), clock.time()),
    }));
}

const CLOCK_STEP: &str = "driver.step";
const CLOCK_TIMES: &str = "driver.times";

/// Takes `solver` back to a boundary that was saved by [`Command::Checkpoint`]; tells where the run goes on.
///
/// # Errors
/// When an array is missing or does not fit the solver's set-up; the solver is then of no further use.
pub fn restore<S: Solver + ?Sized>(solver: &mut S, state: &SavedState) -> Result<ClockState, RestoreError> {
    let [step] = state.u64s(CLOCK_STEP)?;
    let [time, time_step, elapsed_before] = state.numbers(CLOCK_TIMES)?;
    if time_step <= 0.0 {
        return Err(RestoreError::new(CLOCK_TIMES, format!("time step {time_step} s, must be positive")));
    }
    solver.restore(state)?;
    Ok(ClockState { step, time, time_step, elapsed_before })
}

/// Saves what [`restore`] takes.
pub fn save<S: Solver + ?Sized>(solver: &S, clock: &ClockState) -> Checkpoint {
    let ClockState { step, time, time_step, elapsed_before } = *clock;
    let mut state = SavedState::default();
    state.put_u64(CLOCK_STEP, [step]);
    state.put_f64(CLOCK_TIMES, [time, time_step, elapsed_before]);
    solver.save(&mut state);
    Checkpoint { step, time, time_step, state }
}

impl<'a, S: Solver + ?Sized> Runner<'a, S> {
    fn new(
        solver: &'a mut S,
        setup: &'a RunSetup,
        link: &Link,
        exchange: Option<Box<dyn Exchange>>,
        clock: &Clock,
    ) -> Self {
        let empty = || Frame::empty(clock.stage(Stage::Predictor));
        let mut own = empty();
        own.extent.clone_from(solver.extent());
        let meeting = Meeting::of(solver.role(), exchange.is_some(), setup);
        own.content = meeting.content();
        Self {
            meeting,
            known_extents: [own.extent.clone(), own.extent.clone()],
            solver,
            exchange,
            partner_extent: link.partner_extent.clone(),
            own,
            partner: empty(),
            before: None,
            waited: Duration::ZERO,
            breaches: 0,
            torque: TorqueCheck::of(setup),
            stop_wanted: false,
            setup,
        }
    }

    fn failed(&self, fault: Fault, clock: &Clock) -> Event {
        Event::Failed(FailureReport {
            fault,
            step: clock.step(),
            time: clock.time(),
            counts: self.solver.counts(),
            state: self.solver.snapshot(clock.step(), clock.time()),
        })
    }

    fn checkpoint(&self, clock: &Clock) -> Checkpoint {
        let _span = trace_span!(target: TRACE, "checkpoint", step = clock.step()).entered();
        save(&*self.solver, &clock.state())
    }

    /// One step: predictor and corrector.
    fn step(&mut self, clock: &mut Clock) -> Result<StepReport, Fault> {
        let _span = trace_span!(target: TRACE, "step", step = clock.step()).entered();
        let started = Instant::now();
        let waited_before = self.waited;
        let breaches_before = self.breaches;
        let time_step = clock.time_step();
        let mut report = StepReport { step: clock.step(), time_step, ..StepReport::default() };
        let mut limit = f64::INFINITY;
        for (k, stage) in Stage::BOTH.into_iter().enumerate() {
            let time = clock.stage(stage);
            (report.books[k], limit) = self.half_step(&time)?;
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
        Ok(report)
    }

    /// One half-step; returns its books and the smaller of both sides' limits for the next step \[s\].
    fn half_step(&mut self, time: &StageTime) -> Result<(StageBooks, f64), Fault> {
        let _span = trace_span!(target: TRACE, "stage", at = %time.at).entered();
        trace_span!(target: TRACE, "begin stage")
            .in_scope(|| self.solver.begin_stage(time))
            .map_err(Fault::Diverged)?;
        let own_limit = self.solver.time_step_limit();
        self.check_step(time, own_limit)?;
        let digests = self.evaluate(time, own_limit)?;
        let books = trace_span!(target: TRACE, "advance")
            .in_scope(|| self.solver.advance(time))
            .map_err(Fault::Diverged)?;
        self.before = digests.map(|digests| Before { at: time.at, sums: books.interface, digests });
        let limit = if digests.is_some() { own_limit.min(self.partner.time_step_limit) } else { own_limit };
        Ok((books, limit))
    }

    /// Whether a fixed step is still one, by the own `limit` \[s\]; an adaptive one follows its limit by itself.
    fn check_step(&self, time: &StageTime, limit: f64) -> Result<(), Fault> {
        let StepPolicy::Fixed { .. } = self.setup.time.step else { return Ok(()) };
        if time.time_step <= LARGEST_STEP_OVER_LIMIT * limit {
            return Ok(());
        }
        Err(Fault::Diverged(Divergence {
            at: time.at,
            particle: None,
            position: None,
            quantity: "time step over its stability limit [-]".into(),
            value: time.time_step / limit,
            allowed: format!("at most {LARGEST_STEP_OVER_LIMIT}; the limit has become {limit:.3e} s"),
            hint: "speeds, accelerations or contacts have grown far beyond those of the start: use a smaller step, or an \
                   adaptive one"
                .into(),
        }))
    }

    /// Exchange and rates of one half-step: the one place where the kinds of coupling differ.
    ///
    /// With loads the partner's work depends on this side's, so that the fluid answers before its own sums.
    fn evaluate(&mut self, time: &StageTime, limit: f64) -> Result<Option<Digests>, Fault> {
        let at = time.at;
        let not_offered = |error: NoLoads| Fault::Peer { at, message: error.to_string() };
        let digests = match self.meeting {
            Meeting::Alone => {
                self.evaluate_own(time);
                self.evaluate_cross(time);
                return Ok(None);
            }
            Meeting::States => {
                self.prepare(time, limit)?;
                let sent = self.send(at)?;
                self.evaluate_own(time);
                let used = self.receive(time)?;
                self.evaluate_cross(time);
                Digests { sent, used }
            }
            Meeting::GivesLoads => {
                let used = self.receive(time)?;
                self.prepare(time, limit)?;
                let (own, samples) = (&mut self.own, &self.partner.states);
                trace_span!(target: TRACE, "reactions")
                    .in_scope(|| self.solver.reactions(time, &own.states, samples, &mut own.forces))
                    .map_err(not_offered)?;
                own.set_version = self.partner.set_version;
                let sent = self.send(at)?;
                self.evaluate_own(time);
                self.evaluate_cross(time);
                Digests { sent, used }
            }
            Meeting::TakesLoads => {
                self.prepare(time, limit)?;
                let sent = self.send(at)?;
                self.evaluate_own(time);
                let used = self.receive(time)?;
                self.check_forces(at)?;
                trace_span!(target: TRACE, "cross sums")
                    .in_scope(|| self.solver.evaluate_loads(time, &self.own.states, &self.partner.forces))
                    .map_err(not_offered)?;
                Digests { sent, used }
            }
        };
        Ok(Some(digests))
    }

    fn evaluate_own(&mut self, time: &StageTime) {
        let _span = trace_span!(target: TRACE, "own sums").entered();
        self.solver.evaluate_own(time);
    }

    fn evaluate_cross(&mut self, time: &StageTime) {
        let _span = trace_span!(target: TRACE, "cross sums").entered();
        self.solver.evaluate_cross(time, &self.own.states, &self.partner.states);
    }

    /// Whether the partner's forces belong to the samples that were sent.
    fn check_forces(&self, at: StepStage) -> Result<(), Fault> {
        let (own, partner) = (&self.own, &self.partner);
        if (partner.set_version, partner.forces.len()) == (own.set_version, own.states.len()) {
            return Ok(());
        }
        let message = format!(
            "the frame of {at} has {} forces for set {}, sent were {} samples of set {}",
            partner.forces.len(),
            partner.set_version,
            own.states.len(),
            own.set_version
        );
        Err(Fault::Peer { at, message })
    }

    /// Fills the own frame.
    fn prepare(&mut self, time: &StageTime, limit: f64) -> Result<(), Fault> {
        let _span = trace_span!(target: TRACE, "interface").entered();
        let Some(coupling) = &self.setup.coupling else {
            return Err(Fault::Peer { at: time.at, message: "the set-up has no coupling".into() });
        };
        let reach = 2.0 * coupling.fluid.smoothing_length + coupling.margin;
        let own = &mut self.own;
        own.time = *time;
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
        });
        Ok(())
    }

    /// Sends the own frame and returns its digest.
    fn send(&mut self, at: StepStage) -> Result<u32, Fault> {
        let _span = trace_span!(target: TRACE, "send").entered();
        let digest = self.own.digest();
        if let Some(exchange) = self.exchange.as_mut() {
            exchange.send(&self.own).map_err(|e| peer_fault(at, e))?;
        }
        Ok(digest)
    }

    fn receive(&mut self, time: &StageTime) -> Result<u32, Fault> {
        let at = time.at;
        if let Some(exchange) = self.exchange.as_mut() {
            let _span = trace_span!(target: TRACE, "wait for partner").entered();
            let started = Instant::now();
            exchange.receive(at, &mut self.partner).map_err(|e| peer_fault(at, e))?;
            self.waited += started.elapsed();
        }
        let partner = &self.partner;
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
        self.check_before(at)?;
        // The partner chose its particles by the extent of an earlier frame.
        let known = self.partner.partner_extent_version;
        let Some(extent) = self.known_extents.iter().find(|extent| extent.version == known) else {
            let message = format!("the frame of {at} refers to extent {known}, which was not sent lately");
            return Err(Fault::Peer { at, message });
        };
        if let Err(shortfall) = self.solver.covered_by(extent, self.partner.reach) {
            return Err(Fault::Coverage { at, shortfall });
        }
        if self.partner.extent.version != self.partner_extent.version {
            self.partner_extent.clone_from(&self.partner.extent);
        }
        Ok(self.partner.digest())
    }

    /// Compares the partner's report of the half-step before with own books.
    fn check_before(&mut self, at: StepStage) -> Result<(), Fault> {
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
        self.breaches += faults.len() as u64;
        match (self.setup.ledger.action, faults.into_iter().next()) {
            (BreachAction::Stop, Some(fault)) => Err(fault),
            // Which side used an old state is known to one side alone: both cannot stop at one boundary.
            (BreachAction::StopAndCheckpoint, Some(fault @ Fault::StaleFrame { .. })) => Err(fault),
            (BreachAction::StopAndCheckpoint, Some(_)) => {
                self.stop_wanted = true;
                Ok(())
            }
            _ => Ok(()),
        }
    }
}

fn peer_fault(at: StepStage, error: PeerError) -> Fault {
    match error {
        PeerError::Cancelled => Fault::Aborted { at },
        other => Fault::Peer { at, message: other.to_string() },
    }
}

impl Frame {
    /// A frame of `time` without particles.
    pub fn empty(time: StageTime) -> Self {
        Self {
            time,
            content: FrameContent::States,
            states: InterfaceStates::default(),
            forces: Vec::new(),
            set_version: 0,
            extent: Extent::default(),
            partner_extent_version: 0,
            reach: 0.0,
            time_step_limit: f64::INFINITY,
            previous: None,
        }
    }
}
