//! A black-box kit for any participant: does it keep to the protocol, and does it compute what it says?
//!
//! The kit plays coordinator and partner and puts damaged frames on the wire by a relay. Each [`Check`] has
//! one subject; what a participant does not offer is reported as such and never counts as passed.

use std::time::{Duration, Instant};

use sph::coupling::solver::Role;
use sph::setup::CouplingKind;

use crate::description::Description;
use crate::error::RpcError;
use crate::transport::channel;
use crate::transport::client::{Deadlines, ParticipantClient};
use crate::transport::security::{ClientSecurity, SecuredChannel};

mod bench;
mod bodies;
mod checkpoints;
mod describe;
mod dummy;
mod faults;
mod implicit;
mod life_cycle;
mod physics;
mod scene;

use bench::Bench;

/// How to examine a participant.
#[derive(Clone, Debug)]
pub struct Options {
    /// Longest wait for any one answer.
    pub deadline: Duration,
    /// Kind of coupling to examine; by default the first that the participant offers.
    pub kind: Option<CouplingKind>,
    /// Number of dimensions of the runs of the examination, 2 or 3.
    pub dimensions: u32,
    /// Address of a fresh process of the same participant, for checks that need one.
    pub fresh: Option<String>,
    /// Only checks whose name contains this.
    pub only: Option<String>,
    /// How the participant is known, and what it is shown.
    pub security: ClientSecurity,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            deadline: Duration::from_secs(10),
            kind: None,
            dimensions: 2,
            fresh: None,
            only: None,
            security: ClientSecurity::default(),
        }
    }
}

/// What a check found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// As it should be, with what was measured.
    Passed(String),
    /// Not as it should be, with what was expected and what came.
    Failed(String),
    /// The participant does not offer what the check is about, or the check does not apply to it.
    NotOffered(String),
}

/// One line of a report.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// What was checked.
    pub check: Check,
    /// What was found.
    pub verdict: Verdict,
    /// Wall time of the check.
    pub elapsed: Duration,
}

/// All that was found.
#[derive(Clone, Debug)]
pub struct Report {
    /// Who was examined.
    pub description: Description,
    /// Role in which it was examined.
    pub role: Role,
    /// Kind of coupling by which it was examined.
    pub kind: CouplingKind,
    /// Number of dimensions of the runs.
    pub dimensions: u32,
    /// One for each check, in order.
    pub outcomes: Vec<Outcome>,
}

impl Report {
    /// Number of failed checks.
    pub fn failures(&self) -> usize {
        self.outcomes.iter().filter(|outcome| matches!(outcome.verdict, Verdict::Failed(_))).count()
    }
}

/// `Err` says what is wrong.
type Finding = Result<Verdict, String>;

fn passed(measured: impl Into<String>) -> Finding {
    Ok(Verdict::Passed(measured.into()))
}

fn not_offered(why: impl Into<String>) -> Finding {
    Ok(Verdict::NotOffered(why.into()))
}

macro_rules! checks {
    ($($variant:ident $name:literal $what:literal => $run:expr;)*) => {
        /// A check of the kit.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Check {
            $(#[doc = $what] $variant,)*
        }

        impl Check {
            /// All checks in order.
            pub const ALL: &'static [Check] = &[$(Check::$variant,)*];

            /// Name on the command line and in reports.
            pub fn name(self) -> &'static str {
                match self {
                    $(Check::$variant => $name,)*
                }
            }

            /// What it asks for, in a sentence.
            pub fn what(self) -> &'static str {
                match self {
                    $(Check::$variant => $what,)*
                }
            }

            async fn find(self, bench: &Bench) -> Finding {
                match self {
                    $(Check::$variant => $run(bench).await,)*
                }
            }
        }
    };
}

