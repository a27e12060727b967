//! `coordinator run`: from a case file to results.

pub mod checkpoint_scheduler;
pub(crate) mod completion;
pub mod control;
mod frame_path;
pub mod header;
mod losses;
pub mod origin;
pub mod participants;
mod take_over;
pub mod trace;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use proto::player::Replayed;
use proto::recording::RecordingWriter;
use sph::setup::{CouplingKind, ParticipantSetup};
use sph::solver::Role;
use terminal::stop::StopSignals;
use tokio::sync::mpsc;

use crate::case::{self, Case};
use crate::checkpoint::{OriginDigests, RunCheckpoint, Store};
use crate::cli::{RunArguments, RunOptions};
use crate::failure::{Failure, Kind};
use crate::results::directory::OutputDirectory;
use crate::results::names;
use crate::results::progress::Progress;
use crate::results::recorder::Recorder;
use crate::results::summary::Participant;
use crate::results::table::Changed;
use crate::results::writer::Writer;
use crate::resume;
use crate::run::checkpoint_scheduler::{CaseFacts, Keeper, Schedule};
use crate::run::control::{Ending, Pace, Resumed, StopWish};
use crate::run::participants::in_process::{self, ThreadParticipant};
use crate::run::participants::launch::Source;
use crate::run::participants::remote::{Plan, Remote, Resume, Start};
use crate::run::participants::threads::Threads;
use crate::run::participants::{CommandLine, NewsResult, Participants};
use crate::run::trace::Trace;
use losses::Losses;

/// Events that may wait for the coordinator when solvers are threads.
const PENDING_EVENTS: usize = 256;

/// Runs a case as the command line says.
///
/// # Errors
/// When the case is wrong, a server is not to be had, an output cannot be written, or the run ends out of order; what
/// was computed until then is written in every case.
pub fn run(arguments: &RunArguments) -> Result<(), Failure> {
    arguments.new.options.force_arithmetic()?;
    let (case, origin) = origin::load(&arguments.case)?;
    let directory = Arc::new(arguments.new.create(&arguments.case, "", &origin)?);
    let origin = origin.keep(&directory)?;
    let options = arguments.new.options.clone();
    execute(&Job { case, origin, directory, options, resume: None, alone: None }).map(drop)
}

/// A run to be made, or to go on.
pub struct Job {
    /// What is computed.
    pub case: Case,
    /// What it started from.
    pub origin: OriginDigests,
    /// Where results go.
    pub directory: Arc<OutputDirectory>,
    /// How it is run.
    pub options: RunOptions,
    /// Where it continues.
    pub resume: Option<Resumption>,
    /// The only side that runs, and the recording from which the other is played.
    pub alone: Option<(Role, PathBuf)>,
}

/// Where a run continues, and what it may be that it was not.
pub struct Resumption {
    /// State of both sides and of the outputs.
    pub checkpoint: RunCheckpoint,
    /// Another build of a solver may take over.
    pub accept_other_build: bool,
    /// What to do with outputs that are not as they were.
    pub changed: Changed,
}

/// Makes a run; answers what came of a replay, if it was one.
///
/// # Errors
/// As [`run`].
pub fn execute(job: &Job) -> Result<Option<Replayed>, Failure> {
    let out = job.directory.path();
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(|e| Failure::internal(format!("cannot start the runtime: {e}")))?;
    let trace = job.options.trace.as_deref().map(Trace::start).transpose()?;
    let outcome = runtime.block_on(run_in(job, trace.as_ref()));
    // Blocking readers of a child's output may linger; nothing waits for them.
    runtime.shutdown_background();
    let traced = trace.map_or(Ok(()), Trace::finish);
    let (ending, replayed) = outcome.map_err(|failure| with_way_on(failure, job))?;
    job.directory.complete()?;
    traced?;
    if !job.options.quiet {
        terminal::note(format_args!("results in {}", out.display()));
    }
    match ending {
        Ending::Completed => Ok(replayed),
        // Where it differs says more than the end to which that led.
        _ if replayed.as_ref().is_some_and(|replayed| replayed.difference.is_some()) => Ok(replayed),
        Ending::Stopped => {
            let text = "stopped from outside before the end time at a step boundary; results up to there are complete in";
            Err(with_way_on(Failure::new(Kind::Stopped, format!("{text} {}", out.display())), job))
        }
        Ending::Failed(failure) | Ending::Lost { failure, .. } => Err(with_way_on(failure, job)),
    }
}

