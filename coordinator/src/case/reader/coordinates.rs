//! Vectors of a case file, of as many numbers as the case has dimensions.

use std::ops::Index;

use serde::Serialize;
use sph::space::Space;
use sph::space::components::Components;
use sph::space::tensors::SpaceVector;

/// A vector as written, one number for each axis.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Coordinates(Vec<f64>);

impl Coordinates {
    /// `value` along each of `dimensions` axes.
    pub fn repeat(dimensions: usize, value: f64) -> Self {
        Self(vec![value; dimensions])
    }

    /// The vector in the space of the case; zero where it is of another number of dimensions.
    pub fn to<S: Space>(&self) -> S::Vector {
        <S::Vector as Components>::of_row(&self.0).unwrap_or_else(S::Vector::zeros)
    }

    /// The numbers.
    pub fn as_slice(&self) -> &[f64] {
        &self.0
    }

    /// Whether any number is not zero.
    pub fn is_nonzero(&self) -> bool {
        self.0.iter().any(|value| *value != 0.0)
    }
}

impl From<Vec<f64>> for Coordinates {
    fn from(values: Vec<f64>) -> Self {
        Self(values)
    }
}

impl<V: Components> From<&V> for Coordinates {
    fn from(vector: &V) -> Self {
        Self(vector.row().as_ref().to_vec())
    }
}

impl Index<usize> for Coordinates {
    type Output = f64;

    fn index(&self, axis: usize) -> &f64 {
        &self.0[axis]
    }
}
