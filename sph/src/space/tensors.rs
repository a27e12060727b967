//! What laws need of vectors and tensors of a space, whatever its dimensions.

use std::fmt::Debug;
use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, Index, IndexMut, Mul, Neg, Sub, SubAssign};

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::components::Components;

/// A quantity that states hold.
pub trait Value:
    Copy + Debug + Default + PartialEq + Send + Sync + Serialize + DeserializeOwned + 'static
{
}

impl<T: Copy + Debug + Default + PartialEq + Send + Sync + Serialize + DeserializeOwned + 'static> Value
    for T
{
}

/// A quantity that can be added and scaled; operators take it by value.
pub trait Linear:
    Value
    + Add<Output = Self>
    + Sub<Output = Self>
    + Neg<Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
    + AddAssign
    + SubAssign
    + Sum
{
}

impl<T> Linear for T where
    T: Value
        + Add<Output = Self>
        + Sub<Output = Self>
        + Neg<Output = Self>
        + Mul<f64, Output = Self>
        + Div<f64, Output = Self>
        + AddAssign
        + SubAssign
        + Sum
{
}

/// A vector.
pub trait SpaceVector: Linear + Components + Index<usize, Output = f64> + IndexMut<usize> {
    /// The zero vector.
    fn zeros() -> Self;

    /// `value` along each axis.
    fn repeat(value: f64) -> Self;

    /// a·b.
    fn dot(&self, other: &Self) -> f64;

    /// Square of the length.
    fn norm_squared(&self) -> f64;

    /// Length.
    fn norm(&self) -> f64;

    /// The smaller of both along each axis.
    fn inf(&self, other: &Self) -> Self;

    /// The larger of both along each axis.
    fn sup(&self, other: &Self) -> Self;

    /// The vector of length one, unless this one is no longer than `least`.
    fn try_normalize(&self, least: f64) -> Option<Self>;

    /// The vector with a length of at most `largest`.
    fn cap_magnitude(&self, largest: f64) -> Self;
}

/// A tensor.
pub trait SpaceTensor<V>:
    Linear + Components + Mul<V, Output = V> + Mul<Output = Self> + Index<(usize, usize), Output = f64>
{
    /// The zero tensor.
    fn zeros() -> Self;

    /// The unit tensor.
    fn identity() -> Self;

    /// a ⊗ b.
    fn outer(a: &V, b: &V) -> Self;

    /// The transpose.
    fn transpose(&self) -> Self;

    /// Sum of the diagonal.
    fn trace(&self) -> f64;

    /// Determinant.
    fn determinant(&self) -> f64;

    /// A : A, the sum of the squares of all components.
    fn norm_squared(&self) -> f64;

    /// Cofactor matrix J A⁻ᵀ, J the determinant.
    fn cofactor(&self) -> Self;
}

/// A symmetric tensor.
pub trait SpaceSymmetric<V, T>: Value + Components {
    /// The isotropic tensor `value · I`.
    fn isotropic(value: f64) -> Self;

    /// The symmetric part of a tensor.
    fn of(tensor: &T) -> Self;

    /// Product with a vector.
    fn dot(&self, v: &V) -> V;

    /// Sum of two tensors.
    fn plus(&self, other: &Self) -> Self;

    /// Product with a number.
    fn scaled(&self, factor: f64) -> Self;

    /// The same with all components.
    fn full(&self) -> T;

    /// Largest and smallest principal value.
    fn extremes(&self) -> [f64; 2];

    /// The tensor of the same principal directions with `f` of each principal value.
    fn map_principal(&self, f: impl Fn(f64) -> f64) -> Self;

    /// Unit vector along the direction of the largest principal value.
    fn major_direction(&self) -> V;
}
