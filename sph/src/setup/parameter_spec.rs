//! The row of a parameter: key, meaning, range, and the values that mean something special.

use std::fmt;

/// The value of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value<'a> {
    /// A number, in the unit of the key.
    Number(f64),
    /// Yes or no.
    Flag(bool),
    /// A word of a closed list.
    Choice(&'a str),
    /// A whole number.
    Count(u64),
}

impl Value<'_> {
    /// Equality of all bits: −0 is not 0.
    pub fn is(&self, other: &Value<'_>) -> bool {
        match (self, other) {
            (Value::Number(a), Value::Number(b)) => a.to_bits() == b.to_bits(),
            _ => self == other,
        }
    }
}

impl fmt::Display for Value<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => write!(f, "{number}"),
            Self::Flag(flag) => write!(f, "{flag}"),
            Self::Choice(word) => f.write_str(word),
            Self::Count(count) => write!(f, "{count}"),
        }
    }
}

/// A range of numbers.
#[derive(Clone, Copy, Debug)]
pub struct Allowed {
    /// Lowest number.
    pub lowest: f64,
    /// Highest number.
    pub highest: f64,
    includes: (bool, bool),
    /// The range in words.
    pub words: &'static str,
}

impl Allowed {
    /// Any finite number.
    pub const FINITE: Self = Self::new(f64::MIN, f64::MAX, (true, true), "a finite number");
    /// Above zero.
    pub const POSITIVE: Self = Self::new(0.0, f64::MAX, (false, true), "a number above 0");
    /// Zero or above.
    pub const NOT_NEGATIVE: Self = Self::new(0.0, f64::MAX, (true, true), "a number of 0 or above");
    /// In (0, 1].
    pub const FRACTION: Self = Self::new(0.0, 1.0, (false, true), "a number above 0 and at most 1");
    /// In [0, 1].
    pub const SHARE: Self = Self::new(0.0, 1.0, (true, true), "a number from 0 to 1");
    /// Kernel ratio h/Δx: below, particles lose their neighbours; above, their number explodes.
    pub const KERNEL_RATIO: Self = Self::new(0.8, 4.0, (true, true), "a number from 0.8 to 4 (h/Δx)");

    /// A range from `lowest` to `highest`, ends included or not, described by `words`.
    pub const fn new(lowest: f64, highest: f64, includes: (bool, bool), words: &'static str) -> Self {
        Self { lowest, highest, includes, words }
    }

    /// Whether the lowest and the highest number are of the range.
    pub const fn includes(&self) -> (bool, bool) {
        self.includes
    }

    /// Whether `value` lies in the range.
    pub fn holds(&self, value: f64) -> bool {
        let (low, high) = self.includes;
        (value > self.lowest || low && value == self.lowest)
            && (value < self.highest || high && value == self.highest)
    }

    /// A number of the range, in place of one that is missing or wrong and has been reported.
    pub fn fallback(&self) -> f64 {
        [0.0, 1.0].into_iter().find(|value| self.holds(*value)).unwrap_or(self.highest)
    }
}

/// What values a parameter may have.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// A number.
    Number(Allowed),
    /// Yes or no.
    Flag,
    /// A whole number, first to last.
    Count(u64, u64),
    /// A word of a closed list, with its meaning.
    Choice(&'static [(&'static str, &'static str)]),
}

/// The row of a parameter.
#[derive(Clone, Copy, Debug)]
pub struct ParameterSpec {
    /// Name in case files and messages, with the unit.
    pub key: &'static str,
    /// Lines of its meaning, with symbol, unit and equation.
    meaning: &'static [&'static str],
    /// Values it may have.
    pub kind: Kind,
    /// The value that leaves the feature out; messages leave the parameter out then.
    pub off: Option<Value<'static>>,
    /// Without a value the feature is left out.
    pub is_optional: bool,
    /// A case must state it.
    pub is_stated: bool,
    /// The pair law between fluid and solid needs it, so that both sides hold it.
    pub is_of_pair_law: bool,
    /// What other values than the default cost.
    pub cost: Option<&'static str>,
    /// The value of the source paper.
    pub paper: Option<Value<'static>>,
}

