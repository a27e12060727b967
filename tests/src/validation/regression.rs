//! Figures of the short members as they were last stored, with the tolerance and the reason for it: shows a drift that is
//! far from any goal.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::{Figure, Goal};

/// Stored figures of one case.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Series {
    /// Largest difference from a stored value, relative to it \[-\].
    pub tolerance: f64,
    /// Why it is what it is.
    pub reason: String,
    /// Values by member and figure; those that compare members stand under `all`.
    pub figures: BTreeMap<String, BTreeMap<String, f64>>,
}

/// Name for figures that compare members.
pub const COMPARISON: &str = "all";

/// Differences below this part of the largest figure of a member are round-off, as residuals of balances are \[-\].
const ROUND_OFF: f64 = 1e-9;

/// Part of its bound below which a figure may change \[-\].
const NEGLIGIBLE: f64 = 1e-3;

/// Whether `figure` is one of the physics; what a run costs is no such.
fn is_stored(figure: &&Figure) -> bool {
    !figure.name.starts_with("CPU time")
}

fn path() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("reference/regression.toml")
}

/// The stored series by case.
///
/// # Errors
/// When the file cannot be read.
pub fn stored() -> Result<BTreeMap<String, Series>, String> {
    let path = path();
    let text = std::fs::read_to_string(&path).map_err(|e| format!("`{}`: {e}", path.display()))?;
    toml::from_str(&text).map_err(|e| format!("`{}`: {e}", path.display()))
}

/// Stores the figures of `case` in place of those of `member`; tolerance and reason stay.
///
/// # Errors
/// When the file cannot be written, or does not name the case.
pub fn store(case: &str, member: &str, figures: &[Figure]) -> Result<(), String> {
    let mut all = stored()?;
    let series = all.get_mut(case).ok_or_else(|| {
        format!("`{}`: no `[{case}]`; add it with `tolerance` and `reason`", path().display())
    })?;
    series.figures.insert(
        member.to_owned(),
        figures.iter().filter(is_stored).map(|f| (f.name.clone(), f.value)).collect(),
    );
    let text = toml::to_string(&all).map_err(|e| e.to_string())?;
    std::fs::write(path(), text).map_err(|e| format!("`{}`: {e}", path().display()))
}

impl Series {
    /// How `figures` of `member` differ from those that are stored.
    pub fn differences(&self, member: &str, figures: &[Figure]) -> Vec<String> {
        let none = BTreeMap::new();
        let stored = self.figures.get(member).unwrap_or(&none);
        let round_off = ROUND_OFF * stored.values().map(|value| value.abs()).fold(0.0, f64::max);
        let mut found = Vec::new();
        for Figure { name, value, goal, .. } in figures.iter().filter(is_stored) {
            match stored.get(name) {
                None => found.push(format!("{member}, {name}: no value is stored, now {value}")),
                Some(before) => {
                    let close = (value - before).abs() <= self.tolerance * before.abs() + round_off;
                    let largest = value.abs().max(before.abs());
                    let negligible = matches!(goal, Goal::AtMost(limit) if largest < NEGLIGIBLE * limit);
                    if !(close || negligible || value.is_nan() && before.is_nan()) {
                        found.push(format!("{member}, {name}: {before} is stored, now {value}"));
                    }
                }
            }
        }
        let gone = stored.keys().filter(|name| !figures.iter().any(|figure| figure.name == **name));
        found.extend(gone.map(|name| format!("{member}, {name}: stored, but no figure now")));
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_that_drifts_appears_or_goes_is_a_difference() {
        let figures = BTreeMap::from([("a".to_owned(), 2.0), ("b".to_owned(), 0.0)]);
        let series = Series {
            tolerance: 0.01,
            reason: String::new(),
            figures: BTreeMap::from([("m".to_owned(), figures)]),
        };
        let differences = |pairs: &[(&str, f64)]| {
            let figures: Vec<_> = pairs.iter().map(|(name, value)| Figure::reported(*name, *value)).collect();
            series.differences("m", &figures).len()
        };
        assert_eq!(differences(&[("a", 2.019), ("b", 0.0)]), 0);
        assert_eq!(differences(&[("a", 2.021), ("b", 0.0)]), 1);
        assert_eq!(differences(&[("a", f64::NAN), ("b", 1e-6)]), 2);
        assert_eq!(differences(&[("a", 2.0)]), 1);
        assert_eq!(differences(&[("a", 2.0), ("b", 0.0), ("c", 1.0)]), 1);
    }
}
