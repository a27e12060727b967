//! Components in the plane: their order is that of [`Algebra`]'s types.

use super::Plane;
use crate::lanes::Real;
use crate::space::algebra::{Algebra, Element};

impl Algebra for Plane {
    type Of<T: Element> = [T; 2];
    type Symmetric<T: Element> = [T; 3];
    type Matrix<T: Element> = [T; 4];
    type SpinOf<T: Element> = T;

    #[inline(always)]
    fn axes<T: Element>(value: impl FnMut(usize) -> T) -> [T; 2] {
        std::array::from_fn(value)
    }

    #[inline(always)]
    fn splat<T: Element>(value: T) -> [T; 2] {
        [value; 2]
    }

    #[inline(always)]
    fn splat_each<R: Real>(a: &[f64; 2]) -> [R; 2] {
        [R::splat(a[0]), R::splat(a[1])]
    }

    #[inline(always)]
    fn plus<R: Real>(a: [R; 2], b: [R; 2]) -> [R; 2] {
        [a[0] + b[0], a[1] + b[1]]
    }

    #[inline(always)]
    fn minus<R: Real>(a: [R; 2], b: [R; 2]) -> [R; 2] {
        [a[0] - b[0], a[1] - b[1]]
    }

    #[inline(always)]
    fn scaled<R: Real>(a: [R; 2], s: R) -> [R; 2] {
        [a[0] * s, a[1] * s]
    }

    #[inline(always)]
    fn plus_product<R: Real>(a: [R; 2], s: R, b: [R; 2]) -> [R; 2] {
        [a[0].plus_product(s, b[0]), a[1].plus_product(s, b[1])]
    }

    #[inline(always)]
    fn minus_product<R: Real>(a: [R; 2], s: R, b: [R; 2]) -> [R; 2] {
        [a[0].minus_product(s, b[0]), a[1].minus_product(s, b[1])]
    }

    #[inline(always)]
    fn dot<R: Real>(a: [R; 2], b: [R; 2]) -> R {
        (a[0] * b[0]).plus_product(a[1], b[1])
    }

    #[inline(always)]
    fn rounded_dot<R: Real>(a: [R; 2], b: [R; 2]) -> R {
        a[0] * b[0] + a[1] * b[1]
    }

    #[inline(always)]
    fn rounded_cross<R: Real>(a: [R; 2], b: [R; 2]) -> R {
        a[0] * b[1] - a[1] * b[0]
    }

    #[inline(always)]
    fn zero_spin<R: Real>() -> R {
        R::zero()
    }

    #[inline(always)]
    fn spin_plus<R: Real>(a: R, b: R) -> R {
        a + b
    }

    #[inline(always)]
    fn spin_minus<R: Real>(a: R, b: R) -> R {
        a - b
    }

    #[inline(always)]
    fn spin_scaled<R: Real>(a: R, s: R) -> R {
        a * s
    }

    #[inline(always)]
    fn minus_dot<R: Real>(s: R, a: [R; 2], b: [R; 2]) -> R {
        s.minus_product(a[0], b[0]).minus_product(a[1], b[1])
    }

    #[inline(always)]
    fn zero_matrix<R: Real>() -> [R; 4] {
        [R::zero(); 4]
    }

    #[inline(always)]
    fn splat_matrix<R: Real>(m: &[f64; 4]) -> [R; 4] {
        R::splat_each(*m)
    }

    #[inline(always)]
    fn matrix_plus<R: Real>(m: [R; 4], n: [R; 4]) -> [R; 4] {
        [m[0] + n[0], m[1] + n[1], m[2] + n[2], m[3] + n[3]]
    }

    #[inline(always)]
    fn matrix_scaled<R: Real>(m: [R; 4], s: R) -> [R; 4] {
        [m[0] * s, m[1] * s, m[2] * s, m[3] * s]
    }

    #[inline(always)]
    fn matrix_plus_isotropic<R: Real>(m: [R; 4], s: R) -> [R; 4] {
        [m[0] + s, m[1], m[2], m[3] + s]
    }

    #[inline(always)]
    fn plus_outer<R: Real>(m: [R; 4], a: [R; 2], b: [R; 2]) -> [R; 4] {
        let [xx, xy, yx, yy] = m;
        let [x, y] = a;
        [
            xx.plus_product(x, b[0]),
            xy.plus_product(x, b[1]),
            yx.plus_product(y, b[0]),
            yy.plus_product(y, b[1]),
        ]
    }

    #[inline(always)]
    fn minus_outer<R: Real>(m: [R; 4], a: [R; 2], b: [R; 2]) -> [R; 4] {
        let [xx, xy, yx, yy] = m;
        let [x, y] = a;
        [
            xx.minus_product(x, b[0]),
            xy.minus_product(x, b[1]),
            yx.minus_product(y, b[0]),
            yy.minus_product(y, b[1]),
        ]
    }

    #[inline(always)]
    fn matrix_times<R: Real>(m: [R; 4], a: [R; 2]) -> [R; 2] {
        [Self::dot([m[0], m[1]], a), Self::dot([m[2], m[3]], a)]
    }

    #[inline(always)]
    fn transposed<R: Real>(m: [R; 4]) -> [R; 4] {
        [m[0], m[2], m[1], m[3]]
    }

    #[inline(always)]
    fn transposed_less_trace<R: Real>(m: [R; 4]) -> [R; 4] {
        [R::zero() - m[3], m[2], m[1], R::zero() - m[0]]
    }

