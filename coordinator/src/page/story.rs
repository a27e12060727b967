//! What a run says in short: a sentence, key figures, the energy budget.

use serde::Serialize;

use super::film::Extreme;
use super::particles::Matter;
use super::plots::{energy_dimensions, title};
use crate::results::ledger::{energy_column, energy_residual_column};
use crate::results::plots::quantities::meaning;
use crate::results::plots::scale::superscript;
use crate::results::table::Table;
use sph::coupling::ledger::{EnergyAccount, EnergyKind};
use sph::coupling::solver::Role;

/// A number as a person writes it: four digits, with a prefix or, far from 1, a power of ten.
pub fn plain(value: f64, unit: &str) -> String {
    if value == 0.0 {
        return join("0", unit);
    }
    if !value.is_finite() {
        return "no number".into();
    }
    // That of the number as shown: 9.9999 is shown as 10.
    let shown = format!("{value:.3e}");
    let decade: i32 = shown.split_once('e').and_then(|(_, decade)| decade.parse().ok()).unwrap_or(0);
    let is_short = unit == "m" || unit == "s";
    let takes_prefix = is_short || ["Pa", "N", "J", "W"].iter().any(|start| unit.starts_with(start));
    let (exponent, prefix) = match decade.div_euclid(3) {
        3 if takes_prefix && !is_short => (9, "G"),
        2 if takes_prefix && !is_short => (6, "M"),
        1 if takes_prefix && !is_short => (3, "k"),
        // Tenths of a metre and thousandths of a second are as common as they are.
        -1 if takes_prefix && unit != "s" && (unit != "m" || decade < -1) => (-3, "m"),
        -2 if takes_prefix => (-6, "µ"),
        -3 if takes_prefix => (-9, "n"),
        _ => (0, ""),
    };
    let shown = value / 10f64.powi(exponent);
    let decade = decade - exponent;
    if !(-4..=5).contains(&decade) {
        let mantissa = value / 10f64.powi(decade + exponent);
        return join(&format!("{}·10{}", digits(mantissa, 0), superscript(decade + exponent)), unit);
    }
    join(&digits(shown, decade), &format!("{prefix}{unit}"))
}

fn join(number: &str, unit: &str) -> String {
    let number = number.replace('-', "−");
    if unit.is_empty() || unit == "-" { number } else { format!("{number}\u{a0}{unit}") }
}

/// Four digits of a number of the given decade.
fn digits(value: f64, decade: i32) -> String {
    let decimals = usize::try_from(3 - decade).unwrap_or(0);
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// A time as it is written beside a figure.
fn at(time: f64) -> String {
    let text = format!("{time:.4}");
    format!("{}\u{a0}s", text.trim_end_matches('0').trim_end_matches('.'))
}

/// A quantity with its extremes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct KeyFigure {
    /// What it is.
    pub name: String,
    /// Largest value, in words.
    pub largest: String,
    /// When that was, in words; empty where it is not known.
    pub largest_at: String,
    /// The time of it, for the player.
    pub largest_time: Option<f64>,
    /// Smallest value; empty where only the largest is known.
    pub smallest: String,
    /// When that was.
    pub smallest_at: String,
    /// The time of it.
    pub smallest_time: Option<f64>,
    /// Last value.
    pub last: String,
    /// Where the largest was, in words; empty for a probe, whose place the case names.
    pub place: String,
    /// Position of the largest \[m\], for the player.
    pub position: Option<[f64; 3]>,
    /// Rank: lower ones matter more.
    #[serde(skip)]
    rank: usize,
    /// Largest magnitude, and whether it is that of the largest value.
    #[serde(skip)]
    magnitude: f64,
    #[serde(skip)]
    is_largest: bool,
}

/// Quantities in the order of their weight in a table.
const WEIGHT: [&str; 12] = [
    "displacement",
    "von mises",
    "force",
    "pressure",
    "level",
    "front",
    "centre",
    "angle",
    "gap",
    "velocity",
    "torque",
    "flow rate",
];

