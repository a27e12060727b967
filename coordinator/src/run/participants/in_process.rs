//! Both solvers as threads of this process: the same driver, the same frames, a channel instead of a network.

use std::sync::mpsc;
use std::thread::JoinHandle;

use proto::checkpoint::{CheckpointData, CheckpointHeader, restore_solver};
use proto::description::Description;
use proto::service::{SetupProblems, SolverFactory};
use sph::coupling::audit::PartnerParticles;
use sph::coupling::driver::{self, Command, Event, Link};
use sph::coupling::exchange::{Exchange, Extent, in_process_pair};
use sph::coupling::solver::{Role, Solver};
use sph::in_space;
use sph::setup::{AnyFluidSetup, AnySolidSetup, ParticipantSetup, RunPlan};
use tokio::sync::mpsc::Sender;

use crate::checkpoint::RunCheckpoint;
use crate::failure::Failure;
use crate::failure::Kind;
use crate::run::participants::threads::Threads;
use crate::run::participants::{News, NewsResult};

/// A participant that runs as a thread.
pub struct ThreadParticipant {
    /// Which side it is.
    pub role: Role,
    /// Largest stable step at the start \[s\].
    pub time_step_limit: f64,
    /// What deserves a second look about the start, in words.
    pub remarks: Vec<String>,
    /// Its command channel.
    pub commands: mpsc::Sender<Command>,
    thread: JoinHandle<()>,
}

impl ThreadParticipant {
    /// Waits for the thread to end.
    pub fn join(self) {
        drop(self.commands);
        // A panic of the solver has already closed its event channel, which the caller reports.
        drop(self.thread.join());
    }
}

/// Starts the participants that have a set-up; events arrive through `events`, in order for each role.
///
/// # Errors
/// When a solver refuses its set-up, with all reasons.
pub fn start(
    fluid: Option<AnyFluidSetup>,
    solid: Option<AnySolidSetup>,
    threads: Threads,
    resume: Option<&RunCheckpoint>,
    events: &Sender<(Role, NewsResult)>,
) -> Result<Vec<ThreadParticipant>, Failure> {
    let mut particles = solid.as_ref().map(|setup| in_space!(setup, setup => PartnerParticles::of(setup)));
    let setups = fluid.map(ParticipantSetup::Fluid).into_iter().chain(solid.map(ParticipantSetup::Solid));
    let mut solvers: Vec<(Box<dyn Solver>, RunPlan)> = Vec::new();
    for setup in setups {
        let (role, run) = (setup.role(), setup.plan());
        let opened = match role {
            Role::Fluid => fluid_server::FluidFactory::in_threads(threads.fluid_parts()).open(setup),
            Role::Solid => solid_server::SolidFactory.open(setup),
        };
        let opened = opened.map_err(|SetupProblems(problems)| refused(role, &problems))?;
        solvers.push((opened.solver, run));
    }
    let mut clocks = vec![None; solvers.len()];
    if let Some(checkpoint) = resume {
        for ((solver, _), clock) in solvers.iter_mut().zip(&mut clocks) {
            let role = solver.role();
            let failed = |problem| Failure::input(format!("the {role}'s checkpoint: {problem}"));
            let side = checkpoint.sides.iter().find(|side| side.header.role == role);
            let side = side.ok_or_else(|| failed("is missing".to_owned()))?;
            *clock = Some(restore_solver(solver.as_mut(), side).map_err(failed)?);
        }
    }
    let first_limit =
        solvers.iter().map(|(solver, _)| solver.time_step_limit()).fold(f64::INFINITY, f64::min);
    let extents: Vec<Extent> = solvers.iter().map(|(solver, _)| solver.extent().clone()).collect();
    let mut exchanges: Vec<Option<Box<dyn Exchange>>> = vec![None, None];
    if solvers.len() == 2 {
        let (a, b) = in_process_pair();
        exchanges = vec![Some(Box::new(a)), Some(Box::new(b))];
    }
    let coupled = solvers.len() == 2;
    let mut participants = Vec::new();
    for (k, (((solver, run), exchange), resume)) in solvers.into_iter().zip(exchanges).zip(clocks).enumerate()
    {
        // With two participants, the partner of 0 is 1 and of 1 is 0.
        let partner_extent = extents.get(1 - k).cloned().unwrap_or_default();
        let partner_particles = match (solver.role(), coupled) {
            (Role::Fluid, true) => particles.take(),
            _ => None,
        };
        let link = Link { partner_extent, first_limit, resume, partner_particles };
        participants.push(spawn(solver, run, link, exchange, threads, events.clone())?);
    }
    Ok(participants)
}

fn spawn(
    mut solver: Box<dyn Solver>,
    run: RunPlan,
    link: Link,
    exchange: Option<Box<dyn Exchange>>,
    threads: Threads,
    events: Sender<(Role, NewsResult)>,
) -> Result<ThreadParticipant, Failure> {
    let (role, time_step_limit, remarks) = (solver.role(), solver.time_step_limit(), solver.remarks());
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads.for_role(role))
        .thread_name(move |k| format!("{role}-{k}"))
        .build()
        .map_err(|e| Failure::internal(format!("cannot start the {role}'s threads: {e}")))?;
    let (commands, receiver) = mpsc::channel();
    let thread = std::thread::Builder::new()
        .name(role.to_string())
        .spawn(move || {
            pool.install(move || {
                let _told = PanicReport { role, events: &events };
                driver::run(&mut *solver, &run, &link, exchange, &receiver, &mut |event| {
                    let news = match event {
                        Event::Checkpoint(checkpoint) => {
                            let header = CheckpointHeader::new(&description(role), role, &checkpoint);
                            News::Checkpoint(Box::new(CheckpointData::new(header, *checkpoint)))
                        }
                        event => News::Event(Box::new(event)),
                    };
                    // A closed channel means that the run is being aborted; the driver sees it on its commands.
                    drop(events.blocking_send((role, Ok(news))));
                });
            });
        })
        .map_err(|e| Failure::internal(format!("cannot start the {role}'s thread: {e}")))?;
    Ok(ThreadParticipant { role, time_step_limit, remarks, commands, thread })
}

/// Description of the solver of `role` in this program.
pub fn description(role: Role) -> Description {
    match role {
        Role::Fluid => fluid_server::FluidFactory::default().describe(),
        Role::Solid => solid_server::SolidFactory.describe(),
    }
}

/// Reports a panic of a solver's thread: nothing else would.
struct PanicReport<'a> {
    role: Role,
    events: &'a Sender<(Role, NewsResult)>,
}

impl Drop for PanicReport<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            let failure = Failure::new(Kind::Internal, format!("the {} solver panicked", self.role));
            // No one listens when the run is being aborted.
            drop(self.events.blocking_send((self.role, Err(failure))));
        }
    }
}

fn refused(role: Role, problems: &[String]) -> Failure {
    Failure::input(format!("the {role} solver refuses the case:\n  {}", problems.join("\n  ")))
}
