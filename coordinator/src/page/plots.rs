//! Lines over time for the page: probes by what they show, the ledger, energies; long series thinned without their peaks.

use serde::Serialize;
use sph::coupling::ledger::{EnergyAccount, EnergyKind, SignRule};
use sph::coupling::solver::Role;

use crate::results::ledger::{energy_column, energy_residual_column};
use crate::results::plots::quantities::groups;
use crate::results::table::Table;

/// Stretches of a long series; of each the lowest and the highest value of each line stay.
const STRETCHES: usize = 400;
/// Lines of one energy plot: the accounts that grew largest.
const MOST_ACCOUNTS: usize = 8;

/// Plots under one headline.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlotGroup {
    /// Anchor.
    pub id: &'static str,
    /// Headline.
    pub headline: &'static str,
    /// A sentence on what is shown.
    pub note: String,
    /// The plots.
    pub plots: Vec<Plot>,
}

/// Lines over time.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Plot {
    /// What it shows.
    pub title: String,
    /// SI unit; empty without.
    pub unit: String,
    /// Whether the axis is logarithmic.
    pub logarithmic: bool,
    /// A level to mark, such as a tolerance.
    pub level: Option<f64>,
    /// Times \[s\], six digits.
    #[serde(serialize_with = "short_numbers")]
    pub times: Vec<f64>,
    /// The lines.
    pub lines: Vec<Line>,
}

/// A line of a plot.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Line {
    /// Name in the legend; empty where the plot has one line.
    pub name: String,
    /// Values, one per time, six digits; NaN is `null`.
    #[serde(serialize_with = "short_numbers")]
    pub values: Vec<f64>,
}

/// Numbers with six digits, which is finer than a screen.
fn short_numbers<S: serde::Serializer>(values: &[f64], to: S) -> Result<S::Ok, S::Error> {
    to.collect_seq(values.iter().map(|value| short(*value)))
}

/// A number with six digits; `None` where it is no finite one.
pub fn short(value: f64) -> Option<f64> {
    value.is_finite().then(|| format!("{value:.5e}").parse().unwrap_or(value))
}

/// Headlines of the plots of probes, and the quantities under each in their order; the last takes all else.
const KINDS: [(&str, &str, &[&str]); 5] = [
    (
        "motion",
        "Motion",
        &["displacement", "centre", "angle", "gap", "deepest", "velocity", "angular velocity", "quaternion"],
    ),
    (
        "loads",
        "Loads and stresses",
        &[
            "force",
            "von mises",
            "stress",
            "principal",
            "torque",
            "contact bodies",
            "contact walls",
            "impulse",
            "strain energy density",
        ],
    ),
    ("water", "Water", &["pressure", "level", "front", "flow rate", "immersed"]),
    ("energies-of-probes", "Energies of probes", &["energy"]),
    ("sums", "Sums and further quantities", &[]),
];

/// The probes.
pub fn probes(table: &Table) -> Vec<PlotGroup> {
    let times = table.column_at(0);
    let mut list: Vec<PlotGroup> = KINDS
        .iter()
        .map(|(id, headline, _)| PlotGroup { id, headline, note: String::new(), plots: Vec::new() })
        .collect();
    let mut found: Vec<(usize, usize, Plot)> = Vec::new();
    for group in groups(table.columns()).iter().filter(|_| !times.is_empty()) {
        let meaning = &group.meaning;
        let place = KINDS.iter().enumerate().find_map(|(kind, (_, _, quantities))| {
            let rank = quantities.iter().position(|quantity| *quantity == meaning.quantity)?;
            Some((kind, rank))
        });
        let line = |(component, index): &(String, usize)| Line {
            name: component.clone(),
            values: table.column_at(*index),
        };
        let plot = Plot {
            title: title(&meaning.probe, &meaning.quantity),
            unit: meaning.unit.clone(),
            logarithmic: false,
            level: None,
            times: times.clone(),
            lines: group.columns.iter().map(line).collect(),
        };
        let (kind, rank) = place.unwrap_or((KINDS.len() - 1, 0));
        found.push((kind, rank, plot.thinned()));
    }
    // Stable: probes of a quantity stay in the order of the case.
    found.sort_by_key(|(kind, rank, _)| (*kind, *rank));
    for (kind, _, plot) in found {
        list[kind].plots.push(plot);
    }
    list.retain(|group| !group.plots.is_empty());
    list
}

