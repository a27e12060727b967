//! `report.html`: what a run says, its film and its pictures, in one file that needs no network.

mod fields;
pub(crate) mod page;

use std::io::Write;
use std::path::Path;

use super::error::OutputError;
use super::files::write_file;
use super::plots::PlotError;
use super::plots::gallery::PairedSnapshot;
use crate::page::document;
use crate::page::film::Film;
use crate::page::run::RunPage;

/// Everything that a report shows.
#[derive(Clone, Debug, Default)]
pub struct ReportData {
    /// What the run says.
    pub page: RunPage,
    /// Its frames; `None` where there are none.
    pub film: Option<Film>,
    /// Snapshots to show as pictures, in time order.
    pub snapshots: Vec<PairedSnapshot>,
    /// Names of the groups of the fluid that are walls.
    pub walls: Vec<String>,
    /// Axis that points against gravity.
    pub up_axis: usize,
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
    let sections = [fields::outside(data)?, fields::pressure(data)?, fields::stress(data)?];
    let mut pictures = String::new();
    for section in sections.into_iter().flatten() {
        page::folded_section(&mut pictures, &section);
    }
    document::report(&data.page, data.film.as_ref(), &pictures).map_err(PlotError::new)
}

#[cfg(test)]
mod tests;
