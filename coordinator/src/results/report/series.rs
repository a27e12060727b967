//! Quantities over time: probes, the ledger's checks.

use sph::coupling::solver::Role;

use super::page::{Section, svg_figure};
use crate::results::plots::PlotError;
use crate::results::plots::chart::{Chart, Line, Vertical};
use crate::results::plots::colour::{LINES, Rgb};
use crate::results::plots::quantities::groups;
use crate::results::table::Table;

/// Every probe over time; `None` without rows or columns.
pub fn probes(table: &Table) -> Result<Option<Section>, PlotError> {
    let times = table.column_at(0);
    let mut figures = Vec::new();
    for group in groups(table.columns()).iter().filter(|_| !times.is_empty()) {
        let lines: Vec<Line> = group
            .columns
            .iter()
            .map(|(component, index)| Line { name: component.clone(), values: table.column_at(*index) })
            .collect();
        let meaning = &group.meaning;
        let title = match meaning.quantity.as_str() {
            "" => meaning.probe.clone(),
            quantity => format!("{}: {quantity}", meaning.probe),
        };
        figures.push(linear(&title, &times, lines, &meaning.unit)?);
    }
    Ok((!figures.is_empty()).then_some(Section {
        id: "probes",
        headline: "Probes",
        note: "As in probes.csv; long series show the lowest and the highest value of each short stretch."
            .into(),
        figures,
    }))
}

/// Imbalances and interface forces over time; `None` without rows.
pub fn ledger(table: &Table, tolerance: Option<f64>) -> Result<Option<Section>, PlotError> {
    let times = table.column("t_s").unwrap_or_default();
    if times.is_empty() {
        return Ok(None);
    }
    let mut figures = Vec::new();
    let coupled = [Role::Fluid, Role::Solid].iter().all(|side| has(table, *side));
    let both = [("imbalance_force", "force"), ("imbalance_torque", "torque")];
    let momentum = [("fluid_momentum_residual", "fluid"), ("solid_momentum_residual", "solid")];
    let action = ("Action = reaction: imbalance over gross", lines(table, &both));
    let change = ("Momentum change = impulse: residual over gross", lines(table, &momentum));
    let angular =
        [("fluid_angular_momentum_residual", "fluid"), ("solid_angular_momentum_residual", "solid")];
    let turn = ("Angular momentum change = angular impulse: residual over gross", lines(table, &angular));
    for (title, lines) in coupled.then_some(action).into_iter().chain([change, turn]) {
        let legend = legend(&lines);
        let chart =
            Chart { times: &times, lines, unit: "", vertical: Vertical::Logarithmic, level: tolerance };
        let svg = chart.svg()?;
        figures.push(svg_figure(title, &legend, svg.as_deref(), "exactly zero at every half-step"));
    }
    if coupled {
        // Of the plane and of space; the table has one of them.
        let force = [
            ("solid_force_x_n_per_m", "x"),
            ("solid_force_y_n_per_m", "y"),
            ("solid_force_x_n", "x"),
            ("solid_force_y_n", "y"),
            ("solid_force_z_n", "z"),
        ];
        let in_space = table.columns().iter().any(|name| name == "solid_force_z_n");
        let [force_unit, impulse_unit] = if in_space { ["N", "N s"] } else { ["N/m", "N s/m"] };
        figures.push(linear("Force of the fluid on the solids", &times, lines(table, &force), force_unit)?);
        let impulse = [
            ("solid_interface_impulse_x_n_s_per_m", "solid x"),
            ("solid_interface_impulse_y_n_s_per_m", "solid y"),
            ("fluid_interface_impulse_x_n_s_per_m", "fluid x"),
            ("fluid_interface_impulse_y_n_s_per_m", "fluid y"),
            ("solid_interface_impulse_x_n_s", "solid x"),
            ("solid_interface_impulse_y_n_s", "solid y"),
            ("solid_interface_impulse_z_n_s", "solid z"),
            ("fluid_interface_impulse_x_n_s", "fluid x"),
            ("fluid_interface_impulse_y_n_s", "fluid y"),
            ("fluid_interface_impulse_z_n_s", "fluid z"),
        ];
        figures.push(linear("Impulse across the interface", &times, lines(table, &impulse), impulse_unit)?);
    }
    let dashed =
        tolerance.map(|t| format!(" The dashed line is what the case allows, {t:e}.")).unwrap_or_default();
    Ok(Some(Section {
        id: "ledger",
        headline: "Ledger",
        note: format!(
            "Each point is the worst half-step since the point before it, relative to the sum of all magnitudes. \
             Nothing is drawn where the value is exactly zero or not finite.{dashed}"
        ),
        figures,
    }))
}

fn has(table: &Table, side: Role) -> bool {
    table.columns().iter().any(|column| column.starts_with(&format!("{side}_")))
}

/// The columns that the table has, under their names in the legend.
fn lines(table: &Table, columns: &[(&str, &str)]) -> Vec<Line> {
    let line =
        |(column, name): &(&str, &str)| Some(Line { name: (*name).into(), values: table.column(column)? });
    columns.iter().filter_map(line).collect()
}

fn legend(lines: &[Line]) -> Vec<(String, Rgb)> {
    lines.iter().map(|line| line.name.clone()).zip(LINES.into_iter().cycle()).collect()
}

/// A figure of lines over time.
///
/// # Errors
/// When it cannot be drawn.
pub fn linear(title: &str, times: &[f64], lines: Vec<Line>, unit: &str) -> Result<String, PlotError> {
    let legend = legend(&lines);
    let svg = Chart { times, lines, unit, vertical: Vertical::Linear, level: None }.svg()?;
    Ok(svg_figure(title, &legend, svg.as_deref(), "no value at any time"))
}
