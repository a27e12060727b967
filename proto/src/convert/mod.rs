//! Checked conversions between wire messages and the types of the rest of the program.
//!
//! Nothing from the wire is used before its length, range and finiteness are checked; an error names the path of the
//! field, its value and what is allowed. Both directions stand side by side, so that they cannot drift apart.

/// Implements [`Choice`] for an enum whose values have the same names on the wire.
macro_rules! choices {
    ($choice:ident = wire::$wire:ident { $($value:ident),+ $(,)? }) => {
        impl crate::convert::Choice for $choice {
            const ALL: &'static [Self] = &[$($choice::$value),+];

            fn code(self) -> i32 {
                match self {
                    $($choice::$value => crate::wire::$wire::$value.into()),+
                }
            }
        }
    };
}

mod arrays;
mod description;
mod events;
mod fluid;
mod frame;
mod frame_reader;
mod implicit;
mod link;
mod parameters;
mod partner;
mod probes;
mod report;
mod run;
mod saved;
mod setup;
mod snapshot;
mod solid;
mod walls;

pub(crate) use events::{BatchItem, decode_batch, decode_command, encode_batch, encode_command};
pub use events::{Beat, Phase};
pub(crate) use frame::{FrameWriter, Layout};
pub(crate) use frame_reader::{FrameReader, ReceivedFrame};
pub(crate) use link::{extent_from_wire, extent_to_wire, link_from_wire, link_to_wire};
pub use saved::{decode_state, encode_state};
pub(crate) use setup::{decode_setup, encode_setup};
pub use setup::{decoded_setup, encoded_setup};
pub(crate) use snapshot::{SnapshotAssembler, snapshot_chunks};

use std::fmt;

use sph::space::components::Components;

use crate::limits::{MAX_LIST, MAX_NAME_BYTES, MAX_TEXT_BYTES};
use crate::wire;

/// A value from the wire that is not allowed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{path}`: {problem}")]
pub(crate) struct WireError {
    /// Path of the field in its message.
    pub path: String,
    /// Its value and what is allowed.
    pub problem: String,
}

/// Where a value stands in its message; text is made only for an error.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Path<'a> {
    parent: Option<&'a Path<'a>>,
    name: &'a str,
    index: Option<usize>,
}

impl<'a> Path<'a> {
    pub(crate) fn root(name: &'a str) -> Self {
        Self { parent: None, name, index: None }
    }

    pub(crate) fn field(&'a self, name: &'a str) -> Self {
        Self { parent: Some(self), name, index: None }
    }

    pub(crate) fn item(&'a self, name: &'a str, index: usize) -> Self {
        Self { parent: Some(self), name, index: Some(index) }
    }

    pub(crate) fn error(&self, problem: impl Into<String>) -> WireError {
        WireError { path: self.to_string(), problem: problem.into() }
    }
}

impl fmt::Display for Path<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(parent) = self.parent {
            write!(f, "{parent}.")?;
        }
        f.write_str(self.name)?;
        match self.index {
            Some(index) => write!(f, "[{index}]"),
            None => Ok(()),
        }
    }
}

/// A type of the program that travels as a message.
pub(crate) trait Convert: Sized {
    /// The message.
    type Wire;

    /// The message of this value.
    fn to_wire(&self) -> Self::Wire;

    /// The value of a message that stands at `at`.
    fn from_wire(wire: &Self::Wire, at: &Path<'_>) -> Result<Self, WireError>;
}

/// A closed choice that travels as an enum; zero, "unspecified", is no value of it.
pub(crate) trait Choice: Copy + fmt::Debug + 'static {
    /// All values.
    const ALL: &'static [Self];

    /// Number on the wire.
    fn code(self) -> i32;
}

/// The choice of number `code`.
pub(crate) fn choice<T: Choice>(code: i32, at: &Path<'_>) -> Result<T, WireError> {
    T::ALL.iter().find(|value| value.code() == code).copied().ok_or_else(|| {
        let allowed: Vec<String> = T::ALL.iter().map(|v| format!("{} ({v:?})", v.code())).collect();
        at.error(format!("is {code}, must be one of {}", allowed.join(", ")))
    })
}

