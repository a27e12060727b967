//! Ranges, ticks and their labels.

use plotters::style::{IntoFont, TextStyle};

use crate::results::font;

/// Ticks at multiples of 1, 2 or 5 times a power of ten within [lower, upper], about `wanted` of them and at least two,
/// since one alone shows no scale.
///
/// Returns the ticks and their distance; no ticks when the range is empty or not finite.
pub fn ticks(lower: f64, upper: f64, wanted: usize) -> (Vec<f64>, f64) {
    let span = upper - lower;
    if !(span > 0.0 && span.is_finite()) || wanted == 0 {
        return (Vec::new(), 1.0);
    }
    let raw = span / wanted as f64;
    let decade = 10f64.powf(raw.log10().floor());
    let factors = [0.2, 0.5, 1.0, 2.0, 5.0, 10.0];
    let fitting = factors.iter().position(|f| f * decade >= raw * 0.999).unwrap_or(factors.len() - 1);
    // Ends of a range that lie just off two multiples leave one between them.
    let count = |step: f64| (upper / step + 1e-3).floor() - (lower / step - 1e-3).ceil() + 1.0;
    let several = factors[..=fitting].iter().rev().find(|factor| count(*factor * decade) >= 2.0);
    let step = several.unwrap_or(&factors[0]) * decade;
    // A thousandth of a step absorbs the round-off of range ends that are ticks themselves.
    let first = (lower / step - 1e-3).ceil();
    let ticks = (0..=2 * wanted + 2)
        .map(|k| (first + k as f64) * step)
        .take_while(|tick| *tick <= upper + 1e-3 * step)
        .map(|tick| if tick.abs() < 1e-9 * step { 0.0 } else { tick })
        .collect();
    (ticks, step)
}

/// `value` with the decimals that distinguish ticks at distance `step`.
pub fn label(value: f64, step: f64) -> String {
    // Ticks are 1, 2 or 5 times a power of ten; the clamp keeps the cast in range.
    let decimals = (-step.log10() - 1e-9).ceil().clamp(0.0, 17.0) as usize;
    let text = format!("{value:.decimals$}");
    // A hyphen is too short for a minus sign.
    text.replace('-', "\u{2212}")
}

/// A power of ten taken out of numbers, and the unit that then applies.
#[derive(Clone, Debug, PartialEq)]
pub struct Magnitude {
    /// Shown number = value / divisor.
    pub divisor: f64,
    /// Unit of the shown numbers.
    pub unit: String,
}

impl Magnitude {
    /// Fits numbers up to `largest` in `unit`, so that labels have few digits.
    ///
    /// Large pressures, and all forces, energies and powers take SI prefixes, all else a power of ten: mPa would be
    /// taken for MPa.
    pub fn of(largest: f64, unit: &str) -> Self {
        let plain = Self { divisor: 1.0, unit: unit.to_string() };
        if !(largest > 0.0 && largest.is_finite()) || (1e-2..1e4).contains(&largest) {
            return plain;
        }
        // The clamp keeps the divisor within the finite and normal numbers.
        let exponent = (largest.log10() / 3.0 + 1e-9).floor().clamp(-102.0, 102.0) as i32 * 3;
        let prefixed = unit.starts_with(['N', 'J', 'W']) || (unit.starts_with("Pa") && exponent > 0);
        let prefix = match exponent {
            9 => "G",
            6 => "M",
            3 => "k",
            -3 => "m",
            -6 => "µ",
            _ => "",
        };
        let unit = match (prefixed && !prefix.is_empty(), unit) {
            (true, unit) => format!("{prefix}{unit}"),
            (false, "" | "1") => format!("10{}", superscript(exponent)),
            (false, unit) => format!("10{} {unit}", superscript(exponent)),
        };
        Self { divisor: 10f64.powi(exponent), unit }
    }
}

/// A power of ten in words of mathematics: 10⁻¹².
pub fn superscript(exponent: i32) -> String {
    exponent
        .to_string()
        .chars()
        .map(|c| match c {
            '-' => '⁻',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            '4' => '⁴',
            '5' => '⁵',
            '6' => '⁶',
            '7' => '⁷',
            '8' => '⁸',
            '9' => '⁹',
            _ => '⁰',
        })
        .collect()
}

/// Range of the finite values, widened by a twentieth on either side; a constant gets some room around it.
pub fn padded_range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (lower, upper) = values
        .filter(|value| value.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), value| (a.min(value), b.max(value)));
    if lower > upper {
        return (0.0, 1.0);
    }
    let largest = lower.abs().max(upper.abs());
    // Round-off of a constant is not worth a picture.
    if upper - lower <= 1e-9 * largest {
        let room = if largest > 0.0 { 0.1 * largest } else { 1.0 };
        return (lower - room, upper + room);
    }
    let room = 0.05 * (upper - lower);
    (lower - room, upper + room)
}

