//! The energy budget over time, by account.

use sph::coupling::ledger::{EnergyAccount, EnergyKind, SignRule};
use sph::coupling::solver::Role;

use super::page::Section;
use super::series::linear;
use crate::results::ledger::{energy_column, energy_residual_column};
use crate::results::plots::PlotError;
use crate::results::plots::chart::Line;
use crate::results::table::Table;

/// Lines in one picture: the accounts that grew largest.
const MOST_LINES: usize = 8;

/// Energy of each side over time; `None` without rows.
///
/// # Errors
/// When a picture cannot be drawn.
pub fn energies(table: &Table) -> Result<Option<Section>, PlotError> {
    let times = table.column("t_s").unwrap_or_default();
    let mut figures = Vec::new();
    // A run in space has columns in J, one of the plane in J/m.
    let in_space = table.columns().iter().any(|name| name.contains("_energy_") && name.ends_with("_j"));
    let (dimensions, unit) = if in_space { (3, "J") } else { (2, "J/m") };
    for (side, title) in [(Role::Fluid, "Fluid"), (Role::Solid, "Solids")] {
        if times.is_empty() {
            continue;
        }
        let lines = |kinds: &[EnergyKind]| -> Vec<Line> {
            let of_kind = EnergyAccount::all().filter(|account| kinds.contains(&account.kind()));
            let mut lines: Vec<Line> = of_kind
                .filter_map(|account| {
                    let values = table.column(&energy_column(side, account, dimensions))?;
                    let name = label(account);
                    let is_store = account.kind() == EnergyKind::Store;
                    Some(Line { name, values: if is_store { change(values) } else { values } })
                })
                .collect();
            lines.sort_by(|a, b| extent(&b.values).total_cmp(&extent(&a.values)));
            lines.truncate(MOST_LINES);
            lines
        };
        let stores = lines(&[EnergyKind::Store]);
        if stores.is_empty() {
            continue;
        }
        figures.push(linear(&format!("{title}: stores, change since the first row"), &times, stores, unit)?);
        let mut flows = lines(&[EnergyKind::Work, EnergyKind::Loss]);
        if let Some(values) = table.column(&energy_residual_column(side, dimensions)) {
            flows.push(Line { name: "residual".into(), values });
        }
        figures.push(linear(&format!("{title}: works and losses since the start"), &times, flows, unit)?);
    }
    Ok((!figures.is_empty()).then_some(Section {
        id: "energies",
        headline: "Energy",
        note: format!(
            "Change of the stores = works − losses. A loss marked ± may have either sign. At most {MOST_LINES} accounts \
             are drawn, the largest; ledger.csv and the table in summary.json have all."
        ),
        figures,
    }))
}

/// Name of an account in a legend.
fn label(account: EnergyAccount) -> String {
    let name = account.name().replace('_', " ");
    match (account.kind(), account.sign_rule()) {
        (EnergyKind::Store, _) => name,
        (EnergyKind::Work, _) => format!("work: {name}"),
        (EnergyKind::Loss, SignRule::NeverNegative) => format!("loss: {name}"),
        (EnergyKind::Loss, SignRule::Either) => format!("loss: {name} ±"),
    }
}

fn extent(values: &[f64]) -> f64 {
    values.iter().filter(|value| value.is_finite()).fold(0.0, |most, value| value.abs().max(most))
}

/// Values minus the first.
fn change(mut values: Vec<f64>) -> Vec<f64> {
    let first = values.first().copied().unwrap_or(0.0);
    values.iter_mut().for_each(|value| *value -= first);
    values
}
