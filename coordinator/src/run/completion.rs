//! What is written when a run has ended: summary and report.

use std::collections::BTreeMap;

use sha2::{Digest, Sha256};
use sph::coupling::driver::TRACE;
use sph::coupling::solver::Role;
use terminal::program;
use tracing::trace_span;

use super::attempt::EndedAttempt;
use super::checkpoint_scheduler::CheckpointScheduler;
use super::control::ending::Ending;
use super::header::{self, Fact};
use super::job::Job;
use super::participants::hints;
use crate::case::Case;
use crate::failure::Failure;
use crate::page::film::Film;
use crate::page::folder::{CaseFacts, Snapshots};
use crate::page::run::{FactTable, RunPage, Sources};
use crate::results::energy::{EnergySummary, SideEnergy};
use crate::results::names;
use crate::results::plots::gallery::PairedSnapshot;
use crate::results::process::Process;
use crate::results::quality::{self, Evidence, Sampler};
use crate::results::recorder::Recorded;
use crate::results::report::{self, ReportData};
use crate::results::state;
use crate::results::summary::{self, Checkpoints, LedgerSummary, Participant, Span, Summary, Verdict};
use crate::results::table::Table;
use crate::results::tally::Iterations;

/// Completes the outputs of a run.
pub(super) async fn finish(
    job: &Job,
    resolved: &str,
    attempt: EndedAttempt,
    scheduler: &CheckpointScheduler,
    restarts: Vec<String>,
) -> Result<(Ending, Summary), Failure> {
    let Job { case, directory, options, .. } = job;
    let EndedAttempt { ending, mut solvers, outputs, facts } = attempt;
    let roles = [Role::Fluid, Role::Solid].into_iter().filter(|role| job.runs(*role));
    let sides: Vec<_> = roles.map(|role| (role, solvers.participant(role))).collect();
    let remarks = solvers.remarks();
    match ending {
        Ending::Lost { .. } => solvers.kill().await,
        _ => solvers.end().await,
    }
    let recorded = outputs.finish().await?;
    let mut summary = summarise(
        case,
        resolved,
        &ending,
        scheduler.wall_seconds(),
        &recorded,
        sides,
        options.servers().is_none(),
    );
    summary.checkpoints = scheduler.figures().clone();
    summary.restarts = restarts;
    summary.warnings.extend(remarks);
    summary.warnings.extend(recorded.warnings.iter().cloned());
    // As for the report: a fault here leaves the results as they are.
    match trace_span!(target: TRACE, "quality").in_scope(|| program::contain(|| quality(job, &recorded))) {
        Ok(evidence) => summary.quality = evidence.figures(),
        Err(panic) => summary.warnings.push(format!("the quality of the run was not judged: {panic}")),
    }
    summary.reservations = quality::reservations(&summary.quality);
    summary.write(&directory.file(names::SUMMARY))?;
    let report = || write_report(job, &summary, facts, recorded.snapshots);
    // The run has the exit code that it earned, whatever becomes of its pictures.
    let written = trace_span!(target: TRACE, "report")
        .in_scope(|| program::contain(report))
        .unwrap_or_else(|panic| Err(Failure::internal(panic)));
    if let Err(failure) = written {
        let path = directory.file(names::REPORT);
        options.messages.warning(format_args!("the run has no report: {}", failure.message));
        if matches!(ending, Ending::Completed) {
            let command = hints::resume_command(directory.path());
            options.messages.notice(format_args!(
                "all other results are complete; `{command}` makes `{}`",
                path.display()
            ));
        }
    }
    header::print_results(&summary, options.messages);
    Ok((ending, summary))
}

/// What the results say of the run's answer.
fn quality(job: &Job, recorded: &Recorded) -> Evidence {
    let Job { case, directory, .. } = job;
    let mut sampler = Sampler::new(case);
    let last = |role: Role| state::read(&directory.final_state(&role.to_string())).ok();
    // A side that was lost has no final state; one that was played has none of its own.
    let last = PairedSnapshot { time: f64::INFINITY, fluid: last(Role::Fluid), solid: last(Role::Solid) };
    let is_last =
        |pair: &&PairedSnapshot| pair.fluid.as_ref().map(|f| f.step) == last.fluid.as_ref().map(|f| f.step);
    for pair in recorded.snapshots.iter().filter(|pair| !is_last(pair)).chain([&last]) {
        if let Some(fluid) = &pair.fluid {
            sampler.take(fluid, pair.solid.as_ref());
        }
    }
    let escaped = recorded.tally.sides.iter().map(|side| side.counts.escaped).sum();
    let probes = Table::read(&directory.file(names::PROBES)).ok();
    // Of the worse side; what is no number is worse than any.
    let worst = |a: f64, b: f64| if a.total_cmp(&b).is_lt() { b } else { a };
    let energy_residual = recorded.energy.iter().filter_map(SideEnergy::residual_share).reduce(worst);
    let energy_gain = recorded.energy[Role::Solid.index()].gain_share();
    Evidence { energy_residual, energy_gain, ..sampler.finish(probes.as_ref(), escaped) }
}

