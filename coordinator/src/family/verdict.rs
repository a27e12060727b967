//! What a family says of each key figure under refinement, and of the answer as a whole.

use serde::Serialize;

use super::convergence::Trend;
use super::{Family, FigureResult};

/// Largest estimated error over the value at which a figure counts as converged, unless another is asked for.
pub const TOLERANCE: f64 = 0.05;

/// A key figure under refinement.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// The figure, in words.
    pub figure: String,
    /// Column of the probes that it is read off.
    pub column: String,
    /// Values at the finest spacing of each kind, coarse before fine, at the highest sound speed.
    pub over_spacing: Vec<Option<f64>>,
    /// Value at the finest spacing and the highest sound speed.
    pub finest: Option<f64>,
    /// Observed order in space.
    pub order: Option<f64>,
    /// Estimated error of the finest value, of spacing and sound speed together; `None` where it is unknown.
    pub error: Option<f64>,
    /// Whether the error is known and small enough.
    pub converged: bool,
    /// Why not, in words; empty where it is.
    pub reason: String,
}

/// Estimated error of the finest value; `None` where it is unknown.
fn error_of(trend: &Trend) -> Option<f64> {
    match trend {
        Trend::Unchanged => Some(0.0),
        Trend::WithinSpread { uncertainty } => Some(*uncertainty),
        Trend::Pair { error, .. } | Trend::Converging { error, .. } | Trend::NotConverged { error, .. } => {
            Some(*error)
        }
        Trend::TooFew => None,
    }
}

impl Verdict {
    /// Of `result`, which is converged up to an error of `tolerance` over its value.
    pub fn of(result: &FigureResult, tolerance: f64) -> Self {
        let speed = result.values.last().and_then(|at| at.sound_speed_m_s);
        let at_speed = result.values.iter().filter(|at| at.sound_speed_m_s == speed);
        let over_spacing: Vec<Option<f64>> = at_speed.map(|at| at.spread.map(|spread| spread.mean)).collect();
        let finest = over_spacing.last().copied().flatten();
        let in_space = result.over_spacing.iter().find(|(at, _)| *at == speed).map(|(_, trend)| trend);
        let in_sound = result.over_sound_speed.last().map(|(_, trend)| trend);
        let order = match in_space {
            Some(Trend::Converging { order, .. }) => Some(*order),
            _ => None,
        };
        let trends = [("spacing", in_space), ("sound speed", in_sound)];
        let trends = trends.into_iter().filter_map(|(what, trend)| Some((what, trend?)));
        let squares = trends
            .clone()
            .try_fold(0.0, |sum: f64, (_, trend)| error_of(trend).map(|error| sum + error * error));
        let error = squares.filter(|_| finest.is_some()).map(f64::sqrt);
        let is_small = error.zip(finest).is_some_and(|(error, value)| error <= tolerance * value.abs());
        let mut reasons = Vec::new();
        if !is_small {
            // Where there is no order, the cause is better known than the size of the error.
            let without = |trend: &Trend| matches!(trend, Trend::TooFew | Trend::NotConverged { .. });
            let without = trends.filter(|(_, trend)| without(trend));
            reasons.extend(without.map(|(what, trend)| format!("over the {what} {trend}")));
            match (error, finest) {
                (_, None) => reasons.push("the finest run has no such value".to_owned()),
                // Of a value of zero no share can be taken.
                (Some(error), Some(0.0)) => {
                    reasons.push(format!("the estimated error is {error:.2e} at a value of 0"));
                }
                (Some(error), Some(value)) if reasons.is_empty() => {
                    reasons.push(format!("the estimated error is {:.1} %", 100.0 * error / value.abs()));
                }
                _ => {}
            }
        }
        let figure = result.figure.to_string();
        let column = result.figure.column.clone();
        let reason = reasons.join("; ");
        Self { figure, column, over_spacing, finest, order, error, converged: is_small, reason }
    }

    /// Estimated error over the value; `None` where it is unknown, or the value is zero.
    pub fn error_over_value(&self) -> Option<f64> {
        let value = self.finest.filter(|value| *value != 0.0)?;
        Some(self.error? / value.abs())
    }

    /// Whether the figure is the same at all resolutions, so that there is nothing to judge.
    pub fn is_constant(&self) -> bool {
        self.error == Some(0.0)
    }
}

/// What `family` says of each key figure, those apart that are the same at all resolutions, or everywhere as an earlier one.
pub fn verdicts(family: &Family, tolerance: f64) -> Vec<Verdict> {
    let means = |result: &FigureResult| -> Vec<Option<f64>> {
        result.values.iter().map(|at| at.spread.map(|spread| spread.mean)).collect()
    };
    let is_new =
        |k: usize| !family.figures[..k].iter().any(|other| means(other) == means(&family.figures[k]));
    let all = family.figures.iter().enumerate().filter(|(k, _)| is_new(*k));
    all.map(|(_, result)| Verdict::of(result, tolerance)).filter(|verdict| !verdict.is_constant()).collect()
}

