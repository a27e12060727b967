//! `report.html`: the run's facts and pictures in one file that needs no network.

mod energies;
mod fields;
pub(crate) mod page;
mod series;

use std::io::Write;
use std::path::Path;

use super::error::OutputError;
use super::files::write_file;
use super::plots::PlotError;
use super::plots::gallery::PairedSnapshot;
use super::table::Table;

/// Everything that a report shows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReportData {
    /// Title, usually that of the case.
    pub title: String,
    /// How the run ended: one word such as `completed`.
    pub verdict: String,
    /// Why it ended, in a sentence.
    pub reason: String,
    /// Facts of the run by name.
    pub facts: Vec<(String, String)>,
    /// What the solvers agreed on before the run, by name.
    pub negotiated: Vec<(String, String)>,
    /// Things that the user should know of.
    pub warnings: Vec<String>,
    /// Snapshots to show, in time order.
    pub snapshots: Vec<PairedSnapshot>,
    /// Names of the groups of the fluid that are walls.
    pub walls: Vec<String>,
    /// Axis that points against gravity.
    pub up_axis: usize,
    /// Content of `probes.csv`.
    pub probes: Table,
    /// Content of `ledger.csv`.
    pub ledger: Table,
    /// Largest imbalance that the case allows \[-\].
    pub tolerance: Option<f64>,
}

/// Writes the report to `path`.
///
/// # Errors
/// When a picture cannot be drawn or the file cannot be written.
pub fn write(path: &Path, data: &ReportData) -> Result<(), OutputError> {
    let html = html(data).map_err(|e| OutputError::content(path, e.to_string()))?;
    write_file(path, |file| file.write_all(html.as_bytes()))
}

/// The report as text.
///
/// # Errors
/// When a picture cannot be drawn.
pub fn html(data: &ReportData) -> Result<String, PlotError> {
    let sections = [
        fields::outside(data)?,
        fields::pressure(data)?,
        fields::stress(data)?,
        series::probes(&data.probes)?,
        series::ledger(&data.ledger, data.tolerance)?,
        energies::energies(&data.ledger)?,
    ];
    let sections: Vec<page::Section> = sections.into_iter().flatten().collect();
    Ok(page::page(data, &sections))
}

#[cfg(test)]
mod tests;