/// Probe and quantity in words, without saying one thing twice.
pub fn title(probe: &str, quantity: &str) -> String {
    let words = probe.replace('_', " ");
    if quantity.is_empty() || words.split(' ').any(|word| word == quantity) {
        words
    } else {
        format!("{words}: {quantity}")
    }
}

/// Balances and forces of the interface; `None` without rows.
pub fn ledger(table: &Table, tolerance: Option<f64>) -> Option<PlotGroup> {
    let times = table.column("t_s").filter(|times| !times.is_empty())?;
    let has = |side: Role| table.columns().iter().any(|column| column.starts_with(&format!("{side}_")));
    let coupled = has(Role::Fluid) && has(Role::Solid);
    let in_space = table.columns().iter().any(|name| name == "solid_force_z_n");
    let per_depth = if in_space { "" } else { "/m" };
    let plot = |title: &str, unit: String, logarithmic: bool, columns: &[(&str, &str)]| {
        let line = |(column, name): &(&str, &str)| {
            Some(Line { name: (*name).into(), values: table.column(column)? })
        };
        let lines: Vec<Line> = columns.iter().filter_map(line).collect();
        let level = tolerance.filter(|_| logarithmic);
        let plot = Plot { title: title.into(), unit, logarithmic, level, times: times.clone(), lines };
        (!plot.lines.is_empty()).then(|| plot.thinned())
    };
    let mut plots = Vec::new();
    if coupled {
        let columns = [
            ("solid_force_x_n_per_m", "x"),
            ("solid_force_y_n_per_m", "y"),
            ("solid_force_x_n", "x"),
            ("solid_force_y_n", "y"),
            ("solid_force_z_n", "z"),
        ];
        plots.push(plot("Force of the fluid on the solids", format!("N{per_depth}"), false, &columns));
        let columns = [
            ("solid_interface_impulse_x_n_s_per_m", "x"),
            ("solid_interface_impulse_y_n_s_per_m", "y"),
            ("solid_interface_impulse_x_n_s", "x"),
            ("solid_interface_impulse_y_n_s", "y"),
            ("solid_interface_impulse_z_n_s", "z"),
        ];
        plots.push(plot("Impulse of the fluid on the solids", format!("N s{per_depth}"), false, &columns));
        let columns = [("imbalance_force", "force"), ("imbalance_torque", "torque")];
        plots.push(plot("Action = reaction: imbalance over gross", String::new(), true, &columns));
    }
    let columns = [("fluid_momentum_residual", "fluid"), ("solid_momentum_residual", "solid")];
    plots.push(plot("Momentum change = impulse: residual over gross", String::new(), true, &columns));
    let columns =
        [("fluid_angular_momentum_residual", "fluid"), ("solid_angular_momentum_residual", "solid")];
    plots.push(plot(
        "Angular momentum change = angular impulse: residual over gross",
        String::new(),
        true,
        &columns,
    ));
    plots.push(plot("Time step", "s".into(), false, &[("time_step_s", "")]));
    let note = "Each point is the worst half-step since the point before. Nothing is drawn where a residual is exactly zero.";
    let allowed = tolerance
        .map_or(String::new(), |t| format!(" The dashed line is the largest that the case allows, {t:e}."));
    let plots: Vec<Plot> = plots.into_iter().flatten().collect();
    (!plots.is_empty()).then(|| PlotGroup {
        id: "ledger",
        headline: "Interface and balances",
        note: format!("{note}{allowed}"),
        plots,
    })
}

