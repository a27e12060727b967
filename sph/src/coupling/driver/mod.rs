//! The half-step driver: the same loop steps a solver inside a server and inside one process.

use std::sync::mpsc::Receiver;

use tracing::trace_span;

pub(crate) mod checks;
mod half_step;
mod implicit;
mod messages;
mod saved;

pub use messages::{Checkpoint, Command, Event, FailureReport, FinalReport, Paused, ProbeValues, StepReport};
pub use saved::{restore, save};

use crate::coupling::audit::PartnerParticles;
use crate::coupling::exchange::{Exchange, Extent};
use crate::coupling::solver::{Fault, Solver};
use crate::coupling::stage::{Clock, ClockState, Stage};
use crate::setup::RunPlan;
use half_step::Runner;

/// Target of the spans that tell where the time of a run goes; they cost nothing unless somebody records them.
pub const TRACE: &str = "tidelock::trace";

/// What both sides know before the first frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// The partner's extent at the start.
    pub partner_extent: Extent,
    /// Smaller of both sides' limits for the first step \[s\].
    pub first_limit: f64,
    /// Where a restored run continues, see [`restore`].
    pub resume: Option<ClockState>,
    /// What the set-up says of a solid partner, for the audit of its frames.
    pub partner_particles: Option<PartnerParticles>,
}

/// Runs `solver` to its end under `commands`, reporting through `report`.
///
/// Without an exchange the solver has no partner. Every event is reported in order, `Finished` or `Failed` last.
pub fn run<S: Solver + ?Sized>(
    solver: &mut S,
    setup: &RunPlan,
    link: &Link,
    exchange: Option<Box<dyn Exchange>>,
    commands: &Receiver<Command>,
    report: &mut dyn FnMut(Event),
) {
    let mut clock = match &link.resume {
        Some(state) => Clock::resumed(setup.time.clone(), setup.outputs.clone(), state),
        None => Clock::new(setup.time.clone(), setup.outputs.clone(), link.first_limit),
    };
    let mut runner = Runner::new(solver, setup, link, exchange, &clock);
    let mut granted = 0;
    let mut stopping = false;
    let (mut pauses_at_end, mut paused) = (false, false);
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
            if (runner.stop_wanted || clock.finished() && pauses_at_end) && !paused {
                paused = true;
                report(Event::Paused(Paused { step: clock.step(), time: clock.time() }));
            }
            let waits = paused || clock.finished() || clock.step() >= granted;
            if waits && stopping || clock.finished() && !pauses_at_end {
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
                Some(Command::Pause) => pauses_at_end = true,
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
        if paused || clock.finished() || clock.step() >= granted {
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
