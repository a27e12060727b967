//! Typed reading of TOML tables that collects every error instead of stopping at the first.
//!
//! A key that was asked for is known; [`Table::finish`] reports the others. A value that is missing or wrong is
//! reported and replaced by a fallback, so that reading continues; nothing is built from such a table later. Ranges,
//! words and defaults come from the rows of the table, see [`spec`](super::spec).

mod coordinates;
mod described;
mod lists;
mod parameters;
mod text;
mod value;

use std::path::Path;

use toml::de::{DeTable, DeValue};

use super::errors::{CaseError, ErrorList, Place, suggest, suggestion};
use super::spec::{Fallback, TableSpec};
pub use coordinates::Coordinates;
pub use parameters::Parameters;
pub use sph::setup::Allowed;
pub use value::{At, Choice, SOUND, Written, is_bounded, is_sound};

/// Longest list read from a file; anything longer is refused before it is looked at.
pub const LONGEST_LIST: usize = 10_000;

/// A table of the file while it is read.
pub struct Table<'t> {
    errors: &'t ErrorList,
    /// Number of dimensions of the case.
    pub dimensions: usize,
    /// Folder of the case file, against which file names are resolved.
    pub directory: &'t Path,
    source: &'t str,
    spec: &'static TableSpec,
    /// Word of the table on which the meaning of its keys depends.
    variant: Option<&'static str>,
    entries: Option<&'t DeTable<'t>>,
    place: Place,
    known: Vec<&'static str>,
    missing: Vec<&'static str>,
    /// Errors when the first key was read: tables of a list are made together and read one after the other.
    errors_before: Option<usize>,
    /// Missing keys when reading of the table ended.
    abandoned: Option<usize>,
}

impl<'t> Table<'t> {
    /// The whole file, whose rows are `spec`.
    pub fn root(
        spec: &'static TableSpec,
        entries: &'t DeTable<'t>,
        source: &'t str,
        directory: &'t Path,
        errors: &'t ErrorList,
    ) -> Self {
        // A missing key of the file itself is shown at its start.
        let place = Place { key: String::new(), span: Some(0..0) };
        Self {
            errors,
            dimensions: 2,
            directory,
            source,
            spec,
            variant: None,
            entries: Some(entries),
            place,
            known: Vec::new(),
            missing: Vec::new(),
            errors_before: None,
            abandoned: None,
        }
    }

    fn child(&self, spec: &'static TableSpec, entries: Option<&'t DeTable<'t>>, place: Place) -> Self {
        Self {
            spec,
            variant: None,
            entries,
            place,
            known: Vec::new(),
            missing: Vec::new(),
            errors_before: None,
            abandoned: None,
            ..*self
        }
    }

    /// Where the table stands.
    pub fn place(&self) -> &Place {
        &self.place
    }

