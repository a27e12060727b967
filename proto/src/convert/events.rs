//! Commands and events of the Run stream.

use sph::coupling::driver::{Command, Paused, ProbeValues, StepReport};
use sph::coupling::ledger::StageBudget;
use sph::coupling::solver::{Counts, Fault};
use sph::coupling::stage::StepStage;

use super::arrays::{pack, unpack_all};
use super::report::{energies_from_wire, energies_to_wire, stores_to_wire};
use super::{Choice, Convert, Path, WireError, choice, finite, length, optional, required};
use crate::limits::MAX_LIST;
use crate::wire;

/// What the compute thread of a server is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Stepping.
    Computing,
    /// In the exchange.
    WaitingForPartner,
    /// At a step boundary.
    WaitingForGrant,
}

/// Sign of life of a server.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beat {
    /// Completed steps.
    pub step: u64,
    /// What it is doing.
    pub phase: Phase,
    /// Time since the last completed step \[s\].
    pub since_last_step: f64,
    /// Half-step of the partner's frame that it awaited last.
    pub awaited: Option<StepStage>,
}

/// One event as it travels: particle fields go beside it, by number.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum BatchItem {
    Step(Box<StepReport>),
    Probes(ProbeValues),
    Snapshot { index: u64, step: u64, time: f64 },
    Finished { step: u64, time: f64, reached_end: bool, counts: Counts, state_index: u64 },
    Failed { fault: Box<Fault>, step: u64, time: f64, counts: Counts, state_index: u64 },
    Beat(Beat),
    Paused(Paused),
}

impl std::fmt::Display for Beat {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let doing = match self.phase {
            Phase::Computing => "computing",
            Phase::WaitingForPartner => "waiting for its partner",
            Phase::WaitingForGrant => "waiting for a grant",
        };
        match self.awaited.filter(|at| at.step >= self.step) {
            Some(at) => write!(f, "in {at}, {doing}"),
            None => write!(f, "after {} completed steps, {doing}", self.step),
        }
    }
}

choices!(Phase = wire::Phase { Computing, WaitingForPartner, WaitingForGrant });

pub(crate) fn encode_command(run_id: &str, epoch: u32, command: Command) -> wire::Command {
    use wire::command::Order;
    let order = match command {
        Command::GrantThrough(step) => Order::GrantThrough(step),
        Command::Stop => Order::Stop(wire::Unit {}),
        Command::Abort => Order::Abort(wire::Unit {}),
        Command::Pause => Order::Pause(wire::Unit {}),
        // Has a call of its own; as an order it is empty, and refused.
        Command::Checkpoint => return wire::Command { run_id: run_id.to_owned(), epoch, order: None },
    };
    wire::Command { run_id: run_id.to_owned(), epoch, order: Some(order) }
}

/// The order of a command; the caller compares run and epoch.
pub(crate) fn decode_command(wire: &wire::Command) -> Result<Command, WireError> {
    use wire::command::Order;
    match &wire.order {
        Some(Order::GrantThrough(step)) => Ok(Command::GrantThrough(*step)),
        Some(Order::Stop(_)) => Ok(Command::Stop),
        Some(Order::Abort(_)) => Ok(Command::Abort),
        Some(Order::Pause(_)) => Ok(Command::Pause),
        None => Err(Path::root("command")
            .field("order")
            .error("is missing or of a later version of the protocol")),
    }
}

pub(crate) fn encode_batch(run_id: &str, epoch: u32, items: &[BatchItem]) -> wire::EventBatch {
    let events = items.iter().map(|item| wire::Event { body: Some(item.to_wire()) }).collect();
    wire::EventBatch { run_id: run_id.to_owned(), epoch, events }
}

/// Events of a batch; the caller compares run and epoch.
pub(crate) fn decode_batch(wire: &wire::EventBatch) -> Result<Vec<BatchItem>, WireError> {
    let root = Path::root("batch");
    length(wire.events.len(), MAX_LIST, &root.field("events"))?;
    let item = |(k, event): (usize, &wire::Event)| match &event.body {
        Some(body) => BatchItem::from_wire(body, &root.item("events", k)),
        None => Err(root.item("events", k).error("is empty or of a later version of the protocol")),
    };
    wire.events.iter().enumerate().map(item).collect()
}

/// A time that travels by its bits.
fn time(bits: u64, at: &Path<'_>, name: &str) -> Result<f64, WireError> {
    finite(f64::from_bits(bits), &at.field(name))
}