/// Adds the command that goes on, where there is a checkpoint and going on may help.
fn with_way_on(mut failure: Failure, job: &Job) -> Failure {
    // What was refused before anything was changed would be refused again.
    let helps = job.directory.is_changed()
        && matches!(failure.kind, Kind::Lost | Kind::Stopped | Kind::Output | Kind::Ledger | Kind::Server);
    let store = Store::new(job.directory.file(names::CHECKPOINTS));
    if helps && store.newest().checkpoint.is_some() {
        let command = resume::command(job.directory.path());
        failure.message.push_str(&format!("\ngo on from the last checkpoint with `{command}`"));
    }
    failure
}

/// Reads and checks a case file.
///
/// # Errors
/// All mistakes of the file.
pub fn load(path: &Path) -> Result<Case, Failure> {
    origin::load(path).map(|(case, _)| case)
}

/// The solvers of a run, wherever they are.
enum Solvers {
    Threads(Vec<ThreadParticipant>),
    Servers(Remote),
}

async fn run_in(job: &Job, trace: Option<&Trace>) -> Result<(Ending, Option<Replayed>), Failure> {
    let recording = match &job.options.record {
        Some(path) if job.case.run_setup().coupling.is_some() => Some(RecordingWriter::create(path)?),
        Some(_) => {
            return Err(Failure::input("`--record`: the case has one side only, whose run has no frames"));
        }
        None => None,
    };
    let outcome = make_attempts(job, recording.as_ref(), trace).await;
    if let Some(recording) = recording {
        let frames = recording.finish().await;
        // A run that failed says why first.
        if outcome.is_ok() {
            let frames = frames?;
            if !job.options.quiet {
                terminal::note(format_args!("{frames} frames recorded"));
            }
        }
    }
    outcome
}

async fn make_attempts(
    job: &Job,
    recording: Option<&RecordingWriter>,
    trace: Option<&Trace>,
) -> Result<(Ending, Option<Replayed>), Failure> {
    let Job { case, directory, options, .. } = job;
    let resolved = case.resolved_toml();
    if job.resume.is_none() {
        job.write_case()?;
    }
    let mut wishes = watch_signals()?;
    let mut keeper = Keeper::new(
        directory.file(names::CHECKPOINTS),
        schedule(case, options),
        case.disk_deadline(),
        CaseFacts { identity: case.identity(), origin: job.origin.clone() },
    );
    let mut from = job.resume.as_ref().map(|resume| resume.checkpoint.clone());
    let mut restarts: Vec<String> = Vec::new();
    let mut losses = Losses::default();
    // A recording is no partner that could be started again.
    let most =
        if job.alone.is_some() { 0 } else { options.max_restarts.unwrap_or(case.checkpoint().max_restarts) };
    loop {
        let attempt = Attempt { job, from: from.as_ref(), number: restarts.len(), recording, trace };
        let mut run = attempt.make(&mut keeper, &mut wishes).await?;
        let Some((roles, failure)) = run.lost(&mut losses, most).await else {
            let replayed = run.solvers.remote().and_then(Remote::replayed);
            let ending = completion::finish(job, &resolved, run, &keeper, restarts).await?;
            return Ok((ending, replayed));
        };
        let lost = roles.iter().map(Role::to_string).collect::<Vec<_>>().join(" and ");
        let lost = if lost.is_empty() { "the connection".to_owned() } else { format!("the {lost} solver") };
        run.solvers.kill().await;
        // What is still queued belongs before what the next attempt cuts back.
        run.outputs.close().await?;
        from = keeper.store().newest().checkpoint;
        let step = from.as_ref().map_or(0, |checkpoint| checkpoint.step);
        let text = format!("{}\nstarting {lost} again and going on from step {step}", failure.message);
        terminal::note(format_args!("{text}, restart {} of {most}", restarts.len() + 1));
        restarts.push(text);
    }
}

