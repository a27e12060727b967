//! Histories of several runs on common axes, as figures of a page.

use super::{Column, Overlay, Run, common_times};
use crate::results::plots::PlotError;
use crate::results::plots::chart::{Chart, Line, Vertical};
use crate::results::plots::colour::{LINES, Rgb};
use crate::results::plots::quantities::{Meaning, meaning};
use crate::results::report::page::{Section, document, escaped, svg_figure, table};
use crate::study::series;

/// What is drawn in addition to the runs themselves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Summing {
    /// Nothing.
    #[default]
    None,
    /// The mean of all runs, wherever each of them has a value.
    Mean,
}

/// A figure for each column, a line for each run.
///
/// # Errors
/// When one cannot be drawn.
pub fn section(overlay: &Overlay, summing: Summing) -> Result<Section, PlotError> {
    let mut figures = Vec::new();
    for column in &overlay.columns {
        figures.push(figure(&overlay.runs, column, summing)?);
    }
    let mean = match summing {
        Summing::None => "",
        Summing::Mean => " The last line is the mean, where all runs have a value.",
    };
    Ok(Section {
        id: "probes",
        headline: "Probes",
        note: format!(
            "A line for each run, at the times of all of them; long series show the lowest and the highest value of each \
             short stretch.{mean}"
        ),
        figures,
    })
}

fn figure(runs: &[Run], column: &Column, summing: Summing) -> Result<String, PlotError> {
    let histories: Vec<Vec<(f64, f64)>> = runs.iter().map(|run| run.history(&column.name)).collect();
    let times = common_times(histories.iter().map(Vec::as_slice));
    let values = |history: &Vec<(f64, f64)>| times.iter().map(|t| series::at(history, *t)).collect();
    let mut lines: Vec<Line> = runs
        .iter()
        .zip(&histories)
        .map(|(run, history)| Line { name: run.name.clone(), values: values(history) })
        .collect();
    if summing == Summing::Mean {
        // What is no number in one run is none of the mean. Counts far below 2^53.
        let mean = |k| lines.iter().map(|line| line.values[k]).sum::<f64>() / lines.len() as f64;
        let values = (0..times.len()).map(mean).collect();
        lines.push(Line { name: "mean".to_owned(), values });
    }
    let legend: Vec<(String, Rgb)> =
        lines.iter().map(|line| line.name.clone()).zip(LINES.into_iter().cycle()).collect();
    let Meaning { probe, quantity, component, unit } = meaning(&column.name);
    let quantity = format!("{quantity} {component}");
    let title = match quantity.trim() {
        "" => probe,
        quantity => format!("{probe}: {quantity}"),
    };
    let chart = Chart { times: &times, lines, unit: &unit, vertical: Vertical::Linear, level: None };
    Ok(svg_figure(&title, &legend, chart.svg()?.as_deref(), "no value at any time"))
}

/// Tables of what differs between the cases and of peaks, as HTML.
pub fn tables(overlay: &Overlay) -> String {
    let mut html = String::from("<div class=\"tables\">\n");
    let verdicts: Vec<(String, String)> = overlay
        .runs
        .iter()
        .map(|run| (run.name.clone(), format!("{} ({})", run.folder.display(), run.verdict)))
        .collect();
    table(&mut html, "runs", "Runs", &verdicts);
    html.push_str("</div>\n");
    let names = || overlay.runs.iter().map(|run| run.name.as_str());
    if !overlay.differing_keys.is_empty() {
        let rows = overlay.differing_keys.iter().map(|(key, values)| {
            let values = values.iter().map(|value| value.clone().unwrap_or_else(|| "-".to_owned()));
            std::iter::once(key.clone()).chain(values).collect()
        });
        let head = std::iter::once("key").chain(names()).collect::<Vec<_>>();
        html.push_str(&wide_table("Where the cases differ", &head, rows));
    }
    let head =
        ["column", "run", "largest", "at [s]", "smallest", "at [s]", "last", "largest difference", "rms"];
    html + &wide_table("Peaks, and differences from the first run", &head, peak_rows(overlay).into_iter())
}

/// A row for each column and run: peaks, and differences from the first run.
pub fn peak_rows(overlay: &Overlay) -> Vec<Vec<String>> {
    let mut rows = Vec::new();
    for column in &overlay.columns {
        for (k, run) in overlay.runs.iter().enumerate() {
            let Some(peaks) = &column.peaks[k] else { continue };
            let mut row = vec![column.name.clone(), run.name.clone()];
            row.extend(
                [peaks.largest.0, peaks.largest.1, peaks.smallest.0, peaks.smallest.1, peaks.last].map(short),
            );
            let difference = column.differences[k];
            row.push(difference.map_or(String::new(), |d| short(d.largest.0)));
            row.push(difference.map_or(String::new(), |d| short(d.root_mean_square)));
            rows.push(row);
        }
    }
    rows
}

/// Five digits.
pub fn short(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let magnitude = value.abs().log10().floor();
    match magnitude {
        // Decimals of five digits in this range.
        -4.0..6.0 => format!("{value:.*}", (4.0 - magnitude).max(0.0) as usize),
        _ => format!("{value:.4e}"),
    }
}

/// Columns of [`wide_table`] are as wide as what is in them, and its texts keep their lines.
const STYLE: &str = "<style>.many table { width: auto; } .many th { width: auto; padding-right: 1.2rem; } \
    .many td { overflow-wrap: normal; white-space: pre-wrap; padding-right: 1.2rem; }</style>";

/// A table whose columns are as wide as what is in them.
pub fn wide_table(headline: &str, head: &[&str], rows: impl Iterator<Item = Vec<String>>) -> String {
    let headline = escaped(headline);
    let mut html =
        format!("<section><h2>{headline}</h2><figure class=\"wide many\">{STYLE}<table><thead><tr>");
    for cell in head {
        html.push_str(&format!("<th scope=\"col\">{}</th>", escaped(cell)));
    }
    html.push_str("</tr></thead><tbody>");
    for row in rows {
        html.push_str("<tr>");
        for cell in row {
            html.push_str(&format!("<td>{}</td>", escaped(&cell)));
        }
        html.push_str("</tr>");
    }
    html + "</tbody></table></figure></section>\n"
}

/// A page of `sections`, pictures first, since the `tables` below them may be long.
pub fn page(title: &str, head: &str, sections: &[Section], tables: &str) -> String {
    document(title, head, "", sections).replacen("</main>", &format!("{tables}</main>"), 1)
}

/// The page of an overlay.
///
/// # Errors
/// When a picture cannot be drawn.
pub fn html(overlay: &Overlay) -> Result<String, PlotError> {
    let names: Vec<&str> = overlay.runs.iter().map(|run| run.name.as_str()).collect();
    let title = format!("{} runs side by side", names.len());
    let sections = [section(overlay, Summing::None)?];
    let head = "<p>Histories of the probes on common axes. Differences are from the first run.</p>\n";
    Ok(page(&title, head, &sections, &tables(overlay)))
}
