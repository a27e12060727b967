//! Sets of parameters, one row for each parameter.
//!
//! A row states the field, its type, its default, its key and its meaning. Case files, set-up messages, the run header
//! and `docs/parameters.md` read the rows, so that a parameter is spelled in one place.

use std::fmt;

use super::parameter_spec::{Choice, Kind, ParameterError, ParameterSpec, Value};

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

/// A set of parameters, made by `parameters!`.
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
mod tests;
