//! Matrices of the plane.

use sph::space::SymmetricTensor;
use sph::space::plane::principal::Principal;

/// Symmetric 2 × 2 matrix: components 11, 12, 22.
pub type Symmetric = [f64; 3];

/// 2 × 2 matrix by rows.
pub type Matrix = [f64; 4];

/// Unit matrix.
pub const IDENTITY: Symmetric = [1.0, 0.0, 1.0];

/// Product of `m` and `l`.
pub fn times(m: &Matrix, l: &Symmetric) -> Matrix {
    [
        m[0] * l[0] + m[1] * l[1],
        m[0] * l[1] + m[1] * l[2],
        m[2] * l[0] + m[3] * l[1],
        m[2] * l[1] + m[3] * l[2],
    ]
}

/// Principal values and directions of `m`.
#[inline(always)]
pub fn principal(m: &Symmetric) -> Principal {
    let [xx, xy, yy] = *m;
    SymmetricTensor { xx, yy, xy }.principal()
}
