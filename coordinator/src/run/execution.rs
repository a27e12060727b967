//! Executes a run: attempts until it has ended, outputs, restarts of lost servers.

use std::time::Duration;

use proto::recording::RecordingWriter;
use proto::recording::player::Replayed;
use sph::coupling::solver::Role;

use super::attempt::Attempt;
use super::checkpoint_scheduler::{CaseFacts, CheckpointScheduler, Schedule};
use super::completion;
use super::control::ending::Ending;
use super::job::Job;
use super::losses::Losses;
use super::outcome::RunOutcome;
use super::page::RunPage;
use super::participants::hints;
use super::participants::remote::Remote;
use super::request::{OnReservations, RunOptions};
use super::signals::watch_signals;
use super::trace::Trace;
use crate::case::Case;
use crate::checkpoint::Store;
use crate::failure::{Failure, Kind};
use crate::results::names;
use crate::results::summary::Summary;

/// A run that has ended, its results written.
struct EndedRun {
    ending: Ending,
    summary: Summary,
    replayed: Option<Replayed>,
}

/// Executes a run.
///
/// # Errors
/// As [`super::run`].
pub(crate) fn execute(job: &Job) -> Result<RunOutcome, Failure> {
    let out = job.directory.path();
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(|e| Failure::internal(format!("cannot start the runtime: {e}")))?;
    let trace = job.options.trace.as_deref().map(Trace::start).transpose()?;
    let page = job.options.view.then(|| RunPage::start(job)).transpose()?;
    let ended = runtime.block_on(run_recorded(job, trace.as_ref(), page.as_ref()));
    if let Some(page) = page {
        page.end(ended.as_ref().map(|ended| &ended.ending));
    }
    // Blocking readers of a child's output may linger; nothing waits for them.
    runtime.shutdown_background();
    let traced = trace.map_or(Ok(()), Trace::finish);
    let EndedRun { ending, summary, replayed } = ended.map_err(|failure| with_resume_hint(failure, job))?;
    job.directory.complete()?;
    job.options.messages.progress(format_args!("results in {}", out.display()));
    let failure = match ending {
        Ending::Completed => reserved(job, &summary),
        Ending::Stopped => {
            let text = "stopped from outside before the end time at a step boundary; results up to there are complete in";
            Some(Failure::new(Kind::Stopped, format!("{text} {}", out.display())))
        }
        Ending::Failed(failure) | Ending::Lost { failure, .. } => Some(failure),
    };
    let failure = match (failure, traced) {
        (Some(failure), traced) => {
            if let Err(problem) = traced {
                job.options.messages.notice(format_args!("{problem}"));
            }
            Some(with_resume_hint(failure, job))
        }
        (None, traced) => {
            traced?;
            None
        }
    };
    Ok(RunOutcome { directory: out.to_owned(), summary, failure, replayed })
}

/// The failure of a run that reached its end with reservations, where these fail it.
fn reserved(job: &Job, summary: &Summary) -> Option<Failure> {
    let fails = job.options.reservations == OnReservations::Fail && !summary.reservations.is_empty();
    let list = summary.reservations.join("\n  ");
    fails.then(|| {
        Failure::new(
            Kind::Reserved,
            format!("completed, with reservations; the results are complete\n  {list}"),
        )
    })
}

/// Adds the command that continues the run, where there is a checkpoint and to continue may help.
fn with_resume_hint(mut failure: Failure, job: &Job) -> Failure {
    // What was refused before anything was changed would be refused again.
    let helps = job.directory.is_changed()
        && matches!(failure.kind, Kind::Lost | Kind::Stopped | Kind::Output | Kind::Ledger | Kind::Server);
    let store = Store::new(job.directory.file(names::CHECKPOINTS));
    if helps && store.newest().checkpoint.is_some() {
        let command = hints::resume_command(job.directory.path());
        failure.message.push_str(&format!("\ncontinue from the last checkpoint with `{command}`"));
    }
    failure
}

