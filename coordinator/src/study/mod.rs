//! What accuracy costs. Cases with known answers are run over resolution, scheme and step; error
//! against CPU time shows which settings are worth their cost.
//!
//! A case is an entry of [`cases::ALL`]. A run that this build has finished is not repeated. The measures of error
//! are shared with the verification suite `validate`, which judges goals instead.

pub mod cases;
pub mod cost;
pub mod front;
pub mod order;
mod page;
mod picture;
pub mod references;
pub mod results;
pub mod runner;
pub mod series;
pub mod template;

use std::io::Write as _;
use std::path::{Path, PathBuf};

use proto::trace;

use self::cases::{ALL, Member, Study};
use self::cost::Totals;
use self::picture::Panel;
use self::results::{Measured, Results};
use crate::batch::member::made_by;
use crate::failure::{Failure, Kind};
use crate::family::convergence::order_of_errors;

use crate::results::files::write_file;
use crate::results::names;
use crate::results::plots::field;
use crate::run::RunOutcome;

/// File that marks a run as finished.
const MEASURED: &str = "measured.json";
/// Columns of `report.csv`.
const COLUMNS: [&str; 20] = [
    "case",
    "scheme",
    "step",
    "particle_spacing_m",
    "particles",
    "steps",
    "relative_error",
    "cpu_seconds",
    "cpu_over_fixed_kernel",
    "cpu_ns_per_particle_stage",
    "pareto_front",
    "observed_order",
    "process_cpu_seconds",
    "begin_stage_share",
    "own_sums_share",
    "cross_sums_share",
    "advance_share",
    "end_of_step_share",
    "rest_share",
    "flaw",
];

/// One run of a report.
pub struct Row {
    /// Place of its case in [`ALL`].
    pub study: usize,
    /// Scheme.
    pub scheme: &'static str,
    /// Step policy.
    pub step: &'static str,
    /// Spacing \[m\].
    pub spacing: f64,
    /// What was measured.
    pub measured: Measured,
    /// Whether no other run of the case is cheaper and better.
    pub on_front: bool,
    /// Order observed from the next coarser run of the same scheme and step.
    pub order: Option<f64>,
}

impl Row {
    /// Relative error; not a number where there is none.
    pub fn error(&self) -> f64 {
        self.measured.error.unwrap_or(f64::NAN)
    }
}

/// A study to be made.
#[derive(Clone, Debug, Default)]
pub struct StudyRequest {
    /// Cases to run; all when empty.
    pub cases: Vec<String>,
    /// Further resolutions, schemes, steps and cases.
    pub full: bool,
    /// Folder for the report and all runs.
    pub out: PathBuf,
    /// Repeat all runs; otherwise those that this build has finished in that folder are kept.
    pub fresh: bool,
}

/// What the study would run, in lines.
///
/// # Errors
/// When a case is not known.
pub fn list(request: &StudyRequest) -> Result<Vec<String>, Failure> {
    let members = members(request)?;
    let line = |member: &Member| {
        format!("  {:<16} {:<44} {:>8.1} s", ALL[member.study].name, member.label(), member.expected)
    };
    Ok(std::iter::once(forecast(&members)).chain(members.iter().map(line)).collect())
}

fn forecast(members: &[Member]) -> String {
    let expected: f64 = members.iter().map(|member| member.expected).sum();
    format!("{} runs, about {expected:.0} s of CPU time on one core", members.len())
}

