//! Vectors, tensors and rotations of space as the methods take them.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use crate::space::components::Components;
use crate::space::tensors::{SpaceSymmetric, SpaceTensor, SpaceVector};

impl Components for Vector3<f64> {
    const COUNT: usize = 3;

    type Row = [f64; 3];

    #[inline]
    fn row(self) -> [f64; 3] {
        self.into()
    }

    #[inline]
    fn from_row(row: [f64; 3]) -> Self {
        row.into()
    }
}

/// By rows.
impl Components for Matrix3<f64> {
    const COUNT: usize = 9;

    type Row = [f64; 9];

    #[inline]
    fn row(self) -> [f64; 9] {
        // Stored by columns.
        let [[xx, yx, zx], [xy, yy, zy], [xz, yz, zz]] = self.into();
        [xx, xy, xz, yx, yy, yz, zx, zy, zz]
    }

    #[inline]
    fn from_row(row: [f64; 9]) -> Self {
        Self::from_row_slice(&row)
    }
}

/// Scalar part first: w, x, y, z.
impl Components for UnitQuaternion<f64> {
    const COUNT: usize = 4;

    type Row = [f64; 4];

    #[inline]
    fn row(self) -> [f64; 4] {
        [self.w, self.i, self.j, self.k]
    }

    /// Without normalising, so that a saved rotation keeps its bits.
    #[inline]
    fn from_row([w, x, y, z]: [f64; 4]) -> Self {
        Self::new_unchecked(nalgebra::Quaternion::new(w, x, y, z))
    }
}

/// In the order of VTK: xx, yy, zz, xy, yz, xz.
impl Components for SymmetricTensor3 {
    const COUNT: usize = 6;

    type Row = [f64; 6];

    #[inline]
    fn row(self) -> [f64; 6] {
        [self.xx, self.yy, self.zz, self.xy, self.yz, self.xz]
    }

    #[inline]
    fn from_row([xx, yy, zz, xy, yz, xz]: [f64; 6]) -> Self {
        Self { xx, yy, zz, xy, yz, xz }
    }
}

impl SpaceVector for Vector3<f64> {
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

impl SpaceTensor<Vector3<f64>> for Matrix3<f64> {
    #[inline]
    fn zeros() -> Self {
        Self::zeros()
    }

    #[inline]
    fn identity() -> Self {
        Self::identity()
    }

    #[inline]
    fn outer(a: &Vector3<f64>, b: &Vector3<f64>) -> Self {
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

    /// Its rows are the cross products of the other two.
    #[inline]
    fn cofactor(&self) -> Self {
        let row = |i: usize| Vector3::new(self[(i, 0)], self[(i, 1)], self[(i, 2)]);
        let (a, b, c) = (row(0), row(1), row(2));
        let rows = [b.cross(&c), c.cross(&a), a.cross(&b)].map(|row| row.transpose());
        Self::from_rows(&rows)
    }
}

/// A symmetric tensor in space, such as a stress \[Pa\].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SymmetricTensor3 {
    /// Component 11.
    pub xx: f64,
    /// Component 22.
    pub yy: f64,
    /// Component 33.
    pub zz: f64,
    /// Component 12 = 21.
    pub xy: f64,
    /// Component 23 = 32.
    pub yz: f64,
    /// Component 13 = 31.
    pub xz: f64,
}

impl SpaceSymmetric<Vector3<f64>, Matrix3<f64>> for SymmetricTensor3 {
    #[inline]
    fn isotropic(value: f64) -> Self {
        Self { xx: value, yy: value, zz: value, ..Self::default() }
    }

    #[inline]
    fn of(tensor: &Matrix3<f64>) -> Self {
        let mean = |i, j| 0.5 * (tensor[(i, j)] + tensor[(j, i)]);
        Self {
            xx: tensor[(0, 0)],
            yy: tensor[(1, 1)],
            zz: tensor[(2, 2)],
            xy: mean(0, 1),
            yz: mean(1, 2),
            xz: mean(0, 2),
        }
    }

    #[inline]
    fn dot(&self, v: &Vector3<f64>) -> Vector3<f64> {
        Vector3::new(
            self.xx * v.x + self.xy * v.y + self.xz * v.z,
            self.xy * v.x + self.yy * v.y + self.yz * v.z,
            self.xz * v.x + self.yz * v.y + self.zz * v.z,
        )
    }

    #[inline]
    fn plus(&self, other: &Self) -> Self {
        Self {
            xx: self.xx + other.xx,
            yy: self.yy + other.yy,
            zz: self.zz + other.zz,
            xy: self.xy + other.xy,
            yz: self.yz + other.yz,
            xz: self.xz + other.xz,
        }
    }

    #[inline]
    fn scaled(&self, factor: f64) -> Self {
        Self {
            xx: self.xx * factor,
            yy: self.yy * factor,
            zz: self.zz * factor,
            xy: self.xy * factor,
            yz: self.yz * factor,
            xz: self.xz * factor,
        }
    }

    #[inline]
    fn full(&self) -> Matrix3<f64> {
        Matrix3::new(
            self.xx, self.xy, self.xz, //
            self.xy, self.yy, self.yz, //
            self.xz, self.yz, self.zz,
        )
    }

    #[inline]
    fn extremes(&self) -> [f64; 2] {
        let [major, _, minor] = self.principal_values();
        [major, minor]
    }

    fn map_principal(&self, f: impl Fn(f64) -> f64) -> Self {
        let principal = self.principal();
        principal.with_values(principal.values.map(f))
    }

    fn major_direction(&self) -> Vector3<f64> {
        self.principal().directions[0]
    }
}
