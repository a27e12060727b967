//! Sets of parameters, one row for each parameter.
//!
//! A row states the field, its type, its default, its key and its meaning. Case files, set-up messages, the run header
//! and `docs/parameters.md` read the rows, so that a parameter is spelled in one place.

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
    lowest: f64,
    highest: f64,
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
    /// The recommended value, and what other values cost.
    pub recommended: Option<(Value<'static>, &'static str)>,
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
            recommended: None,
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

    /// `value` is recommended; `cost` is what the default costs.
    pub const fn recommended(self, value: Value<'static>, cost: &'static str) -> Self {
        Self { recommended: Some((value, cost)), ..self }
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

    fn refuse(&self, value: Value<'_>) -> ParameterError {
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

/// A type that a parameter may have.
pub trait ParameterType: Copy {
    /// The value; `None` where there is none.
    fn value(self) -> Option<Value<'static>>;

    /// Takes a value that the row allows.
    ///
    /// # Errors
    /// The row does not allow it.
    fn taken(value: Value<'_>, spec: &ParameterSpec) -> Result<Self, ParameterError>;
}

impl ParameterType for f64 {
    fn value(self) -> Option<Value<'static>> {
        Some(Value::Number(self))
    }

    fn taken(value: Value<'_>, spec: &ParameterSpec) -> Result<Self, ParameterError> {
        match (value, spec.kind) {
            (Value::Number(number), Kind::Number(allowed)) if number.is_finite() && allowed.holds(number) => {
                Ok(number)
            }
            _ => Err(spec.refuse(value)),
        }
    }
}

impl ParameterType for Option<f64> {
    fn value(self) -> Option<Value<'static>> {
        self.map(Value::Number)
    }

    fn taken(value: Value<'_>, spec: &ParameterSpec) -> Result<Self, ParameterError> {
        f64::taken(value, spec).map(Some)
    }
}

impl ParameterType for bool {
    fn value(self) -> Option<Value<'static>> {
        Some(Value::Flag(self))
    }

    fn taken(value: Value<'_>, spec: &ParameterSpec) -> Result<Self, ParameterError> {
        if let Value::Flag(flag) = value { Ok(flag) } else { Err(spec.refuse(value)) }
    }
}

impl ParameterType for u64 {
    fn value(self) -> Option<Value<'static>> {
        Some(Value::Count(self))
    }

    fn taken(value: Value<'_>, spec: &ParameterSpec) -> Result<Self, ParameterError> {
        match (value, spec.kind) {
            (Value::Count(count), Kind::Count(first, last)) if (first..=last).contains(&count) => Ok(count),
            _ => Err(spec.refuse(value)),
        }
    }
}

impl<T: Choice> ParameterType for T {
    fn value(self) -> Option<Value<'static>> {
        Some(Value::Choice(self.name()))
    }

    fn taken(value: Value<'_>, spec: &ParameterSpec) -> Result<Self, ParameterError> {
        let found = T::NAMES.iter().find(|(name, _)| value == Value::Choice(name));
        found.map(|(_, value)| *value).ok_or_else(|| spec.refuse(value))
    }
}