/// Makes a study, calls `each` with a line about the whole and about each run, and writes the report.
///
/// # Errors
/// When a case is not known, a file cannot be written, or the study is stopped from outside; finished runs are kept.
pub fn report(request: &StudyRequest, each: impl Fn(&str)) -> Result<Vec<Row>, Failure> {
    let members = members(request)?;
    each(&forecast(&members));
    let totals = Totals::default();
    trace::record(totals.clone()).map_err(|e| Failure::internal(e.to_string()))?;
    let mut rows = Vec::new();
    let (mut spent, mut forecast) = (0.0, 0.0);
    for (k, member) in members.iter().enumerate() {
        let (measured, kept) = measured(member, request, &totals)?;
        if !kept {
            spent += measured.process_cpu_seconds;
            forecast += member.expected;
        }
        // From plus zero: the sum of nothing would be minus zero.
        let left = members[k + 1..].iter().fold(0.0, |sum, member| sum + member.expected);
        // Forecasts are from one machine; what was run here shows how this one compares.
        let left = if forecast > 0.0 { left * spent / forecast } else { left };
        let what = match (&measured.error, &measured.flaw) {
            (Some(error), _) => format!("error {:.3} %", 100.0 * error),
            (None, flaw) => flaw.clone().unwrap_or_default(),
        };
        let how = if kept { "kept" } else { "ran" };
        each(&format!(
            "[{}/{}] {} {} {}: {what}, {:.2} s CPU; about {left:.0} s left",
            k + 1,
            members.len(),
            how,
            ALL[member.study].name,
            member.label(),
            measured.cpu_seconds,
        ));
        let (study, scheme, step, spacing) = (member.study, member.scheme, member.step, member.spacing);
        rows.push(Row { study, scheme, step, spacing, measured, on_front: false, order: None });
    }
    judge(&mut rows);
    write(&request.out, &rows, request.full)?;
    Ok(rows)
}

fn members(request: &StudyRequest) -> Result<Vec<Member>, Failure> {
    let known = |name: &&String| ALL.iter().any(|study| study.name == **name);
    if let Some(unknown) = request.cases.iter().find(|name| !known(name)) {
        let names: Vec<&str> = ALL.iter().map(|study| study.name).collect();
        return Err(Failure::input(format!("no case `{unknown}`; there are {}", names.join(", "))));
    }
    let mut members = Vec::new();
    for (index, study) in ALL.iter().enumerate() {
        let named = request.cases.iter().any(|name| name == study.name);
        // Who asks for a case by name gets it: one that is for the full study only then in its whole extent.
        let full = request.full || named && !study.chosen(false);
        if named || request.cases.is_empty() && study.chosen(request.full) {
            let found = Study::members(index, full);
            members.extend(found.map_err(|e| Failure::internal(format!("case `{}`: {e}", study.name)))?);
        }
    }
    Ok(members)
}

/// Runs a member, or reads what it left; returns whether it was kept.
fn measured(member: &Member, request: &StudyRequest, totals: &Totals) -> Result<(Measured, bool), Failure> {
    let folder = request.out.join("runs").join(ALL[member.study].name).join(member.label());
    let (file, kept) = (folder.join("case.toml"), folder.join(MEASURED));
    let made_by = made_by();
    let same_case = std::fs::read_to_string(&file).is_ok_and(|before| before == member.text);
    if same_case && !request.fresh {
        let before =
            std::fs::read(&kept).ok().and_then(|bytes| serde_json::from_slice::<Measured>(&bytes).ok());
        if let Some(before) = before.filter(|before| before.made_by == made_by) {
            return Ok((before, true));
        }
    }
    std::fs::create_dir_all(&folder)
        .map_err(|e| Failure::output(format!("cannot create `{}`: {e}", folder.display())))?;
    if let Err(e) = std::fs::remove_file(&kept)
        && e.kind() != std::io::ErrorKind::NotFound
    {
        return Err(Failure::output(format!("cannot remove `{}`: {e}", kept.display())));
    }
    write_file(&file, |out| out.write_all(member.text.as_bytes()))?;
    let measured = make(member, &file, &folder.join("results"), made_by, totals)?;
    write_file(&kept, |out| serde_json::to_writer_pretty(out, &measured).map_err(std::io::Error::from))?;
    Ok((measured, false))
}

