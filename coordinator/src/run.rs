//! `coordinator run`: from a case file to results.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

use sha2::{Digest, Sha256};
use sph::setup::{CouplingKind, ParticipantSetup};
use sph::solver::Role;
use tokio::sync::mpsc;

use crate::case::{self, Case};
use crate::cli::RunArguments;
use crate::control::{self, Ending, StopWish};
use crate::failure::Failure;
use crate::header;
use crate::in_process::{self, ThreadParticipant};
use crate::launch::Source;
use crate::output::directory::{self, Existing, OutputDirectory, write_file};
use crate::output::process::Process;
use crate::output::report::{self, ReportData};
use crate::output::state;
use crate::output::summary::{self, LedgerSummary, Participant, Span, Summary, Verdict};
use crate::output::table::Table;
use crate::participants::{CommandLine, EventResult, Participants};
use crate::progress::Progress;
use crate::recorder::{Recorded, Recorder};
use crate::remote::{Plan, Remote};

/// Events that may wait for the coordinator when solvers are threads.
const PENDING_EVENTS: usize = 256;
/// Folder of server logs within the results.
const LOGS: &str = "logs";

/// Runs a case as the command line says.
///
/// # Errors
/// When the case is wrong, a server is not to be had, an output cannot be written, or the run ends out of order; what
/// was computed until then is written in every case.
pub fn run(arguments: &RunArguments) -> Result<(), Failure> {
    let case = load(&arguments.case)?;
    let out = arguments.out.clone().unwrap_or_else(|| default_folder(&arguments.case));
    let existing = if arguments.force { Existing::Replace } else { Existing::Refuse };
    let directory = OutputDirectory::create(&out, existing)?;
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(|e| Failure::internal(format!("cannot start the runtime: {e}")))?;
    let outcome = runtime.block_on(run_in(arguments, &case, &directory));
    // Blocking readers of a child's output may linger; nothing waits for them.
    runtime.shutdown_background();
    let ending = outcome?;
    directory.complete()?;
    if !arguments.quiet {
        eprintln!("results in {}", out.display());
    }
    match ending {
        Ending::Completed => Ok(()),
        Ending::Stopped => Err(Failure::new(
            crate::failure::Kind::Stopped,
            format!(
                "stopped from outside before the end time; results up to there are complete in {}",
                out.display()
            ),
        )),
        Ending::Failed(failure) => Err(failure),
    }
}

/// Reads and checks a case file.
///
/// # Errors
/// All mistakes of the file.
pub fn load(path: &Path) -> Result<Case, Failure> {
    case::load(path, &state::read).map_err(|errors| Failure::input(errors.to_string()))
}

fn default_folder(case: &Path) -> PathBuf {
    Path::new("results").join(case.file_stem().unwrap_or(case.as_os_str()))
}

/// The solvers of a run, wherever they are.
enum Solvers {
    Threads(Vec<ThreadParticipant>),
    Servers(Remote),
}

async fn run_in(
    arguments: &RunArguments,
    case: &Case,
    directory: &OutputDirectory,
) -> Result<Ending, Failure> {
    let resolved = case.resolved_toml();
    write_file(&directory.file(directory::CASE), |file| {
        std::io::Write::write_all(file, resolved.as_bytes())
    })?;
    let mut wishes = watch_signals()?;
    let (mut solvers, mut participants) = start(arguments, case, directory).await?;
    let facts = header::facts(case, solvers.remote());
    if !arguments.quiet {
        header::print_start(&facts, &case.summary().warnings);
    }
    let roles = participants.roles();
    let mut setup = case.run_setup();
    if let (Some(coupling), Some(kind)) = (&mut setup.coupling, solvers.coupling_kind()) {
        coupling.kind = kind;
    }
    let progress = Progress::new(setup.time, arguments.quiet);
    let mut recorder = Recorder::create(directory, case, &roles, progress)?;
    let started = Instant::now();
    let ending =
        control::drive(&mut participants, &setup, arguments.window, &mut recorder, &mut wishes).await;
    let wall_seconds = started.elapsed().as_secs_f64();
    let sides = roles.iter().map(|role| (*role, solvers.participant(*role))).collect();
    drop(participants);
    solvers.end().await;
    let recorded = recorder.finish()?;
    let ending = ending?;
    let summary = summarise(case, &resolved, &ending, wall_seconds, &recorded, sides, arguments.in_process);
    summary.write(&directory.file(directory::SUMMARY))?;
    let data = ReportData {
        title: case.name.clone(),
        verdict: summary.verdict.to_string(),
        reason: summary.reason.clone(),
        facts: header::results(&summary),
        negotiated: facts,
        warnings: summary.warnings.clone(),
        snapshots: recorded.snapshots,
        walls: case
            .fluid_setup()
            .iter()
            .flat_map(|fluid| &fluid.walls)
            .map(|wall| wall.name.clone())
            .collect(),
        tolerance: setup.coupling.map(|_| setup.ledger.balance_tolerance),
        probes: Table::read(&directory.file(directory::PROBES))?,
        ledger: Table::read(&directory.file(directory::LEDGER))?,
    };
    report::write(&directory.file(directory::REPORT), &data)?;
    if !arguments.quiet {
        header::print_results(&summary);
    }
    Ok(ending)
}