/// A message that must be present.
pub(crate) fn required<T: Convert>(wire: &Option<T::Wire>, at: &Path<'_>) -> Result<T, WireError> {
    match wire {
        Some(wire) => T::from_wire(wire, at),
        None => Err(at.error("is missing")),
    }
}

/// A message that may be absent.
pub(crate) fn optional<T: Convert>(wire: &Option<T::Wire>, at: &Path<'_>) -> Result<Option<T>, WireError> {
    wire.as_ref().map(|wire| T::from_wire(wire, at)).transpose()
}

/// A list of messages of limited length.
pub(crate) fn list<T: Convert>(wire: &[T::Wire], at: &Path<'_>, name: &str) -> Result<Vec<T>, WireError> {
    length(wire.len(), MAX_LIST, &at.field(name))?;
    wire.iter().enumerate().map(|(k, item)| T::from_wire(item, &at.item(name, k))).collect()
}

/// Messages of a list.
pub(crate) fn wires<T: Convert>(values: &[T]) -> Vec<T::Wire> {
    values.iter().map(T::to_wire).collect()
}

/// A length within its limit.
pub(crate) fn length(length: usize, limit: usize, at: &Path<'_>) -> Result<(), WireError> {
    if length <= limit {
        Ok(())
    } else {
        Err(at.error(format!("has {length} entries, at most {limit} are allowed")))
    }
}

fn number(
    value: impl Into<Option<f64>>,
    at: &Path<'_>,
    allowed: &str,
    accept: impl Fn(f64) -> bool,
) -> Result<f64, WireError> {
    match value.into() {
        Some(value) if accept(value) => Ok(value),
        Some(value) => Err(at.error(format!("is {value:?}, must be {allowed}"))),
        None => Err(at.error(format!("is missing, must be {allowed}"))),
    }
}

/// A number of a report, which may be anything; absent ones are zero.
pub(crate) fn any_number(value: Option<f64>) -> f64 {
    value.unwrap_or(0.0)
}

pub(crate) fn finite(value: impl Into<Option<f64>>, at: &Path<'_>) -> Result<f64, WireError> {
    number(value, at, "finite", f64::is_finite)
}

pub(crate) fn positive(value: impl Into<Option<f64>>, at: &Path<'_>) -> Result<f64, WireError> {
    number(value, at, "positive and finite", |v| v.is_finite() && v > 0.0)
}

pub(crate) fn positive_or_infinite(value: impl Into<Option<f64>>, at: &Path<'_>) -> Result<f64, WireError> {
    number(value, at, "positive", |v| v > 0.0)
}

pub(crate) fn not_negative(value: impl Into<Option<f64>>, at: &Path<'_>) -> Result<f64, WireError> {
    number(value, at, "zero or positive, and finite", |v| v.is_finite() && v >= 0.0)
}

/// `value` in the half-open interval (0, 1].
pub(crate) fn fraction(value: impl Into<Option<f64>>, at: &Path<'_>) -> Result<f64, WireError> {
    number(value, at, "above 0 and at most 1", |v| v > 0.0 && v <= 1.0)
}

/// Text of at least one byte, at most that of a name.
pub(crate) fn name(text: &str, at: &Path<'_>) -> Result<String, WireError> {
    if text.is_empty() {
        return Err(at.error("is empty, must be a name"));
    }
    bounded_text(text, MAX_NAME_BYTES, at)
}

/// Text of limited length.
pub(crate) fn text(text: &str, at: &Path<'_>) -> Result<String, WireError> {
    bounded_text(text, MAX_TEXT_BYTES, at)
}

fn bounded_text(text: &str, limit: usize, at: &Path<'_>) -> Result<String, WireError> {
    if text.len() <= limit {
        Ok(text.to_owned())
    } else {
        Err(at.error(format!("has {} bytes, at most {limit} are allowed", text.len())))
    }
}

