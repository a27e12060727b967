//! Rows of all makes in one form, for documents.

use sph::setup::{Allowed, ArgumentKind, ArgumentSpec, Kind as ParameterKind, ParameterSpec, Value};

use super::{Fallback, KeySpec, Kind, SetSpec, TableSpec, Variant, unit};

/// The row of a key as documents show it.
#[derive(Clone, Debug)]
pub struct Row {
    /// The key.
    pub key: &'static str,
    /// Its meaning.
    pub about: String,
    /// What it may hold.
    pub kind: Kind,
    /// What holds without it.
    pub fallback: Fallback,
}

impl Row {
    /// The unit; `-` without one.
    pub fn unit(&self) -> &'static str {
        match self.kind {
            Kind::Name | Kind::Text(_) | Kind::Texts(_) | Kind::Table(_) | Kind::Tables(_) => "-",
            _ => unit(self.key),
        }
    }

    /// The default in words.
    pub fn default(&self) -> String {
        match self.fallback {
            Fallback::Required => "must be written".to_owned(),
            Fallback::Number(number) => number_text(number),
            Fallback::Count(count) => count.to_string(),
            Fallback::Flag(flag) => flag.to_string(),
            Fallback::Word(word) => format!("\"{word}\""),
            Fallback::Else(words) => words.to_owned(),
        }
    }

    /// The allowed values in words.
    pub fn range(&self) -> String {
        let counts = |first: u64, last: u64| format!("a whole number from {first} to {}", count_text(last));
        match self.kind {
            Kind::Number(allowed) => allowed.words.to_owned(),
            Kind::NumberOrWord(allowed, words) => format!("{}, or {}", allowed.words, quoted(words)),
            Kind::Count(first, last) => counts(first, last),
            Kind::CountOrWord(first, last, words) => format!("{}, or {}", counts(first, last), quoted(words)),
            Kind::Flag => "true or false".to_owned(),
            Kind::Word(words) => quoted(words),
            Kind::SomeWords(words) => format!("a list of some of {}", quoted(words)),
            Kind::Name => "1 to 64 letters, digits, `_` or `-`".to_owned(),
            Kind::Text(what) => what.to_owned(),
            Kind::Texts(what) => format!("a list: {what}"),
            Kind::Numbers(allowed) => format!("a list, each {}", allowed.words),
            Kind::Vector => "a finite number for each axis".to_owned(),
            Kind::Points => "a list of points, each with a finite number for each axis".to_owned(),
            Kind::Spin => "a finite number; in space one for each axis".to_owned(),
            Kind::Expression(variables) => {
                format!("a finite number or an expression of {}", variable_text(variables))
            }
            Kind::Expressions(variables) => {
                format!("a finite number or an expression of {} for each axis", variable_text(variables))
            }
            Kind::Table(_) => "a table".to_owned(),
            Kind::Tables(_) => "a list of tables".to_owned(),
        }
    }

    /// The words that it may be, with their meanings.
    pub fn words(&self) -> &'static [(&'static str, &'static str)] {
        match self.kind {
            Kind::Word(words)
            | Kind::SomeWords(words)
            | Kind::NumberOrWord(_, words)
            | Kind::CountOrWord(_, _, words) => words,
            _ => &[],
        }
    }

    /// A row for people in one text: meaning, words, unit, default, range.
    pub fn text(&self) -> String {
        let mut text = format!("{}.\n", self.about.trim_end_matches('.'));
        for (word, meaning) in self.words() {
            text += &format!("\n- `{word}`: {}", meaning.trim().trim_end_matches('.'));
        }
        if !self.words().is_empty() {
            text.push('\n');
        }
        let (unit, default, range) = (self.unit(), self.default(), self.range());
        text + &format!("\nUnit: {unit}. Default: {default}. Range: {range}.")
    }
}

/// A number without needless digits: small and large ones with an exponent, which TOML can read.
pub(super) fn number_text(number: f64) -> String {
    let magnitude = number.abs();
    if magnitude != 0.0 && !(1e-3..1e6).contains(&magnitude) {
        format!("{number:e}")
    } else {
        number.to_string()
    }
}

fn count_text(count: u64) -> String {
    match count {
        // Numbers of TOML have 63 bits, so that seeds end at a power of two.
        _ if count >= 1 << 53 => "2^62 − 1".to_owned(),
        _ => count.to_string(),
    }
}

fn quoted(words: super::Words) -> String {
    let words: Vec<String> = words.iter().map(|(word, _)| format!("\"{word}\"")).collect();
    words.join(", ")
}

fn variable_text(variables: super::Variables) -> &'static str {
    match variables {
        super::Variables::Time => "t",
        super::Variables::Coordinates => "the coordinates",
        super::Variables::CoordinatesAndTime => "the coordinates and t",
    }
}

impl From<&KeySpec> for Row {
    fn from(row: &KeySpec) -> Self {
        Self { key: row.key, about: row.about.to_owned(), kind: row.kind, fallback: row.fallback }
    }
}

impl From<&ArgumentSpec> for Row {
    fn from(argument: &ArgumentSpec) -> Self {
        let name = argument.name;
        let about = match argument.kind {
            ArgumentKind::Number | ArgumentKind::Point => format!("`{name}` of the kind of probe"),
            ArgumentKind::Index | ArgumentKind::OptionalIndex => format!("name of the {name}"),
        };
        let (kind, fallback) = match argument.kind {
            ArgumentKind::Number => (Kind::Number(Allowed::FINITE), Fallback::Required),
            ArgumentKind::Point => (Kind::Vector, Fallback::Required),
            ArgumentKind::Index => (Kind::Name, Fallback::Required),
            ArgumentKind::OptionalIndex => (Kind::Name, Fallback::Else("all")),
        };
        Self { key: name, about, kind, fallback }
    }
}

impl SetSpec {
    /// Its rows.
    fn described(&self) -> impl Iterator<Item = Row> {
        self.rows.iter().map(|row| self.row(row))
    }

    fn row(&self, row: &ParameterSpec) -> Row {
        let kind = match row.kind {
            ParameterKind::Number(allowed) => Kind::Number(allowed),
            ParameterKind::Flag => Kind::Flag,
            ParameterKind::Count(first, last) => Kind::Count(first, last),
            ParameterKind::Choice(words) => Kind::Word(words),
        };
        let derived = self.derived.iter().find(|(key, _)| *key == row.key);
        let fallback = match ((self.default)(row.key), derived) {
            (_, Some((_, words))) => Fallback::Else(words),
            _ if row.is_stated => Fallback::Required,
            (Some(Value::Number(number)), _) => Fallback::Number(number),
            (Some(Value::Count(count)), _) => Fallback::Count(count),
            (Some(Value::Flag(flag)), _) => Fallback::Flag(flag),
            (Some(Value::Choice(word)), _) => Fallback::Word(word),
            (None, _) => Fallback::Else("left out"),
        };
        Row { key: row.key, about: row.meaning(), kind, fallback }
    }
}

impl TableSpec {
    /// Rows of the keys that do not depend on a word.
    pub fn described(&self) -> Vec<Row> {
        self.keys.iter().map(Row::from).chain(self.set.iter().flat_map(SetSpec::described)).collect()
    }
}

impl Variant {
    /// Rows of its keys.
    pub fn described(&self) -> Vec<Row> {
        self.keys.iter().map(Row::from).chain(self.set.iter().flat_map(SetSpec::described)).collect()
    }
}
