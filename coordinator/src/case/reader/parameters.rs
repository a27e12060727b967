//! Sets of parameters.

use std::collections::BTreeMap;
use std::ops::Deref;

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use sph::setup::{Kind, ParameterSet, ParameterSpec, Value};

use super::Table;
use crate::case::errors::Place;

/// A set of parameters as a case writes it, with every default filled in.
#[derive(Clone, Debug)]
pub struct Parameters<S> {
    values: S,
    /// Where each key stands, or the table that leaves it out; without those that are not read.
    places: BTreeMap<&'static str, Place>,
    /// Keys that are missing or wrong.
    wrong: Vec<&'static str>,
}

impl<S> Deref for Parameters<S> {
    type Target = S;

    fn deref(&self) -> &S {
        &self.values
    }
}

impl<S: ParameterSet> Parameters<S> {
    /// Values of a table that is missing.
    pub fn unwritten() -> Self {
        Self { values: S::default(), places: BTreeMap::new(), wrong: Vec::new() }
    }

    /// The values.
    pub fn values(&self) -> S {
        self.values
    }

    /// Sets values that follow from other parts of the case.
    pub fn derive(&mut self, set: impl FnOnce(&mut S)) {
        set(&mut self.values);
    }

    /// Where `key` stands, or the table that leaves it out.
    pub fn place(&self, key: &str) -> Place {
        self.places.get(key).cloned().unwrap_or_default()
    }

    /// Whether a value of `key` can be relied on.
    pub fn is_sound(&self, key: &str) -> bool {
        !self.wrong.contains(&key)
    }
}

impl<S: ParameterSet> Serialize for Parameters<S> {
    fn serialize<T: Serializer>(&self, serializer: T) -> Result<T::Ok, T::Error> {
        let mut map = serializer.serialize_map(None)?;
        for (spec, value) in self.values.values().filter(|(spec, _)| self.places.contains_key(spec.key)) {
            match value {
                Value::Number(number) => map.serialize_entry(spec.key, &number)?,
                Value::Flag(flag) => map.serialize_entry(spec.key, &flag)?,
                Value::Choice(word) => map.serialize_entry(spec.key, word)?,
                Value::Count(count) => map.serialize_entry(spec.key, &count)?,
            }
        }
        map.end()
    }
}

impl Table<'_> {
    /// Reads a set of parameters; what the table leaves out is as in `base`, and `derived` keys are not read.
    pub fn parameters<S: ParameterSet>(&mut self, base: S, derived: &[&str]) -> Parameters<S> {
        let mut read = Parameters { values: base, ..Parameters::unwritten() };
        for spec in S::SPECIFICATIONS.iter().filter(|spec| !derived.contains(&spec.key)) {
            let errors = self.errors().count();
            let value = self.parameter(spec);
            // The reader has checked it against the row.
            let taken = value.is_none_or(|value| read.values.assign(spec, value).is_ok());
            let missing = value.is_none() && spec.is_stated;
            if !taken || missing || errors < self.errors().count() {
                read.wrong.push(spec.key);
            }
            read.places.insert(spec.key, self.place_of(spec.key));
        }
        read
    }

    fn parameter(&mut self, spec: &ParameterSpec) -> Option<Value<'static>> {
        let key = spec.key;
        if spec.is_stated && !self.has(key) {
            self.demand(key);
            return None;
        }
        match spec.kind {
            Kind::Number(allowed) => self.optional_number_in(key, &allowed).map(Value::Number),
            Kind::Count(first, last) => self.optional_count_in(key, first, last).map(Value::Count),
            Kind::Flag => self.optional_flag(key).map(Value::Flag),
            Kind::Choice(words) => self.optional_word(key, words).map(|choice| Value::Choice(choice.word)),
        }
    }
}