/// The key figures: extremes of particles and of probes, the weightiest first.
pub fn key_figures(extremes: &[Extreme], probes: &Table, dimensions: usize) -> Vec<KeyFigure> {
    let mut figures: Vec<KeyFigure> =
        extremes.iter().map(|extreme| of_extreme(extreme, dimensions)).collect();
    let times = probes.column_at(0);
    for (index, column) in probes.columns().iter().enumerate().skip(1) {
        let values = probes.column_at(index);
        let finite = || values.iter().zip(&times).filter(|(value, _)| value.is_finite());
        let (Some(most), Some(least)) =
            (finite().max_by(|a, b| a.0.total_cmp(b.0)), finite().min_by(|a, b| a.0.total_cmp(b.0)))
        else {
            continue;
        };
        let meaning = meaning(column);
        let rank = WEIGHT.iter().position(|name| *name == meaning.quantity);
        let component =
            if meaning.component.is_empty() { String::new() } else { format!(", {}", meaning.component) };
        figures.push(KeyFigure {
            name: format!("{}{component}", title(&meaning.probe, &meaning.quantity)),
            largest: plain(*most.0, &meaning.unit),
            largest_at: at(*most.1),
            largest_time: Some(*most.1),
            smallest: plain(*least.0, &meaning.unit),
            smallest_at: at(*least.1),
            smallest_time: Some(*least.1),
            last: values
                .iter()
                .rev()
                .find(|v| v.is_finite())
                .map_or(String::new(), |v| plain(*v, &meaning.unit)),
            place: String::new(),
            position: None,
            rank: rank.map_or(100, |rank| 10 + rank),
            magnitude: most.0.abs().max(least.0.abs()),
            is_largest: most.0.abs() >= least.0.abs(),
        });
    }
    figures.sort_by_key(|figure| figure.rank);
    figures
}

fn of_extreme(extreme: &Extreme, dimensions: usize) -> KeyFigure {
    let whose = match extreme.matter {
        Matter::Solid => "solids",
        _ => "water",
    };
    let place: Vec<String> = extreme.position.iter().take(dimensions).map(|x| format!("{x:.4}")).collect();
    KeyFigure {
        name: format!("{}, {whose}", extreme.field),
        largest: plain(extreme.value, extreme.unit),
        largest_at: at(extreme.time),
        largest_time: Some(extreme.time),
        smallest: String::new(),
        smallest_at: String::new(),
        smallest_time: None,
        last: String::new(),
        place: format!(
            "{}, ({})\u{a0}m",
            extreme.group.replace('_', " "),
            place.join(", ").replace('-', "−")
        ),
        position: Some(extreme.position),
        rank: match (extreme.matter, extreme.field) {
            (Matter::Solid, "von Mises stress") => 0,
            (Matter::Fluid, "pressure") => 1,
            (Matter::Fluid, _) => 2,
            _ => 3,
        },
        magnitude: extreme.value.abs(),
        is_largest: true,
    }
}

/// What came out, in a sentence: the largest displacement, the largest stress, what the water did.
pub fn sentence(figures: &[KeyFigure], simulated: f64, steps: u64) -> String {
    let mut parts: Vec<String> = Vec::new();
    let displacement = figures
        .iter()
        .filter(|figure| figure.name.contains("displacement"))
        .max_by(|a, b| a.magnitude.total_cmp(&b.magnitude));
    if let Some(figure) = displacement {
        let (value, when) = match figure.is_largest {
            true => (&figure.largest, &figure.largest_at),
            false => (&figure.smallest, &figure.smallest_at),
        };
        parts.push(format!("{} reaches {value} at {when}", figure.name.replace(": ", " ")));
    }
    for figure in figures.iter().filter(|figure| figure.position.is_some()).take(2) {
        parts.push(format!(
            "largest {} {} at {} in {}",
            figure.name.replace(", water", " of the water").replace(", solids", ""),
            figure.largest,
            figure.largest_at,
            figure.place.split(',').next().unwrap_or("")
        ));
    }
    let head = format!("{} simulated in {steps} steps", plain(simulated, "s"));
    if parts.is_empty() { format!("{head}.") } else { format!("{head}: {}.", parts.join("; ")) }
}

/// One account of the energy budget.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Account {
    /// Name in words.
    pub name: String,
    /// `store`, `work`, `loss` or `residual`.
    pub kind: &'static str,
    /// Change of a store, sum of a work or loss.
    pub value: f64,
    /// The same in words.
    pub text: String,
}

/// The energy budget of one side.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Budget {
    /// `Fluid` or `Solids`.
    pub side: &'static str,
    /// Its accounts, stores first, the largest first within a kind; zeros are left out.
    pub accounts: Vec<Account>,
}