    /// Where errors go.
    pub fn errors(&self) -> &'t ErrorList {
        self.errors
    }

    /// Reports an error.
    pub fn error(&self, error: CaseError) {
        self.errors.add(error);
    }

    /// Whether nothing was wrong in this table so far.
    pub fn intact(&self) -> bool {
        self.missing.is_empty() && self.unharmed()
    }

    fn unharmed(&self) -> bool {
        self.errors_before.is_none_or(|before| before == self.errors.count())
    }

    /// Whether the file names `key` here.
    pub fn has(&self, key: &str) -> bool {
        self.entries.is_some_and(|entries| entries.contains_key(key))
    }

    /// Place of `key`, whether it is written or not.
    pub fn place_of(&self, key: &str) -> Place {
        let span = self.entries.and_then(|entries| entries.get(key)).map(|value| value.span());
        Place { key: join(&self.place.key, key), span: span.or_else(|| self.place.span.clone()) }
    }

    /// The value of `key` as written.
    fn take(&mut self, key: &'static str) -> Option<(&'t DeValue<'t>, Place)> {
        self.known.push(key);
        self.errors_before.get_or_insert(self.errors.count());
        self.check_described(key);
        let value = self.entries?.get(key)?;
        Some((value.get_ref(), Place { key: join(&self.place.key, key), span: Some(value.span()) }))
    }

    /// Gives up on the keys that are left: what they may be depends on one that is wrong.
    pub fn abandon(&mut self) {
        self.abandoned.get_or_insert(self.missing.len());
    }

    /// Like [`Table::take`], noting a key that is not written as missing.
    fn demand(&mut self, key: &'static str) -> Option<(&'t DeValue<'t>, Place)> {
        let found = self.take(key);
        if found.is_none() {
            self.missing.push(key);
        }
        found
    }

    fn or_default<T>(&self, key: &str, found: Option<T>, default: T) -> At<T> {
        At { value: found.unwrap_or(default), place: self.place_of(key) }
    }

    /// A number that must be written or has a constant default.
    pub fn number(&mut self, key: &'static str) -> At<f64> {
        let allowed = self.range(key);
        if let Fallback::Number(default) = self.fallback(key) {
            let found = self.optional_number_in(key, &allowed);
            return self.or_default(key, found, default);
        }
        self.number_within(key, &allowed)
    }

    /// A number of a range that must be written.
    pub fn number_within(&mut self, key: &'static str, allowed: &Allowed) -> At<f64> {
        let found = self.demand(key).and_then(|(value, place)| self.as_number(value, &place, allowed));
        self.or_default(key, found, allowed.fallback())
    }

    /// A number with a default that depends on other values.
    pub fn number_or(&mut self, key: &'static str, default: f64) -> At<f64> {
        let found = self.optional_number(key);
        self.or_default(key, found, default)
    }

    /// A number that may be left out.
    pub fn optional_number(&mut self, key: &'static str) -> Option<f64> {
        let allowed = self.range(key);
        self.optional_number_in(key, &allowed)
    }

    fn optional_number_in(&mut self, key: &'static str, allowed: &Allowed) -> Option<f64> {
        let (value, place) = self.take(key)?;
        self.as_number(value, &place, allowed)
    }

    fn as_number(&self, value: &DeValue<'_>, place: &Place, allowed: &Allowed) -> Option<f64> {
        let Some(number) = plain_number(value) else {
            self.wrong_type(value, place, allowed.words);
            return None;
        };
        if !number.is_finite() || !allowed.holds(number) {
            self.error(
                CaseError::new(place, "out of range").value(self.written(place)).allowed(allowed.words),
            );
            return None;
        }
        if !is_sound(number) {
            let error = CaseError::new(place, "out of range").value(self.written(place));
            self.error(error.allowed(format!("{}; {SOUND}", allowed.words)));
            return None;
        }
        Some(number)
    }

    /// A whole number with a constant default.
    pub fn count(&mut self, key: &'static str) -> At<u64> {
        let found = self.optional_count(key);
        let default = if let Fallback::Count(default) = self.fallback(key) { default } else { 0 };
        self.or_default(key, found, default)
    }

    /// A whole number that may be left out.
    pub fn optional_count(&mut self, key: &'static str) -> Option<u64> {
        let (first, last) = self.count_range(key);
        self.optional_count_in(key, first, last)
    }

    fn optional_count_in(&mut self, key: &'static str, first: u64, last: u64) -> Option<u64> {
        let (value, place) = self.take(key)?;
        let number = match value {
            DeValue::Integer(integer) => u64::from_str_radix(integer.as_str(), integer.radix()).ok(),
            _ => None,
        };
        let number = number.filter(|number| (first..=last).contains(number));
        if number.is_none() {
            let words = format!("a whole number from {first} to {last}");
            self.error(CaseError::new(&place, "out of range").value(self.written(&place)).allowed(words));
        }
        number
    }

    /// A whole number or one of a list of words; may be left out.
    pub fn optional_count_or_word<T: Clone>(
        &mut self,
        key: &'static str,
        options: &[(&'static str, T)],
    ) -> Option<Result<u64, Choice<T>>> {
        if !self.is_text(key) {
            return self.optional_count(key).map(Ok);
        }
        self.optional_choice(key, options).map(Err)
    }

    /// A number or one of a list of words, of which one is the default.
    pub fn number_or_word<T: Clone>(
        &mut self,
        key: &'static str,
        options: &[(&'static str, T)],
    ) -> Result<f64, Choice<T>> {
        if self.is_text(key) {
            return Err(self.choice_or_default(key, options));
        }
        let default = self.default_choice(key, options);
        self.optional_number(key).ok_or(default)
    }

    fn is_text(&self, key: &str) -> bool {
        self.entries.and_then(|entries| entries.get(key)).is_some_and(|value| value.get_ref().is_str())
    }

    fn wrong_type(&self, value: &DeValue<'_>, place: &Place, allowed: &str) {
        let problem = format!("wrong type: {}", value.type_str());
        self.error(CaseError::new(place, problem).value(self.written(place)).allowed(allowed));
    }

    /// The text of the file at `place`.
    pub fn written(&self, place: &Place) -> &'t str {
        place.span.clone().and_then(|span| self.source.get(span)).unwrap_or_default()
    }

    /// Ends reading: reports missing and unknown keys. Whether nothing was wrong in this table or its children.
    pub fn finish(mut self) -> bool {
        self.errors_before.get_or_insert(self.errors.count());
        // Of a table that was not read to its end only the keys that were missing until then are known.
        let missing = &self.missing[..self.abandoned.unwrap_or(self.missing.len())];
        let mut meant = Vec::new();
        for (key, value) in self.entries.into_iter().flat_map(DeTable::iter) {
            let word: &str = key.get_ref();
            if self.known.contains(&word) {
                continue;
            }
            let place = Place { key: String::new(), span: Some(key.span()) };
            if self.errors.is_full() {
                self.error(CaseError::new(&place, "unknown key"));
                continue;
            }
            let unused: Vec<&str> = match self.abandoned {
                Some(_) => missing.to_vec(),
                None => self.known.iter().copied().filter(|known| !self.has(known)).collect(),
            };
            let suggested = suggestion(word, unused.iter().copied());
            if self.abandoned.is_some() && suggested.is_none() {
                continue;
            }
            meant.extend(suggested);
            let place = Place { key: join(&self.place.key, word), ..place };
            // A value set over the file may mean a key that the file has.
            let is_near_used = suggested.is_none() && suggestion(word, self.known.iter().copied()).is_some();
            let hint = suggest(word, if is_near_used { &self.known } else { &unused });
            let error = CaseError::new(&place, "unknown key").hint(hint);
            let is_table = value.get_ref().is_table();
            self.error(if is_table { error } else { error.value(self.written(&self.place_of(word))) });
        }
        for key in missing.iter().filter(|key| !meant.contains(key)) {
            let place = Place { key: join(&self.place.key, key), span: self.place.span.clone() };
            self.error(CaseError::new(&place, "missing").hint(format!("add `{key}` here")));
        }
        self.unharmed()
    }
}

fn plain_number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str().parse().ok(),
        _ => None,
    }
}

fn join(parent: &str, key: &str) -> String {
    if parent.is_empty() { key.to_owned() } else { format!("{parent}.{key}") }
}
