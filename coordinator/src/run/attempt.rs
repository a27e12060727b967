//! One attempt at a run: from its start or a checkpoint to its end.

use std::sync::Arc;

use proto::recording::RecordingWriter;
use sph::coupling::solver::Role;
use sph::setup::ParticipantSetup;
use tokio::sync::mpsc;

use super::checkpoint_scheduler::CheckpointScheduler;
use super::control::ending::Ending;
use super::control::{self, Pace, ResumedAt};
use super::header;
use super::job::Job;
use super::participants::in_process::{self, ThreadParticipant};
use super::participants::launch::Source;
use super::participants::remote::{Plan, Remote, Start};
use super::participants::restore::Restore;
use super::participants::threads::Threads;
use super::participants::{CommandChannel, NewsResult, Participants};
use super::signals::OutsideRequest;
use super::solvers::Solvers;
use super::trace::Trace;
use crate::brief::Layout;
use crate::case;
use crate::checkpoint::RunCheckpoint;
use crate::failure::Failure;
use crate::page::live::Live;
use crate::results::names;
use crate::results::progress::Progress;
use crate::results::recorder::Recorder;
use crate::results::writer::Writer;

/// Events that may wait for the coordinator when solvers are threads.
const PENDING_EVENTS: usize = 256;

/// One attempt at a run: from its start, or from a checkpoint.
pub(super) struct Attempt<'a> {
    pub job: &'a Job,
    /// Where it starts, unless with the case.
    pub from: Option<&'a RunCheckpoint>,
    /// Counts the attempts from 0.
    pub number: usize,
    /// Where frames are recorded.
    pub recording: Option<&'a RecordingWriter>,
    /// Trace of all processes.
    pub trace: Option<&'a Trace>,
    /// What the page of the run reads.
    pub live: Option<&'a Arc<Live>>,
}

/// An attempt that has ended, its solvers still there.
pub(super) struct EndedAttempt {
    pub ending: Ending,
    pub solvers: Solvers,
    pub outputs: Writer,
    /// What decides the results, in words.
    pub facts: Vec<header::Fact>,
}

impl Attempt<'_> {
    /// Starts the solvers and drives them to the end.
    ///
    /// # Errors
    /// When they cannot be started, or an output cannot be written.
    pub(super) async fn run(
        &self,
        scheduler: &mut CheckpointScheduler,
        requests: &mut mpsc::Receiver<OutsideRequest>,
    ) -> Result<EndedAttempt, Failure> {
        let Job { case, directory, options, .. } = self.job;
        let (mut solvers, mut participants) = self.start().await?;
        let facts = header::facts(case, solvers.remote());
        if self.number == 0 {
            header::print_start(&facts, case, solvers.remote(), directory.path(), options.messages);
            for remark in solvers.remarks() {
                options.messages.progress(Layout::of_errors().warning(remark));
            }
        }
        let roles = participants.roles();
        let mut setup = case.run_plan();
        if let (Some(coupling), Some(kind)) = (&mut setup.coupling, solvers.coupling_kind()) {
            coupling.kind = kind;
        }
        if let Some(live) = self.live {
            live.agreed(&facts, header::step_limits(case));
        }
        let progress = Progress::new(case, options.messages).with_live(self.live.cloned());
        let taken = match self.from {
            Some(checkpoint) => self.take_over(checkpoint, scheduler.store()),
            None => self.begin(),
        };
        if let Err(failure) = taken {
            drop(participants);
            solvers.end().await;
            return Err(failure);
        }
        let (recorder, resumed) = match self.from {
            Some(checkpoint) => {
                scheduler.resume(checkpoint);
                let state = &checkpoint.outputs.recorder;
                let resumed = ResumedAt { step: checkpoint.step, impulse: state.impulse };
                let changed = self.job.changed();
                (Recorder::resume(directory, case, &roles, progress, state, changed)?, Some(resumed))
            }
            None => (Recorder::create(directory, case, &roles, progress)?, None),
        };
        let outputs = Writer::start(recorder, case.disk_deadline())?;
        let pace = Pace { window: options.window, step_deadline: case.step_deadline() };
        let driven =
            control::drive(&mut participants, &setup, pace, resumed, &outputs, scheduler, requests).await;
        drop(participants);
        match driven {
            Ok(ending) => Ok(EndedAttempt { ending, solvers, outputs, facts }),
            Err(failure) => {
                solvers.end().await;
                // The cause is returned; what the tables hold stays under their partial names.
                drop(outputs.finish().await);
                Err(failure)
            }
        }
    }

    /// Holds the step of the case against the limit that a solver states. A run that continues may be past its start.
    fn check_limit(&self, role: Role, limit: f64) -> Result<(), Failure> {
        if self.from.is_some() { Ok(()) } else { self.job.case.check_stated_limit(role, limit) }
    }

    async fn start(&self) -> Result<(Solvers, Participants), Failure> {
        let Job { case, directory, options, .. } = self.job;
        let threads = Threads::of(case, options.threads);
        let Some(servers) = options.servers() else {
            let (events, received) = mpsc::channel::<(Role, NewsResult)>(PENDING_EVENTS);
            let from = self.from;
            let solvers = in_process::start(case.fluid_setup(), case.solid_setup(), threads, from, &events)?;
            let checked = solvers.iter().try_for_each(|t| self.check_limit(t.role, t.time_step_limit));
            if let Err(failure) = checked {
                solvers.into_iter().for_each(ThreadParticipant::join);
                return Err(failure);
            }
            let lines =
                solvers.iter().map(|t| (t.role, CommandChannel::Thread(t.commands.clone()))).collect();
            return Ok((Solvers::Threads(solvers), Participants::new(lines, received, events, true)));
        };
        let logs = directory.file(names::LOGS);
        std::fs::create_dir_all(&logs)
            .map_err(|e| Failure::output(format!("cannot create `{}`: {e}", logs.display())))?;
        let mut plans = Vec::new();
        if let Some(setup) = case.fluid_setup().filter(|_| self.job.runs(Role::Fluid)) {
            let source = servers.fluid.clone().unwrap_or_else(|| source_of(&case.servers.fluid));
            plans.push(Plan { setup: ParticipantSetup::Fluid(setup), source });
        }
        if let Some(setup) = case.solid_setup().filter(|_| self.job.runs(Role::Solid)) {
            let source = servers.solid.clone().unwrap_or_else(|| source_of(&case.servers.solid));
            plans.push(Plan { setup: ParticipantSetup::Solid(setup), source });
        }
        let mut deadlines = case.deadlines();
        deadlines.silence = servers.silence.unwrap_or(deadlines.silence);
        let accept_other_build = self.job.resume.as_ref().is_some_and(|resume| resume.accept_other_build);
        // Attempts are limited to some thousand.
        let epoch = u32::try_from(self.number + 1).unwrap_or(u32::MAX);
        let restore = self.from.map(|checkpoint| Restore { checkpoint, epoch, accept_other_build });
        let kinds = case.coupling_kinds();
        let security = servers.files(&case.servers.files);
        let (frame_path, kinds) = self.frame_path(servers, kinds)?;
        let with = Start {
            kinds: &kinds,
            threads,
            logs: &logs,
            deadlines,
            security: &security,
            restore,
            attempt: self.number,
            frame_path,
            trace: self.trace.map(Trace::folder),
            messages: options.messages,
        };
        let mut remote = Remote::start(plans, with).await?;
        let mut reports = remote.servers.iter().map(|server| &server.report);
        let checked = reports.try_for_each(|report| self.check_limit(report.role, report.time_step_limit));
        if let Err(failure) = checked {
            remote.end().await;
            return Err(failure);
        }
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
