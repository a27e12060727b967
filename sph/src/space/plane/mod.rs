//! The plane.

mod algebra;
pub mod principal;

use std::fmt::Debug;

use nalgebra::{Matrix2, Vector2};
use serde::{Deserialize, Serialize};

use super::Space;
use super::components::Components;
use super::tensors::{SpaceSymmetric, SpaceTensor, SpaceVector};
use crate::lanes::{Lanes, WIDTH};

/// The plane: x to the right, y up; extensive quantities are per metre of depth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Plane;

impl Space for Plane {
    const DIMENSIONS: usize = 2;

    type Vector = Vector2<f64>;
    type Tensor = Matrix2<f64>;
    type SymmetricTensor = SymmetricTensor;
    type PerAxis<T: Clone + Debug + PartialEq + Send + Sync + 'static> = [T; 2];
    /// About z.
    type Spin = f64;
    /// Angle counter-clockwise \[rad\].
    type Rotation = f64;

    /// 10/(7π): ∫ f(s) 2πs ds = 7π/10 over the unscaled spline.
    #[inline(always)]
    fn kernel_normalised(factor: f64) -> f64 {
        factor * 10.0 / (7.0 * std::f64::consts::PI)
    }

    fn per_axis<T: Clone + Debug + PartialEq + Send + Sync + 'static>(
        value: impl FnMut(usize) -> T,
    ) -> Self::PerAxis<T> {
        std::array::from_fn(value)
    }

    #[inline(always)]
    fn cell_volume(spacing: f64) -> f64 {
        spacing * spacing
    }

    fn cell_inertia(mass: f64, density: f64) -> f64 {
        mass * mass / (6.0 * density)
    }

    #[inline(always)]
    fn cross(a: &Vector2<f64>, b: &Vector2<f64>) -> f64 {
        a.x * b.y - a.y * b.x
    }

    #[inline(always)]
    fn spin_cross(spin: f64, arm: &Vector2<f64>) -> Vector2<f64> {
        Vector2::new(-arm.y * spin, arm.x * spin)
    }

    #[inline(always)]
    fn centripetal(spin: f64, arm: &Vector2<f64>) -> Vector2<f64> {
        -arm * spin.powi(2)
    }

    #[inline]
    fn rotated(rotation: f64, spin: f64, duration: f64) -> f64 {
        rotation + spin * duration
    }

    #[inline]
    fn rotation_matrix(rotation: f64) -> Matrix2<f64> {
        let (sine, cosine) = rotation.sin_cos();
        Matrix2::new(cosine, -sine, sine, cosine)
    }

    #[inline(always)]
    fn vector(components: [f64; 2]) -> Vector2<f64> {
        components.into()
    }

    #[inline(always)]
    fn components(vector: &Vector2<f64>) -> [f64; 2] {
        vector.data.0[0]
    }

    #[inline(always)]
    fn symmetric_tensor([xx, xy, yy]: [f64; 3]) -> SymmetricTensor {
        SymmetricTensor { xx, yy, xy }
    }

    #[inline(always)]
    fn symmetric_components(tensor: &SymmetricTensor) -> [f64; 3] {
        [tensor.xx, tensor.xy, tensor.yy]
    }

    #[inline(always)]
    fn tensor([xx, xy, yx, yy]: [f64; 4]) -> Matrix2<f64> {
        Matrix2::new(xx, xy, yx, yy)
    }

    #[inline(always)]
    fn tensor_components(tensor: &Matrix2<f64>) -> [f64; 4] {
        let [[xx, yx], [xy, yy]] = tensor.data.0;
        [xx, xy, yx, yy]
    }

    #[inline(always)]
    fn splat_vector<L: Lanes>(vector: &Vector2<f64>) -> [L; 2] {
        [L::splat(vector.x), L::splat(vector.y)]
    }

    #[inline(always)]
    fn lanes<L: Lanes>([a, b, c, d]: [&Vector2<f64>; WIDTH]) -> [L; 2] {
        L::halves([&a.data.0[0], &b.data.0[0], &c.data.0[0], &d.data.0[0]])
    }

    #[inline(always)]
    fn tensor_lanes<L: Lanes>([a, b, c, d]: [&[f64; 4]; WIDTH]) -> [L; 4] {
        L::columns([a, b, c, d])
    }

    #[inline(always)]
    fn symmetric_component_lanes<L: Lanes>([a, b, c, d]: [&[f64; 3]; WIDTH]) -> [L; 3] {
        [0, 1, 2].map(|k| L::from_array([a[k], b[k], c[k], d[k]]))
    }

    #[inline(always)]
    fn symmetric_lanes<L: Lanes>([a, b, c, d]: [&SymmetricTensor; WIDTH]) -> [L; 3] {
        [
            L::from_array([a.xx, b.xx, c.xx, d.xx]),
            L::from_array([a.xy, b.xy, c.xy, d.xy]),
            L::from_array([a.yy, b.yy, c.yy, d.yy]),
        ]
    }

    #[inline(always)]
    fn vector_pairs<L: Lanes>([x, y]: [L; 2], [v_x, v_y]: [L; 2]) -> [[Vector2<f64>; 2]; WIDTH] {
        let [a, b, c, d] = L::columns([&x.to_array(), &y.to_array(), &v_x.to_array(), &v_y.to_array()]);
        let pair = |[x, y, v_x, v_y]: [f64; 4]| [Vector2::new(x, y), Vector2::new(v_x, v_y)];
        [pair(a.to_array()), pair(b.to_array()), pair(c.to_array()), pair(d.to_array())]
    }

    #[inline(always)]
    fn spin_sum<L: Lanes>(a: L) -> f64 {
        let [sum, ..] = L::sums([a, L::zero(), L::zero(), L::zero()]);
        sum
    }

    #[inline(always)]
    fn sums_with<L: Lanes>([x, y]: [L; 2], [a, b]: [L; 2]) -> ([f64; 2], [f64; 2]) {
        let [a, b, x, y] = L::sums([a, b, x, y]);
        ([x, y], [a, b])
    }

    #[inline(always)]
    fn vector_sums<L: Lanes>([a, b]: [L; 2], [c, d]: [L; 2]) -> [[f64; 2]; 2] {
        let [a, b, c, d] = L::sums([a, b, c, d]);
        [[a, b], [c, d]]
    }

    #[inline(always)]
    fn matrix_sums<L: Lanes>(m: [L; 4]) -> [f64; 4] {
        L::sums(m)
    }

    #[inline(always)]
    fn symmetric_sums<L: Lanes>([xx, xy, yy]: [L; 3]) -> [f64; 3] {
        let [xx, xy, yy, _] = L::sums([xx, xy, yy, L::zero()]);
        [xx, xy, yy]
    }
}

