//! Space: vectors and tensors, the domain and its periodic directions.

pub mod domain;
pub mod geometry;
pub mod principal;

use nalgebra::{Matrix2, Vector2};
use serde::{Deserialize, Serialize};

/// Number of space dimensions.
pub const DIMENSIONS: usize = 2;

/// A vector in space; component 0 is x, component 1 is y (up).
pub type Vector = Vector2<f64>;

/// A full second-order tensor, row = first index.
pub type Tensor = Matrix2<f64>;

/// z component of `a × b`.
#[inline]
pub fn cross(a: &Vector, b: &Vector) -> f64 {
    a.x * b.y - a.y * b.x
}

/// A symmetric tensor in the plane, such as a stress \[Pa\].
///
/// The out-of-plane component is implied by the constitutive law (plane strain) and not stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SymmetricTensor {
    /// Component 11.
    pub xx: f64,
    /// Component 22.
    pub yy: f64,
    /// Component 12 = 21.
    pub xy: f64,
}

impl SymmetricTensor {
    /// The isotropic tensor `value · I`.
    pub fn isotropic(value: f64) -> Self {
        Self { xx: value, yy: value, xy: 0.0 }
    }

    /// Product with a vector.
    #[inline]
    pub fn dot(&self, v: &Vector) -> Vector {
        Vector::new(self.xx * v.x + self.xy * v.y, self.xy * v.x + self.yy * v.y)
    }

    /// Sum of two tensors.
    #[inline]
    pub fn plus(&self, other: &Self) -> Self {
        Self { xx: self.xx + other.xx, yy: self.yy + other.yy, xy: self.xy + other.xy }
    }

    /// The same with all components.
    #[inline]
    pub fn full(&self) -> Tensor {
        Tensor::new(self.xx, self.xy, self.xy, self.yy)
    }

    /// Product with a number.
    #[inline]
    pub fn scaled(&self, factor: f64) -> Self {
        Self { xx: self.xx * factor, yy: self.yy * factor, xy: self.xy * factor }
    }
}