/// The answer as a whole, in a sentence or two.
pub fn sentence(verdicts: &[Verdict], tolerance: f64) -> String {
    let open: Vec<&str> =
        verdicts.iter().filter(|verdict| !verdict.converged).map(|verdict| verdict.figure.as_str()).collect();
    let share = 100.0 * tolerance;
    match (verdicts.len(), open.len()) {
        (0, _) => "All key figures are the same at all resolutions.".to_owned(),
        (count, 0) => {
            format!("Converged: the estimated error of each of {count} key figures is at most {share} %.")
        }
        (count, k) => {
            const NAMED: usize = 3;
            let mut named = open[..k.min(NAMED)].join(", ");
            if k > NAMED {
                named.push_str(&format!(" and {} more", k - NAMED));
            }
            format!(
                "NOT CONVERGED: {k} of {count} key figures have an estimated error above {share} %: {named}. \
                 Refine by `--spacings`; where the motion is chaotic, judge means of `ensemble` in its place."
            )
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Resolution;
    use super::super::convergence::{Reason, trend};
    use super::super::figures::{Figure, Measure};
    use super::super::spread::Spread;
    use super::*;

    /// A figure with `values` at halved spacings, at one sound speed, and `slower` at the finest with sound 1.5 times slower.
    fn result(values: [f64; 3], slower: Option<f64>) -> FigureResult {
        let spread = |value: f64| Spread::of(&[value]).unwrap();
        let at = |(k, value): (usize, &f64)| Resolution {
            spacing_m: 4.0 / 2f64.powi(k as i32),
            sound_speed_m_s: Some(30.0),
            missing: 0,
            spread: Some(spread(*value)),
        };
        let values: Vec<Resolution> = values.iter().enumerate().map(at).collect();
        let points: Vec<_> = values.iter().map(|at| (at.spacing_m, at.spread.unwrap())).collect();
        let finest = points[2].1;
        let sound = slower.map(|slower| trend(&[(1.0 / 20.0, spread(slower)), (1.0 / 30.0, finest)]));
        FigureResult {
            figure: Figure { column: "tip_m".into(), measure: Measure::Last },
            over_spacing: vec![(Some(30.0), trend(&points))],
            over_sound_speed: sound.map(|trend| (1.0, trend)).into_iter().collect(),
            values,
        }
    }

    #[test]
    fn errors_of_spacing_and_sound_add_up() {
        // 10 + h²: errors 16, 4, 1; the estimate of the last is 1.25. Sound: 3/(1.5² − 1) of a difference of 0.5 is 1.2.
        let verdict = Verdict::of(&result([26.0, 14.0, 11.0], Some(11.5)), 0.2);
        assert!((verdict.order.unwrap() - 2.0).abs() < 1e-9);
        assert!((verdict.error.unwrap() - 1.25_f64.hypot(1.2)).abs() < 1e-9, "{verdict:?}");
        assert!(verdict.converged && verdict.reason.is_empty());
        let strict = Verdict::of(&result([26.0, 14.0, 11.0], Some(11.5)), 0.1);
        assert!(!strict.converged);
        assert_eq!(strict.reason, "the estimated error is 15.8 %");
    }

    #[test]
    fn a_figure_without_an_order_has_the_error_of_its_range_and_the_sentence_names_it() {
        let open = Verdict::of(&result([1.0, 3.0, 2.0], None), TOLERANCE);
        assert_eq!((open.error, open.order, open.converged), (Some(6.0), None, false));
        let why = Trend::NotConverged { reason: Reason::Oscillates, error: 6.0 }.to_string();
        assert!(open.reason.contains(&why), "{}", open.reason);
        // Up and down by so little that it does not matter: the level of the water at the start.
        let level = Verdict::of(&result([0.29134, 0.29133, 0.29134], None), TOLERANCE);
        assert!(level.converged && level.order.is_none() && level.reason.is_empty(), "{level:?}");
        let good = Verdict::of(&result([10.16, 10.04, 10.01], None), TOLERANCE);
        assert!(good.converged, "{good:?}");
        let said = sentence(&[open, good.clone()], TOLERANCE);
        assert!(
            said.starts_with("NOT CONVERGED: 1 of 2 key figures") && said.contains("last tip_m"),
            "{said}"
        );
        let said = sentence(&[good], TOLERANCE);
        assert!(said.starts_with("Converged: ") && said.contains("at most 5 %"), "{said}");
        let constant = Verdict::of(&result([1.0, 1.0, 1.0], Some(1.0)), TOLERANCE);
        assert!(constant.is_constant() && constant.converged);
    }

    #[test]
    fn a_value_of_zero_with_an_error_is_not_converged() {
        let verdict = Verdict::of(&result([0.5, 0.2, 0.0], None), TOLERANCE);
        assert!(!verdict.converged && !verdict.reason.is_empty(), "{verdict:?}");
    }
}