fn make(
    member: &Member,
    file: &Path,
    out: &Path,
    made_by: String,
    totals: &Totals,
) -> Result<Measured, Failure> {
    let kernel_seconds = cost::fixed_kernel();
    totals.take();
    let run = runner::run(file, out, Some(1));
    let (cpu_seconds, passes) = Measured::passes_of(&totals.take());
    let mut flaw = match run.outcome.and_then(RunOutcome::completed) {
        Ok(_) => None,
        Err(failure) if failure.kind == Kind::Diverged => Some(failure.message),
        Err(failure) => return Err(failure),
    };
    let summary = std::fs::read(out.join(names::SUMMARY)).ok();
    let summary: serde_json::Value =
        summary.and_then(|b| serde_json::from_slice(&b).ok()).unwrap_or_default();
    let count = |place: &str| summary.pointer(place).and_then(serde_json::Value::as_u64).unwrap_or_default();
    let mut error = None;
    if flaw.is_none() {
        match Results::read(out, member.spacing).and_then(|results| (ALL[member.study].error)(&results)) {
            Ok(found) => error = Some(found),
            Err(reason) => flaw = Some(reason),
        }
    }
    Ok(Measured {
        made_by,
        error,
        flaw,
        cpu_seconds,
        process_cpu_seconds: run.cpu_seconds,
        kernel_seconds,
        steps: count("/steps"),
        particles: count("/fluid/counts/particles") + count("/solid/counts/particles"),
        passes,
    })
}

/// Marks the fronts and finds the orders.
fn judge(rows: &mut [Row]) {
    for study in 0..ALL.len() {
        let places: Vec<usize> = (0..rows.len()).filter(|k| rows[*k].study == study).collect();
        let points: Vec<(f64, f64)> =
            places.iter().map(|k| (rows[*k].measured.cpu_seconds, rows[*k].error())).collect();
        for (place, on_front) in places.iter().zip(front::pareto(&points)) {
            rows[*place].on_front = on_front;
        }
    }
    for k in 1..rows.len() {
        let (coarse, fine) = (&rows[k - 1], &rows[k]);
        let alike = |row: &Row| (row.study, row.scheme, row.step);
        if alike(coarse) == alike(fine) {
            rows[k].order = order_of_errors((coarse.spacing, coarse.error()), (fine.spacing, fine.error()));
        }
    }
}

fn write(out: &Path, rows: &[Row], full: bool) -> Result<(), Failure> {
    let panels: Vec<(usize, Panel<'_>)> = (0..ALL.len())
        .filter(|study| rows.iter().any(|row| row.study == *study))
        .map(|study| (study, panel(study, rows)))
        .collect();
    let failed = |e: crate::results::plots::PlotError| Failure::output(e.to_string());
    let html = page::html(&panels, full).map_err(failed)?;
    write_file(&out.join(names::REPORT), |file| file.write_all(html.as_bytes()))?;
    write_file(&out.join("report.csv"), |file| file.write_all(csv(rows)?.as_slice()))?;
    let panels: Vec<Panel<'_>> = panels.into_iter().map(|(_, panel)| panel).collect();
    let (pixels, size) = picture::pixels(&panels).map_err(failed)?;
    let png = field::encode(&pixels, size).map_err(failed)?;
    write_file(&out.join("report.png"), |file| file.write_all(&png))?;
    Ok(())
}

fn panel(study: usize, rows: &[Row]) -> Panel<'_> {
    Panel {
        title: ALL[study].title,
        schemes: ALL[study].schemes().collect(),
        steps: Study::steps().collect(),
        rows: rows.iter().filter(|row| row.study == study).collect(),
    }
}

fn csv(rows: &[Row]) -> std::io::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(COLUMNS)?;
    for row in rows {
        let measured = &row.measured;
        let optional = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
        let share =
            |pass: &str| optional(measured.passes.get(pass).map(|seconds| seconds / measured.cpu_seconds));
        let mut cells = vec![
            ALL[row.study].name.to_owned(),
            row.scheme.to_owned(),
            row.step.to_owned(),
            row.spacing.to_string(),
            measured.particles.to_string(),
            measured.steps.to_string(),
            optional(measured.error),
            measured.cpu_seconds.to_string(),
            (measured.cpu_seconds / measured.kernel_seconds).to_string(),
            (1e9 * measured.per_particle_stage()).to_string(),
            if row.on_front { "yes" } else { "no" }.to_owned(),
            optional(row.order),
            measured.process_cpu_seconds.to_string(),
        ];
        cells.extend(cost::PASSES.iter().map(|pass| share(pass)));
        cells.push(share(results::REST));
        cells.push(measured.flaw.clone().unwrap_or_default());
        writer.write_record(&cells)?;
    }
    writer.into_inner().map_err(|e| e.into_error())
}

#[cfg(test)]
mod tests;