async fn run_recorded(job: &Job, trace: Option<&Trace>, page: Option<&RunPage>) -> Result<EndedRun, Failure> {
    let relay = job.options.servers().and_then(|servers| servers.relay.as_ref());
    let recording = match relay.and_then(|relay| relay.record.as_ref()) {
        Some(path) if job.case.run_plan().coupling.is_some() => Some(RecordingWriter::create(path)?),
        Some(_) => {
            return Err(Failure::input("`--record`: the case has one side only, whose run has no frames"));
        }
        None => None,
    };
    let ended = make_attempts(job, recording.as_ref(), trace, page).await;
    if let Some(recording) = recording {
        let path = recording.path().to_owned();
        let frames = recording.finish().await;
        match (&ended, frames) {
            (Ok(_), frames) => job.options.messages.progress(format_args!("{} frames recorded", frames?)),
            // A run that was refused leaves nothing behind; that it was matters more than a file that remains.
            (Err(_), Ok(0)) => drop(std::fs::remove_file(path)),
            // A run that failed says why first.
            (Err(_), _) => {}
        }
    }
    ended
}

async fn make_attempts(
    job: &Job,
    recording: Option<&RecordingWriter>,
    trace: Option<&Trace>,
    page: Option<&RunPage>,
) -> Result<EndedRun, Failure> {
    let Job { case, directory, options, .. } = job;
    let resolved = case.resolved_toml();
    let (sender, mut requests) = watch_signals(options.messages)?;
    if let Some(page) = page {
        page.take_orders(sender);
    }
    let live = page.map(RunPage::live);
    let mut scheduler = CheckpointScheduler::new(
        directory.file(names::CHECKPOINTS),
        schedule(case, options),
        case.disk_deadline(),
        CaseFacts { identity: case.identity(), origin: job.origin_digests() },
    );
    let mut from = job.resume.as_ref().map(|resume| resume.checkpoint.clone());
    let mut restarts: Vec<String> = Vec::new();
    let mut losses = Losses::default();
    // A recording is no partner that could be started again.
    let most =
        if job.replay.is_some() { 0 } else { options.max_restarts.unwrap_or(case.checkpoint().max_restarts) };
    loop {
        let attempt = Attempt { job, from: from.as_ref(), number: restarts.len(), recording, trace, live };
        let mut ended = attempt.run(&mut scheduler, &mut requests).await?;
        let Some((roles, failure)) = ended.lost(&mut losses, most).await else {
            if let Some(live) = live {
                live.doing("writing summary and report");
            }
            let replayed = ended.solvers.remote().and_then(Remote::replayed);
            let (ending, summary) = completion::finish(job, &resolved, ended, &scheduler, restarts).await?;
            return Ok(EndedRun { ending, summary, replayed });
        };
        let lost = roles.iter().map(Role::to_string).collect::<Vec<_>>().join(" and ");
        let lost = if lost.is_empty() { "the connection".to_owned() } else { format!("the {lost} solver") };
        ended.solvers.kill().await;
        // What is still queued belongs before what the next attempt cuts back.
        ended.outputs.close().await?;
        from = scheduler.store().newest().checkpoint;
        let step = from.as_ref().map_or(0, |checkpoint| checkpoint.step);
        let text = format!("{}\nrestarting {lost}, to continue from step {step}", failure.message);
        options.messages.notice(format_args!("{text}, restart {} of {most}", restarts.len() + 1));
        restarts.push(text);
    }
}

fn schedule(case: &Case, options: &RunOptions) -> Schedule {
    let table = case.checkpoint();
    let every_wall = options.checkpoint_every_wall;
    Schedule {
        every_steps: options.checkpoint_every_steps.or(table.every_steps),
        every_wall: every_wall.unwrap_or_else(|| Duration::from_secs_f64(table.every_wall_s)),
    }
}
