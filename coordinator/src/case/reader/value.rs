//! Values as they come from a table: with their place, from a closed list, within a range.

use serde::{Serialize, Serializer};

use crate::case::errors::Place;

/// A value with its place in the file.
#[derive(Clone, Debug)]
pub struct At<T> {
    /// The value.
    pub value: T,
    /// Where it stands, or where the table stands that leaves it out.
    pub place: Place,
}

impl<T: Serialize> Serialize for At<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.value.serialize(serializer)
    }
}

/// A word of a closed list with its meaning.
#[derive(Clone, Debug)]
pub struct Choice<T> {
    /// The word as written.
    pub word: &'static str,
    /// What it means.
    pub value: T,
    /// Where it stands.
    pub place: Place,
}

impl<T> Serialize for Choice<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.word)
    }
}

/// Smallest and largest magnitude of a number that is not 0: between them products of a few numbers neither vanish nor
/// overflow.
const MAGNITUDES: std::ops::RangeInclusive<f64> = 1e-30..=1e30;

/// [`is_sound`] in words.
pub const SOUND: &str = "0 or a magnitude from 1e-30 to 1e30";

/// Whether the solvers can compute with `value`: 0, or of a magnitude between 1e-30 and 1e30.
pub fn is_sound(value: f64) -> bool {
    value == 0.0 || MAGNITUDES.contains(&value.abs())
}

/// Whether `value` is a number that does not overflow soon: what expressions may give.
pub fn is_bounded(value: f64) -> bool {
    value.abs() <= *MAGNITUDES.end()
}

/// A range of numbers.
#[derive(Clone, Copy, Debug)]
pub struct Allowed {
    lowest: f64,
    highest: f64,
    includes: (bool, bool),
    pub(super) fallback: f64,
    pub(super) words: &'static str,
}

impl Allowed {
    /// Any finite number.
    pub const FINITE: Self = Self::new(f64::MIN, f64::MAX, (true, true), 0.0, "a finite number");
    /// Above zero.
    pub const POSITIVE: Self = Self::new(0.0, f64::MAX, (false, true), 1.0, "a number above 0");
    /// Zero or above.
    pub const NOT_NEGATIVE: Self = Self::new(0.0, f64::MAX, (true, true), 0.0, "a number of 0 or above");
    /// In (0, 1].
    pub const FRACTION: Self = Self::new(0.0, 1.0, (false, true), 1.0, "a number above 0 and at most 1");
    /// In [0, 1].
    pub const SHARE: Self = Self::new(0.0, 1.0, (true, true), 0.0, "a number from 0 to 1");
    /// Kernel ratio h/Δx: below, particles lose their neighbours; above, their number explodes.
    pub const KERNEL_RATIO: Self = Self::new(0.8, 4.0, (true, true), 1.2, "a number from 0.8 to 4 (h/Δx)");

    /// A range from `lowest` to `highest`, ends included or not, described by `words`.
    pub const fn new(
        lowest: f64,
        highest: f64,
        includes: (bool, bool),
        fallback: f64,
        words: &'static str,
    ) -> Self {
        Self { lowest, highest, includes, fallback, words }
    }

    pub(super) fn holds(&self, value: f64) -> bool {
        let (low, high) = self.includes;
        (value > self.lowest || low && value == self.lowest)
            && (value < self.highest || high && value == self.highest)
    }
}

/// A number, or the text of an expression.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Written {
    /// A number.
    Number(f64),
    /// An expression.
    Text(String),
}

impl Written {
    /// The text of the expression; a number is written without an exponent and reads back to the same bits.
    pub fn text(&self) -> String {
        match self {
            Written::Number(number) => format!("{number}"),
            Written::Text(text) => text.clone(),
        }
    }
}
