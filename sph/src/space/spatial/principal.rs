//! Principal values and directions of symmetric tensors.

use nalgebra::{Matrix3, Vector3};

use super::tensors::SymmetricTensor3;
use crate::space::tensors::SpaceSymmetric;

/// Sweeps of Jacobi's rotations: they converge quadratically, in at most six from any tensor.
const SWEEPS: usize = 10;

/// A symmetric tensor by its principal values and directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Principal3 {
    /// Principal values, the largest first.
    pub values: [f64; 3],
    /// Unit vectors along the principal directions, right-handed.
    pub directions: [Vector3<f64>; 3],
}

impl SymmetricTensor3 {
    /// Principal values, the largest first.
    ///
    /// From the cubic equation by cosines (Smith 1961): to round-off of the largest, unless two of them are equal, then to
    /// its square root.
    ///
    /// ```text
    /// λ = m + 2√p cos(φ + 2πk/3),  m = tr σ/3,  p = (σ − m I):(σ − m I)/6,  cos 3φ = det(σ − m I)/(2 p^{3/2})
    /// ```
    #[inline]
    pub fn principal_values(&self) -> [f64; 3] {
        let mean = (self.xx + self.yy + self.zz) / 3.0;
        let (xx, yy, zz) = (self.xx - mean, self.yy - mean, self.zz - mean);
        let (xy, yz, xz) = (self.xy, self.yz, self.xz);
        let p = (xx * xx + yy * yy + zz * zz + 2.0 * (xy * xy + yz * yz + xz * xz)) / 6.0;
        if p <= 0.0 {
            return [mean; 3];
        }
        let root = p.sqrt();
        let determinant = xx * (yy * zz - yz * yz) - xy * (xy * zz - xz * yz) + xz * (xy * yz - xz * yy);
        let cosine = (0.5 * determinant / (p * root)).clamp(-1.0, 1.0);
        let angle = cosine.acos() / 3.0;
        let major = mean + 2.0 * root * angle.cos();
        let minor = mean + 2.0 * root * (angle + std::f64::consts::TAU / 3.0).cos();
        [major, (3.0 * mean - major - minor).clamp(minor, major), minor]
    }

    /// Principal values and directions, by Jacobi's rotations: to round-off of the largest value.
    pub fn principal(&self) -> Principal3 {
        let (mut m, mut axes) = (self.full(), Matrix3::<f64>::identity());
        for _ in 0..SWEEPS {
            let off = m[(0, 1)].abs() + m[(0, 2)].abs() + m[(1, 2)].abs();
            if off <= f64::EPSILON * m.norm() {
                break;
            }
            for (p, q) in [(0, 1), (0, 2), (1, 2)] {
                rotate(&mut m, &mut axes, p, q);
            }
        }
        let mut order = [0, 1, 2];
        order.sort_by(|a, b| m[(*b, *b)].total_cmp(&m[(*a, *a)]));
        let values = order.map(|k| m[(k, k)]);
        let [major, middle, _] = order.map(|k| axes.column(k).into_owned());
        Principal3 { values, directions: [major, middle, major.cross(&middle)] }
    }
}

/// Makes component (p, q) of `m` zero by a rotation of these two axes.
fn rotate(m: &mut Matrix3<f64>, axes: &mut Matrix3<f64>, p: usize, q: usize) {
    let off = m[(p, q)];
    if off == 0.0 {
        return;
    }
    let ratio = 0.5 * (m[(q, q)] - m[(p, p)]) / off;
    // The smaller of the two roots; beyond 1e150 its square overflows to an infinite sum and the tangent to zero.
    let tangent = ratio.signum() / (ratio.abs() + ratio.hypot(1.0));
    let cosine = 1.0 / tangent.hypot(1.0);
    let sine = tangent * cosine;
    let mut turn = Matrix3::identity();
    (turn[(p, p)], turn[(q, q)], turn[(p, q)], turn[(q, p)]) = (cosine, cosine, sine, -sine);
    *m = turn.transpose() * *m * turn;
    (m[(p, q)], m[(q, p)]) = (0.0, 0.0);
    *axes *= turn;
}

impl Principal3 {
    /// The tensor of the same directions with other principal values.
    pub fn with_values(&self, values: [f64; 3]) -> SymmetricTensor3 {
        let mut full = Matrix3::zeros();
        for (value, direction) in values.iter().zip(&self.directions) {
            full += direction * direction.transpose() * *value;
        }
        SymmetricTensor3::of(&full)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tensors with three, two and one principal value, and hardly different ones.
    fn tensors() -> impl Iterator<Item = SymmetricTensor3> {
        let (a, b) = (Vector3::new(1.0, 2.0, -2.0) / 3.0, Vector3::new(2.0, 1.0, 2.0) / 3.0);
        let directions = [a, b, a.cross(&b)];
        [
            [3.0, 1.0, -2.0],
            [2.0, 2.0, -1.0],
            [5.0, 0.0, 0.0],
            [1.0, 1.0, 1.0],
            [1.0, 1.0 - 1e-9, 1e-12],
            [0.0; 3],
        ]
        .into_iter()
        .map(move |values| Principal3 { values, directions }.with_values(values))
    }

    #[test]
    fn the_tensor_follows_from_its_values_and_directions() {
        for tensor in tensors() {
            let principal = tensor.principal();
            let again = principal.with_values(principal.values);
            // Round-off of numbers up to 5.
            assert!((again.full() - tensor.full()).norm() < 1e-14, "{tensor:?} {principal:?}");
            let axes = Matrix3::from_columns(&principal.directions);
            assert!((axes.transpose() * axes - Matrix3::identity()).norm() < 1e-14, "{principal:?}");
            assert!((axes.determinant() - 1.0).abs() < 1e-14, "{principal:?}");
        }
    }

    #[test]
    fn values_alone_are_those_with_directions() {
        for tensor in tensors() {
            let (quick, values) = (tensor.principal_values(), tensor.principal().values);
            assert!(quick.is_sorted_by(|a, b| a >= b), "{quick:?}");
            for (quick, value) in quick.iter().zip(values) {
                // The square root of round-off where two are equal.
                assert!((quick - value).abs() < 5e-8, "{tensor:?}: {quick} {value}");
            }
        }
    }
}