/// A set of parameters, made by [`parameters!`].
pub trait ParameterSet: Copy + Default + PartialEq + fmt::Debug + 'static {
    /// The rows.
    const SPECIFICATIONS: &'static [ParameterSpec];

    /// The value of a parameter; `None` where it has none, or is none of this set.
    fn get(&self, key: &str) -> Option<Value<'static>>;

    /// Sets the parameter of the row `spec`.
    ///
    /// # Errors
    /// The row does not allow the value.
    fn assign(&mut self, spec: &ParameterSpec, value: Value<'_>) -> Result<(), ParameterError>;

    /// Rows and values, without parameters that have no value.
    fn values(&self) -> impl Iterator<Item = (&'static ParameterSpec, Value<'static>)> {
        Self::SPECIFICATIONS.iter().filter_map(|spec| Some((spec, self.get(spec.key)?)))
    }

    /// Sets the parameter `key`.
    ///
    /// # Errors
    /// There is no such parameter, or its row does not allow the value.
    fn set(&mut self, key: &str, value: Value<'_>) -> Result<(), ParameterError> {
        match Self::SPECIFICATIONS.iter().find(|spec| spec.key == key) {
            Some(spec) => self.assign(spec, value),
            None => {
                let problem =
                    "is not a parameter that this solver knows; it would change the result".to_owned();
                Err(ParameterError { key: key.to_owned(), problem })
            }
        }
    }

    /// What a message states: all values but those that leave a feature out.
    fn stated(&self) -> impl Iterator<Item = (&'static ParameterSpec, Value<'static>)> {
        self.values().filter(|(spec, value)| !spec.off.is_some_and(|off| off.is(value)))
    }

    /// The set that a message states: parameters that it leaves out are at the value that leaves the feature out.
    /// Those that are `needed` and have no such value must be stated.
    ///
    /// # Errors
    /// A parameter that is unknown, not allowed, stated twice or missing.
    fn from_stated<'a>(
        stated: impl Iterator<Item = (&'a str, Value<'a>)>,
        needed: impl Fn(&ParameterSpec) -> bool,
    ) -> Result<Self, ParameterError> {
        let mut set = Self::default().with(|spec| spec.off);
        let mut missing: Vec<&ParameterSpec> = Self::SPECIFICATIONS.iter().collect();
        for (key, value) in stated {
            set.set(key, value)?;
            let Some(k) = missing.iter().position(|spec| spec.key == key) else {
                return Err(ParameterError { key: key.to_owned(), problem: "is stated twice".to_owned() });
            };
            missing.remove(k);
        }
        match missing.iter().find(|spec| needed(spec) && spec.off.is_none() && !spec.is_optional) {
            Some(spec) => {
                let problem = format!("is missing, must be {}", spec.allowed());
                Err(ParameterError { key: spec.key.to_owned(), problem })
            }
            None => Ok(set),
        }
    }

    /// The same with other values.
    #[must_use]
    fn with(mut self, value: impl Fn(&ParameterSpec) -> Option<Value<'static>>) -> Self {
        for spec in Self::SPECIFICATIONS {
            // The tests assign all values of all rows.
            let _ = value(spec).map(|value| self.assign(spec, value));
        }
        self
    }

    /// The recommended values, and the defaults where nothing is recommended.
    fn recommended() -> Self {
        Self::default().with(|spec| spec.recommended.map(|(value, _)| value))
    }

    /// The values of the source paper, and the defaults where it has none.
    fn paper() -> Self {
        Self::default().with(|spec| spec.paper)
    }

    /// The parameters of the pair law between fluid and solid; the features of all others are left out.
    #[must_use]
    fn of_pair_law(&self) -> Self {
        Self::default().with(|spec| if spec.is_of_pair_law { self.get(spec.key) } else { spec.off })
    }

    /// Values that their rows do not allow.
    fn errors(&self) -> Vec<ParameterError> {
        self.values().filter_map(|(spec, value)| { *self }.assign(spec, value).err()).collect()
    }
}