/// An index below the length of the list that it points into.
pub(crate) fn index(index: u32, len: usize, list: &str, at: &Path<'_>) -> Result<u32, WireError> {
    if usize::try_from(index).is_ok_and(|index| index < len) {
        Ok(index)
    } else {
        Err(at.error(format!("is {index}, but there are {len} {list}")))
    }
}

/// A length as the wire holds it; no list in memory exceeds 64 bits.
pub(crate) fn count(len: usize) -> u64 {
    u64::try_from(len).unwrap_or(u64::MAX)
}

/// The three components of a vector of the ledger.
pub(crate) fn components<T: Clone, const D: usize>(values: &[T], at: &Path<'_>) -> Result<[T; D], WireError> {
    values
        .to_vec()
        .try_into()
        .map_err(|values: Vec<T>| at.error(format!("has {} components, must have {D}", values.len())))
}

/// A vector of `values`.
pub(crate) fn components_to_wire(values: &[f64]) -> Option<wire::Vector> {
    Some(wire::Vector { components: values.to_vec() })
}

/// Whether a vector of the scene has one component for each of the `dimensions` of the run.
pub(crate) fn one_for_each(dimensions: usize, components: usize, at: &Path<'_>) -> Result<(), WireError> {
    if components == dimensions {
        Ok(())
    } else {
        Err(at.error(format!(
            "has {components} components, must have {dimensions} in a run of {dimensions} dimensions"
        )))
    }
}

/// The finite numbers of a vector of the scene, one for each of the `dimensions` of the run.
pub(crate) fn numbers_from_wire(
    wire: &Option<wire::Vector>,
    dimensions: usize,
    at: &Path<'_>,
) -> Result<Vec<f64>, WireError> {
    let Some(wire) = wire else { return Err(at.error("is missing")) };
    one_for_each(dimensions, wire.components.len(), at)?;
    let checked = |(k, value): (usize, &f64)| finite(*value, &at.item("components", k));
    wire.components.iter().enumerate().map(checked).collect()
}

/// A vector of the scene.
pub(crate) fn vector_to_wire(vector: &impl Components) -> Option<wire::Vector> {
    components_to_wire(vector.row().as_ref())
}

/// The same back.
pub(crate) fn vector_from_wire<V: Components>(
    wire: &Option<wire::Vector>,
    at: &Path<'_>,
) -> Result<V, WireError> {
    let numbers = numbers_from_wire(wire, V::COUNT, at)?;
    V::of_row(&numbers).ok_or_else(|| at.error("has another number of components than the run"))
}

pub(crate) fn flags_to_wire(flags: &[bool]) -> Option<wire::Flags> {
    Some(wire::Flags { components: flags.to_vec() })
}

/// One flag for each of the `dimensions` of the run; absent ones are unset.
pub(crate) fn flags_from_wire(
    wire: &Option<wire::Flags>,
    dimensions: usize,
    at: &Path<'_>,
) -> Result<Vec<bool>, WireError> {
    let Some(flags) = wire else { return Ok(vec![false; dimensions]) };
    one_for_each(dimensions, flags.components.len(), at)?;
    Ok(flags.components.clone())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_names_path_value_and_what_is_allowed() {
        let root = Path::root("open");
        let walls = root.item("walls", 3);
        let error = positive(-1.0, &walls.field("release_time_s")).unwrap_err();
        assert_eq!(error.to_string(), "`open.walls[3].release_time_s`: is -1.0, must be positive and finite");
        assert!(finite(f64::NAN, &root).unwrap_err().to_string().contains("NaN"));
        assert!(positive_or_infinite(f64::INFINITY, &root).is_ok());
        assert!(positive_or_infinite(f64::NAN, &root).is_err());
        assert!(fraction(0.0, &root).is_err());
        assert!(not_negative(-0.0, &root).is_ok());
    }
}
