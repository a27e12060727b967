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
