//! What a sequence of refined runs says: whether it converges, at which order, to which value, how far off it still is.

use serde::Serialize;

use super::spread::Spread;

/// Order of the scheme in space. An observed order above it is chance, and is not trusted when the error is estimated.
const FORMAL_ORDER: f64 = 2.0;

/// Factor of safety on the estimated error: that of the grid convergence index for three resolutions, by which about 95 of
/// 100 sequences bound the true error (Roache 1994; Celik et al. 2008).
const SAFETY: f64 = 1.25;

/// Factor of safety where there is no order: of two resolutions, with the formal one (Roache 1994), and of three that do not
/// converge, on their range (Eça and Hoekstra 2006).
const SAFETY_WITHOUT_ORDER: f64 = 3.0;

/// Least order that counts as convergence. Below it, half the step takes off less than 30 % of the error, and the
/// extrapolated value lies more than 2.4 times the last difference beyond the finest run.
const LEAST_ORDER: f64 = 0.5;

/// Differences below this part of the values are round-off, not a trend.
const ROUND_OFF: f64 = 1e-12;

/// Standard errors within which a difference of means is chance at 95 %.
const CHANCE: f64 = 2.0;

/// What the values of a figure do under refinement.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "verdict", rename_all = "kebab-case")]
pub enum Trend {
    /// Fewer than two resolutions have a value: nothing can be said.
    TooFew,
    /// Two resolutions have a value: there is a difference, but no order.
    Pair {
        /// Finer less coarser value.
        difference: f64,
        /// Estimated error of the finer value, were the order that of the scheme, in the unit of the figure.
        error: f64,
    },
    /// All values are the same up to round-off.
    Unchanged,
    /// The difference of the two finest is no larger than chance, as the spread over seeds says.
    WithinSpread {
        /// Half the width of the interval that holds the difference of the two finest by chance.
        uncertainty: f64,
    },
    /// Differences fall as a power of the step.
    Converging {
        /// Observed order, of the three finest.
        order: f64,
        /// Value at a step of zero by Richardson's extrapolation.
        extrapolated: f64,
        /// Estimated error of the finest value, grid convergence index, in the unit of the figure.
        error: f64,
    },
    /// The three finest do not converge: there is no order.
    NotConverged {
        /// Why.
        reason: Reason,
        /// Estimated error of the finest value: three times the range of the three (Eça and Hoekstra 2006), in the unit of
        /// the figure.
        error: f64,
    },
}

/// Why a sequence does not count as converging.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reason {
    /// The last two differences have different signs.
    Oscillates,
    /// The last difference is no smaller than the one before, step for step.
    Grows,
    /// Differences fall at an order below one half.
    TooSlow,
}

impl std::fmt::Display for Trend {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::TooFew => write!(f, "there are fewer than two values"),
            Self::Pair { difference, error } => {
                write!(f, "difference {difference:.3e}, estimated error at second order {error:.2e}")
            }
            Self::Unchanged => write!(f, "the same at all resolutions"),
            Self::WithinSpread { uncertainty } => {
                write!(f, "the two finest differ by chance only, within {uncertainty:.3e}")
            }
            Self::Converging { order, extrapolated, error } => {
                write!(f, "order {order:.2}, extrapolated {extrapolated:.6e}, estimated error {error:.2e}")
            }
            Self::NotConverged { reason, .. } => f.write_str(match reason {
                Reason::Oscillates => "not converged: the values go up and down",
                Reason::Grows => "not converged: the differences do not fall",
                Reason::TooSlow => "not converged: the differences hardly fall",
            }),
        }
    }
}

/// Observed order between a coarser and a finer run, each given as (step, error against a known answer).
pub fn order_of_errors(coarse: (f64, f64), fine: (f64, f64)) -> Option<f64> {
    let order = (coarse.1 / fine.1).abs().ln() / (coarse.0 / fine.0).ln();
    order.is_finite().then_some(order)
}

