//! The cubic spline, Eq. (11), and its slope: the one place that knows the formulas.
//!
//! Both are written over s = r/h ≥ 0 and carry a factor, such as the normalisation, in their coefficients.

use crate::lanes::Real;

/// A factor times the spline, which is 1 at its centre.
///
/// ```text
/// ¼(2 − s)₊³ − (1 − s)₊³                        Eq. (11) over 10/(7π); Monaghan & Lattanzio 1985
/// ```
/// ```
/// let spline = sph::kernel::shape::Spline::scaled(1.0);
/// // 1 at the centre, 1/4 at r = h, 0 from r = 2h on.
/// assert_eq!([0.0, 1.0, 2.0, 3.0].map(|s| spline.at(s)), [1.0, 0.25, 0.0, 0.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spline<R> {
    outer: R,
    inner: R,
}

impl<R: Real> Spline<R> {
    /// `factor` times the spline.
    #[inline(always)]
    pub fn scaled(factor: f64) -> Self {
        Self { outer: R::splat(0.25 * factor), inner: R::splat(factor) }
    }

    /// Its value at s = r/h.
    #[inline(always)]
    pub fn at(&self, s: R) -> R {
        let (outer, inner) = parts(s);
        (self.outer * outer * (outer * outer)).minus_product(self.inner * inner, inner * inner)
    }
}

/// A factor times the derivative of the spline by s.
///
/// ```text
/// 3(1 − s)₊² − ¾(2 − s)₊²                       Eq. (11) over 10/(7π), derived
/// ```
/// ```
/// let slope = sph::kernel::shape::Slope::scaled(1.0);
/// // Steepest at s = 2/3, where it is −1.
/// assert!((slope.at(2.0 / 3.0) + 1.0).abs() < 1e-15);
/// assert_eq!([0.0, 1.0, 2.0].map(|s| slope.at(s)), [0.0, -0.75, 0.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slope<R> {
    outer: R,
    inner: R,
}

impl<R: Real> Slope<R> {
    /// `factor` times the derivative.
    #[inline(always)]
    pub fn scaled(factor: f64) -> Self {
        Self { outer: R::splat(0.75 * factor), inner: R::splat(3.0 * factor) }
    }

    /// Its value at s = r/h.
    #[inline(always)]
    pub fn at(&self, s: R) -> R {
        let (outer, inner) = parts(s);
        (self.inner * (inner * inner)).minus_product(self.outer * outer, outer)
    }
}

/// (2 − s)₊ and (1 − s)₊.
#[inline(always)]
fn parts<R: Real>(s: R) -> (R, R) {
    ((R::splat(2.0) - s).max(R::zero()), (R::splat(1.0) - s).max(R::zero()))
}