/// Defines a set of parameters: `field: type = default, key, row;`, with the meaning as doc comment.
macro_rules! parameters {
    ($(#[$attribute:meta])* pub struct $name:ident {
        $($(#[doc = $meaning:literal])+ $field:ident: $type:ty = $default:expr, $key:literal, $row:expr;)+
    }) => {
        $(#[$attribute])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $name {
            $($(#[doc = $meaning])+ pub $field: $type,)+
        }

        impl $name {
            /// The default values.
            pub const DEFAULT: Self = Self { $($field: $default,)+ };
        }

        impl Default for $name {
            fn default() -> Self {
                Self::DEFAULT
            }
        }

        impl $crate::setup::ParameterSet for $name {
            const SPECIFICATIONS: &'static [$crate::setup::ParameterSpec] =
                &[$($row.named($key, &[$($meaning),+]),)+];

            fn get(&self, key: &str) -> Option<$crate::setup::Value<'static>> {
                match key {
                    $($key => $crate::setup::ParameterType::value(self.$field),)+
                    _ => None,
                }
            }

            fn assign(
                &mut self,
                spec: &$crate::setup::ParameterSpec,
                value: $crate::setup::Value<'_>,
            ) -> Result<(), $crate::setup::ParameterError> {
                match spec.key {
                    $($key => self.$field = $crate::setup::ParameterType::taken(value, spec)?,)+
                    _ => {}
                }
                Ok(())
            }
        }
    };
}

/// Defines a closed choice: `Variant = "name"`, with the meaning as doc comment.
macro_rules! choices {
    ($(#[$attribute:meta])* pub enum $name:ident {
        $($(#[doc = $meaning:literal])+ $variant:ident = $word:literal,)+
    }) => {
        $(#[$attribute])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $name {
            $($(#[doc = $meaning])+ $variant,)+
        }

        impl $crate::setup::Choice for $name {
            const NAMES: &'static [(&'static str, Self)] = &[$(($word, Self::$variant),)+];
            const MEANINGS: &'static [(&'static str, &'static str)] = &[$(($word, concat!($($meaning),+)),)+];
        }
    };
}

pub(crate) use {choices, parameters};

#[cfg(test)]
mod tests {
    use crate::setup::{
        ElasticParameters, FluidParameters, RepulsionParameters, TotalLagrangian, UpdatedLagrangian,
    };

    use super::*;

    fn check<T: ParameterSet>() {
        for set in [T::default(), T::recommended(), T::paper()] {
            assert_eq!(set.errors(), [], "{set:?}");
            let stated = set.stated().map(|(spec, value)| (spec.key, value));
            assert_eq!(T::from_stated(stated, |_| true).as_ref(), Ok(&set));
        }
        let values = |spec: &ParameterSpec| [spec.off, spec.paper, spec.recommended.map(|(value, _)| value)];
        for spec in T::SPECIFICATIONS {
            for value in values(spec).into_iter().flatten() {
                let mut set = T::default();
                assert_eq!(set.set(spec.key, value), Ok(()));
                assert!(set.get(spec.key).is_some_and(|taken| taken.is(&value)));
            }
            assert!(spec.meaning().ends_with('.'), "{}", spec.key);
        }
    }

    #[test]
    fn all_rows_take_their_own_values_and_travel() {
        check::<FluidParameters>();
        check::<ElasticParameters>();
        check::<UpdatedLagrangian>();
        check::<TotalLagrangian>();
        check::<RepulsionParameters>();
    }

    #[test]
    fn minus_zero_is_stated() {
        let set = FluidParameters { viscosity_b: -0.0, ..FluidParameters::default() };
        let stated = |(spec, value): (&'static ParameterSpec, _)| (spec.key, value);
        let carried = FluidParameters::from_stated(set.stated().map(stated), |_| true).unwrap();
        assert!(carried.viscosity_b.is_sign_negative());
    }

    #[test]
    fn what_would_change_the_result_is_refused_by_name() {
        let mut set = FluidParameters::default();
        let error = set.set("surface_tension_n_m", Value::Number(0.07)).unwrap_err();
        assert!(error.to_string().starts_with("`surface_tension_n_m`: is not a parameter"), "{error}");
        let error = set.set("scheme", Value::Choice("euler")).unwrap_err();
        assert_eq!(error.problem, "is \"euler\", must be \"leapfrog\", \"predictor-corrector\"");
        let error = set.set("lambda", Value::Number(f64::NAN)).unwrap_err();
        assert_eq!(error.to_string(), "`lambda`: is NaN, must be a number from 0 to 1");
        let error = FluidParameters::from_stated(std::iter::empty(), |_| true).unwrap_err();
        assert!(error.problem.starts_with("is missing"), "{error}");
        let twice = [("lambda", Value::Number(0.5)); 2];
        assert_eq!(
            FluidParameters::from_stated(twice.into_iter(), |_| true).unwrap_err().problem,
            "is stated twice"
        );
    }
}
