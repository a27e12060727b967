//! What a sweep writes and prints: `sweep.csv`, a row per member, `sweep.html`, and a table for the terminal.

use std::io::Write as _;

use super::manifest::Progress;
use super::scatter::{Point, scatter};
use super::{Joined, batch, member};
use crate::failure::Failure;
use crate::overlay::output::aligned;
use crate::overlay::page::{Summing, page, section, short, wide_table};
use crate::overlay::{Overlay, Run};
use crate::results::files::write_file;
use crate::results::plots::PlotError;
use crate::results::report::page::{Section, escaped};

/// Name of the table.
pub const TABLE: &str = "sweep.csv";
/// Name of the page.
pub const PAGE: &str = "sweep.html";

/// Most members whose histories the page shows: more lines look alike.
const MOST_DRAWN: usize = 24;
/// Most key figures of the page and of the terminal; the table has all.
const MOST_FIGURES: usize = 6;

/// Writes table and page.
pub(super) fn write(joined: &Joined) -> Result<(), Failure> {
    let table = csv(joined).map_err(|e| Failure::internal(format!("`{TABLE}`: {e}")))?;
    write_file(&joined.folder.join(TABLE), |out| out.write_all(&table))?;
    let page = html(joined)?;
    write_file(&joined.folder.join(PAGE), |out| out.write_all(page.as_bytes()))?;
    Ok(())
}

/// What a member sets `key` to.
fn value(joined: &Joined, member: usize, key: &str) -> String {
    let set = joined.manifest.members[member].set.iter().find(|set| set.key == key);
    set.map_or(String::new(), |set| set.value.trim_matches('"').to_owned())
}

fn csv(joined: &Joined) -> std::io::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let head = ["member", "run", "state"].map(str::to_owned).into_iter().chain(joined.manifest.keys.clone());
    let head = head.chain(["steps".to_owned(), "wall_s".to_owned()]);
    writer.write_record(head.chain(joined.manifest.figures.clone()).chain(["reason".to_owned()]))?;
    for (k, (progress, values)) in joined.members.iter().enumerate() {
        let entry = &joined.manifest.members[k];
        let mut row = vec![entry.number.to_string(), entry.label.clone(), progress.word().to_owned()];
        row.extend(joined.manifest.keys.iter().map(|key| value(joined, k, key)));
        match progress {
            Progress::Finished { steps, wall_seconds } => {
                row.extend([steps.to_string(), wall_seconds.to_string()]);
            }
            _ => row.extend([String::new(), String::new()]),
        }
        row.extend(values.iter().map(|value| value.map_or(String::new(), |value| value.to_string())));
        row.push(progress.reason().to_owned());
        writer.write_record(&row)?;
    }
    writer.into_inner().map_err(|e| e.into_error())
}

/// Key figures that are shown: the first that vary from member to member, those apart that are everywhere as an earlier one.
fn shown(joined: &Joined) -> Vec<usize> {
    let of = |k: usize| joined.members.iter().map(move |(_, values)| values[k]);
    let is_new = |k: &usize| (0..*k).all(|earlier| !of(earlier).eq(of(*k)));
    let varies = |k: &usize| {
        let mut values = joined.members.iter().filter_map(|(_, values)| values[*k]);
        let first = values.next();
        values.any(|value| Some(value) != first)
    };
    let varying: Vec<usize> =
        (0..joined.figures.len()).filter(varies).filter(is_new).take(MOST_FIGURES).collect();
    if varying.is_empty() { (0..joined.figures.len()).take(MOST_FIGURES).collect() } else { varying }
}

/// A table of members: number, what each sets, how far it is, key figures.
fn rows(joined: &Joined, figures: &[usize]) -> Vec<Vec<String>> {
    let row = |(k, (progress, values)): (usize, &(Progress, Vec<Option<f64>>))| {
        let mut row = vec![joined.manifest.members[k].number.to_string()];
        row.extend(joined.manifest.keys.iter().map(|key| value(joined, k, key)));
        row.push(progress.word().to_owned());
        row.extend(figures.iter().map(|k| values[*k].map_or("-".to_owned(), short)));
        row
    };
    joined.members.iter().enumerate().map(row).collect()
}