impl ParameterSpec {
    const fn new(kind: Kind) -> Self {
        Self {
            key: "",
            meaning: &[],
            kind,
            off: None,
            is_optional: false,
            is_stated: false,
            is_of_pair_law: false,
            cost: None,
            paper: None,
        }
    }

    /// A number of a range.
    pub const fn number(allowed: Allowed) -> Self {
        Self::new(Kind::Number(allowed))
    }

    /// Yes or no.
    pub const fn flag() -> Self {
        Self::new(Kind::Flag)
    }

    /// A whole number, `first` to `last`.
    pub const fn count(first: u64, last: u64) -> Self {
        Self::new(Kind::Count(first, last))
    }

    /// A word of a closed list.
    pub const fn choice<T: Choice>() -> Self {
        Self::new(Kind::Choice(T::MEANINGS))
    }

    /// Gives it key and meaning.
    pub const fn named(self, key: &'static str, meaning: &'static [&'static str]) -> Self {
        Self { key, meaning, ..self }
    }

    /// `value` leaves the feature out.
    pub const fn off(self, value: Value<'static>) -> Self {
        Self { off: Some(value), ..self }
    }

    /// A parameter without a value leaves the feature out.
    pub const fn optional(self) -> Self {
        Self { is_optional: true, ..self }
    }

    /// A case must state it.
    pub const fn stated(self) -> Self {
        Self { is_stated: true, ..self }
    }

    /// The pair law between fluid and solid needs it.
    pub const fn of_pair_law(self) -> Self {
        Self { is_of_pair_law: true, ..self }
    }

    /// `cost` is what other values than the default cost.
    pub const fn cost(self, cost: &'static str) -> Self {
        Self { cost: Some(cost), ..self }
    }

    /// The value of the source paper.
    pub const fn paper(self, value: Value<'static>) -> Self {
        Self { paper: Some(value), ..self }
    }

    /// Its meaning, with symbol, unit and equation.
    pub fn meaning(&self) -> String {
        let lines: Vec<&str> = self.meaning.iter().map(|line| line.trim()).collect();
        lines.join(" ").replace('\\', "")
    }

    /// The allowed values in words.
    pub fn allowed(&self) -> String {
        match self.kind {
            Kind::Number(allowed) => allowed.words.to_owned(),
            Kind::Flag => "true or false".to_owned(),
            Kind::Count(first, last) => format!("a whole number from {first} to {last}"),
            Kind::Choice(words) => {
                let words: Vec<&str> = words.iter().map(|(word, _)| *word).collect();
                format!("\"{}\"", words.join("\", \""))
            }
        }
    }

    /// The error of a value that the row does not allow.
    pub(super) fn refuse(&self, value: Value<'_>) -> ParameterError {
        let value = match value {
            Value::Number(number) => format!("{number:?}"),
            Value::Choice(word) => format!("{word:?}"),
            value => value.to_string(),
        };
        ParameterError {
            key: self.key.to_owned(),
            problem: format!("is {value}, must be {}", self.allowed()),
        }
    }
}

/// A parameter that cannot be taken.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{key}`: {problem}")]
pub struct ParameterError {
    /// Name of the parameter.
    pub key: String,
    /// What is wrong with it.
    pub problem: String,
}

/// A closed choice: an enum whose variants have names in case files and messages.
pub trait Choice: Copy + PartialEq + fmt::Debug + 'static {
    /// Names and values.
    const NAMES: &'static [(&'static str, Self)];

    /// Names and meanings.
    const MEANINGS: &'static [(&'static str, &'static str)];

    /// Name of this value.
    fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(_, value)| *value == self).map_or("", |(name, _)| name)
    }
}