/// Writes the report of a run whose tables and summary are complete.
fn write_report(
    job: &Job,
    summary: &Summary,
    facts: Vec<Fact>,
    snapshots: Vec<PairedSnapshot>,
) -> Result<(), Failure> {
    let Job { case, directory, .. } = job;
    let folder = directory.path();
    let facts_of_case = CaseFacts::of(&case.resolved_toml()).map_err(Failure::internal)?;
    // Snapshots that are not there any more take nothing else from the report.
    let (film, problem) = match Film::of(&facts_of_case, &Snapshots::list(folder, false)) {
        Ok(film) => (film, None),
        Err(why) => (None, Some(format!("the report has no film of the particles: {why}"))),
    };
    let value = serde_json::to_value(summary).map_err(|e| Failure::internal(e.to_string()))?;
    let sources = Sources {
        summary: Some(&value),
        probes: Table::read(&directory.file(names::PROBES))?,
        ledger: Table::read(&directory.file(names::LEDGER))?,
        extremes: film.as_ref().map_or(&[], |film| &film.extremes),
        tables: vec![
            FactTable { id: "facts", headline: "Run", rows: header::results(summary) },
            FactTable { id: "negotiated", headline: "Agreed before the run", rows: facts },
        ],
    };
    let mut page = RunPage::new(folder, &facts_of_case, sources);
    page.warnings.extend(problem);
    let data = ReportData {
        page: film.iter().fold(page, |page, film| page.with_film(film)),
        film,
        snapshots,
        walls: facts_of_case.walls,
        up_axis: facts_of_case.up_axis,
    };
    Ok(report::write(&directory.file(names::REPORT), &data)?)
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
        Ending::Failed(failure) | Ending::Lost { failure, .. } => (Verdict::Failed, failure.message.clone()),
    };
    let mut participants = [None, None];
    for (role, mut participant) in sides {
        let side = &tally.sides[role.index()];
        participant.set_counts(side.counts.clone());
        participant.state_digest.clone_from(&side.state_digest);
        participant.set_waits(side.step_seconds, side.waited_seconds);
        participants[role.index()] = Some(participant);
    }
    let particles: u64 = tally.sides.iter().map(|side| side.counts.particles).sum();
    let [fluid, solid] = participants;
    let start_s = case.run_plan().time.start_time;
    Summary {
        format: summary::FORMAT,
        case: case.name.clone(),
        run_id: case.run_plan().run_id,
        dimensions: case.dimensions(),
        verdict,
        reservations: Vec::new(),
        quality: Vec::new(),
        reason,
        steps: tally.steps,
        simulated: Span { start_s, end_s: tally.time },
        wall_seconds,
        time_step: tally.step_sizes,
        // Counts far below 2^53.
        particle_stages_per_second: (tally.steps > 0 && wall_seconds > 0.0)
            .then(|| 2.0 * (tally.steps * particles) as f64 / wall_seconds),
        energy: EnergySummary::new(&recorded.energy),
        ledger: LedgerSummary::new(
            tally.breaches,
            tally.first_breaches.clone(),
            &recorded.extremes,
            recorded.work,
        ),
        iterations: case.run_plan().coupling.and_then(|coupling| coupling.implicit).map(|_| {
            let Iterations { sum, largest, unconverged } = tally.iterations;
            let mean = (tally.steps > 0).then(|| sum as f64 / tally.steps as f64);
            summary::IterationSummary { mean, largest, unsettled_steps: unconverged }
        }),
        fluid,
        solid,
        coordinator: Process::own(),
        checkpoints: Checkpoints::default(),
        restarts: Vec::new(),
        in_process,
        case_digest: digest(resolved),
        set: case.overrides().to_vec(),
        parameters: case.parameters(),
        constants: case.fixed_constants().map(|c| (c.name.to_owned(), c.value)).collect(),
        versions: BTreeMap::from([
            ("coordinator".to_owned(), env!("CARGO_PKG_VERSION").to_owned()),
            ("protocol".to_owned(), proto::description::PROTOCOL.to_string()),
        ]),
        warnings: case.summary().warnings,
    }
}

pub(crate) fn digest(text: &str) -> String {
    proto::hex::hex(&Sha256::digest(text.as_bytes()))
}
