//! What a case file may say: a row for each key.
//!
//! The rows of a table stand beside its reader, which takes ranges and defaults from them. The schema for editors and the
//! tables of `cases/FORMAT.md` are made of the same rows, so that a key is described in one place.

pub mod document;
mod rows;
pub mod schema;
mod units;

#[cfg(test)]
pub(super) mod read;

use sph::setup::{Allowed, ParameterSet, ParameterSpec, ProbeSpec, Value};

pub use rows::Row;
pub use units::unit;

/// Words of a closed list with their meanings.
pub type Words = &'static [(&'static str, &'static str)];

/// What a key may hold.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// A number of a range.
    Number(Allowed),
    /// A number of a range, or a word.
    NumberOrWord(Allowed, Words),
    /// A whole number, first to last.
    Count(u64, u64),
    /// A whole number, first to last, or a word.
    CountOrWord(u64, u64, Words),
    /// Yes or no.
    Flag,
    /// A word.
    Word(Words),
    /// Some of a list of words, each at most once.
    SomeWords(Words),
    /// Letters, digits, `_` and `-`.
    Name,
    /// A text in quotes: what it names.
    Text(&'static str),
    /// A list of texts: what they name.
    Texts(&'static str),
    /// A list of numbers of a range.
    Numbers(Allowed),
    /// A number for each axis.
    Vector,
    /// A list of vectors.
    Points,
    /// A rotation: a number in the plane, a vector in space.
    Spin,
    /// A number or an expression.
    Expression(Variables),
    /// A number or an expression for each axis.
    Expressions(Variables),
    /// A table.
    Table(&'static TableSpec),
    /// A list of tables.
    Tables(&'static TableSpec),
}

/// What an expression may depend on.
#[derive(Clone, Copy, Debug)]
pub enum Variables {
    /// t.
    Time,
    /// x, y, in space z.
    Coordinates,
    /// The coordinates and t.
    CoordinatesAndTime,
}

impl Variables {
    /// Their names in a case of `dimensions` dimensions.
    pub fn names(self, dimensions: usize) -> &'static [&'static str] {
        match (self, dimensions) {
            (Self::Time, _) => &["t"],
            (Self::Coordinates, 2) => &["x", "y"],
            (Self::Coordinates, _) => &["x", "y", "z"],
            (Self::CoordinatesAndTime, 2) => &["x", "y", "t"],
            (Self::CoordinatesAndTime, _) => &["x", "y", "z", "t"],
        }
    }
}

/// What holds where a key is left out.
#[derive(Clone, Copy, Debug)]
pub enum Fallback {
    /// It must be written.
    Required,
    /// This number.
    Number(f64),
    /// This whole number.
    Count(u64),
    /// This answer.
    Flag(bool),
    /// This word.
    Word(&'static str),
    /// What the words say; it depends on other keys, or there is nothing then.
    Else(&'static str),
}

/// The row of a key.
#[derive(Clone, Copy, Debug)]
pub struct KeySpec {
    /// The key, with the unit at its end.
    pub key: &'static str,
    /// Its meaning.
    pub about: &'static str,
    /// What it may hold.
    pub kind: Kind,
    /// What holds without it.
    pub fallback: Fallback,
}

/// A key that must be written, unless a default is added.
pub const fn key(key: &'static str, kind: Kind, about: &'static str) -> KeySpec {
    KeySpec { key, about, kind, fallback: Fallback::Required }
}

impl KeySpec {
    /// `number` by default.
    pub const fn or(self, number: f64) -> Self {
        Self { fallback: Fallback::Number(number), ..self }
    }

    /// `count` by default.
    pub const fn or_count(self, count: u64) -> Self {
        Self { fallback: Fallback::Count(count), ..self }
    }

    /// `flag` by default.
    pub const fn or_flag(self, flag: bool) -> Self {
        Self { fallback: Fallback::Flag(flag), ..self }
    }

    /// `word` by default.
    pub const fn or_word(self, word: &'static str) -> Self {
        Self { fallback: Fallback::Word(word), ..self }
    }

    /// It may be left out; `words` say what holds then.
    pub const fn or_else(self, words: &'static str) -> Self {
        Self { fallback: Fallback::Else(words), ..self }
    }
}

/// A set of parameters in a table.
#[derive(Clone, Copy, Debug)]
pub struct SetSpec {
    /// The rows.
    pub rows: &'static [ParameterSpec],
    /// Default of a parameter.
    pub default: fn(&str) -> Option<Value<'static>>,
    /// Defaults that depend on other tables, by key, in words.
    pub derived: &'static [(&'static str, &'static str)],
}

impl SetSpec {
    /// The parameters of `S`.
    pub const fn of<S: ParameterSet>(derived: &'static [(&'static str, &'static str)]) -> Self {
        Self { rows: S::SPECIFICATIONS, default: |key| S::default().get(key), derived }
    }
}

/// The rows of a table.
#[derive(Clone, Copy, Debug)]
pub struct TableSpec {
    /// Name in the schema and in documents.
    pub name: &'static str,
    /// What the table is for.
    pub about: &'static str,
    /// Its keys.
    pub keys: &'static [KeySpec],
    /// A set of parameters among them.
    pub set: Option<SetSpec>,
    /// Groups of keys of which exactly one is written.
    pub either: &'static [&'static [&'static str]],
    /// Whether none of the groups may be written too.
    pub or_none: bool,
    /// Keys that depend on a word of the table.
    pub variants: Option<Variants>,
}

impl TableSpec {
    /// A table of `keys`.
    pub const fn new(name: &'static str, about: &'static str, keys: &'static [KeySpec]) -> Self {
        Self { name, about, keys, set: None, either: &[], or_none: false, variants: None }
    }

    /// Adds a set of parameters.
    pub const fn with_set(self, set: SetSpec) -> Self {
        Self { set: Some(set), ..self }
    }

    /// Exactly one of the groups is written.
    pub const fn either(self, groups: &'static [&'static [&'static str]]) -> Self {
        Self { either: groups, ..self }
    }

    /// As [`TableSpec::either`], or none of them in some tables.
    pub const fn either_or_none(self, groups: &'static [&'static [&'static str]]) -> Self {
        Self { either: groups, or_none: true, ..self }
    }

    /// Adds keys that depend on the word of `variants.tag`.
    pub const fn by(self, variants: Variants) -> Self {
        Self { variants: Some(variants), ..self }
    }

    /// Whether there is a row of any make for `key`, where the word of the tag is `word`.
    pub(super) fn has(&self, key: &str, word: Option<&str>) -> bool {
        let is_of_set =
            |set: &Option<SetSpec>| set.is_some_and(|set| set.rows.iter().any(|row| row.key == key));
        let is_meant = |known: &str| word.is_none_or(|word| word == known);
        let is_of_variant = |variants: &Variants| {
            variants.tag == key
                || variants.rows.iter().any(|variant| is_meant(variant.word) && is_of_set(&variant.set))
                || variants.probes.iter().copied().flatten().any(|probe| {
                    is_meant(probe.word) && probe.arguments.iter().any(|argument| argument.name == key)
                })
        };
        self.row(key, word).is_some()
            || is_of_set(&self.set)
            || self.variants.as_ref().is_some_and(is_of_variant)
    }

    /// Whether `word` is one of the words of the tag.
    pub(super) fn has_variant(&self, word: &str) -> bool {
        self.variants.iter().any(|variants| {
            variants.rows.iter().any(|variant| variant.word == word)
                || variants.probes.iter().copied().flatten().any(|probe| probe.word == word)
        })
    }

    /// The row of `key`, where the word of the tag is `word`.
    pub(super) fn row(&self, key: &str, word: Option<&str>) -> Option<&'static KeySpec> {
        let own = self.keys.iter().find(|row| row.key == key);
        let of_variant = || {
            let rows = self.variants.iter().flat_map(|variants| variants.rows).filter(|variant| {
                // A wrong word was reported; the others say what is known.
                word.is_none_or(|word| word == variant.word)
            });
            rows.flat_map(|variant| variant.keys).find(|row| row.key == key)
        };
        own.or_else(of_variant)
    }
}

/// Keys that depend on a word of the table.
#[derive(Clone, Copy, Debug)]
pub struct Variants {
    /// The key of the word.
    pub tag: &'static str,
    /// Its meaning.
    pub about: &'static str,
    /// What holds without it.
    pub fallback: Fallback,
    /// What each word means and brings.
    pub rows: &'static [Variant],
    /// Rows of kinds of probes in place of those.
    pub probes: &'static [&'static [ProbeSpec]],
}

impl Variants {
    /// A word under `tag` that must be written.
    pub const fn new(tag: &'static str, about: &'static str, rows: &'static [Variant]) -> Self {
        Self { tag, about, fallback: Fallback::Required, rows, probes: &[] }
    }

    /// The word by default.
    pub const fn or_word(self, word: &'static str) -> Self {
        Self { fallback: Fallback::Word(word), ..self }
    }

    /// The word by default, as `words` say.
    pub const fn or_else(self, words: &'static str) -> Self {
        Self { fallback: Fallback::Else(words), ..self }
    }
}

/// A word with the keys that it brings.
#[derive(Clone, Copy, Debug)]
pub struct Variant {
    /// The word.
    pub word: &'static str,
    /// Its meaning.
    pub about: &'static str,
    /// Its keys.
    pub keys: &'static [KeySpec],
    /// A set of parameters among them.
    pub set: Option<SetSpec>,
    /// Groups of keys of which exactly one is written.
    pub either: &'static [&'static [&'static str]],
}

impl Variant {
    /// A word that brings `keys`.
    pub const fn new(word: &'static str, about: &'static str, keys: &'static [KeySpec]) -> Self {
        Self { word, about, keys, set: None, either: &[] }
    }

    /// Adds a set of parameters.
    pub const fn with_set(self, set: SetSpec) -> Self {
        Self { set: Some(set), ..self }
    }

    /// Exactly one of the groups is written.
    pub const fn either(self, groups: &'static [&'static [&'static str]]) -> Self {
        Self { either: groups, ..self }
    }
}