checks! {
    Description "description" "The description is complete and makes sense." => describe::complete;
    Idempotent "description-repeats" "Describe answers the same each time, also around a run." => describe::idempotent;
    Versions "protocol-version" "A later minor version is tolerated, another major one refused as UNIMPLEMENTED." => describe::versions;
    UnknownFields "unknown-fields" "Fields of a later version are ignored." => describe::unknown_fields;
    Idle "state-idle" "Calls without a run are answered with the code of the table." => life_cycle::idle;
    Open "state-open" "Calls in state OPEN are answered with the code of the table." => life_cycle::open;
    Linked "state-linked" "Calls in state LINKED are answered with the code of the table." => life_cycle::linked;
    Running "state-running" "Calls in state RUNNING are answered with the code of the table." => life_cycle::running;
    Ended "state-ended" "Calls in state ENDED are answered with the code of the table." => life_cycle::ended;
    Token "token" "A wrong token is refused as PERMISSION_DENIED and changes nothing." => life_cycle::token;
    BadSetups "bad-set-ups" "Impossible set-ups are refused as INVALID_ARGUMENT, in words." => life_cycle::bad_setups;
    Coordinator "coordinator-vanishes" "A coordinator that vanishes frees the server." => life_cycle::coordinator_vanishes;
    Constants "constants" "Constants are those of the set-up, bit for bit, and change with it." => physics::constants;
    Gravity "gravity" "Free fall gains exactly g t, for more than one g." => physics::gravity;
    FreeFlight "free-flight" "Without contact everything flies on, and no force is reported." => physics::free_flight;
    Rest "rest" "What is at rest beside a partner at rest stays so." => physics::rest;
    ActionReaction "action-reaction" "Forces and torques of both sides cancel; momentum changes as its budget says." => physics::action_reaction;
    Masses "body-masses" "Mass and moment of inertia of bodies are those of the set-up." => bodies::masses;
    AngularMomentum "angular-momentum" "Under an eccentric force the angular momentum changes as the torques say." => bodies::angular_momentum;
    Galilean "galilean" "A common velocity of everything changes no force." => physics::galilean;
    QuarterTurn "quarter-turn" "A quarter turn of everything turns the forces." => physics::quarter_turn;
    Oscillator "order-oscillator" "On an exact oscillator the error falls as the square of the step." => physics::oscillator;
    Convergence "order-convergence" "Differences between steps dt, dt/2, dt/4 fall by four each." => physics::convergence;
    Iterated "iterated-half-step" "Iterations converge, and the accepted state follows the midpoint rule." => implicit::iterated;
    Determinism "determinism" "The same run gives the same bits, as declared." => physics::determinism;
    Replay "checkpoint-replay" "Saved, continued, restored and repeated: the same bits." => checkpoints::replay;
    Fresh "checkpoint-fresh" "A checkpoint restores into a fresh process: the same bits." => checkpoints::fresh;
    Truncated "frame-truncated" "A truncated array is refused by name." => faults::truncated;
    Checksum "frame-checksum" "A wrong checksum is refused by name." => faults::checksum;
    NotANumber "frame-nan" "A NaN is refused by name." => faults::not_a_number;
    Duplicate "frame-duplicate" "A frame that came before is refused by name." => faults::duplicate;
    Early "frame-early" "A frame of a later step is refused by name." => faults::early;
    Epoch "frame-epoch" "A frame of another epoch is refused by name." => faults::epoch;
    Clock "frame-clock" "A frame of another time step is refused by name." => faults::clock;
    Oversize "frame-oversize" "A frame above the size limit is refused." => faults::oversize;
    Sums "frame-sums" "Sums of the partner that do not balance are a breach." => faults::sums;
    Provenance "frame-provenance" "A partner that used another frame than the one sent is found out." => faults::provenance;
    Vanished "partner-vanishes" "A partner that vanishes ends the run." => faults::vanished;
    Frozen "partner-freezes" "While the partner is silent, beats say so, and an abort ends the wait." => faults::frozen;
    LargeFrame "large-frame" "A frame above 4 MiB arrives." => faults::large_frame;
    Latency "latency" "Wall time of a half-step, as the partner sees it." => physics::latency;
}

/// Examines the participant at `address`; `progress` hears of each check as it is done.
///
/// # Errors
/// When nothing answers there, or it is no participant.
pub async fn examine(
    address: &str,
    options: &Options,
    mut progress: impl FnMut(&Outcome),
) -> Result<Report, RpcError> {
    let deadlines = Deadlines {
        connect: options.deadline,
        describe: options.deadline,
        call: options.deadline,
        ..Deadlines::default()
    };
    let mut client = ParticipantClient::connect_secured(address, deadlines, &options.security).await?;
    let description = client.describe().await?;
    let bench = Bench::new(address, options, deadlines, description.clone()).await?;
    let mut report = Report {
        description,
        role: bench.role,
        kind: bench.kind,
        dimensions: options.dimensions,
        outcomes: Vec::new(),
    };
    let chosen =
        |check: &&Check| options.only.as_ref().is_none_or(|only| check.name().contains(only.as_str()));
    for check in Check::ALL.iter().filter(chosen) {
        let started = Instant::now();
        // A check has several waits in a row.
        let limit = 6 * options.deadline;
        let found = match tokio::time::timeout(limit, check.find(&bench)).await {
            Ok(found) => found,
            Err(_) => Err(format!("no end within {} s", limit.as_secs_f64())),
        };
        let mut verdict = found.unwrap_or_else(Verdict::Failed);
        // Whatever a check left behind must not spoil the next one.
        if let Err(problem) = bench.free().await {
            verdict = Verdict::Failed(match verdict {
                Verdict::Failed(text) => format!("{text}; then {problem}"),
                _ => problem,
            });
        }
        let outcome = Outcome { check: *check, verdict, elapsed: started.elapsed() };
        progress(&outcome);
        report.outcomes.push(outcome);
    }
    Ok(report)
}

/// A raw connection to `address`, where the participant under examination or another process of it listens.
async fn connect(address: &str, bench: &Bench) -> Result<SecuredChannel, String> {
    let channel = channel::connect_secured(address, bench.deadline, &bench.security).await;
    channel.map(|channel| bench.security.over(channel)).map_err(|problem| format!("{address} {problem}"))
}