impl Components for Vector2<f64> {
    const COUNT: usize = 2;

    type Row = [f64; 2];

    #[inline]
    fn row(self) -> [f64; 2] {
        self.into()
    }

    #[inline]
    fn from_row(row: [f64; 2]) -> Self {
        row.into()
    }
}

/// By rows.
impl Components for Matrix2<f64> {
    const COUNT: usize = 4;

    type Row = [f64; 4];

    #[inline]
    fn row(self) -> [f64; 4] {
        [self.m11, self.m12, self.m21, self.m22]
    }

    #[inline]
    fn from_row([xx, xy, yx, yy]: [f64; 4]) -> Self {
        Self::new(xx, xy, yx, yy)
    }
}

impl Components for SymmetricTensor {
    const COUNT: usize = 3;

    type Row = [f64; 3];

    #[inline]
    fn row(self) -> [f64; 3] {
        [self.xx, self.yy, self.xy]
    }

    #[inline]
    fn from_row([xx, yy, xy]: [f64; 3]) -> Self {
        Self { xx, yy, xy }
    }
}

impl SpaceVector for Vector2<f64> {
    #[inline]
    fn zeros() -> Self {
        Self::zeros()
    }

    #[inline]
    fn repeat(value: f64) -> Self {
        Self::repeat(value)
    }

