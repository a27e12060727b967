//! Finished runs side by side: their probes on common axes, peaks, and differences from the first.

pub mod output;
pub mod page;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::case::suggest;
use crate::failure::Failure;
use crate::results::names;
use crate::results::table::Table;
use crate::study::series;

/// Runs to be laid over each other.
#[derive(Clone, Debug, Default)]
pub struct OverlayRequest {
    /// Folders of the runs; the others are compared with the first.
    pub runs: Vec<PathBuf>,
    /// Probe columns to show; all when empty.
    pub columns: Vec<String>,
    /// Folder for `overlay.html` and `overlay.csv`.
    pub out: PathBuf,
}

/// A run as its folder holds it.
#[derive(Clone, Debug)]
pub struct Run {
    /// Shortest end of its path that no other run has.
    pub name: String,
    /// Its folder.
    pub folder: PathBuf,
    /// Rows of its probes.
    pub probes: Table,
    /// What its case says, key by key.
    pub case: BTreeMap<String, String>,
    /// How it ended; empty where it has no summary.
    pub verdict: String,
}

/// Runs and what their probe columns show.
#[derive(Clone, Debug)]
pub struct Overlay {
    /// The runs.
    pub runs: Vec<Run>,
    /// Columns that at least one run has.
    pub columns: Vec<Column>,
    /// Keys in which the cases differ, with the value of each run.
    pub differing_keys: Vec<(String, Vec<Option<String>>)>,
}

/// A probe column over all runs.
#[derive(Clone, Debug, Serialize)]
pub struct Column {
    /// Name, such as `tip_displacement_y_m`.
    pub name: String,
    /// Peaks in each run; `None` where it has no such column or no number in it.
    pub peaks: Vec<Option<Peaks>>,
    /// Difference of each run from the first; `None` for the first, and where both share no time.
    pub differences: Vec<Option<Difference>>,
}

/// Peaks of a history.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Peaks {
    /// Largest value, and when \[s\].
    pub largest: (f64, f64),
    /// Smallest value, and when \[s\].
    pub smallest: (f64, f64),
    /// Last value.
    pub last: f64,
}

/// How a history departs from another over the time that both cover.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// Largest magnitude, and when \[s\].
    pub largest: (f64, f64),
    /// Root of the mean square over time.
    pub root_mean_square: f64,
    /// Range of values of the other, largest less smallest, over that time.
    pub range: f64,
}

impl Peaks {
    /// Of a history of (time \[s\], value).
    pub fn of(history: &[(f64, f64)]) -> Option<Self> {
        let finite = || history.iter().filter(|row| row.1.is_finite());
        let turned = |row: &(f64, f64)| (row.1, row.0);
        Some(Self {
            // The first of several equal ones.
            largest: turned(finite().rev().max_by(|a, b| a.1.total_cmp(&b.1))?),
            smallest: turned(finite().min_by(|a, b| a.1.total_cmp(&b.1))?),
            last: finite().next_back()?.1,
        })
    }
}

impl Difference {
    /// Of `history` from `reference`, both of (time \[s\], value), at all times of either within both; between rows by a
    /// straight line. `None` where there are fewer than two such times.
    pub fn of(history: &[(f64, f64)], reference: &[(f64, f64)]) -> Option<Self> {
        let times = common_times([history, reference]);
        let values = |of: &[(f64, f64)]| -> Vec<f64> { times.iter().map(|t| series::at(of, *t)).collect() };
        let (own, other) = (values(history), values(reference));
        let rows: Vec<(f64, f64)> = times
            .iter()
            .zip(own.iter().zip(&other))
            .map(|(t, (a, b))| (*t, a - b))
            .filter(|row| row.1.is_finite())
            .collect();
        let (first, last) = (rows.first()?.0, rows.last()?.0);
        if first == last {
            return None;
        }
        let largest = rows.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
        let squares: Vec<(f64, f64)> = rows.iter().map(|row| (row.0, row.1 * row.1)).collect();
        let reference: Vec<f64> = other.into_iter().filter(|value| value.is_finite()).collect();
        Some(Self {
            largest: (largest.1.abs(), largest.0),
            root_mean_square: series::mean(&squares, first, last).sqrt(),
            range: series::largest(reference.iter().copied())
                + series::largest(reference.iter().map(|value| -value)),
        })
    }
}

/// All times of any of `histories`, ascending, each once.
pub fn common_times<'a>(histories: impl IntoIterator<Item = &'a [(f64, f64)]>) -> Vec<f64> {
    let mut times: Vec<f64> =
        histories.into_iter().flatten().map(|row| row.0).filter(|time| time.is_finite()).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    times
}

impl Run {
    /// Reads the run in `folder`.
    ///
    /// # Errors
    /// When it holds no probes of a run that has ended.
    pub fn read(folder: &Path) -> Result<Self, Failure> {
        let path = folder.join(names::PROBES);
        if !path.is_file() {
            return Err(Failure::input(format!(
                "`{}` holds no `{}`; give the folder of a run that has ended",
                folder.display(),
                names::PROBES
            )));
        }
        let text = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap_or_default();
        let mut case = BTreeMap::new();
        if let Ok(table) = text(names::CASE).parse::<toml::Table>() {
            flatten("", &toml::Value::Table(table), &mut case);
        }
        let summary: serde_json::Value = serde_json::from_str(&text(names::SUMMARY)).unwrap_or_default();
        Ok(Self {
            name: folder.display().to_string(),
            folder: folder.to_owned(),
            probes: Table::read(&path)?,
            case,
            verdict: summary["verdict"].as_str().unwrap_or_default().to_owned(),
        })
    }