/// What the three finest of `points`, steps with values, say. A step is what refinement makes smaller: the spacing,
/// or one over the sound speed.
pub fn trend(points: &[(f64, Spread)]) -> Trend {
    let mut points: Vec<(f64, Spread)> = points.to_vec();
    points.sort_by(|a, b| b.0.total_cmp(&a.0));
    let (coarse, middle, fine) = match points[..] {
        [.., coarse, middle, fine] => (coarse, middle, fine),
        [coarse, fine] => return pair(coarse, fine),
        _ => return Trend::TooFew,
    };
    let (f1, f2, f3) = (coarse.1.mean, middle.1.mean, fine.1.mean);
    let scale = f1.abs().max(f2.abs()).max(f3.abs());
    let (first, last) = (f2 - f1, f3 - f2);
    if first.abs().max(last.abs()) <= ROUND_OFF * scale {
        return Trend::Unchanged;
    }
    if let (Some(a), Some(b)) = (middle.1.standard_error(), fine.1.standard_error()) {
        let uncertainty = CHANCE * a.hypot(b);
        if last.abs() <= uncertainty {
            return Trend::WithinSpread { uncertainty };
        }
    }
    match order([coarse.0, middle.0, fine.0], last / first) {
        Err(reason) => {
            let range = f1.max(f2).max(f3) - f1.min(f2).min(f3);
            Trend::NotConverged { reason, error: SAFETY_WITHOUT_ORDER * range }
        }
        Ok(order) => {
            let ahead = |order: f64| last / ((middle.0 / fine.0).powf(order) - 1.0);
            // Above the formal order the last difference may be small by chance: the one before it counts too. At that
            // order both estimates are the same.
            let error = if order > FORMAL_ORDER {
                let from_coarser = first / (coarse.0.powf(FORMAL_ORDER) - middle.0.powf(FORMAL_ORDER))
                    * fine.0.powf(FORMAL_ORDER);
                ahead(FORMAL_ORDER).abs().max(from_coarser.abs())
            } else {
                ahead(order).abs()
            };
            Trend::Converging { order, extrapolated: f3 + ahead(order), error: SAFETY * error }
        }
    }
}

/// What two values, steps before means, say.
fn pair(coarse: (f64, Spread), fine: (f64, Spread)) -> Trend {
    let (before, after) = (coarse.1.mean, fine.1.mean);
    let difference = after - before;
    if difference.abs() <= ROUND_OFF * before.abs().max(after.abs()) {
        return Trend::Unchanged;
    }
    let error = SAFETY_WITHOUT_ORDER * (difference / ((coarse.0 / fine.0).powf(FORMAL_ORDER) - 1.0)).abs();
    Trend::Pair { difference, error }
}

