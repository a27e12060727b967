//! The gradient of the cubic spline for four pairs at a time.

use super::shape::Slope;
use super::{CubicSpline, SMALLEST_RATIO};
use crate::lanes::Lanes;
use crate::space::Space;

/// The gradient of the cubic spline, Eq. (11) for four pairs at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairKernel {
    inverse_h: f64,
    norm: f64,
}

impl PairKernel {
    /// The gradient of `kernel` times `scale`, which is 1/M where the lattice moment M corrects it.
    pub fn new<S: Space>(kernel: &CubicSpline<S>, scale: f64) -> Self {
        let inverse_h = 1.0 / kernel.smoothing_length();
        let norm = S::kernel_normalised(scale) * inverse_h.powi(S::DIMENSIONS as i32 + 2);
        Self { inverse_h, norm }
    }

    /// Its constants in lanes.
    #[inline(always)]
    pub fn lanes<L: Lanes>(&self) -> KernelLanes<L> {
        KernelLanes {
            inverse_h: L::splat(self.inverse_h),
            smallest: L::splat(SMALLEST_RATIO),
            slope: Slope::scaled(self.norm),
        }
    }
}

/// [`PairKernel`] in lanes.
#[derive(Clone, Copy, Debug)]
pub struct KernelLanes<L> {
    inverse_h: L,
    smallest: L,
    slope: Slope<L>,
}

impl<L: Lanes> KernelLanes<L> {
    /// s = r/h and s·(dW/dr)/r \[1/m⁴\] at r² \[m²\]; the second is exactly zero from 2h on.
    #[inline(always)]
    pub fn slope(&self, square: L) -> (L, L) {
        let s = (self.inverse_h * square.sqrt()).max(self.smallest);
        (s, self.slope.at(s))
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
    use crate::space::Plane;

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
        let kernel = CubicSpline::<Plane>::new(0.036);
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