    /// Rows of the column `name` as (time \[s\], value); none where there is no such column.
    pub fn history(&self, name: &str) -> Vec<(f64, f64)> {
        let values = self.probes.column(name).unwrap_or_default();
        self.probes.column_at(0).into_iter().zip(values).collect()
    }
}

/// Writes each plain value below `value` into `found`, under its path.
fn flatten(path: &str, value: &toml::Value, found: &mut BTreeMap<String, String>) {
    let below = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
    match value {
        toml::Value::Table(table) => table.iter().for_each(|(key, value)| flatten(&below(key), value, found)),
        toml::Value::Array(list) if list.iter().any(toml::Value::is_table) => {
            for (k, entry) in list.iter().enumerate() {
                let name = entry.get("name").and_then(toml::Value::as_str);
                flatten(&name.map_or_else(|| format!("{path}[{k}]"), below), entry, found);
            }
        }
        plain => drop(found.insert(path.to_owned(), plain.to_string())),
    }
}

/// Reads the runs asked for and compares them.
///
/// # Errors
/// When a folder holds no run that has ended, or a column is not known.
pub fn read(request: &OverlayRequest) -> Result<Overlay, Failure> {
    let mut runs = request.runs.iter().map(|folder| Run::read(folder)).collect::<Result<Vec<_>, _>>()?;
    name_apart(&mut runs);
    Overlay::of(runs, &request.columns)
}

/// [`read`], then writes `overlay.html` and `overlay.csv`.
///
/// # Errors
/// As [`read`], and when a file cannot be written.
pub fn make(request: &OverlayRequest) -> Result<Overlay, Failure> {
    let overlay = read(request)?;
    output::write(&overlay, &request.out)?;
    Ok(overlay)
}

/// Names each run by the shortest end of its path that no other has, without a folder `results` at its end.
fn name_apart(runs: &mut [Run]) {
    let parts = |folder: &Path| -> Vec<String> {
        let full = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
        full.components().map(|part| part.as_os_str().to_string_lossy().into_owned()).collect()
    };
    let mut paths: Vec<Vec<String>> = runs.iter().map(|run| parts(&run.folder)).collect();
    if paths.iter().all(|path| path.last().is_some_and(|last| last == "results")) {
        paths.iter_mut().for_each(|path| drop(path.pop()));
    }
    let longest = paths.iter().map(Vec::len).max().unwrap_or(0);
    let end = |path: &[String], count: usize| path[path.len().saturating_sub(count)..].join("/");
    for (k, run) in runs.iter_mut().enumerate() {
        let apart = |count: &usize| {
            let own = end(&paths[k], *count);
            paths.iter().enumerate().all(|(other, path)| other == k || end(path, *count) != own)
        };
        run.name = end(&paths[k], (1..=longest).find(apart).unwrap_or(longest));
    }
}

impl Overlay {
    /// Compares `runs` in the `columns` asked for, all when there are none.
    ///
    /// # Errors
    /// When there is no run, or no run has a column of that name.
    pub fn of(runs: Vec<Run>, columns: &[String]) -> Result<Self, Failure> {
        if runs.is_empty() {
            return Err(Failure::input("no run to show"));
        }
        let mut known: Vec<String> = Vec::new();
        for name in runs.iter().flat_map(|run| run.probes.columns().iter().skip(1)) {
            if !known.contains(name) {
                known.push(name.clone());
            }
        }
        if let Some(unknown) = columns.iter().find(|name| !known.contains(name)) {
            let known: Vec<&str> = known.iter().map(String::as_str).collect();
            return Err(Failure::input(format!(
                "no run has a probe column `{unknown}`; {}",
                suggest(unknown, &known)
            )));
        }
        let names = if columns.is_empty() { known } else { columns.to_vec() };
        let columns = names.into_iter().map(|name| column(&runs, name)).collect();
        Ok(Self { differing_keys: differing_keys(&runs), runs, columns })
    }
}

fn column(runs: &[Run], name: String) -> Column {
    let histories: Vec<Vec<(f64, f64)>> = runs.iter().map(|run| run.history(&name)).collect();
    let from_first = |(k, own): (usize, &Vec<(f64, f64)>)| {
        let first = histories.first().filter(|_| k > 0)?;
        Difference::of(own, first)
    };
    Column {
        peaks: histories.iter().map(|history| Peaks::of(history)).collect(),
        differences: histories.iter().enumerate().map(from_first).collect(),
        name,
    }
}

/// Keys of the cases whose values differ among `runs`.
fn differing_keys(runs: &[Run]) -> Vec<(String, Vec<Option<String>>)> {
    let mut keys: Vec<&String> = runs.iter().flat_map(|run| run.case.keys()).collect();
    keys.sort();
    keys.dedup();
    let values = |key: &String| runs.iter().map(|run| run.case.get(key).cloned()).collect::<Vec<_>>();
    keys.into_iter()
        .map(|key| (key.clone(), values(key)))
        .filter(|(_, values)| values.iter().any(|value| *value != values[0]))
        .collect()
}

#[cfg(test)]
mod tests;