async fn start(
    arguments: &RunArguments,
    case: &Case,
    directory: &OutputDirectory,
) -> Result<(Solvers, Participants), Failure> {
    let threads = arguments.threads.map(usize::from);
    if arguments.in_process {
        let (events, received) = mpsc::channel::<(Role, EventResult)>(PENDING_EVENTS);
        let threads = in_process::start(case.fluid_setup(), case.solid_setup(), threads, &events)?;
        let lines = threads.iter().map(|t| (t.role, CommandLine::Thread(t.commands.clone()))).collect();
        return Ok((Solvers::Threads(threads), Participants::new(lines, received)));
    }
    let logs = directory.file(LOGS);
    std::fs::create_dir_all(&logs)
        .map_err(|e| Failure::output(format!("cannot create `{}`: {e}", logs.display())))?;
    let mut plans = Vec::new();
    if let Some(setup) = case.fluid_setup() {
        let source = arguments.fluid_source().unwrap_or_else(|| source_of(&case.servers.fluid));
        plans.push(Plan { setup: ParticipantSetup::Fluid(setup), source });
    }
    if let Some(setup) = case.solid_setup() {
        let source = arguments.solid_source().unwrap_or_else(|| source_of(&case.servers.solid));
        plans.push(Plan { setup: ParticipantSetup::Solid(setup), source });
    }
    let mut remote = Remote::start(plans, &case.coupling_kinds(), threads, &logs).await?;
    match remote.run().await {
        Ok(participants) => Ok((Solvers::Servers(remote), participants)),
        Err(failure) => {
            remote.end().await;
            Err(failure)
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
}

/// Ctrl-C or SIGTERM stop the run at a step boundary, a second one at once.
fn watch_signals() -> Result<mpsc::Receiver<StopWish>, Failure> {
    use tokio::signal::unix::{SignalKind, signal};
    let failed = |e| Failure::internal(format!("cannot watch for signals: {e}"));
    let mut interrupt = signal(SignalKind::interrupt()).map_err(failed)?;
    let mut terminate = signal(SignalKind::terminate()).map_err(failed)?;
    let (sender, wishes) = mpsc::channel(4);
    tokio::spawn(async move {
        for wish in [StopWish::AtBoundary, StopWish::Now] {
            tokio::select! {
                _ = interrupt.recv() => {}
                _ = terminate.recv() => {}
            }
            if sender.send(wish).await.is_err() {
                return;
            }
            if wish == StopWish::AtBoundary {
                eprintln!("\nstopping at the next step boundary; a second signal gives up at once");
            }
        }
    });
    Ok(wishes)
}

fn summarise(
    case: &Case,
    resolved: &str,
    ending: &Ending,
    wall_seconds: f64,
    recorded: &Recorded,
    sides: Vec<(Role, Participant)>,
    in_process: bool,
) -> Summary {
    let tally = &recorded.tally;
    let (verdict, reason) = match ending {
        Ending::Completed => (Verdict::Completed, "the end time was reached".to_owned()),
        Ending::Stopped => (Verdict::Stopped, "stopped from outside at a step boundary".to_owned()),
        Ending::Failed(failure) => (Verdict::Failed, failure.message.clone()),
    };
    let mut participants = [None, None];
    for (role, mut participant) in sides {
        let side = &tally.sides[role.index()];
        participant.counts = side.counts;
        participant.state_digest.clone_from(&side.state_digest);
        participant.set_waits(side.step_seconds, side.waited_seconds);
        participants[role.index()] = Some(participant);
    }
    let particles: u64 = tally.sides.iter().map(|side| side.counts.particles).sum();
    let [fluid, solid] = participants;
    let start_s = case.run_setup().time.start_time;
    Summary {
        format: summary::FORMAT,
        case: case.name.clone(),
        run_id: case.run_setup().run_id,
        verdict,
        reason,
        steps: tally.steps,
        simulated: Span { start_s, end_s: tally.time },
        wall_seconds,
        time_step: tally.step_sizes,
        // Counts far below 2^53.
        particle_stages_per_second: (tally.steps > 0 && wall_seconds > 0.0)
            .then(|| 2.0 * (tally.steps * particles) as f64 / wall_seconds),
        ledger: LedgerSummary::new(tally.breaches, tally.first_breaches.clone(), &recorded.extremes),
        fluid,
        solid,
        coordinator: Process::own(),
        in_process,
        case_digest: digest(resolved),
        versions: BTreeMap::from([
            ("coordinator".to_owned(), env!("CARGO_PKG_VERSION").to_owned()),
            ("protocol".to_owned(), proto::description::PROTOCOL.to_string()),
        ]),
        warnings: case.summary().warnings,
    }
}

fn digest(text: &str) -> String {
    Sha256::digest(text.as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect()
}
