//! Space of three dimensions.

mod algebra;
pub mod principal;
mod tensors;

use std::fmt::Debug;

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

pub use tensors::SymmetricTensor3;

use super::Space;
use crate::lanes::{Lanes, WIDTH};

/// Space: x, y and z; which way is up follows from gravity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Spatial;

/// The three numbers that `component` gives of four vectors or tensors, one for each lane.
macro_rules! each_lane {
    ($lanes:ident, [$a:ident, $b:ident, $c:ident, $d:ident], [$($component:tt)*]) => {
        [$($lanes::from_array([$a.$component, $b.$component, $c.$component, $d.$component])),*]
    };
}

/// `N` components from number `from` on.
#[inline(always)]
fn part<const N: usize>(components: &[f64], from: usize) -> &[f64; N] {
    let Some(part) = components[from..].first_chunk() else { unreachable!("a part of the components") };
    part
}

impl Space for Spatial {
    const DIMENSIONS: usize = 3;

    type Vector = Vector3<f64>;
    type Tensor = Matrix3<f64>;
    type SymmetricTensor = SymmetricTensor3;
    type PerAxis<T: Clone + Debug + PartialEq + Send + Sync + 'static> = [T; 3];
    type Spin = Vector3<f64>;
    type Rotation = UnitQuaternion<f64>;

    /// 1/π: ∫ f(s) 4πs² ds = π over the unscaled spline.
    #[inline(always)]
    fn kernel_normalised(factor: f64) -> f64 {
        factor / std::f64::consts::PI
    }

