//! The gradient of the cubic spline for four pairs at a time.

use super::CubicSpline;
use crate::lanes::Lanes;

/// Distances below this fraction of h count as this fraction: keeps 1/r finite at r = 0, where the factor of x_ij
/// stays right to 1e-8.
const SMALLEST_RATIO: f64 = 1e-8;

/// The gradient of the cubic spline, Eq. (11), in a form without branches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairKernel {
    inverse_h: f64,
    norm: f64,
}

impl PairKernel {
    /// The gradient of `kernel` times `scale`, which is 1/M where the lattice moment M corrects it.
    pub fn new(kernel: &CubicSpline, scale: f64) -> Self {
        let inverse_h = 1.0 / kernel.smoothing_length();
        let norm = scale * 10.0 / (7.0 * std::f64::consts::PI) * inverse_h.powi(4);
        Self { inverse_h, norm }
    }

    /// Its constants in lanes.
    #[inline(always)]
    pub fn lanes<L: Lanes>(&self) -> KernelLanes<L> {
        KernelLanes {
            inverse_h: L::splat(self.inverse_h),
            smallest: L::splat(SMALLEST_RATIO),
            inner: L::splat(3.0 * self.norm),
            outer: L::splat(0.75 * self.norm),
        }
    }
}

/// [`PairKernel`] in lanes.
#[derive(Clone, Copy, Debug)]
pub struct KernelLanes<L> {
    inverse_h: L,
    smallest: L,
    inner: L,
    outer: L,
}

impl<L: Lanes> KernelLanes<L> {
    /// s and s h⁴·7π/10·(dW/dr)/r at r² \[m²\]; the second is exactly zero from 2h on.
    ///
    /// ```text
    /// h⁴·7π/10·(dW/dr)/r = [3·max(1−s, 0)² − 3/4·max(2−s, 0)²]/s,  s = r/h
    /// ```
    #[inline(always)]
    pub fn slope(&self, square: L) -> (L, L) {
        let s = (self.inverse_h * square.sqrt()).max(self.smallest);
        let outer = (L::splat(2.0) - s).max(L::zero());
        let inner = (L::splat(1.0) - s).max(L::zero());
        let slope = self.inner * (inner * inner);
        (s, slope.minus_product(self.outer * outer, outer))
    }

    /// (dW/dr)/r \[1/m⁴\] at r² \[m²\], so that ∇_i W_ij is this times x_ij; exactly zero from 2h on.
    #[inline(always)]
    pub fn gradient_factor(&self, square: L) -> L {
        let (s, slope) = self.slope(square);
        slope / s
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{Arithmetic, LanePass, WIDTH};

    /// (dW/dr)/r at four distances.
    struct Factor(PairKernel, [f64; WIDTH]);

    impl LanePass for Factor {
        type Output = [f64; WIDTH];

        #[inline(always)]
        fn run<L: Lanes>(self) -> [f64; WIDTH] {
            self.0.lanes().gradient_factor(L::from_array(self.1.map(|r| r * r))).to_array()
        }
    }

    #[test]
    fn the_branchless_gradient_is_that_of_the_kernel() {
        let kernel = CubicSpline::new(0.036);
        for (arithmetic, k) in Arithmetic::all().flat_map(|arithmetic| (0..300).map(move |k| (arithmetic, k)))
        {
            let r = 3e-4 * f64::from(k);
            let expected = 0.5 * kernel.gradient_factor(r);
            let [found, others @ ..] = arithmetic.run(Factor(PairKernel::new(&kernel, 0.5), [r; WIDTH]));
            assert_eq!(others, [found; 3]);
            // Round-off of a difference of two terms of size 1/s; 1e-8 at r = 0 by the floor of s.
            let allowed = if k == 0 { 1e-7 } else { 1e-11 };
            assert!((found - expected).abs() <= allowed * kernel.gradient_factor(0.0).abs(), "at {r}");
            if r >= 0.072 {
                assert_eq!(found, 0.0);
            }
        }
    }
}