/// The sweep as lines of a terminal: key figures under letters, a row for each member, then why some are not finished.
pub fn lines(joined: &Joined) -> Vec<String> {
    let figures = shown(joined);
    let mut lines: Vec<String> = Vec::new();
    let letter = |k: usize| format!("({})", char::from(b'a' + u8::try_from(k).unwrap_or(0)));
    let last = |key: &String| key.rsplit('.').next().unwrap_or(key).to_owned();
    let mut table = vec![
        std::iter::once("member".to_owned())
            .chain(joined.manifest.keys.iter().map(last))
            .chain(["state".to_owned()])
            .chain((0..figures.len()).map(letter))
            .collect::<Vec<_>>(),
    ];
    table.extend(rows(joined, &figures));
    lines.extend(aligned(&table));
    for (k, figure) in figures.iter().enumerate() {
        lines.push(format!("{} {}", letter(k), joined.manifest.figures[*figure]));
    }
    if figures.len() < joined.figures.len() {
        lines.push(format!("all {} key figures are in {TABLE}", joined.figures.len()));
    }
    for (entry, progress) in joined.unfinished() {
        lines.push(format!(
            "member {}, {}: {}: {}",
            entry.number,
            entry.label,
            progress.word(),
            progress.reason()
        ));
    }
    lines
}

fn html(joined: &Joined) -> Result<String, Failure> {
    let failed = |e: PlotError| Failure::output(e.to_string());
    let figures = shown(joined);
    let finished = joined.members.len() - joined.unfinished().count();
    let title = format!("{}: sweep of {} runs", joined.manifest.case, joined.members.len());
    let mut head = format!("<p>{finished} of {} runs are finished. ", joined.members.len());
    head.push_str(&format!("{TABLE} has all {} key figures.</p>\n", joined.figures.len()));
    let heads: Vec<&str> = std::iter::once("member")
        .chain(joined.manifest.keys.iter().map(String::as_str))
        .chain(["state"])
        .chain(figures.iter().map(|k| joined.manifest.figures[*k].as_str()))
        .collect();
    let mut after = wide_table("Members", &heads, rows(joined, &figures).into_iter());
    let unfinished: Vec<Vec<String>> = joined
        .unfinished()
        .map(|(entry, progress)| {
            vec![
                entry.number.to_string(),
                entry.label.clone(),
                progress.word().to_owned(),
                progress.reason().to_owned(),
            ]
        })
        .collect();
    if !unfinished.is_empty() {
        after.push_str(&wide_table(
            "Not finished",
            &["member", "run", "state", "reason"],
            unfinished.into_iter(),
        ));
    }
    let mut sections = Vec::new();
    let scatters = scatters(joined, &figures).map_err(failed)?;
    if !scatters.is_empty() {
        let note = "A point for each finished run.".to_owned();
        sections.push(Section { id: "figures", headline: "Key figures", note, figures: scatters });
    }
    let runs = drawn(joined)?;
    if !runs.is_empty() {
        let overlay = Overlay::of(runs, &[])?;
        let mut section = section(&overlay, Summing::None).map_err(failed)?;
        if finished > MOST_DRAWN {
            section.note.push_str(&format!(" The first {MOST_DRAWN} of {finished} finished runs."));
        }
        sections.push(section);
    }
    Ok(page(&title, &head, &sections, &after))
}

/// Histories of the first finished members.
fn drawn(joined: &Joined) -> Result<Vec<Run>, Failure> {
    let finished = joined.members.iter().zip(&joined.manifest.members);
    let finished = finished.filter(|((progress, _), _)| matches!(progress, Progress::Finished { .. }));
    let run = |entry: &super::Entry| {
        let mut run = Run::read(&member::results_of(&batch::folder_of(&joined.folder, &entry.label)))?;
        run.name.clone_from(&entry.label);
        Ok(run)
    };
    finished.take(MOST_DRAWN).map(|(_, entry)| run(entry)).collect()
}

/// Each shown key figure against each key that takes numbers.
fn scatters(joined: &Joined, figures: &[usize]) -> Result<Vec<String>, PlotError> {
    let mut found = Vec::new();
    for figure in figures {
        for key in &joined.manifest.keys {
            let point = |(k, (_, values)): (usize, &(Progress, Vec<Option<f64>>))| {
                let x =
                    value(joined, k, key).replace('_', "").parse::<f64>().ok().filter(|x| x.is_finite())?;
                Some(Point { x, y: values[*figure]? })
            };
            let points: Vec<Point> = joined.members.iter().enumerate().filter_map(point).collect();
            if let Some(svg) = scatter(key, &points)? {
                let title = escaped(&joined.manifest.figures[*figure]);
                found.push(format!("<figure class=\"field\" style=\"display:block\"><figcaption style=\"color:#000\"><b>{title}</b></figcaption>{svg}</figure>"));
            }
        }
    }
    Ok(found)
}