/// Energies of both sides by mechanism; `None` without.
pub fn energies(table: &Table) -> Option<PlotGroup> {
    let times = table.column("t_s").filter(|times| !times.is_empty())?;
    let dimensions = energy_dimensions(table);
    let unit = if dimensions == 3 { "J" } else { "J/m" };
    let mut plots = Vec::new();
    for (side, name) in [(Role::Fluid, "Fluid"), (Role::Solid, "Solids")] {
        let lines = |kinds: &[EnergyKind]| -> Vec<Line> {
            let of_kind = EnergyAccount::all().filter(|account| kinds.contains(&account.kind()));
            let mut lines: Vec<Line> = of_kind
                .filter_map(|account| {
                    let values = table.column(&energy_column(side, account, dimensions))?;
                    let is_store = account.kind() == EnergyKind::Store;
                    Some(Line {
                        name: label(account),
                        values: if is_store { change(values) } else { values },
                    })
                })
                .filter(|line| extent(&line.values) > 0.0)
                .collect();
            lines.sort_by(|a, b| extent(&b.values).total_cmp(&extent(&a.values)));
            lines.truncate(MOST_ACCOUNTS);
            lines
        };
        let mut add = |title: String, lines: Vec<Line>| {
            if !lines.is_empty() {
                let plot = Plot {
                    title,
                    unit: unit.into(),
                    logarithmic: false,
                    level: None,
                    times: times.clone(),
                    lines,
                };
                plots.push(plot.thinned());
            }
        };
        add(format!("{name}: stores, change since the first row"), lines(&[EnergyKind::Store]));
        let mut flows = lines(&[EnergyKind::Work, EnergyKind::Loss]);
        if let Some(values) =
            table.column(&energy_residual_column(side, dimensions)).filter(|_| !flows.is_empty())
        {
            flows.push(Line { name: "residual".into(), values });
        }
        add(format!("{name}: works and losses since the start"), flows);
    }
    let note = format!(
        "Change of the stores = works − losses + residual. A loss marked ± may have either sign. The {MOST_ACCOUNTS} \
         largest accounts are drawn; ledger.csv has all."
    );
    (!plots.is_empty()).then_some(PlotGroup { id: "energies", headline: "Energy over time", note, plots })
}

/// Whether the energies of a ledger are of space, 3, or per metre of the plane, 2.
pub fn energy_dimensions(table: &Table) -> usize {
    let in_space = table.columns().iter().any(|name| name.contains("_energy_") && name.ends_with("_j"));
    if in_space { 3 } else { 2 }
}

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

impl Plot {
    /// At most the ends and, of each stretch, the rows where a line is lowest or highest.
    fn thinned(mut self) -> Self {
        let rows = self.times.len();
        let length = rows.div_ceil(STRETCHES / self.lines.len().max(1)).max(1);
        if length <= 2 * self.lines.len().max(1) {
            return self;
        }
        let mut kept = vec![0, rows - 1];
        for start in (0..rows).step_by(length) {
            let stretch = start..rows.min(start + length);
            for line in &self.lines {
                let finite = || stretch.clone().filter(|i| line.values[*i].is_finite());
                let by_value = |a: &usize, b: &usize| line.values[*a].total_cmp(&line.values[*b]);
                kept.extend(finite().min_by(by_value));
                kept.extend(finite().max_by(by_value));
                // A stretch without a number stays a gap.
                kept.extend((finite().next().is_none()).then_some(start));
            }
        }
        kept.sort_unstable();
        kept.dedup();
        self.times = kept.iter().map(|i| self.times[*i]).collect();
        for line in &mut self.lines {
            line.values = kept.iter().map(|i| line.values[*i]).collect();
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_every_peak_and_few_points() {
        let n = 100_000;
        let times: Vec<f64> = (0..n).map(f64::from).collect();
        let mut values = vec![0.0; times.len()];
        (values[54_321], values[77_777]) = (9.0, -8.0);
        let lines =
            vec![Line { name: String::new(), values }, Line { name: "b".into(), values: times.clone() }];
        let plot =
            Plot { title: String::new(), unit: String::new(), logarithmic: false, level: None, times, lines }
                .thinned();
        assert!(plot.times.len() < 3 * STRETCHES, "{}", plot.times.len());
        let at = |t: f64| plot.times.iter().position(|time| *time == t).map(|i| plot.lines[0].values[i]);
        assert_eq!((at(54_321.0), at(77_777.0)), (Some(9.0), Some(-8.0)));
        assert_eq!((plot.times[0], plot.times.last()), (0.0, Some(&99_999.0)));
    }

    #[test]
    fn probes_stand_under_what_they_show_and_titles_do_not_repeat_themselves() {
        let columns = ["t_s", "tip_displacement_x_m", "tip_displacement_y_m", "front_front_x_m", "odd"]
            .map(String::from);
        let mut table = Table::new(columns.into());
        table.push(&[0.0, 1.0, 2.0, f64::NAN, 4.0]);
        let found = probes(&table);
        let ids: Vec<&str> = found.iter().map(|group| group.id).collect();
        assert_eq!(ids, ["motion", "water", "sums"]);
        assert_eq!(found[0].plots[0].title, "tip: displacement");
        assert_eq!(found[1].plots[0].title, "front");
        let json = serde_json::to_string(&found[1]).unwrap();
        assert!(json.contains("\"values\":[null]"), "{json}");
    }
}
