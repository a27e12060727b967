//! Key figures of a run: numbers read off the histories of its probes.

use std::path::Path;

use serde::Serialize;

use crate::case::Case;
use crate::failure::Failure;
use crate::results::names;
use crate::results::probes;
use crate::results::table::Table;
use crate::study::series;

/// A number read off a column of `probes.csv`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figure {
    /// Column, such as `tip_displacement_y_m`.
    pub column: String,
    /// What of it.
    pub measure: Measure,
}

/// What is read off a history.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Measure {
    /// Largest value in a span of time.
    Largest(Times),
    /// Smallest value in a span of time.
    Smallest(Times),
    /// Mean over a span of time, by trapezia.
    Mean(Times),
    /// Value at a time \[s\], between rows by a straight line.
    At(f64),
    /// Last value.
    Last,
    /// First time \[s\] at which the value rises to a level.
    Rises(f64),
    /// First time \[s\] at which the value falls to a level.
    Falls(f64),
}

/// A span of simulated time \[s\]; rows at its ends belong to it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Times {
    /// Start \[s\].
    pub from: f64,
    /// End \[s\].
    pub to: f64,
}

impl Times {
    /// The whole run.
    pub const ALL: Self = Self { from: f64::NEG_INFINITY, to: f64::INFINITY };
}

impl std::fmt::Display for Times {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match (self.from.is_finite(), self.to.is_finite()) {
            (false, false) => Ok(()),
            (true, false) => write!(f, " from {} s", self.from),
            (false, true) => write!(f, " until {} s", self.to),
            (true, true) => write!(f, " from {} to {} s", self.from, self.to),
        }
    }
}

impl std::fmt::Display for Figure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let column = &self.column;
        match self.measure {
            Measure::Largest(times) => write!(f, "largest {column}{times}"),
            Measure::Smallest(times) => write!(f, "smallest {column}{times}"),
            Measure::Mean(times) => write!(f, "mean {column}{times}"),
            Measure::At(time) => write!(f, "{column} at {time} s"),
            Measure::Last => write!(f, "last {column}"),
            Measure::Rises(level) => write!(f, "time [s] at which {column} rises to {level}"),
            Measure::Falls(level) => write!(f, "time [s] at which {column} falls to {level}"),
        }
    }
}

impl std::str::FromStr for Figure {
    type Err = String;

    /// Reads what [`Figure`] displays, such as `body_centre_y_m at 0.15 s` or `mean plate_force_x_n from 0.24 to 0.4 s`.
    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || {
            format!(
                "`{text}` is no key figure; write `largest COLUMN`, `smallest COLUMN` or `mean COLUMN`, each with \
                 ` from T to T s` where it is of a part of the run, `COLUMN at T s`, `last COLUMN`, or \
                 `COLUMN rises to LEVEL` or `COLUMN falls to LEVEL`"
            )
        };
        let words: Vec<&str> = text.split_whitespace().collect();
        let number =
            |word: &str| word.parse::<f64>().ok().filter(|value| value.is_finite()).ok_or_else(wrong);
        let words = match words[..] {
            // As displayed: what is read off comes first.
            ["time", "[s]", "at", "which", ref rest @ ..] => rest,
            [ref rest @ .., "s"] => rest,
            ref all => all,
        };
        let (column, measure) = match *words {
            ["last", column] => (column, Measure::Last),
            [column, "at", time] => (column, Measure::At(number(time)?)),
            [column, "rises", "to", level] => (column, Measure::Rises(number(level)?)),
            [column, "falls", "to", level] => (column, Measure::Falls(number(level)?)),
            [what @ ("largest" | "smallest" | "mean"), column, ref span @ ..] => {
                let (from, to) = match *span {
                    [] => (f64::NEG_INFINITY, f64::INFINITY),
                    ["from", from] => (number(from)?, f64::INFINITY),
                    ["until", to] => (f64::NEG_INFINITY, number(to)?),
                    ["from", from, "to", to] => (number(from)?, number(to)?),
                    _ => return Err(wrong()),
                };
                let times = Times { from, to };
                let measure = match what {
                    "largest" => Measure::Largest(times),
                    "smallest" => Measure::Smallest(times),
                    _ => Measure::Mean(times),
                };
                (column, measure)
            }
            _ => return Err(wrong()),
        };
        Ok(Self { column: column.to_owned(), measure })
    }
}

impl Figure {
    /// Largest, smallest and last value of each of `columns`.
    pub fn of_all<'a>(columns: impl IntoIterator<Item = &'a str>) -> Vec<Self> {
        let measures = [Measure::Largest(Times::ALL), Measure::Smallest(Times::ALL), Measure::Last];
        columns
            .into_iter()
            .flat_map(|column| measures.map(|measure| Self { column: column.to_owned(), measure }))
            .collect()
    }

    /// Its value in a history of (time \[s\], value).
    ///
    /// # Errors
    /// When the history has none: no row in the span, a level that is not reached, no finite number.
    pub fn of_history(&self, history: &[(f64, f64)]) -> Result<f64, String> {
        let within = |times: Times| series::window(history, times.from, times.to);
        let values = |times: Times| within(times).into_iter().map(|row| row.1);
        let negated = || history.iter().map(|(t, value)| (*t, -value)).collect::<Vec<_>>();
        let value = match self.measure {
            // A row that is no number must not hide behind the others.
            Measure::Largest(times) | Measure::Smallest(times) if values(times).any(f64::is_nan) => f64::NAN,
            Measure::Largest(times) => series::largest(values(times)),
            Measure::Smallest(times) => -series::largest(values(times).map(|value| -value)),
            Measure::Mean(times) => series::mean(history, times.from, times.to),
            Measure::At(time) => series::at(history, time),
            Measure::Last => history.last().map_or(f64::NAN, |row| row.1),
            Measure::Rises(level) => series::first_reach(history, level),
            Measure::Falls(level) => series::first_reach(&negated(), -level),
        };
        match value.is_finite() {
            true => Ok(value),
            false => Err(format!("{self}: the run has no such value")),
        }
    }
}