impl BatchItem {
    fn to_wire(&self) -> wire::event::Body {
        use wire::event::Body;
        match self {
            Self::Step(report) => Body::Step(report.to_wire()),
            Self::Probes(row) => Body::Probes(wire::ProbeRow {
                step: row.step,
                time_s_bits: row.time.to_bits(),
                values: pack(&row.values),
            }),
            Self::Snapshot { index, step, time } => Body::Snapshot(wire::SnapshotTaken {
                index: *index,
                step: *step,
                time_s_bits: time.to_bits(),
            }),
            Self::Finished { step, time, reached_end, counts, state_index } => {
                Body::Finished(wire::Finished {
                    step: *step,
                    time_s_bits: time.to_bits(),
                    reached_end: *reached_end,
                    counts: Some(counts.to_wire()),
                    state_index: *state_index,
                })
            }
            Self::Failed { fault, step, time, counts, state_index } => Body::Failed(wire::Failed {
                fault: Some(fault.to_wire()),
                step: *step,
                time_s_bits: time.to_bits(),
                counts: Some(counts.to_wire()),
                state_index: *state_index,
            }),
            Self::Beat(beat) => Body::Beat(wire::Beat {
                step: beat.step,
                phase: beat.phase.code(),
                since_last_step_s: Some(beat.since_last_step),
                awaited: beat.awaited.map(|at| at.to_wire()),
            }),
            Self::Paused(paused) => {
                Body::Paused(wire::Paused { step: paused.step, time_s_bits: paused.time.to_bits() })
            }
        }
    }

    fn from_wire(body: &wire::event::Body, at: &Path<'_>) -> Result<Self, WireError> {
        use wire::event::Body;
        Ok(match body {
            Body::Step(report) => Self::Step(Box::new(StepReport::from_wire(report, &at.field("step"))?)),
            Body::Probes(row) => {
                let at = at.field("probes");
                Self::Probes(ProbeValues {
                    step: row.step,
                    time: time(row.time_s_bits, &at, "time_s_bits")?,
                    values: unpack_all(&row.values, &at.field("values"))?,
                })
            }
            Body::Snapshot(taken) => Self::Snapshot {
                index: taken.index,
                step: taken.step,
                time: time(taken.time_s_bits, &at.field("snapshot"), "time_s_bits")?,
            },
            Body::Finished(end) => {
                let at = at.field("finished");
                Self::Finished {
                    step: end.step,
                    time: time(end.time_s_bits, &at, "time_s_bits")?,
                    reached_end: end.reached_end,
                    counts: required(&end.counts, &at.field("counts"))?,
                    state_index: end.state_index,
                }
            }
            Body::Failed(end) => {
                let at = at.field("failed");
                Self::Failed {
                    fault: Box::new(required(&end.fault, &at.field("fault"))?),
                    step: end.step,
                    time: time(end.time_s_bits, &at, "time_s_bits")?,
                    counts: required(&end.counts, &at.field("counts"))?,
                    state_index: end.state_index,
                }
            }
            Body::Beat(beat) => {
                let at = at.field("beat");
                Self::Beat(Beat {
                    step: beat.step,
                    phase: choice(beat.phase, &at.field("phase"))?,
                    since_last_step: finite(beat.since_last_step_s, &at.field("since_last_step_s"))?,
                    awaited: optional(&beat.awaited, &at.field("awaited"))?,
                })
            }
            Body::Paused(paused) => Self::Paused(Paused {
                step: paused.step,
                time: time(paused.time_s_bits, &at.field("paused"), "time_s_bits")?,
            }),
        })
    }
}

impl Convert for StepReport {
    type Wire = wire::StepReport;

    fn to_wire(&self) -> wire::StepReport {
        let [predictor, corrector] = &self.budgets;
        let [own, partner] = self.interface_particles;
        wire::StepReport {
            step: self.step,
            end_time_s_bits: self.end_time.to_bits(),
            time_step_s_bits: self.time_step.to_bits(),
            predictor: Some(predictor.to_wire()),
            corrector: Some(corrector.to_wire()),
            energies: Some(stores_to_wire(&self.energies)),
            energy_accounts: energies_to_wire(&self.energies),
            own_interface_particles: own,
            partner_interface_particles: partner,
            elapsed_s: Some(self.elapsed),
            waited_s: Some(self.waited),
            breaches: self.breaches,
            iterations: self.iterations,
            unconverged: self.unconverged,
        }
    }

    fn from_wire(wire: &wire::StepReport, at: &Path<'_>) -> Result<Self, WireError> {
        let predictor: StageBudget = required(&wire.predictor, &at.field("predictor"))?;
        let corrector: StageBudget = required(&wire.corrector, &at.field("corrector"))?;
        let energies = energies_from_wire(&wire.energy_accounts, at)?;
        Ok(Self {
            step: wire.step,
            end_time: time(wire.end_time_s_bits, at, "end_time_s_bits")?,
            time_step: time(wire.time_step_s_bits, at, "time_step_s_bits")?,
            budgets: [predictor, corrector],
            energies,
            interface_particles: [wire.own_interface_particles, wire.partner_interface_particles],
            elapsed: finite(wire.elapsed_s, &at.field("elapsed_s"))?,
            waited: finite(wire.waited_s, &at.field("waited_s"))?,
            breaches: wire.breaches,
            iterations: wire.iterations,
            unconverged: wire.unconverged,
        })
    }
}