fn schedule(case: &Case, options: &RunOptions) -> Schedule {
    let table = case.checkpoint();
    Schedule {
        every_steps: options.checkpoint_every_steps.or(table.every_steps),
        every_wall: Duration::from_secs_f64(options.checkpoint_every_wall.unwrap_or(table.every_wall_s)),
    }
}

/// One attempt at a run: from its start, or from a checkpoint.
struct Attempt<'a> {
    job: &'a Job,
    from: Option<&'a RunCheckpoint>,
    number: usize,
    recording: Option<&'a RecordingWriter>,
    trace: Option<&'a Trace>,
}

/// A run that has ended, its solvers still there.
struct Made {
    ending: Ending,
    solvers: Solvers,
    outputs: Writer,
    facts: Vec<header::Fact>,
}

impl Attempt<'_> {
    async fn make(
        &self,
        keeper: &mut Keeper,
        wishes: &mut mpsc::Receiver<StopWish>,
    ) -> Result<Made, Failure> {
        let Job { case, directory, options, .. } = self.job;
        let (mut solvers, mut participants) = self.start().await?;
        let facts = header::facts(case, solvers.remote());
        if !options.quiet && self.number == 0 {
            header::print_start(&facts, &case.summary().warnings);
        }
        let roles = participants.roles();
        let mut setup = case.run_setup();
        if let (Some(coupling), Some(kind)) = (&mut setup.coupling, solvers.coupling_kind()) {
            coupling.kind = kind;
        }
        let progress = Progress::new(setup.time, options.quiet);
        let (recorder, resumed) = match self.from {
            Some(checkpoint) => {
                if let Err(failure) = self.take_over(checkpoint, keeper.store()) {
                    drop(participants);
                    solvers.end().await;
                    return Err(failure);
                }
                keeper.resume(checkpoint);
                let state = &checkpoint.outputs.recorder;
                let resumed = Resumed { step: checkpoint.step, impulse: state.impulse };
                let changed = self.job.changed();
                (Recorder::resume(directory, case, &roles, progress, state, changed)?, Some(resumed))
            }
            None => (Recorder::create(directory, case, &roles, progress)?, None),
        };
        let outputs = Writer::start(recorder, case.disk_deadline())?;
        let pace = Pace { window: options.window, step_deadline: case.step_deadline() };
        let driven = control::drive(&mut participants, &setup, pace, resumed, &outputs, keeper, wishes).await;
        drop(participants);
        match driven {
            Ok(ending) => Ok(Made { ending, solvers, outputs, facts }),
            Err(failure) => {
                solvers.end().await;
                // The cause is told; what the tables hold stays under their partial names.
                drop(outputs.finish().await);
                Err(failure)
            }
        }
    }

    async fn start(&self) -> Result<(Solvers, Participants), Failure> {
        let Job { case, directory, options, .. } = self.job;
        let threads = Threads::of(case, options.threads);
        if options.in_process {
            let (events, received) = mpsc::channel::<(Role, NewsResult)>(PENDING_EVENTS);
            let from = self.from;
            let solvers = in_process::start(case.fluid_setup(), case.solid_setup(), threads, from, &events)?;
            let lines = solvers.iter().map(|t| (t.role, CommandLine::Thread(t.commands.clone()))).collect();
            return Ok((Solvers::Threads(solvers), Participants::new(lines, received, events, true)));
        }
        let logs = directory.file(names::LOGS);
        std::fs::create_dir_all(&logs)
            .map_err(|e| Failure::output(format!("cannot create `{}`: {e}", logs.display())))?;
        let mut plans = Vec::new();
        let runs = |role| self.job.alone.as_ref().is_none_or(|(alone, _)| *alone == role);
        if let Some(setup) = case.fluid_setup().filter(|_| runs(Role::Fluid)) {
            let source = options.fluid_source().unwrap_or_else(|| source_of(&case.servers.fluid));
            plans.push(Plan { setup: ParticipantSetup::Fluid(setup), source });
        }
        if let Some(setup) = case.solid_setup().filter(|_| runs(Role::Solid)) {
            let source = options.solid_source().unwrap_or_else(|| source_of(&case.servers.solid));
            plans.push(Plan { setup: ParticipantSetup::Solid(setup), source });
        }
        let mut deadlines = case.deadlines();
        if let Some(silence) = options.silence {
            deadlines.silence = Duration::from_secs_f64(silence);
        }
        let accept_other_build = self.job.resume.as_ref().is_some_and(|resume| resume.accept_other_build);
        // Attempts are limited to some thousand.
        let epoch = u32::try_from(self.number + 1).unwrap_or(u32::MAX);
        let resume = self.from.map(|checkpoint| Resume { checkpoint, epoch, accept_other_build });
        let kinds = case.coupling_kinds();
        let security = options.security.over(&case.servers.files);
        let (between, kinds) = self.between(kinds)?;
        let with = Start {
            kinds: &kinds,
            threads,
            logs: &logs,
            deadlines,
            security: &security,
            resume,
            attempt: self.number,
            between,
            trace: self.trace.map(Trace::folder),
        };
        let mut remote = Remote::start(plans, with).await?;
        match remote.run().await {
            Ok(participants) => Ok((Solvers::Servers(remote), participants)),
            Err(failure) => {
                remote.end().await;
                Err(failure)
            }
        }
    }
}

