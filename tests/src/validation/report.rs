//! The table of all figures: on screen, as CSV and as Markdown.

use std::fmt::Write as _;
use std::path::Path;

use coordinator::family::convergence::order_of_errors;
use terminal::say;

use super::{Figure, Goal, Run};

/// One figure of one run.
#[derive(Clone, Debug)]
pub struct Row {
    /// Case.
    pub case: String,
    /// Scheme or variant.
    pub scheme: String,
    /// Particle spacing \[m\].
    pub spacing: f64,
    /// The figure.
    pub figure: Figure,
    /// Order of convergence from the next coarser run of the scheme.
    pub order: Option<f64>,
    /// CPU time of the run \[s\].
    pub cpu_seconds: f64,
    /// Settings of the fluid.
    pub settings: String,
}

/// Rows of the runs of one case with their figures, orders included.
pub fn rows(case: &str, results: &[(&Run, Vec<Figure>)]) -> Vec<Row> {
    let mut rows: Vec<Row> = Vec::new();
    for (run, figures) in results {
        for figure in figures {
            let coarser = rows.iter().rev().find(|row| {
                row.scheme == run.member.scheme
                    && row.figure.name == figure.name
                    && row.spacing > run.member.spacing
            });
            let order = coarser.and_then(|coarser| {
                let errors = (coarser.figure.error()?, figure.error()?);
                order_of_errors((coarser.spacing, errors.0), (run.member.spacing, errors.1))
            });
            rows.push(Row {
                case: case.to_owned(),
                scheme: run.member.scheme.to_owned(),
                spacing: run.member.spacing,
                figure: figure.clone(),
                order,
                cpu_seconds: run.cpu_seconds,
                settings: run.settings(),
            });
        }
    }
    rows
}

const COLUMNS: [&str; 12] = [
    "case",
    "scheme",
    "particle_spacing_m",
    "figure",
    "value",
    "reference",
    "relative_error",
    "goal",
    "met",
    "observed_order",
    "cpu_seconds",
    "settings",
];

impl Row {
    fn cells(&self, digits: impl Fn(f64) -> String) -> [String; 12] {
        let optional = |value: Option<f64>| value.map_or(String::new(), &digits);
        [
            self.case.clone(),
            self.scheme.clone(),
            self.spacing.to_string(),
            self.figure.name.clone(),
            digits(self.figure.value),
            optional(self.figure.reference),
            optional(self.figure.error()),
            goal(self.figure.goal),
            self.figure.passes().map_or("", |met| if met { "yes" } else { "NO" }).to_owned(),
            self.order.filter(|order| order.is_finite()).map_or(String::new(), |order| format!("{order:.2}")),
            format!("{:.1}", self.cpu_seconds),
            self.settings.clone(),
        ]
    }
}

fn goal(goal: Goal) -> String {
    match goal {
        Goal::None => String::new(),
        Goal::Relative(tolerance) => format!("within {} %", short(100.0 * tolerance)),
        Goal::AtMost(limit) => format!("at most {}", short(limit)),
        Goal::AtLeast(limit) => format!("at least {}", short(limit)),
        Goal::Between(low, high) => format!("{} to {}", short(low), short(high)),
    }
}

/// A number with five significant digits.
pub fn short(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let text = if (1e-3..1e6).contains(&value.abs()) {
        // The exponent of a number of this range is within ±6.
        let decimals = (4.0 - value.abs().log10().floor()).max(0.0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.4e}")
    };
    if text.contains('.') && !text.contains('e') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// Writes `validation.csv` and `validation.md` into `folder`.
///
/// # Errors
/// When they cannot be written.
pub fn write(folder: &Path, rows: &[Row]) -> Result<(), String> {
    let mut csv = COLUMNS.join(",") + "\n";
    for row in rows {
        let quoted = |cell: &String| {
            if cell.contains([',', '"']) {
                format!("\"{}\"", cell.replace('"', "\"\""))
            } else {
                cell.clone()
            }
        };
        csv += &row.cells(|value| format!("{value:?}")).iter().map(quoted).collect::<Vec<_>>().join(",");
        csv.push('\n');
    }
    for (name, text) in [("validation.csv", csv), ("validation.md", markdown(rows))] {
        let path = folder.join(name);
        std::fs::write(&path, text).map_err(|e| format!("`{}` cannot be written: {e}", path.display()))?;
    }
    Ok(())
}

/// The table as Markdown; settings stand once per case and scheme below it.
pub fn markdown(rows: &[Row]) -> String {
    let mut text = String::new();
    let shown = COLUMNS.len() - 1;
    let _ = writeln!(text, "| {} |", COLUMNS[..shown].join(" | "));
    let _ = writeln!(text, "|{}", "---|".repeat(shown));
    for row in rows {
        let _ = writeln!(text, "| {} |", row.cells(short)[..shown].join(" | ").replace('_', " "));
    }
    text.push_str("\nSettings:\n\n");
    let mut seen: Vec<(&str, &str, f64)> = Vec::new();
    for row in rows {
        let key = (row.case.as_str(), row.scheme.as_str(), row.spacing);
        if !seen.contains(&key) {
            seen.push(key);
            let _ = writeln!(text, "- {}, {}, {} m: {}", row.case, row.scheme, row.spacing, row.settings);
        }
    }
    text
}

/// Prints rows in columns.
pub fn print(rows: &[Row]) {
    for row in rows {
        let [_, scheme, spacing, name, value, reference, error, goal, met, order, ..] = row.cells(short);
        let reference =
            if reference.is_empty() { String::new() } else { format!("ref {reference} ({error})") };
        let order = if order.is_empty() { String::new() } else { format!("order {order}") };
        say(format_args!(
            "  {met:>3}  {scheme} {spacing:<8} {name:<58} {value:>12}  {reference:<30} {goal:<18} {order}"
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_five_digits() {
        let found: Vec<String> = [2893.95, 0.001_234_56, 1.0, -17.160_4, 3.2e-9].map(short).into();
        assert_eq!(found, ["2893.9", "0.0012346", "1", "-17.16", "3.2000e-9"].map(String::from));
    }
}