/// The energy budget of each side at the last row of the ledger.
pub fn budgets(table: &Table) -> Vec<Budget> {
    let dimensions = energy_dimensions(table);
    let unit = if dimensions == 3 { "J" } else { "J/m" };
    let sides = [(Role::Fluid, "Fluid"), (Role::Solid, "Solids")];
    let budget = |(role, side): (Role, &'static str)| {
        let mut accounts: Vec<Account> = EnergyAccount::all()
            .filter_map(|account| {
                let values = table.column(&energy_column(role, account, dimensions))?;
                let (first, last) = (values.first()?, values.last()?);
                let (kind, value) = match account.kind() {
                    EnergyKind::Store => ("store", last - first),
                    EnergyKind::Work => ("work", *last),
                    EnergyKind::Loss => ("loss", *last),
                };
                Some(Account {
                    name: account.name().replace('_', " "),
                    kind,
                    value,
                    text: plain(value, unit),
                })
            })
            .filter(|account| account.value != 0.0)
            .collect();
        let order = |kind: &str| ["store", "work", "loss"].iter().position(|k| *k == kind);
        accounts.sort_by(|a, b| {
            (order(a.kind)).cmp(&order(b.kind)).then(b.value.abs().total_cmp(&a.value.abs()))
        });
        if accounts.is_empty() {
            return None;
        }
        if let Some(value) =
            table.column(&energy_residual_column(role, dimensions)).and_then(|v| v.last().copied())
        {
            accounts.push(Account {
                name: "residual".into(),
                kind: "residual",
                value,
                text: plain(value, unit),
            });
        }
        Some(Budget { side, accounts })
    };
    sides.into_iter().filter_map(budget).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_as_a_person_does() {
        let cases = [
            (0.01912, "m", "19.12\u{a0}mm"),
            (0.2502, "m", "0.2502\u{a0}m"),
            (712_345.0, "Pa", "712.3\u{a0}kPa"),
            (-7.4733, "J/m", "−7.473\u{a0}J/m"),
            (0.0052, "N/m", "5.2\u{a0}mN/m"),
            (0.05, "s", "0.05\u{a0}s"),
            (1e-4, "s", "100\u{a0}µs"),
            (1000.0, "kg/m³", "1000\u{a0}kg/m³"),
            (3.0, "", "3"),
            (0.0, "Pa", "0\u{a0}Pa"),
            (1.5e-7, "kg/m", "1.5·10⁻⁷\u{a0}kg/m"),
            (2.5e8, "", "2.5·10⁸"),
            (f64::NAN, "m", "no number"),
        ];
        for (value, unit, text) in cases {
            assert_eq!(plain(value, unit), text);
        }
    }

    #[test]
    fn the_sentence_names_the_largest_displacement_of_either_sign_and_what_particles_saw() {
        let columns = ["t_s", "tip_displacement_x_m", "gauge_pressure_pa"].map(String::from);
        let mut probes = Table::new(columns.into());
        for (t, x, p) in [(0.0, 0.0, 5.0), (0.1, -0.02, 9.0), (0.2, 0.01, f64::NAN)] {
            probes.push(&[t, x, p]);
        }
        let extreme = Extreme {
            matter: Matter::Solid,
            field: "von Mises stress",
            unit: "Pa",
            value: 7.1e5,
            time: 0.15,
            position: [0.4, 0.01, 0.0],
            group: "thin_plate".into(),
            id: 7,
        };
        let figures = key_figures(&[extreme], &probes, 2);
        let names: Vec<&str> = figures.iter().map(|figure| figure.name.as_str()).collect();
        assert_eq!(names, ["von Mises stress, solids", "tip: displacement, x", "gauge: pressure"]);
        assert_eq!(figures[0].place, "thin plate, (0.4000, 0.0100)\u{a0}m");
        assert_eq!((figures[2].last.as_str(), figures[2].largest_at.as_str()), ("9\u{a0}Pa", "0.1\u{a0}s"));
        let sentence = sentence(&figures, 0.2, 2000);
        assert!(
            sentence.starts_with(
                "0.2\u{a0}s simulated in 2000 steps: tip displacement, x reaches −20\u{a0}mm at 0.1\u{a0}s; "
            ),
            "{sentence}"
        );
        assert!(
            sentence.ends_with("largest von Mises stress 710\u{a0}kPa at 0.15\u{a0}s in thin plate."),
            "{sentence}"
        );
    }
}
