//! An overlay as lines of a terminal and as files.

use std::io::Write as _;
use std::path::Path;

use super::page::{html, short};
use super::{Overlay, page};
use crate::failure::Failure;
use crate::results::files::write_file;

/// Name of the page.
pub const PAGE: &str = "overlay.html";
/// Name of the table of peaks.
pub const TABLE: &str = "overlay.csv";

/// Columns of [`TABLE`].
const COLUMNS: [&str; 11] = [
    "column",
    "run",
    "largest",
    "largest_at_s",
    "smallest",
    "smallest_at_s",
    "last",
    "largest_difference",
    "largest_difference_at_s",
    "root_mean_square_difference",
    "relative_difference",
];

/// Writes page and table into the folder `out`.
pub(super) fn write(overlay: &Overlay, out: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(out)
        .map_err(|e| Failure::output(format!("cannot create `{}`: {e}", out.display())))?;
    let page = html(overlay).map_err(|e| Failure::output(e.to_string()))?;
    write_file(&out.join(PAGE), |file| file.write_all(page.as_bytes()))?;
    write_file(&out.join(TABLE), |file| file.write_all(&csv(overlay)?))?;
    Ok(())
}

/// The table of peaks and differences, a row for each column and run.
///
/// # Errors
/// None that a writer into memory has.
pub fn csv(overlay: &Overlay) -> std::io::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(COLUMNS)?;
    for column in &overlay.columns {
        for (k, run) in overlay.runs.iter().enumerate() {
            let Some(peaks) = &column.peaks[k] else { continue };
            let mut row = vec![column.name.clone(), run.name.clone()];
            let (largest, smallest) = (peaks.largest, peaks.smallest);
            row.extend([largest.0, largest.1, smallest.0, smallest.1, peaks.last].map(|v| v.to_string()));
            match column.differences[k] {
                None => row.extend(std::iter::repeat_n(String::new(), 4)),
                Some(d) => {
                    let relative = d.largest.0 / d.range;
                    let relative = if relative.is_finite() { relative.to_string() } else { String::new() };
                    row.extend([d.largest.0, d.largest.1, d.root_mean_square].map(|v| v.to_string()));
                    row.push(relative);
                }
            }
            writer.write_record(&row)?;
        }
    }
    writer.into_inner().map_err(|e| e.into_error())
}

/// The overlay as lines of a terminal: where the cases differ, then peaks and differences of each column.
pub fn lines(overlay: &Overlay) -> Vec<String> {
    let mut lines = Vec::new();
    let names = overlay.runs.iter().map(|run| run.name.clone());
    if !overlay.differing_keys.is_empty() {
        let mut rows = vec![std::iter::once("key".to_owned()).chain(names).collect::<Vec<_>>()];
        for (key, values) in &overlay.differing_keys {
            let values = values.iter().map(|value| value.clone().unwrap_or_else(|| "-".to_owned()));
            rows.push(std::iter::once(key.clone()).chain(values).collect());
        }
        lines.extend(aligned(&rows));
        lines.push(String::new());
    }
    let head =
        ["column", "run", "largest", "at [s]", "smallest", "at [s]", "last", "max. diff.", "rms diff."];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    rows.extend(page::peak_rows(overlay));
    // A name once is enough.
    for k in (2..rows.len()).rev() {
        if rows[k][0] == rows[k - 1][0] {
            rows[k][0].clear();
        }
    }
    lines.extend(aligned(&rows));
    let worst = overlay.columns.iter().filter_map(|column| {
        let differences = column.differences.iter().flatten();
        let share = differences.map(|d| d.largest.0 / d.range).filter(|share| share.is_finite());
        Some((share.max_by(f64::total_cmp)?, &column.name))
    });
    if let Some((share, name)) = worst.max_by(|a, b| a.0.total_cmp(&b.0)) {
        lines.push(format!(
            "largest difference over the range of the first run: {} % of `{name}`",
            short(100.0 * share)
        ));
    }
    lines
}

/// Rows of cells, heads first, as lines: columns two spaces apart, those of numbers to the right.
pub fn aligned(rows: &[Vec<String>]) -> Vec<String> {
    let count = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |k: usize| rows.iter().filter_map(|row| row.get(k)).map(|cell| cell.chars().count()).max();
    let widths: Vec<usize> = (0..count).map(|k| width(k).unwrap_or(0)).collect();
    let is_number = |cell: &String| cell.parse::<f64>().is_ok();
    let numbers: Vec<bool> = (0..count)
        .map(|k| k > 0 && rows.iter().skip(1).filter_map(|row| row.get(k)).any(is_number))
        .collect();
    let line = |row: &Vec<String>| {
        let cells = row.iter().zip(&widths).zip(&numbers).map(|((cell, width), number)| match number {
            true => format!("{cell:>width$}"),
            false => format!("{cell:<width$}"),
        });
        cells.collect::<Vec<_>>().join("  ").trim_end().to_owned()
    };
    rows.iter().map(line).collect()
}