/// The order p at which f = f₀ + C hᵖ has the ratio of differences of three steps, coarse before fine:
///
/// ```text
/// (f₃ − f₂)/(f₂ − f₁) = (h₂ᵖ − h₃ᵖ)/(h₁ᵖ − h₂ᵖ)        Roache 1994
/// ```
fn order(steps: [f64; 3], ratio: f64) -> Result<f64, Reason> {
    // Steps over the middle one keep the powers in range.
    let [wide, narrow] = [steps[0] / steps[1], steps[2] / steps[1]];
    let of_order = |p: f64| -(p * narrow.ln()).exp_m1() / (p * wide.ln()).exp_m1();
    if ratio <= 0.0 {
        return Err(Reason::Oscillates);
    }
    // The limit of the right side for p towards zero; it falls with p.
    if ratio >= -narrow.ln() / wide.ln() {
        return Err(Reason::Grows);
    }
    if ratio > of_order(LEAST_ORDER) {
        return Err(Reason::TooSlow);
    }
    let (mut low, mut high) = (LEAST_ORDER, 2.0 * LEAST_ORDER);
    // Beyond 64 the finest two agree to round-off.
    while of_order(high) > ratio && high < 64.0 {
        high *= 2.0;
    }
    // Bisection to round-off.
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if of_order(middle) > ratio { low = middle } else { high = middle }
    }
    Ok(0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(points: &[(f64, f64)]) -> Trend {
        let points: Vec<(f64, Spread)> =
            points.iter().map(|(h, f)| (*h, Spread::of(&[*f]).unwrap())).collect();
        trend(&points)
    }

    #[test]
    fn a_power_law_has_its_order_its_limit_and_a_bound_of_its_error() {
        for p in [0.7, 1.0, 2.0] {
            let f = |h: f64| 3.0 - 0.4 * h.powf(p);
            // Ratios of refinement that differ.
            for steps in [[0.4, 0.2, 0.1], [0.5, 0.2, 0.1], [0.3, 0.25, 0.1]] {
                let Trend::Converging { order, extrapolated, error } = of(&steps.map(|h| (h, f(h)))) else {
                    panic!("{p} {steps:?}")
                };
                // Bisection ends at round-off, which the differences of nearby values enlarge.
                assert!((order - p).abs() < 1e-9, "{order} {p}");
                assert!((extrapolated - 3.0).abs() < 1e-9, "{extrapolated}");
                let exact = (f(0.1) - 3.0).abs();
                assert!((error / exact - SAFETY).abs() < 1e-6, "{error} {exact}");
            }
        }
        // The order of the points does not matter.
        assert_eq!(of(&[(1.0, 4.0), (2.0, 7.0), (4.0, 19.0)]), of(&[(4.0, 19.0), (1.0, 4.0), (2.0, 7.0)]));
    }

    #[test]
    fn an_order_above_that_of_the_scheme_lowers_no_error() {
        // Differences 16 to 1: order 4 by chance.
        let Trend::Converging { order, error, .. } = of(&[(4.0, 17.0), (2.0, 1.0), (1.0, 0.0)]) else {
            panic!()
        };
        assert!((order - 4.0).abs() < 1e-9);
        // As of second order from the larger difference: 16 falls to 16/(4² − 2²) at the finest step.
        assert!((error - SAFETY * 16.0 / 12.0).abs() < 1e-12);
        // The largest load on a plate behind a dam break, N/m, at 6, 4, 3 mm; the two finest agree by chance: 2 mm gives 221.9.
        let loads = [(6.0, 260.42), (4.0, 232.49), (3.0, 232.16)];
        let Trend::Converging { order, error, .. } = of(&loads) else { panic!() };
        assert!(order > 10.0 && error > 232.16 - 221.9, "{order} {error}");
        // No jump where the observed order passes that of the scheme.
        let errors =
            [1.999_999, 2.000_001].map(|p: f64| match of(&[4.0, 2.0, 1.0].map(|h: f64| (h, h.powf(p)))) {
                Trend::Converging { error, .. } => error,
                other => panic!("{other}"),
            });
        assert!((errors[0] / errors[1] - 1.0).abs() < 1e-5, "{errors:?}");
    }

    #[test]
    fn what_does_not_converge_is_said_to() {
        let no_order = |reason, error| Trend::NotConverged { reason, error };
        // The heights of the drifting body at 4, 2, 1 mm.
        assert_eq!(
            of(&[(4.0, 0.223), (2.0, 0.250), (1.0, 0.170)]),
            no_order(Reason::Oscillates, 3.0 * (0.250 - 0.170))
        );
        assert_eq!(of(&[(4.0, 0.0), (2.0, 1.0), (1.0, 2.5)]), no_order(Reason::Grows, 7.5));
        assert_eq!(of(&[(4.0, 0.0), (2.0, 1.0), (1.0, 1.9)]), no_order(Reason::TooSlow, 3.0 * 1.9));
        assert_eq!(of(&[(4.0, 0.0), (2.0, 1.0)]), Trend::Pair { difference: 1.0, error: 1.0 });
        assert_eq!(of(&[(4.0, 1.0), (2.0, 1.0)]), Trend::Unchanged);
        assert_eq!(of(&[(4.0, 0.0)]), Trend::TooFew);
        assert_eq!(of(&[(4.0, 2.0), (2.0, 2.0), (1.0, 2.0)]), Trend::Unchanged);
        // The last refinement changes nothing after an earlier one did: a product of zero is no order.
        assert_eq!(of(&[(4.0, 1.0), (2.0, 2.0), (1.0, 2.0)]), no_order(Reason::Oscillates, 3.0));
    }

    #[test]
    fn a_difference_within_the_spread_of_seeds_is_no_trend() {
        let noisy = |mean: f64| Spread::of(&[mean - 1.0, mean, mean + 1.0]).unwrap();
        let points = [(4.0, noisy(10.0)), (2.0, noisy(6.0)), (1.0, noisy(5.0))];
        // Standard errors of 1/√3 each: 2 √(2/3) = 1.63 is chance.
        let Trend::WithinSpread { uncertainty } = trend(&points) else { panic!() };
        assert!((uncertainty - 2.0 * (2.0_f64 / 3.0).sqrt()).abs() < 1e-12);
        let points = [(4.0, noisy(10.0)), (2.0, noisy(4.0)), (1.0, noisy(2.0))];
        assert!(matches!(trend(&points), Trend::Converging { .. }));
    }

    #[test]
    fn a_quarter_of_the_error_at_half_the_spacing_is_second_order() {
        assert_eq!(order_of_errors((0.2, 0.04), (0.1, -0.01)), Some(2.0));
        assert_eq!(order_of_errors((0.2, 0.04), (0.1, 0.0)), None);
    }
}
