//! Components in space: their order is that of [`Algebra`]'s types.

use super::Spatial;
use crate::lanes::Real;
use crate::space::algebra::{Algebra, Element};

/// Row `i` of a symmetric tensor.
#[inline(always)]
fn row<R: Real>(m: [R; 6], i: usize) -> [R; 3] {
    match i {
        0 => [m[0], m[1], m[2]],
        1 => [m[1], m[3], m[4]],
        _ => [m[2], m[4], m[5]],
    }
}

impl Algebra for Spatial {
    type Of<T: Element> = [T; 3];
    type Symmetric<T: Element> = [T; 6];
    type Matrix<T: Element> = [T; 9];
    type SpinOf<T: Element> = [T; 3];

    #[inline(always)]
    fn axes<T: Element>(value: impl FnMut(usize) -> T) -> [T; 3] {
        std::array::from_fn(value)
    }

    #[inline(always)]
    fn splat<T: Element>(value: T) -> [T; 3] {
        [value; 3]
    }

    #[inline(always)]
    fn splat_each<R: Real>(a: &[f64; 3]) -> [R; 3] {
        [R::splat(a[0]), R::splat(a[1]), R::splat(a[2])]
    }

    #[inline(always)]
    fn plus<R: Real>(a: [R; 3], b: [R; 3]) -> [R; 3] {
        [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
    }

    #[inline(always)]
    fn minus<R: Real>(a: [R; 3], b: [R; 3]) -> [R; 3] {
        [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
    }

    #[inline(always)]
    fn scaled<R: Real>(a: [R; 3], s: R) -> [R; 3] {
        [a[0] * s, a[1] * s, a[2] * s]
    }

    #[inline(always)]
    fn plus_product<R: Real>(a: [R; 3], s: R, b: [R; 3]) -> [R; 3] {
        [a[0].plus_product(s, b[0]), a[1].plus_product(s, b[1]), a[2].plus_product(s, b[2])]
    }

    #[inline(always)]
    fn minus_product<R: Real>(a: [R; 3], s: R, b: [R; 3]) -> [R; 3] {
        [a[0].minus_product(s, b[0]), a[1].minus_product(s, b[1]), a[2].minus_product(s, b[2])]
    }

    #[inline(always)]
    fn dot<R: Real>(a: [R; 3], b: [R; 3]) -> R {
        (a[0] * b[0]).plus_product(a[1], b[1]).plus_product(a[2], b[2])
    }

    #[inline(always)]
    fn rounded_dot<R: Real>(a: [R; 3], b: [R; 3]) -> R {
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    }

    #[inline(always)]
    fn rounded_cross<R: Real>(a: [R; 3], b: [R; 3]) -> [R; 3] {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    }

    #[inline(always)]
    fn zero_spin<R: Real>() -> [R; 3] {
        [R::zero(); 3]
    }

    #[inline(always)]
    fn spin_plus<R: Real>(a: [R; 3], b: [R; 3]) -> [R; 3] {
        Self::plus(a, b)
    }

    #[inline(always)]
    fn spin_minus<R: Real>(a: [R; 3], b: [R; 3]) -> [R; 3] {
        Self::minus(a, b)
    }

    #[inline(always)]
    fn spin_scaled<R: Real>(a: [R; 3], s: R) -> [R; 3] {
        Self::scaled(a, s)
    }

    #[inline(always)]
    fn minus_dot<R: Real>(s: R, a: [R; 3], b: [R; 3]) -> R {
        s.minus_product(a[0], b[0]).minus_product(a[1], b[1]).minus_product(a[2], b[2])
    }

    #[inline(always)]
    fn zero_matrix<R: Real>() -> [R; 9] {
        [R::zero(); 9]
    }

    #[inline(always)]
    fn splat_matrix<R: Real>(m: &[f64; 9]) -> [R; 9] {
        let mut lanes = [R::zero(); 9];
        for (lane, component) in lanes.iter_mut().zip(m) {
            *lane = R::splat(*component);
        }
        lanes
    }

    #[inline(always)]
    fn matrix_plus<R: Real>(mut m: [R; 9], n: [R; 9]) -> [R; 9] {
        for k in 0..9 {
            m[k] = m[k] + n[k];
        }
        m
    }

    #[inline(always)]
    fn matrix_scaled<R: Real>(mut m: [R; 9], s: R) -> [R; 9] {
        for component in &mut m {
            *component = *component * s;
        }
        m
    }

    #[inline(always)]
    fn matrix_plus_isotropic<R: Real>(mut m: [R; 9], s: R) -> [R; 9] {
        for k in [0, 4, 8] {
            m[k] = m[k] + s;
        }
        m
    }

    #[inline(always)]
    fn plus_outer<R: Real>(mut m: [R; 9], a: [R; 3], b: [R; 3]) -> [R; 9] {
        for k in 0..9 {
            m[k] = m[k].plus_product(a[k / 3], b[k % 3]);
        }
        m
    }

    #[inline(always)]
    fn minus_outer<R: Real>(mut m: [R; 9], a: [R; 3], b: [R; 3]) -> [R; 9] {
        for k in 0..9 {
            m[k] = m[k].minus_product(a[k / 3], b[k % 3]);
        }
        m
    }

    #[inline(always)]
    fn matrix_times<R: Real>(m: [R; 9], a: [R; 3]) -> [R; 3] {
        [Self::dot([m[0], m[1], m[2]], a), Self::dot([m[3], m[4], m[5]], a), Self::dot([m[6], m[7], m[8]], a)]
    }

    #[inline(always)]
    fn transposed<R: Real>(m: [R; 9]) -> [R; 9] {
        [m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]]
    }

    #[inline(always)]
    fn transposed_less_trace<R: Real>(m: [R; 9]) -> [R; 9] {
        let zero = R::zero();
        let diagonal = [zero - (m[4] + m[8]), zero - (m[0] + m[8]), zero - (m[0] + m[4])];
        [diagonal[0], m[3], m[6], m[1], diagonal[1], m[7], m[2], m[5], diagonal[2]]
    }

    #[inline(always)]
    fn trace<R: Real>(m: [R; 9]) -> R {
        m[0] + m[4] + m[8]
    }

    #[inline(always)]
    fn zero_symmetric<R: Real>() -> [R; 6] {
        [R::zero(); 6]
    }

    #[inline(always)]
    fn identity<R: Real>() -> [R; 6] {
        let (one, zero) = (R::splat(1.0), R::zero());
        [one, zero, zero, one, zero, one]
    }

    #[inline(always)]
    fn splat_symmetric<R: Real>(m: &[f64; 6]) -> [R; 6] {
        let mut lanes = [R::zero(); 6];
        for (lane, component) in lanes.iter_mut().zip(m) {
            *lane = R::splat(*component);
        }
        lanes
    }

    #[inline(always)]
    fn symmetric_plus<R: Real>(mut m: [R; 6], n: [R; 6]) -> [R; 6] {
        for k in 0..6 {
            m[k] = m[k] + n[k];
        }
        m
    }

    #[inline(always)]
    fn symmetric_scaled<R: Real>(mut m: [R; 6], s: R) -> [R; 6] {
        for component in &mut m {
            *component = *component * s;
        }
        m
    }

    #[inline(always)]
    fn symmetric_plus_isotropic<R: Real>(mut m: [R; 6], s: R) -> [R; 6] {
        for k in [0, 3, 5] {
            m[k] = m[k] + s;
        }
        m
    }

    #[inline(always)]
    fn symmetric_plus_product<R: Real>(mut m: [R; 6], n: [R; 6], s: R) -> [R; 6] {
        for k in 0..6 {
            m[k] = m[k].plus_product(n[k], s);
        }
        m
    }

    #[inline(always)]
    fn symmetric_minus_outer<R: Real>(m: [R; 6], a: [R; 3], b: [R; 3]) -> [R; 6] {
        [
            m[0].minus_product(a[0], b[0]),
            m[1].minus_product(a[0], b[1]),
            m[2].minus_product(a[0], b[2]),
            m[3].minus_product(a[1], b[1]),
            m[4].minus_product(a[1], b[2]),
            m[5].minus_product(a[2], b[2]),
        ]
    }

    #[inline(always)]
    fn symmetric_times<R: Real>(m: [R; 6], a: [R; 3]) -> [R; 3] {
        [Self::dot(row(m, 0), a), Self::dot(row(m, 1), a), Self::dot(row(m, 2), a)]
    }

    #[inline(always)]
    fn matrix_times_symmetric<R: Real>(m: [R; 9], l: [R; 6]) -> [R; 9] {
        let [a, b, c] = Self::symmetric_times(l, [m[0], m[1], m[2]]);
        let [d, e, f] = Self::symmetric_times(l, [m[3], m[4], m[5]]);
        let [g, h, i] = Self::symmetric_times(l, [m[6], m[7], m[8]]);
        [a, b, c, d, e, f, g, h, i]
    }

    #[inline(always)]
    fn contracted<R: Real>(m: [R; 9], l: [R; 6]) -> R {
        (m[0] * l[0])
            .plus_product(m[4], l[3])
            .plus_product(m[8], l[5])
            .plus_product(m[1] + m[3], l[1])
            .plus_product(m[2] + m[6], l[2])
            .plus_product(m[5] + m[7], l[4])
    }

    #[inline(always)]
    fn symmetric_trace<R: Real>(m: [R; 6]) -> R {
        m[0] + m[3] + m[5]
    }

    #[inline(always)]
    fn matrix_of_symmetric<R: Real>([xx, xy, xz, yy, yz, zz]: [R; 6]) -> [R; 9] {
        [xx, xy, xz, xy, yy, yz, xz, yz, zz]
    }

    #[inline(always)]
    fn symmetric_determinant<R: Real>(m: [R; 6]) -> R {
        let [xx, xy, xz, yy, yz, zz] = m;
        xx * (yy * zz - yz * yz) - xy * (xy * zz - xz * yz) + xz * (xy * yz - xz * yy)
    }

    #[inline(always)]
    fn symmetric_inverse<R: Real>(m: [R; 6], determinant: R) -> [R; 6] {
        let [xx, xy, xz, yy, yz, zz] = m;
        let inverse = R::splat(1.0) / determinant;
        [
            (yy * zz - yz * yz) * inverse,
            (xz * yz - xy * zz) * inverse,
            (xy * yz - xz * yy) * inverse,
            (xx * zz - xz * xz) * inverse,
            (xy * xz - xx * yz) * inverse,
            (xx * yy - xy * xy) * inverse,
        ]
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Vector3};

    use super::*;
    use crate::space::Space;
    use crate::space::tensors::SpaceSymmetric;

    #[test]
    fn components_give_what_vectors_and_tensors_give() {
        let (a, b) = ([0.7, -1.3, 0.6], [2.1, 0.4, -0.8]);
        let (u, v) = (Vector3::from(a), Vector3::from(b));
        let (m, n) = (
            [1.5, -0.2, 0.9, 2.0, 0.3, -0.7, 0.1, 1.2, -0.5],
            [0.2, 1.0, 0.4, -1.0, 0.6, 0.3, 0.8, -0.1, 0.9],
        );
        let l = [1.1, 0.3, -0.2, 0.8, 0.15, 1.4];
        let (full, other) = (Spatial::tensor(m), Spatial::tensor(n));
        let symmetric = Matrix3::new(l[0], l[1], l[2], l[1], l[3], l[4], l[2], l[4], l[5]);
        assert_eq!(Spatial::symmetric_tensor(l).full(), symmetric);
        // Round-off of numbers up to 4.
        let close = |a: Matrix3<f64>, b: Matrix3<f64>| assert!((a - b).norm() < 2e-15, "{a} {b}");
        let near = |a: [f64; 3], b: Vector3<f64>| assert!((Vector3::from(a) - b).norm() < 2e-15, "{a:?} {b}");
        let equal = |a: f64, b: f64| assert!((a - b).abs() < 2e-15, "{a} {b}");
        equal(Spatial::dot(a, b), u.dot(&v));
        equal(Spatial::rounded_dot(a, b), u.dot(&v));
        equal(Spatial::minus_dot(0.3, a, b), 0.3 - u.dot(&v));
        near(Spatial::rounded_cross(a, b), u.cross(&v));
        near(Spatial::plus_product(a, 3.0, b), u + v * 3.0);
        near(Spatial::minus_product(a, 3.0, b), u - v * 3.0);
        near(Spatial::matrix_times(m, a), full * u);
        near(Spatial::symmetric_times(l, a), symmetric * u);
        close(Spatial::tensor(Spatial::plus_outer(m, a, b)), full + u * v.transpose());
        close(Spatial::tensor(Spatial::minus_outer(m, a, b)), full - u * v.transpose());
        close(Spatial::tensor(Spatial::matrix_plus(m, n)), full + other);
        close(Spatial::tensor(Spatial::matrix_plus_isotropic(m, 0.4)), full + Matrix3::identity() * 0.4);
        close(Spatial::tensor(Spatial::transposed(m)), full.transpose());
        let less_trace = full.transpose() - Matrix3::identity() * full.trace();
        close(Spatial::tensor(Spatial::transposed_less_trace(m)), less_trace);
        close(Spatial::tensor(Spatial::matrix_times_symmetric(m, l)), full * symmetric);
        equal(Spatial::trace(m), full.trace());
        equal(Spatial::contracted(m, l), (full * symmetric).trace());
        equal(Spatial::symmetric_trace(l), symmetric.trace());
        let determinant = Spatial::symmetric_determinant(l);
        equal(determinant, symmetric.determinant());
        let inverse = Spatial::symmetric_inverse(l, determinant);
        close(Spatial::symmetric_tensor(inverse).full() * symmetric, Matrix3::identity());
        let spread = Spatial::symmetric_minus_outer(l, a, Spatial::scaled(a, 2.0));
        close(Spatial::symmetric_tensor(spread).full(), symmetric - u * u.transpose() * 2.0);
    }
}
