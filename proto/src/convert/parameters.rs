//! Sets of parameters.

use sph::setup::{Choice, ParameterSet, ParameterSpec, Value};

use super::{Path, WireError, length};
use crate::limits::MAX_LIST;
use crate::wire;
use crate::wire::parameter::Value as Wire;

/// Messages of the parameters that `stated` has.
pub(super) fn parameters_to_wire(
    stated: impl Iterator<Item = (&'static ParameterSpec, Value<'static>)>,
) -> Vec<wire::Parameter> {
    let message = |(spec, value): (&ParameterSpec, _)| {
        let value = match value {
            Value::Number(number) => Wire::Number(number),
            Value::Flag(flag) => Wire::Flag(flag),
            Value::Choice(word) => Wire::Choice(word.to_owned()),
            Value::Count(count) => Wire::Count(count),
        };
        wire::Parameter { name: spec.key.to_owned(), value: Some(value) }
    };
    stated.map(message).collect()
}

/// The set that messages state; those that are `needed` must be among them.
pub(super) fn parameters_from_wire<T: ParameterSet>(
    wire: &[wire::Parameter],
    needed: impl Fn(&ParameterSpec) -> bool,
    at: &Path<'_>,
) -> Result<T, WireError> {
    length(wire.len(), MAX_LIST, at)?;
    let mut stated = Vec::with_capacity(wire.len());
    for wire::Parameter { name, value } in wire {
        let value = match value {
            Some(Wire::Number(number)) => Value::Number(*number),
            Some(Wire::Flag(flag)) => Value::Flag(*flag),
            Some(Wire::Choice(word)) => Value::Choice(word),
            Some(Wire::Count(count)) => Value::Count(*count),
            None => {
                return Err(at.field(name).error("has no value, or one of a later version of the protocol"));
            }
        };
        stated.push((name.as_str(), value));
    }
    T::from_stated(stated.into_iter(), needed).map_err(|error| at.field(&error.key).error(error.problem))
}

/// The value of a closed choice by its name.
pub(super) fn word<T: Choice>(name: &str, at: &Path<'_>) -> Result<T, WireError> {
    T::NAMES.iter().find(|(word, _)| *word == name).map(|(_, value)| *value).ok_or_else(|| {
        let words: Vec<&str> = T::NAMES.iter().map(|(word, _)| *word).collect();
        at.error(format!("is {name:?}, must be \"{}\"", words.join("\", \"")))
    })
}