    #[inline]
    fn dot(&self, other: &Self) -> f64 {
        self.dot(other)
    }

    #[inline]
    fn norm_squared(&self) -> f64 {
        self.norm_squared()
    }

    #[inline]
    fn norm(&self) -> f64 {
        self.norm()
    }

    #[inline]
    fn inf(&self, other: &Self) -> Self {
        self.inf(other)
    }

    #[inline]
    fn sup(&self, other: &Self) -> Self {
        self.sup(other)
    }

    #[inline]
    fn try_normalize(&self, least: f64) -> Option<Self> {
        self.try_normalize(least)
    }

    #[inline]
    fn cap_magnitude(&self, largest: f64) -> Self {
        self.cap_magnitude(largest)
    }
}

impl SpaceTensor<Vector2<f64>> for Matrix2<f64> {
    #[inline]
    fn zeros() -> Self {
        Self::zeros()
    }

    #[inline]
    fn identity() -> Self {
        Self::identity()
    }

    #[inline]
    fn outer(a: &Vector2<f64>, b: &Vector2<f64>) -> Self {
        a * b.transpose()
    }

    #[inline]
    fn transpose(&self) -> Self {
        self.transpose()
    }

    #[inline]
    fn trace(&self) -> f64 {
        self.trace()
    }

    #[inline]
    fn determinant(&self) -> f64 {
        self.determinant()
    }

    #[inline]
    fn norm_squared(&self) -> f64 {
        self.norm_squared()
    }

    #[inline]
    fn cofactor(&self) -> Self {
        Self::new(self[(1, 1)], -self[(1, 0)], -self[(0, 1)], self[(0, 0)])
    }
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

impl SpaceSymmetric<Vector2<f64>, Matrix2<f64>> for SymmetricTensor {
    #[inline]
    fn isotropic(value: f64) -> Self {
        Self { xx: value, yy: value, xy: 0.0 }
    }

    #[inline]
    fn of(tensor: &Matrix2<f64>) -> Self {
        Self { xx: tensor[(0, 0)], yy: tensor[(1, 1)], xy: 0.5 * (tensor[(0, 1)] + tensor[(1, 0)]) }
    }

    #[inline]
    fn dot(&self, v: &Vector2<f64>) -> Vector2<f64> {
        Vector2::new(self.xx * v.x + self.xy * v.y, self.xy * v.x + self.yy * v.y)
    }

    #[inline]
    fn plus(&self, other: &Self) -> Self {
        Self { xx: self.xx + other.xx, yy: self.yy + other.yy, xy: self.xy + other.xy }
    }

    #[inline]
    fn scaled(&self, factor: f64) -> Self {
        Self { xx: self.xx * factor, yy: self.yy * factor, xy: self.xy * factor }
    }

    #[inline]
    fn full(&self) -> Matrix2<f64> {
        Matrix2::new(self.xx, self.xy, self.xy, self.yy)
    }

    #[inline]
    fn extremes(&self) -> [f64; 2] {
        let principal = self.principal();
        [principal.major, principal.minor]
    }

    #[inline]
    fn map_principal(&self, f: impl Fn(f64) -> f64) -> Self {
        let principal = self.principal();
        principal.with_values(f(principal.major), f(principal.minor))
    }

    fn major_direction(&self) -> Vector2<f64> {
        self.principal().major_direction()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rotation_turns_counter_clockwise_with_the_bits_of_its_formula() {
        for angle in [0.0, 0.3, -2.5, 7.0] {
            let (v, (sine, cosine)) = (Vector2::new(0.37, -1.9), f64::sin_cos(angle));
            let turned = Plane::rotation_matrix(angle) * v;
            assert_eq!(turned, Vector2::new(cosine * v.x - sine * v.y, sine * v.x + cosine * v.y));
        }
    }
}