    #[inline(always)]
    fn trace<R: Real>(m: [R; 4]) -> R {
        m[0] + m[3]
    }

    #[inline(always)]
    fn zero_symmetric<R: Real>() -> [R; 3] {
        [R::zero(); 3]
    }

    #[inline(always)]
    fn identity<R: Real>() -> [R; 3] {
        [R::splat(1.0), R::zero(), R::splat(1.0)]
    }

    #[inline(always)]
    fn splat_symmetric<R: Real>(m: &[f64; 3]) -> [R; 3] {
        [R::splat(m[0]), R::splat(m[1]), R::splat(m[2])]
    }

    #[inline(always)]
    fn symmetric_plus<R: Real>(m: [R; 3], n: [R; 3]) -> [R; 3] {
        [m[0] + n[0], m[1] + n[1], m[2] + n[2]]
    }

    #[inline(always)]
    fn symmetric_scaled<R: Real>(m: [R; 3], s: R) -> [R; 3] {
        [m[0] * s, m[1] * s, m[2] * s]
    }

    #[inline(always)]
    fn symmetric_plus_isotropic<R: Real>(m: [R; 3], s: R) -> [R; 3] {
        [m[0] + s, m[1], m[2] + s]
    }

    #[inline(always)]
    fn symmetric_plus_product<R: Real>(m: [R; 3], n: [R; 3], s: R) -> [R; 3] {
        [m[0].plus_product(n[0], s), m[1].plus_product(n[1], s), m[2].plus_product(n[2], s)]
    }

    #[inline(always)]
    fn symmetric_minus_outer<R: Real>(m: [R; 3], a: [R; 2], b: [R; 2]) -> [R; 3] {
        [m[0].minus_product(a[0], b[0]), m[1].minus_product(a[0], b[1]), m[2].minus_product(a[1], b[1])]
    }

    #[inline(always)]
    fn symmetric_times<R: Real>(m: [R; 3], a: [R; 2]) -> [R; 2] {
        [Self::dot([m[0], m[1]], a), Self::dot([m[1], m[2]], a)]
    }

    #[inline(always)]
    fn matrix_times_symmetric<R: Real>(m: [R; 4], l: [R; 3]) -> [R; 4] {
        let ([a, b], [c, d]) =
            (Self::symmetric_times(l, [m[0], m[1]]), Self::symmetric_times(l, [m[2], m[3]]));
        [a, b, c, d]
    }

    #[inline(always)]
    fn contracted<R: Real>(m: [R; 4], l: [R; 3]) -> R {
        (m[0] * l[0]).plus_product(m[1] + m[2], l[1]).plus_product(m[3], l[2])
    }

    #[inline(always)]
    fn symmetric_trace<R: Real>(m: [R; 3]) -> R {
        m[0] + m[2]
    }

    #[inline(always)]
    fn matrix_of_symmetric<R: Real>([xx, xy, yy]: [R; 3]) -> [R; 4] {
        [xx, xy, xy, yy]
    }

    #[inline(always)]
    fn symmetric_determinant<R: Real>(m: [R; 3]) -> R {
        m[0] * m[2] - m[1] * m[1]
    }

    #[inline(always)]
    fn symmetric_inverse<R: Real>(m: [R; 3], determinant: R) -> [R; 3] {
        let inverse = R::splat(1.0) / determinant;
        // The sign of zero is that of −m₁₂ over the determinant.
        [m[2] * inverse, m[1] * (R::zero() - inverse), m[0] * inverse]
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix2, Vector2};

    use super::*;
    use crate::space::Space;
    use crate::space::tensors::SpaceSymmetric;

    #[test]
    fn components_give_what_vectors_and_tensors_give() {
        let (a, b) = ([0.7, -1.3], [2.1, 0.4]);
        let (u, v) = (Vector2::from(a), Vector2::from(b));
        let (m, l) = ([1.5, -0.2, 0.9, 2.0], [1.1, 0.3, 0.8]);
        let full = Plane::tensor(m);
        let symmetric = Matrix2::new(l[0], l[1], l[1], l[2]);
        assert_eq!(Plane::dot(a, b), u.dot(&v));
        assert_eq!(Plane::vector(Plane::plus_product(a, 3.0, b)), u + v * 3.0);
        assert_eq!(Plane::vector(Plane::matrix_times(m, a)), full * u);
        assert_eq!(Plane::vector(Plane::symmetric_times(l, a)), symmetric * u);
        assert_eq!(Plane::tensor(Plane::plus_outer(m, a, b)), full + u * v.transpose());
        assert_eq!(Plane::tensor(Plane::minus_outer(m, a, b)), full - u * v.transpose());
        assert_eq!(Plane::tensor(Plane::transposed(m)), full.transpose());
        let less_trace = full.transpose() - Matrix2::identity() * full.trace();
        // Round-off of numbers up to 4.
        let close = |a: Matrix2<f64>, b: Matrix2<f64>| assert!((a - b).norm() < 1e-15, "{a} {b}");
        close(Plane::tensor(Plane::transposed_less_trace(m)), less_trace);
        close(Plane::tensor(Plane::matrix_times_symmetric(m, l)), full * symmetric);
        assert!((Plane::contracted(m, l) - (full * symmetric).trace()).abs() < 1e-15);
        let inverse = Plane::symmetric_inverse(l, Plane::symmetric_determinant(l));
        close(Plane::symmetric_tensor(inverse).full() * symmetric, Matrix2::identity());
    }
}