/// Probes of a finished run.
pub struct Histories(Table);

impl Histories {
    /// Reads the results in `folder`.
    ///
    /// # Errors
    /// When they cannot be read.
    pub fn read(folder: &Path) -> Result<Self, String> {
        Table::read(&folder.join(names::PROBES)).map(Self).map_err(|e| e.to_string())
    }

    /// Rows of the column `name` as (time \[s\], value).
    ///
    /// # Errors
    /// When there is no such column.
    pub fn of(&self, name: &str) -> Result<Vec<(f64, f64)>, String> {
        let column = |name: &str| self.0.column(name).ok_or_else(|| format!("no probe column `{name}`"));
        Ok(column("t_s")?.into_iter().zip(column(name)?).collect())
    }
}

/// The `figures` of the finished run in the folder `results`; `None` where it has no such value.
///
/// # Errors
/// When its probes cannot be read or lack a column.
pub fn of_results(results: &Path, figures: &[Figure]) -> Result<Vec<Option<f64>>, Failure> {
    let histories = Histories::read(results).map_err(Failure::output)?;
    let value = |figure: &Figure| {
        // A level that this run does not reach is a result, a column that is missing none.
        Ok(figure.of_history(&histories.of(&figure.column).map_err(Failure::output)?).ok())
    };
    figures.iter().map(value).collect()
}

/// The figures asked for, whose columns must be those of the case's probes; of all columns when none is.
///
/// # Errors
/// When the case has no probe, or none with such a column.
pub fn of_case(case: &Case, asked: &[Figure]) -> Result<Vec<Figure>, Failure> {
    let [fluid, solid] = case.probe_columns();
    let columns = probes::columns(&fluid, &solid);
    let columns: Vec<&str> = columns.iter().map(String::as_str).filter(|name| *name != "t_s").collect();
    if columns.is_empty() {
        let text = "the case has no probe, so that its runs have no key figure; add a [[probe]]";
        return Err(Failure::input(text));
    }
    if asked.is_empty() {
        return Ok(Figure::of_all(columns));
    }
    match asked.iter().find(|figure| !columns.contains(&figure.column.as_str())) {
        None => Ok(asked.to_vec()),
        Some(figure) => {
            let hint = crate::case::suggest(&figure.column, &columns);
            Err(Failure::input(format!(
                "`{figure}`: the case has no probe column `{}`; {hint}",
                figure.column
            )))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_read_as_they_are_displayed() {
        let spans = [Times::ALL, Times { from: 0.1, ..Times::ALL }, Times { to: 0.2, ..Times::ALL }];
        let spans = spans.into_iter().chain([Times { from: 0.1, to: 0.2 }]);
        let measures = spans
            .flat_map(|span| [Measure::Largest(span), Measure::Smallest(span), Measure::Mean(span)])
            .chain([Measure::At(0.25), Measure::Last, Measure::Rises(-1e-3), Measure::Falls(2.0)]);
        for measure in measures {
            let figure = Figure { column: "tip_x_m".to_owned(), measure };
            assert_eq!(figure.to_string().parse(), Ok(figure));
        }
        for wrong in [
            "",
            "tip_x_m",
            "mean",
            "mean tip_x_m from",
            "tip_x_m at noon",
            "median tip_x_m",
            "tip_x_m at nan",
        ] {
            let error = wrong.parse::<Figure>().unwrap_err();
            assert!(error.contains("no key figure") && error.contains("at T s"), "{error}");
        }
    }

    #[test]
    fn figures_are_read_off_a_history() {
        let history = [(0.0, 1.0), (1.0, 3.0), (2.0, 2.0), (3.0, -1.0)];
        let value = |measure| Figure { column: "p_pa".to_owned(), measure }.of_history(&history);
        let times = Times { from: 1.5, to: 3.0 };
        assert_eq!(value(Measure::Largest(Times::ALL)), Ok(3.0));
        assert_eq!(value(Measure::Largest(times)), Ok(2.0));
        assert_eq!(value(Measure::Smallest(times)), Ok(-1.0));
        assert_eq!(value(Measure::Mean(times)), Ok(0.5));
        assert_eq!(value(Measure::At(0.25)), Ok(1.5));
        assert_eq!(value(Measure::Last), Ok(-1.0));
        assert_eq!(value(Measure::Rises(2.0)), Ok(0.5));
        assert_eq!(value(Measure::Falls(0.5)), Ok(2.5));
        let refused = value(Measure::Rises(4.0)).unwrap_err();
        assert!(refused.contains("rises to 4") && refused.contains("no such value"), "{refused}");
        assert!(value(Measure::At(3.5)).is_err());
        let broken = [(0.0, 1.0), (1.0, f64::NAN)];
        let largest = Figure { column: "p_pa".to_owned(), measure: Measure::Largest(Times::ALL) };
        assert!(largest.of_history(&broken).is_err());
    }
}
