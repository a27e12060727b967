//! The first steps of a case, both solvers as threads of this process, without outputs.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use coordinator::case::Case;
use coordinator::case::forecast::Work;
use coordinator::results::energy::SideEnergy;
use coordinator::results::state;
use coordinator::run::participants::News;
use coordinator::run::participants::in_process;
use coordinator::run::participants::threads::Threads;
use sph::coupling::driver::{Command, Event};
use sph::coupling::solver::{PartCounts, Role};

use crate::source_tree::case_files;

/// The cases that a program goes through.
#[derive(Debug, Args)]
pub struct ChosenCases {
    /// Only cases with this in their path.
    #[arg(long, value_name = "TEXT", default_value = "")]
    only: String,
    /// Case files instead of the shipped ones.
    cases: Vec<PathBuf>,
}

impl ChosenCases {
    /// Calls `process` for each; failures are printed and give the exit code.
    pub fn for_each(&self, mut process: impl FnMut(&Path) -> Result<(), String>) -> ExitCode {
        let cases = if self.cases.is_empty() { case_files() } else { self.cases.clone() };
        let mut code = ExitCode::SUCCESS;
        for path in cases.iter().filter(|path| path.to_string_lossy().contains(&self.only)) {
            if let Err(message) = process(path) {
                terminal::note(format_args!("error: {message}"));
                code = ExitCode::FAILURE;
            }
        }
        code
    }
}

/// Largest residual of the energy budget of a side over the energy that was there to be spent \[-\]. What is not exact is
/// of third order in the change of density in a half-step, far below.
pub const LARGEST_ENERGY_RESIDUAL: f64 = 1e-3;

/// Events that may wait for the reader.
const PENDING_EVENTS: usize = 256;

/// Where one side stands after its first steps.
#[derive(Clone, Debug, PartialEq)]
pub struct SideState {
    /// Which side it is.
    pub role: Role,
    /// Completed steps: fewer than asked for where the case ends before.
    pub step: u64,
    /// Time \[s\].
    pub time: f64,
    /// Digest of all particles, see [`state::digest`].
    pub digest: String,
    /// Its energy budget.
    pub energy: SideEnergy,
    /// The parts that computed it.
    pub parts: Option<PartCounts>,
}

/// Takes `steps` steps of the case file at `path`, or all that it has, with the fluid in `parts`, and says where each side
/// stands.
///
/// # Errors
/// When the case is refused or a side fails; the message names the side.
pub fn first_steps(path: &Path, steps: u64, parts: usize) -> Result<Vec<SideState>, String> {
    let case = coordinator::run::load(path).map_err(|failure| failure.to_string())?;
    run(&case, steps, parts, |_| None).map_err(|message| format!("{}: {message}", path.display()))
}

/// Takes `steps` steps of `case`, with the fluid in `parts`, and says where each side stands.
///
/// # Errors
/// When a side fails; the message names the side.
pub fn first_steps_of(case: &Case, steps: u64, parts: usize) -> Result<Vec<SideState>, String> {
    run(case, steps, parts, |_| None)
}

/// What steps of a case have cost.
#[derive(Clone, Copy, Debug)]
pub struct StepCost {
    /// Steps that were measured.
    pub steps: u64,
    /// CPU time of one, all threads together \[s\].
    pub seconds_per_step: f64,
    /// Work of one, as the forecast counts it.
    pub work: Work,
}

/// Steps before the measurement: pages are touched, and lists are as wide as they need to be.
const WARM_UP: u64 = 20;

/// Measures the CPU time of the first steps of the case file at `path`, for about `seconds`.
///
/// # Errors
/// When the case is refused, a side fails, or the case is too short.
pub fn cpu_time(path: &Path, seconds: f64) -> Result<StepCost, String> {
    let case = coordinator::run::load(path).map_err(|failure| failure.to_string())?;
    let (mut start, mut end) = (None, None);
    run(&case, WARM_UP, 1, |step| {
        let now = proto::trace::process_cpu().as_secs_f64();
        end = Some((step, now));
        let (_, started) = *start.get_or_insert((step, now));
        (now - started < seconds).then_some(step + WARM_UP)
    })
    .map_err(|message| format!("{}: {message}", path.display()))?;
    match (start, end) {
        (Some((first, from)), Some((last, to))) if last > first => Ok(StepCost {
            steps: last - first,
            seconds_per_step: (to - from) / (last - first) as f64,
            work: case.summary().work,
        }),
        _ => Err(format!("{}: fewer than {} steps", path.display(), 2 * WARM_UP)),
    }
}

/// Takes `steps` steps of `case`, then as many more as `further` wants: it gets the steps that all sides have completed
/// and answers with those to complete next.
fn run(
    case: &Case,
    steps: u64,
    parts: usize,
    mut further: impl FnMut(u64) -> Option<u64>,
) -> Result<Vec<SideState>, String> {
    let (events, mut received) = tokio::sync::mpsc::channel(PENDING_EVENTS);
    let threads = Threads::each(1).with_fluid_parts(parts);
    let solvers = in_process::start(case.fluid_setup(), case.solid_setup(), threads, None, &events)
        .map_err(|failure| failure.to_string())?;
    drop(events);
    let order = |command: Command| {
        for solver in &solvers {
            // A side that has failed takes no commands; its last event says why.
            let _ = solver.commands.send(command);
        }
    };
    let (mut granted, mut arrived) = (steps, 0);
    order(Command::GrantThrough(granted));
    let (mut states, mut failure) = (Vec::new(), None);
    let mut energies = [SideEnergy::default(); 2];
    while let Some((role, news)) = received.blocking_recv() {
        match news {
            Ok(News::Event(event)) => match *event {
                Event::Step(report) => {
                    energies[role.index()].take(&report.energies);
                    if report.step + 1 != granted {
                        continue;
                    }
                    arrived += 1;
                    if arrived == solvers.len() {
                        match further(granted) {
                            Some(next) => (granted, arrived) = (next, 0),
                            None => order(Command::Stop),
                        }
                        order(Command::GrantThrough(granted));
                    }
                }
                Event::Finished(report) => states.push(SideState {
                    role,
                    step: report.step,
                    time: report.time,
                    digest: state::digest(&report.state),
                    energy: energies[role.index()],
                    parts: report.counts.parts,
                }),
                Event::Failed(report) => failure = Some(format!("{role}: {report:?}")),
                _ => {}
            },
            Ok(News::Checkpoint(_)) => {}
            Err(lost) => failure = Some(format!("{role}: {lost}")),
        }
    }
    solvers.into_iter().for_each(in_process::ThreadParticipant::join);
    states.sort_by_key(|side| side.role.to_string());
    failure.map_or(Ok(states), Err)
}
