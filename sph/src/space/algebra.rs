//! Algebra of vectors and tensors by components, over one number or one for each lane.
//!
//! Laws of pairs are written with these functions. All of them are `#[inline(always)]` and none takes a closure, so that
//! they are compiled for the instructions of a pass.

use std::fmt::Debug;
use std::ops::{Index, IndexMut};

use crate::lanes::Real;

/// What components may be.
pub trait Element: Copy + Debug + Send + Sync + 'static {}

impl<T: Copy + Debug + Send + Sync + 'static> Element for T {}

/// Vectors and tensors as arrays of their components.
///
/// Sums start with the first component and take each further product by [`Real::plus_product`], unless stated
/// otherwise.
pub trait Algebra: Sized {
    /// One value for each axis.
    type Of<T: Element>: Element + Index<usize, Output = T> + IndexMut<usize>;
    /// A symmetric tensor: components 11, 12, 22.
    type Symmetric<T: Element>: Element;
    /// A tensor by rows: components 11, 12, 21, 22.
    type Matrix<T: Element>: Element;

    /// An angular velocity, a torque or an angular momentum: one number in the plane.
    type SpinOf<T: Element>: Element;

    /// `value` of each axis. Not for lanes, as a closure is not compiled for the instructions of a pass.
    fn axes<T: Element>(value: impl FnMut(usize) -> T) -> Self::Of<T>;

    /// `value` for each axis.
    fn splat<T: Element>(value: T) -> Self::Of<T>;

    /// `a` in each lane.
    fn splat_each<R: Real>(a: &Self::Of<f64>) -> Self::Of<R>;

    /// a + b.
    fn plus<R: Real>(a: Self::Of<R>, b: Self::Of<R>) -> Self::Of<R>;

    /// a − b.
    fn minus<R: Real>(a: Self::Of<R>, b: Self::Of<R>) -> Self::Of<R>;

    /// s a.
    fn scaled<R: Real>(a: Self::Of<R>, s: R) -> Self::Of<R>;

    /// a + s b, by [`Real::plus_product`].
    fn plus_product<R: Real>(a: Self::Of<R>, s: R, b: Self::Of<R>) -> Self::Of<R>;

    /// a − s b, by [`Real::minus_product`].
    fn minus_product<R: Real>(a: Self::Of<R>, s: R, b: Self::Of<R>) -> Self::Of<R>;

    /// a·b.
    fn dot<R: Real>(a: Self::Of<R>, b: Self::Of<R>) -> R;

    /// a·b, with each product rounded: the same bits on all arithmetic paths.
    fn rounded_dot<R: Real>(a: Self::Of<R>, b: Self::Of<R>) -> R;

    /// a × b, each product rounded.
    fn rounded_cross<R: Real>(a: Self::Of<R>, b: Self::Of<R>) -> Self::SpinOf<R>;

    /// The zero spin.
    fn zero_spin<R: Real>() -> Self::SpinOf<R>;

    /// a + b.
    fn spin_plus<R: Real>(a: Self::SpinOf<R>, b: Self::SpinOf<R>) -> Self::SpinOf<R>;

    /// a − b.
    fn spin_minus<R: Real>(a: Self::SpinOf<R>, b: Self::SpinOf<R>) -> Self::SpinOf<R>;

    /// s a.
    fn spin_scaled<R: Real>(a: Self::SpinOf<R>, s: R) -> Self::SpinOf<R>;

    /// s − a·b, by [`Real::minus_product`].
    fn minus_dot<R: Real>(s: R, a: Self::Of<R>, b: Self::Of<R>) -> R;

    /// The zero tensor.
    fn zero_matrix<R: Real>() -> Self::Matrix<R>;

    /// `m` in each lane.
    fn splat_matrix<R: Real>(m: &Self::Matrix<f64>) -> Self::Matrix<R>;

    /// m + n.
    fn matrix_plus<R: Real>(m: Self::Matrix<R>, n: Self::Matrix<R>) -> Self::Matrix<R>;

    /// s m.
    fn matrix_scaled<R: Real>(m: Self::Matrix<R>, s: R) -> Self::Matrix<R>;

    /// m + s I.
    fn matrix_plus_isotropic<R: Real>(m: Self::Matrix<R>, s: R) -> Self::Matrix<R>;

    /// m + a ⊗ b, by [`Real::plus_product`].
    fn plus_outer<R: Real>(m: Self::Matrix<R>, a: Self::Of<R>, b: Self::Of<R>) -> Self::Matrix<R>;

    /// m − a ⊗ b, by [`Real::minus_product`].
    fn minus_outer<R: Real>(m: Self::Matrix<R>, a: Self::Of<R>, b: Self::Of<R>) -> Self::Matrix<R>;

    /// m·a.
    fn matrix_times<R: Real>(m: Self::Matrix<R>, a: Self::Of<R>) -> Self::Of<R>;

    /// mᵀ.
    fn transposed<R: Real>(m: Self::Matrix<R>) -> Self::Matrix<R>;

    /// mᵀ − tr(m) I.
    fn transposed_less_trace<R: Real>(m: Self::Matrix<R>) -> Self::Matrix<R>;

    /// Sum of the diagonal of m.
    fn trace<R: Real>(m: Self::Matrix<R>) -> R;

    /// The zero tensor.
    fn zero_symmetric<R: Real>() -> Self::Symmetric<R>;

    /// The unit tensor.
    fn identity<R: Real>() -> Self::Symmetric<R>;

    /// `m` in each lane.
    fn splat_symmetric<R: Real>(m: &Self::Symmetric<f64>) -> Self::Symmetric<R>;

    /// m + n.
    fn symmetric_plus<R: Real>(m: Self::Symmetric<R>, n: Self::Symmetric<R>) -> Self::Symmetric<R>;

    /// s m.
    fn symmetric_scaled<R: Real>(m: Self::Symmetric<R>, s: R) -> Self::Symmetric<R>;

    /// m + s I.
    fn symmetric_plus_isotropic<R: Real>(m: Self::Symmetric<R>, s: R) -> Self::Symmetric<R>;

    /// m + s n, by [`Real::plus_product`].
    fn symmetric_plus_product<R: Real>(
        m: Self::Symmetric<R>,
        n: Self::Symmetric<R>,
        s: R,
    ) -> Self::Symmetric<R>;

    /// m − a ⊗ b for a ∥ b, by [`Real::minus_product`].
    fn symmetric_minus_outer<R: Real>(
        m: Self::Symmetric<R>,
        a: Self::Of<R>,
        b: Self::Of<R>,
    ) -> Self::Symmetric<R>;

    /// m·a.
    fn symmetric_times<R: Real>(m: Self::Symmetric<R>, a: Self::Of<R>) -> Self::Of<R>;

    /// m·l.
    fn matrix_times_symmetric<R: Real>(m: Self::Matrix<R>, l: Self::Symmetric<R>) -> Self::Matrix<R>;

    /// m : l.
    fn contracted<R: Real>(m: Self::Matrix<R>, l: Self::Symmetric<R>) -> R;

    /// Sum of the diagonal of m.
    fn symmetric_trace<R: Real>(m: Self::Symmetric<R>) -> R;

    /// All components of a symmetric tensor.
    fn matrix_of_symmetric<R: Real>(m: Self::Symmetric<R>) -> Self::Matrix<R>;

    /// det m.
    fn symmetric_determinant<R: Real>(m: Self::Symmetric<R>) -> R;

    /// m⁻¹ of a tensor of the given `determinant`.
    fn symmetric_inverse<R: Real>(m: Self::Symmetric<R>, determinant: R) -> Self::Symmetric<R>;
}
