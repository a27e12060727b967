//! The complete state of a participant at a step boundary, as named arrays: plain data, whatever becomes of it.

use crate::space::components::Components;

/// Values of one named array.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Floating-point numbers; NaN keeps its bits.
    F64(Vec<f64>),
    /// Small whole numbers.
    U32(Vec<u32>),
    /// Large whole numbers.
    U64(Vec<u64>),
}

impl Values {
    /// Number of values.
    pub fn len(&self) -> usize {
        match self {
            Self::F64(values) => values.len(),
            Self::U32(values) => values.len(),
            Self::U64(values) => values.len(),
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Everything that decides the bits of what follows, under names of its owner's choice.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SavedState {
    /// Names and values, in the order in which they were saved; names differ.
    pub arrays: Vec<(String, Values)>,
}

/// Why a saved state cannot be taken over.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("array `{array}`: {problem}")]
pub struct RestoreError {
    /// Array that is missing or wrong.
    pub array: String,
    /// What is wrong and what was expected.
    pub problem: String,
}

impl RestoreError {
    /// Something wrong with `array`.
    pub fn new(array: &str, problem: impl Into<String>) -> Self {
        Self { array: array.to_owned(), problem: problem.into() }
    }
}

impl SavedState {
    fn put(&mut self, name: &str, values: Values) {
        self.arrays.push((name.to_owned(), values));
    }

    /// Saves numbers.
    pub fn put_f64(&mut self, name: &str, values: impl IntoIterator<Item = f64>) {
        self.put(name, Values::F64(values.into_iter().collect()));
    }

    /// Saves small whole numbers.
    pub fn put_u32(&mut self, name: &str, values: impl IntoIterator<Item = u32>) {
        self.put(name, Values::U32(values.into_iter().collect()));
    }

    /// Saves large whole numbers.
    pub fn put_u64(&mut self, name: &str, values: impl IntoIterator<Item = u64>) {
        self.put(name, Values::U64(values.into_iter().collect()));
    }

    /// Saves quantities, the components of each after the other.
    pub fn put_quantities<C: Components>(&mut self, name: &str, values: &[C]) {
        let mut numbers = Vec::with_capacity(C::COUNT * values.len());
        values.iter().for_each(|value| numbers.extend_from_slice(value.row().as_ref()));
        self.put(name, Values::F64(numbers));
    }

    /// Whether `name` was saved.
    pub fn has(&self, name: &str) -> bool {
        self.arrays.iter().any(|(known, _)| known == name)
    }

    fn get(&self, name: &str) -> Result<&Values, RestoreError> {
        let found = self.arrays.iter().find(|(known, _)| known == name);
        found.map(|(_, values)| values).ok_or_else(|| RestoreError::new(name, "is missing"))
    }

    /// `count` numbers, all finite; any number of them without a count.
    ///
    /// # Errors
    /// When the array is missing, is of another kind or length, or holds a number that is not finite.
    pub fn f64s(&self, name: &str, count: Option<usize>) -> Result<&[f64], RestoreError> {
        let Values::F64(values) = self.get(name)? else {
            return Err(RestoreError::new(name, "must hold 64-bit floating-point numbers"));
        };
        expect_length(name, values.len(), count)?;
        match values.iter().position(|value| !value.is_finite()) {
            Some(k) => Err(RestoreError::new(name, format!("entry {k} is {}, must be finite", values[k]))),
            None => Ok(values),
        }
    }

    /// `count` small whole numbers.
    ///
    /// # Errors
    /// When the array is missing, or is of another kind or length.
    pub fn u32s(&self, name: &str, count: Option<usize>) -> Result<&[u32], RestoreError> {
        let Values::U32(values) = self.get(name)? else {
            return Err(RestoreError::new(name, "must hold 32-bit whole numbers"));
        };
        expect_length(name, values.len(), count)?;
        Ok(values)
    }

    /// Exactly `N` large whole numbers.
    ///
    /// # Errors
    /// When the array is missing, or is of another kind or length.
    pub fn u64s<const N: usize>(&self, name: &str) -> Result<[u64; N], RestoreError> {
        let Values::U64(values) = self.get(name)? else {
            return Err(RestoreError::new(name, "must hold 64-bit whole numbers"));
        };
        let problem = || format!("has {} entries, must have {N}", values.len());
        values.as_slice().try_into().map_err(|_| RestoreError::new(name, problem()))
    }

    /// Exactly `N` finite numbers.
    ///
    /// # Errors
    /// As [`SavedState::f64s`].
    pub fn numbers<const N: usize>(&self, name: &str) -> Result<[f64; N], RestoreError> {
        let values = self.f64s(name, Some(N))?;
        values.try_into().map_err(|_| RestoreError::new(name, "has another length"))
    }

    /// `count` quantities of finite components.
    ///
    /// # Errors
    /// As [`SavedState::f64s`].
    pub fn quantities<C: Components>(&self, name: &str, count: usize) -> Result<Vec<C>, RestoreError> {
        let values = self.f64s(name, count.checked_mul(C::COUNT))?;
        Ok(values.chunks_exact(C::COUNT).filter_map(C::of_row).collect())
    }
}

fn expect_length(name: &str, length: usize, expected: Option<usize>) -> Result<(), RestoreError> {
    match expected {
        Some(expected) if expected != length => {
            Err(RestoreError::new(name, format!("has {length} entries, must have {expected}")))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::Vector;

    #[test]
    fn what_is_saved_comes_back_and_everything_else_is_named() {
        let mut state = SavedState::default();
        state.put_quantities("x", &[Vector::new(0.1, -0.0), Vector::new(3.0, 1e-300)]);
        state.put_u64("step", [7]);
        state.put_f64("bad", [1.0, f64::NAN]);
        let x: Vec<Vector> = state.quantities("x", 2).unwrap();
        assert_eq!(x[0].y.to_bits(), (-0.0f64).to_bits());
        assert_eq!(state.u64s::<1>("step").unwrap(), [7]);
        for (error, words) in [
            (state.quantities::<Vector>("x", 3).unwrap_err(), "4 entries, must have 6"),
            (state.f64s("step", None).map(drop).unwrap_err(), "floating-point"),
            (state.f64s("bad", None).map(drop).unwrap_err(), "entry 1 is NaN"),
            (state.u32s("gone", None).map(drop).unwrap_err(), "`gone`: is missing"),
        ] {
            assert!(error.to_string().contains(words), "{error}");
        }
    }
}
