//! The pages of a convergence study and of an ensemble.

use std::io::Write as _;
use std::path::PathBuf;

use super::by_probe::Group;
use super::verdict::{Verdict, sentence};
use super::{Family, FigureResult};
use crate::failure::Failure;
use crate::overlay::page::{Summing, page, section, short, wide_table};
use crate::overlay::{Overlay, Run};
use crate::results::files::write_file;
use crate::results::plots::PlotError;
use crate::results::report::page::escaped;

/// Name of the page of a convergence study.
const CONVERGENCE: &str = "convergence.html";
/// Name of the page of an ensemble.
const ENSEMBLE: &str = "ensemble.html";

/// Most runs whose histories are drawn; more lines look alike.
const MOST_DRAWN: usize = 24;

/// Heads of the table of a convergence study for spacings \[m\].
pub fn convergence_heads(spacings: &[f64]) -> Vec<String> {
    let mut heads = vec!["key figure".to_owned()];
    heads.extend(spacings.iter().map(|spacing| format!("{spacing} m")));
    heads.extend(["order", "estimated error", "verdict"].map(str::to_owned));
    heads
}

/// A row of the table of a convergence study.
pub fn convergence_row(verdict: &Verdict) -> Vec<String> {
    let mut row = vec![verdict.figure.clone()];
    row.extend(verdict.over_spacing.iter().map(|value| value.map_or("-".to_owned(), short)));
    row.push(verdict.order.map_or("-".to_owned(), |order| format!("{order:.2}")));
    row.push(match (verdict.error_over_value(), verdict.error) {
        (Some(share), _) => format!("{:.1} %", 100.0 * share),
        (None, Some(error)) => short(error),
        (None, None) => "unknown".to_owned(),
    });
    row.push(if verdict.converged { "converged".to_owned() } else { verdict.reason.clone() });
    row
}

/// Heads of the table of a convergence study by probe.
pub const PROBE_HEADS: [&str; 4] = ["probe", "key figures", "converged", "median of their estimated errors"];

/// A row of the table of a convergence study by probe.
pub fn probe_row(group: &Group) -> Vec<String> {
    let error = group.median_error().map_or("unknown".to_owned(), |error| format!("{:.1} %", 100.0 * error));
    vec![group.name.clone(), group.count().to_string(), group.converged.to_string(), error]
}

/// Heads of the table of an ensemble.
pub const ENSEMBLE_HEADS: [&str; 6] =
    ["key figure", "mean", "standard deviation", "smallest", "largest", "runs"];

/// A row of the table of an ensemble; `None` where no run has such a value.
pub fn ensemble_row(result: &FigureResult) -> Option<Vec<String>> {
    let spread = result.values.last()?.spread?;
    let mut row = vec![result.figure.to_string(), short(spread.mean)];
    row.push(spread.deviation.map_or("-".to_owned(), short));
    row.extend([short(spread.smallest), short(spread.largest), spread.count.to_string()]);
    Some(row)
}

/// Writes the page of a convergence study at `spacings` \[m\], by probe first where there are `groups`; its path.
///
/// # Errors
/// When it cannot be drawn or written.
pub fn write_convergence(
    family: &Family,
    verdicts: &[Verdict],
    groups: &[Group],
    spacings: &[f64],
    tolerance: f64,
) -> Result<PathBuf, Failure> {
    let heads = convergence_heads(spacings);
    let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
    let mut after = String::new();
    if !groups.is_empty() {
        after = wide_table("Key figures by probe", &PROBE_HEADS, groups.iter().map(probe_row));
    }
    after.push_str(&wide_table("Key figures", &heads, verdicts.iter().map(convergence_row)));
    let head = format!("<p><b>{}</b></p>\n", escaped(&sentence(verdicts, tolerance)));
    write(family, CONVERGENCE, "Convergence", &head, &after, Summing::None)
}

/// Writes the page of an ensemble; its path.
///
/// # Errors
/// When it cannot be drawn or written.
pub fn write_ensemble(family: &Family) -> Result<PathBuf, Failure> {
    let rows = family.figures.iter().filter_map(ensemble_row);
    let after = wide_table("Key figures", &ENSEMBLE_HEADS, rows);
    let head = "<p>Runs of one case whose water particles start displaced by a little, each by a seed of its own.</p>\n";
    write(family, ENSEMBLE, "Ensemble", head, &after, Summing::Mean)
}

fn write(
    family: &Family,
    name: &str,
    title: &str,
    head: &str,
    after: &str,
    summing: Summing,
) -> Result<PathBuf, Failure> {
    let failed = |e: PlotError| Failure::output(e.to_string());
    let finished: Vec<_> = family.members.iter().filter(|member| member.outcome.is_ok()).collect();
    let mut runs = Vec::new();
    for member in finished.iter().take(MOST_DRAWN) {
        let mut run = Run::read(&member.folder)?;
        run.name = member.place.label();
        runs.push(run);
    }
    let mut sections = Vec::new();
    if !runs.is_empty() {
        let mut section = section(&Overlay::of(runs, &[])?, summing).map_err(failed)?;
        if finished.len() > MOST_DRAWN {
            section.note.push_str(&format!(" The first {MOST_DRAWN} of {} runs.", finished.len()));
        }
        sections.push(section);
    }
    let path = family.folder.join(name);
    let page = page(title, head, &sections, after);
    write_file(&path, |out| out.write_all(page.as_bytes()))?;
    Ok(path)
}