fn source_of(server: &case::Server) -> Source {
    match server {
        case::Server::BuiltIn => Source::Own,
        case::Server::Address(address) => Source::Address(address.clone()),
        case::Server::Command(words) => Source::Program(words.clone()),
    }
}

impl Solvers {
    fn remote(&self) -> Option<&Remote> {
        match self {
            Solvers::Threads(_) => None,
            Solvers::Servers(remote) => Some(remote),
        }
    }

    fn remote_mut(&mut self) -> Option<&mut Remote> {
        match self {
            Solvers::Threads(_) => None,
            Solvers::Servers(remote) => Some(remote),
        }
    }

    /// The kind of coupling that the servers agreed on.
    fn coupling_kind(&self) -> Option<CouplingKind> {
        self.remote().and_then(|remote| remote.servers.first()).map(|server| server.report.coupling_kind)
    }

    /// Where the solver of `role` ran and what it used; taken before it ends.
    fn participant(&self, role: Role) -> Participant {
        let server = self.remote().and_then(|r| r.servers.iter().find(|server| server.report.role == role));
        match server {
            Some(server) => Participant {
                solver: format!("{} {}", server.report.name, server.report.version),
                address: server.address().to_owned(),
                process: server.process(),
                ..Participant::default()
            },
            None => Participant {
                solver: format!("{role}-server {}", env!("CARGO_PKG_VERSION")),
                address: "in-process".into(),
                ..Participant::default()
            },
        }
    }

    async fn end(&mut self) {
        match std::mem::replace(self, Solvers::Threads(Vec::new())) {
            Solvers::Threads(threads) => threads.into_iter().for_each(ThreadParticipant::join),
            Solvers::Servers(remote) => remote.end().await,
        }
    }

    /// Ends the solvers though one of them may be frozen.
    async fn kill(self) {
        match self {
            // A thread that hangs cannot be ended.
            Solvers::Threads(_) => {}
            Solvers::Servers(remote) => remote.kill().await,
        }
    }

    /// Whether this program can start those of `roles` again.
    fn may_restart(&self, roles: &[Role]) -> bool {
        self.remote().is_some_and(|remote| {
            remote.servers.iter().all(|s| !roles.contains(&s.report.role) || s.is_child())
        })
    }
}

/// The first request to end stops the run at a step boundary, the second one at once.
fn watch_signals() -> Result<mpsc::Receiver<StopWish>, Failure> {
    let mut signals =
        StopSignals::listen().map_err(|e| Failure::internal(format!("cannot watch for signals: {e}")))?;
    let (sender, wishes) = mpsc::channel(4);
    tokio::spawn(async move {
        for wish in [StopWish::AtBoundary, StopWish::Now] {
            signals.next().await;
            if sender.send(wish).await.is_err() {
                return;
            }
            if wish == StopWish::AtBoundary {
                terminal::note(format_args!(
                    "\nstopping at the next step boundary; a second signal gives up at once"
                ));
            }
        }
    });
    Ok(wishes)
}