/// The value below which the fraction `q` of `values` lies; sorts the finite values to the front.
pub fn quantile(values: &mut Vec<f64>, q: f64) -> Option<f64> {
    values.retain(|value| value.is_finite());
    let last = values.len().checked_sub(1)?;
    // In range by the clamp.
    let k = (q.clamp(0.0, 1.0) * last as f64).round() as usize;
    let (_, value, _) = values.select_nth_unstable_by(k, f64::total_cmp);
    Some(*value)
}

/// Width of `text` in the font of all pictures \[px\].
pub fn text_width(text: &str, size: u32) -> u32 {
    let style = TextStyle::from((font::FAMILY, size).into_font());
    style.font.layout_box(text).ok().and_then(|(_, (width, _))| u32::try_from(width).ok()).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(lower: f64, upper: f64) -> Vec<String> {
        let (ticks, step) = ticks(lower, upper, 5);
        ticks.iter().map(|tick| label(*tick, step)).collect()
    }

    #[test]
    fn ticks_are_round_numbers_within_the_range() {
        assert_eq!(labels(0.0, 0.5), ["0.0", "0.1", "0.2", "0.3", "0.4", "0.5"]);
        assert_eq!(labels(-1.2, 1.2), ["−1.0", "−0.5", "0.0", "0.5", "1.0"]);
        assert_eq!(labels(0.0, 4000.0), ["0", "1000", "2000", "3000", "4000"]);
        assert_eq!(labels(85.21001, 85.21009), ["85.21002", "85.21004", "85.21006", "85.21008"]);
        // Steps of 0.05 would leave the zero alone.
        assert_eq!(ticks(-0.04, 0.04, 2).0, [-0.04, -0.02, 0.0, 0.02, 0.04]);
        assert!(labels(1.0, 1.0).is_empty());
        assert!(labels(f64::NAN, 1.0).is_empty());
        for (a, b) in [(0.0, 0.584), (1e-9, 3e-9), (-7e12, 5.0), (0.013, 0.0131)] {
            let (ticks, _) = ticks(a, b, 6);
            assert!((2..=8).contains(&ticks.len()), "{a}..{b}: {ticks:?}");
            let mut texts = labels(a, b);
            texts.dedup();
            assert_eq!(texts.len(), labels(a, b).len(), "labels differ");
        }
    }

    #[test]
    fn large_and_small_numbers_move_a_power_of_ten_into_the_unit() {
        let unit = |largest, unit: &str| Magnitude::of(largest, unit).unit;
        assert_eq!(unit(2894.0, "Pa"), "Pa");
        assert_eq!(unit(3e5, "Pa"), "kPa");
        assert_eq!(unit(2e7, "Pa"), "MPa");
        assert_eq!(unit(2e-3, "J/m"), "mJ/m");
        assert_eq!(unit(2e-3, "m"), "10⁻³ m");
        assert_eq!(unit(2e-3, "Pa"), "10⁻³ Pa");
        assert_eq!(unit(0.0, "m"), "m");
        assert_eq!(unit(3e-13, "1"), "10⁻¹⁵");
        assert_eq!(Magnitude::of(3e5, "Pa").divisor, 1e3);
        for largest in [f64::MAX, 1e308, 1e-308, 5e-324] {
            let shown = largest / Magnitude::of(largest, "Pa").divisor;
            assert!(shown < 1e3, "{largest:e} is shown as {shown:e}");
        }
    }

    #[test]
    fn ranges_ignore_gaps_and_give_constants_room() {
        let range = |values: &[f64]| padded_range(values.iter().copied());
        assert_eq!(range(&[0.0, f64::NAN, 10.0]), (-0.5, 10.5));
        assert_eq!(range(&[]), (0.0, 1.0));
        assert_eq!(range(&[0.0, 0.0]), (-1.0, 1.0));
        let (a, b) = range(&[5.0, 5.0 + 1e-13]);
        assert!(a < 4.6 && b > 5.4);
    }

    #[test]
    fn quantiles_pass_over_what_is_no_number() {
        let mut values: Vec<f64> = (0..=100).rev().map(f64::from).chain([f64::NAN]).collect();
        assert_eq!(quantile(&mut values, 0.99), Some(99.0));
        assert_eq!(quantile(&mut values, 0.0), Some(0.0));
        assert_eq!(quantile(&mut vec![f64::NAN], 0.5), None);
    }
}