    fn per_axis<T: Clone + Debug + PartialEq + Send + Sync + 'static>(
        value: impl FnMut(usize) -> T,
    ) -> Self::PerAxis<T> {
        std::array::from_fn(value)
    }

    #[inline(always)]
    fn cell_volume(spacing: f64) -> f64 {
        spacing * spacing * spacing
    }

    fn cell_inertia(mass: f64, density: f64) -> f64 {
        mass * (mass / density).cbrt().powi(2) / 6.0
    }

    #[inline(always)]
    fn cross(a: &Vector3<f64>, b: &Vector3<f64>) -> Vector3<f64> {
        a.cross(b)
    }

    #[inline(always)]
    fn spin_cross(spin: Vector3<f64>, arm: &Vector3<f64>) -> Vector3<f64> {
        spin.cross(arm)
    }

    #[inline(always)]
    fn centripetal(spin: Vector3<f64>, arm: &Vector3<f64>) -> Vector3<f64> {
        spin.cross(&spin.cross(arm))
    }

    #[inline]
    fn rotated(rotation: UnitQuaternion<f64>, spin: Vector3<f64>, duration: f64) -> UnitQuaternion<f64> {
        // Normalised, since round-off of products would let the length drift.
        UnitQuaternion::new_normalize(
            UnitQuaternion::from_scaled_axis(spin * duration).into_inner() * rotation.into_inner(),
        )
    }

    #[inline]
    fn rotation_matrix(rotation: UnitQuaternion<f64>) -> Matrix3<f64> {
        rotation.to_rotation_matrix().into_inner()
    }

    #[inline(always)]
    fn vector(components: [f64; 3]) -> Vector3<f64> {
        components.into()
    }

    #[inline(always)]
    fn components(vector: &Vector3<f64>) -> [f64; 3] {
        vector.data.0[0]
    }

    #[inline(always)]
    fn symmetric_tensor([xx, xy, xz, yy, yz, zz]: [f64; 6]) -> SymmetricTensor3 {
        SymmetricTensor3 { xx, yy, zz, xy, yz, xz }
    }

    #[inline(always)]
    fn symmetric_components(t: &SymmetricTensor3) -> [f64; 6] {
        [t.xx, t.xy, t.xz, t.yy, t.yz, t.zz]
    }

    #[inline(always)]
    fn tensor([xx, xy, xz, yx, yy, yz, zx, zy, zz]: [f64; 9]) -> Matrix3<f64> {
        Matrix3::new(xx, xy, xz, yx, yy, yz, zx, zy, zz)
    }

    #[inline(always)]
    fn tensor_components(tensor: &Matrix3<f64>) -> [f64; 9] {
        let [[xx, yx, zx], [xy, yy, zy], [xz, yz, zz]] = tensor.data.0;
        [xx, xy, xz, yx, yy, yz, zx, zy, zz]
    }

    #[inline(always)]
    fn splat_vector<L: Lanes>(vector: &Vector3<f64>) -> [L; 3] {
        [L::splat(vector.x), L::splat(vector.y), L::splat(vector.z)]
    }

    #[inline(always)]
    fn lanes<L: Lanes>([a, b, c, d]: [&Vector3<f64>; WIDTH]) -> [L; 3] {
        each_lane!(L, [a, b, c, d], [x y z])
    }

    #[inline(always)]
    fn tensor_lanes<L: Lanes>([a, b, c, d]: [&[f64; 9]; WIDTH]) -> [L; 9] {
        let [xx, xy, xz, yx] = L::columns([part(a, 0), part(b, 0), part(c, 0), part(d, 0)]);
        let [yy, yz, zx, zy] = L::columns([part(a, 4), part(b, 4), part(c, 4), part(d, 4)]);
        [xx, xy, xz, yx, yy, yz, zx, zy, L::from_array([a[8], b[8], c[8], d[8]])]
    }

    #[inline(always)]
    fn symmetric_component_lanes<L: Lanes>([a, b, c, d]: [&[f64; 6]; WIDTH]) -> [L; 6] {
        let [xx, xy, xz, yy] = L::columns([part(a, 0), part(b, 0), part(c, 0), part(d, 0)]);
        let [yz, zz] = L::halves([part(a, 4), part(b, 4), part(c, 4), part(d, 4)]);
        [xx, xy, xz, yy, yz, zz]
    }

    #[inline(always)]
    fn symmetric_lanes<L: Lanes>([a, b, c, d]: [&SymmetricTensor3; WIDTH]) -> [L; 6] {
        each_lane!(L, [a, b, c, d], [xx xy xz yy yz zz])
    }

    #[inline(always)]
    fn vector_pairs<L: Lanes>(a: [L; 3], b: [L; 3]) -> [[Vector3<f64>; 2]; WIDTH] {
        let ([x, y, z], [u, v, w]) = (a.map(L::to_array), b.map(L::to_array));
        let mut pairs = [[Vector3::zeros(); 2]; WIDTH];
        for (l, pair) in pairs.iter_mut().enumerate() {
            *pair = [Vector3::new(x[l], y[l], z[l]), Vector3::new(u[l], v[l], w[l])];
        }
        pairs
    }

    #[inline(always)]
    fn spin_sum<L: Lanes>([x, y, z]: [L; 3]) -> Vector3<f64> {
        let [x, y, z, _] = L::sums([x, y, z, L::zero()]);
        Vector3::new(x, y, z)
    }

    #[inline(always)]
    fn sums_with<L: Lanes>([x, y, z]: [L; 3], [a, b]: [L; 2]) -> ([f64; 3], [f64; 2]) {
        let [a, b, x, y] = L::sums([a, b, x, y]);
        let [z, ..] = L::sums([z, L::zero(), L::zero(), L::zero()]);
        ([x, y, z], [a, b])
    }

    #[inline(always)]
    fn vector_sums<L: Lanes>([a, b, c]: [L; 3], [d, e, f]: [L; 3]) -> [[f64; 3]; 2] {
        let [a, b, c, d] = L::sums([a, b, c, d]);
        let [e, f, ..] = L::sums([e, f, L::zero(), L::zero()]);
        [[a, b, c], [d, e, f]]
    }

    #[inline(always)]
    fn matrix_sums<L: Lanes>(m: [L; 9]) -> [f64; 9] {
        let [a, b, c, d] = L::sums([m[0], m[1], m[2], m[3]]);
        let [e, f, g, h] = L::sums([m[4], m[5], m[6], m[7]]);
        let [i, ..] = L::sums([m[8], L::zero(), L::zero(), L::zero()]);
        [a, b, c, d, e, f, g, h, i]
    }

    #[inline(always)]
    fn symmetric_sums<L: Lanes>(m: [L; 6]) -> [f64; 6] {
        let [a, b, c, d] = L::sums([m[0], m[1], m[2], m[3]]);
        let [e, f, ..] = L::sums([m[4], m[5], L::zero(), L::zero()]);
        [a, b, c, d, e, f]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::components::Components;
    use crate::space::tensors::{SpaceSymmetric, SpaceTensor};

    /// A rotation about an axis that is none of the frame's.
    const SPIN: Vector3<f64> = Vector3::new(0.3, -1.1, 0.7);

    #[test]
    fn a_rotation_turns_as_its_spin_says() {
        let arm = Vector3::new(0.4, 0.2, -0.9);
        let start = UnitQuaternion::from_scaled_axis(Vector3::new(-0.2, 0.5, 0.1));
        let turned = |duration| Spatial::rotation_matrix(Spatial::rotated(start, SPIN, duration)) * arm;
        // Central differences of the path: velocity ω × r and acceleration ω × (ω × r), their errors below dt².
        let dt = 1e-4;
        let (before, now, after) = (turned(-dt), turned(0.0), turned(dt));
        assert!(((after - before) / (2.0 * dt) - Spatial::spin_cross(SPIN, &now)).norm() < 1e-7);
        let acceleration = (after - now * 2.0 + before) / (dt * dt);
        assert!((acceleration - Spatial::centripetal(SPIN, &now)).norm() < 1e-6);
    }

    #[test]
    fn a_rotation_stays_one_over_many_steps() {
        let steps = 10_000;
        let turn = std::f64::consts::TAU / SPIN.norm();
        let mut rotation = UnitQuaternion::identity();
        for _ in 0..steps {
            rotation = Spatial::rotated(rotation, SPIN, turn / f64::from(steps));
        }
        // One turn about the axis is none; round-off of 10,000 products.
        assert!((Spatial::rotation_matrix(rotation) - Matrix3::identity()).norm() < 1e-11);
        assert_eq!(UnitQuaternion::from_row(rotation.row()), rotation);
    }

    #[test]
    fn the_cofactor_is_the_transposed_inverse_times_the_determinant() {
        let m = Matrix3::new(1.5, -0.2, 0.9, 2.0, 0.3, -0.7, 0.1, 1.2, -0.5);
        let expected = m.try_inverse().map(|inverse| inverse.transpose() * m.determinant());
        // Round-off of numbers up to 3.
        assert!((SpaceTensor::cofactor(&m) - expected.unwrap_or_default()).norm() < 1e-14);
    }

    #[test]
    fn the_columns_of_a_symmetric_tensor_are_in_the_order_of_vtk() {
        let tensor = SymmetricTensor3 { xx: 1.0, yy: 2.0, zz: 3.0, xy: 4.0, yz: 5.0, xz: 6.0 };
        assert_eq!(tensor.row(), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        assert_eq!(SymmetricTensor3::from_row(tensor.row()), tensor);
        assert_eq!(Spatial::symmetric_tensor(Spatial::symmetric_components(&tensor)), tensor);
        assert_eq!(SymmetricTensor3::of(&tensor.full()), tensor);
    }
}
