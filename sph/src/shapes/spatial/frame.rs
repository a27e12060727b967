//! Where a shape is and which way it is turned.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

/// Coordinates in space, turned and moved against those of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Where the local origin lies \[m\].
    origin: Vector3<f64>,
    /// The local axes as columns.
    axes: Matrix3<f64>,
}

impl Default for Frame {
    fn default() -> Self {
        Self { origin: Vector3::zeros(), axes: Matrix3::identity() }
    }
}

impl Frame {
    /// A frame at `origin` \[m\] with x along `x` and y in the plane of `x` and `y`; `None` if these are parallel or zero.
    pub fn new(origin: Vector3<f64>, x: &Vector3<f64>, y: &Vector3<f64>) -> Option<Self> {
        let x = x.try_normalize(0.0)?;
        let y = (y - x * x.dot(y)).try_normalize(1e-12 * y.norm())?;
        Some(Self { origin, axes: Matrix3::from_columns(&[x, y, x.cross(&y)]) })
    }

    /// A frame at `origin` \[m\] with z along `axis`; the directions of x and y are not stated. `None` if `axis` is zero.
    pub fn along(origin: Vector3<f64>, axis: &Vector3<f64>) -> Option<Self> {
        let z = axis.try_normalize(0.0)?;
        // Across the axis, and exact where that is a coordinate axis.
        let across = if z.z.abs() > 0.9 { Vector3::x() } else { Vector3::z() };
        let x = (across - z * z.dot(&across)).try_normalize(0.0)?;
        Some(Self { origin, axes: Matrix3::from_columns(&[x, z.cross(&x), z]) })
    }

    /// The frame of what is turned by `rotation` about the origin and then moved by `by` \[m\].
    pub fn placed(rotation: &UnitQuaternion<f64>, by: Vector3<f64>) -> Self {
        Self { origin: by, axes: rotation.to_rotation_matrix().into_inner() }
    }

    /// Where the local origin lies \[m\].
    pub fn origin(&self) -> Vector3<f64> {
        self.origin
    }

    /// Direction of the local z axis.
    pub fn z(&self) -> Vector3<f64> {
        self.axes.column(2).into_owned()
    }

    /// The frame moved by `by` \[m\].
    #[must_use]
    pub fn translated(&self, by: &Vector3<f64>) -> Self {
        Self { origin: self.origin + by, axes: self.axes }
    }

    /// Local coordinates of `point` \[m\].
    pub fn local(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.axes.tr_mul(&(point - self.origin))
    }

    /// The point of local coordinates `point` \[m\].
    pub fn point(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.origin + self.axes * point
    }

    /// The vector of local components `vector`.
    pub fn vector(&self, vector: &Vector3<f64>) -> Vector3<f64> {
        self.axes * vector
    }

    /// A frame given in the coordinates of this one, in those of the scene.
    pub(super) fn of(&self, inner: &Self) -> Self {
        Self { origin: self.point(&inner.origin), axes: self.axes * inner.axes }
    }
}
