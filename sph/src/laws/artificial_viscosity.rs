//! Artificial viscosity between approaching particles, Eq. (23)-(24), of all of their approach or of the part that a smooth
//! field of velocity does not explain.

use crate::lanes::Real;

/// Artificial viscosity of Monaghan (1992), for pairs that approach each other.
///
/// ```text
/// Π_ij = (−A c θ + B θ²)/ρ̄,  θ = h min(v_ij·x_ij, 0)/(x_ij² + λh²)            Eq. (23)-(24)
/// ```
/// ```
/// use sph::laws::artificial_viscosity::ArtificialViscosity;
/// // h = 1, A c = 2, B = 3, λ = 0: two particles 1 m apart that approach at 0.5 m/s have θ = −0.5 m/s.
/// let law = ArtificialViscosity::new(1.0, 2.0, 3.0, 0.0);
/// assert_eq!(law.pressure(-0.5, 1.0), 0.5 * 2.0 + 0.25 * 3.0);
/// assert_eq!(law.pressure(0.5, 1.0), 0.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArtificialViscosity<R = f64> {
    /// h \[m\].
    smoothing_length: R,
    /// −A c \[m/s\].
    minus_linear: R,
    /// B \[-\].
    quadratic: R,
    /// λh² \[m²\], which keeps θ finite where particles meet.
    softening: R,
}

impl ArtificialViscosity {
    /// No viscosity.
    pub const NONE: Self = Self { smoothing_length: 0.0, minus_linear: 0.0, quadratic: 0.0, softening: 1.0 };

    /// The law of smoothing length h \[m\], A c \[m/s\], B \[-\] and λ \[-\].
    pub fn new(smoothing_length: f64, linear: f64, quadratic: f64, lambda: f64) -> Self {
        let softening = lambda * smoothing_length * smoothing_length;
        Self { smoothing_length, minus_linear: -linear, quadratic, softening }
    }

    /// The same in lanes.
    #[inline(always)]
    pub fn lanes<R: Real>(&self) -> ArtificialViscosity<R> {
        ArtificialViscosity {
            smoothing_length: R::splat(self.smoothing_length),
            minus_linear: R::splat(self.minus_linear),
            quadratic: R::splat(self.quadratic),
            softening: R::splat(self.softening),
        }
    }
}

impl<R: Real> ArtificialViscosity<R> {
    /// x_ij² + λh² \[m²\] of x_ij² = `square` \[m²\].
    #[inline(always)]
    pub fn softened(&self, square: R) -> R {
        square + self.softening
    }

    /// ρ̄ Π_ij \[m²/s²\] of v_ij·x_ij/(x_ij² + λh²) = `approach` \[1/s\]: times a density \[kg/m³\], a pressure.
    #[inline(always)]
    pub fn pressure_over_density(&self, approach: R) -> R {
        // In this order a NaN stays one.
        let theta = self.smoothing_length * R::zero().min(approach);
        theta * self.minus_linear.plus_product(self.quadratic, theta)
    }

    /// The same with θ of the `residual` of the approach \[1/s\] in the linear term.
    #[inline(always)]
    pub fn of_residual(&self, approach: R, residual: R) -> R {
        let theta = self.smoothing_length * R::zero().min(approach);
        let residual = self.smoothing_length * R::zero().min(residual);
        (residual * self.minus_linear).plus_product(self.quadratic, theta * theta)
    }

    /// The same of v_ij·x_ij \[m²/s\] and x_ij² \[m²\].
    #[inline(always)]
    pub fn pressure(&self, approach: R, square: R) -> R {
        self.pressure_over_density(approach / self.softened(square))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{Arithmetic, LanePass, Lanes, WIDTH};

    const LAW: (f64, f64, f64, f64) = (0.4, 3.0, 0.7, 0.01);

    fn law() -> ArtificialViscosity {
        ArtificialViscosity::new(LAW.0, LAW.1, LAW.2, LAW.3)
    }

    #[test]
    fn it_resists_approach_only_and_grows_with_its_square() {
        let law = law();
        assert_eq!(law.pressure(0.3, 0.2), 0.0);
        assert_eq!(law.pressure(0.0, 0.2), 0.0);
        // Eq. (23)-(24) written out.
        let theta = 0.4 * -0.3 / (0.2 + 0.01 * 0.16);
        let expected = -3.0 * theta + 0.7 * theta * theta;
        assert!((law.pressure(-0.3, 0.2) - expected).abs() < 1e-15 * expected);
        assert_eq!(ArtificialViscosity::NONE.pressure(-0.3, 0.2), 0.0);
    }

    struct Four;

    impl LanePass for Four {
        type Output = [f64; WIDTH];

        #[inline(always)]
        fn run<L: Lanes>(self) -> [f64; WIDTH] {
            let approach = L::from_array([-0.3, 0.1, 0.0, -2.0]);
            law().lanes::<L>().pressure(approach, L::splat(0.2)).to_array()
        }
    }

    #[test]
    fn a_speed_that_is_no_number_gives_no_number() {
        assert!(law().pressure(f64::NAN, 0.2).is_nan());
        struct Broken;
        impl LanePass for Broken {
            type Output = [f64; WIDTH];

            #[inline(always)]
            fn run<L: Lanes>(self) -> [f64; WIDTH] {
                law().lanes::<L>().pressure(L::splat(f64::NAN), L::splat(0.2)).to_array()
            }
        }
        for arithmetic in Arithmetic::all() {
            assert!(arithmetic.run(Broken).into_iter().all(f64::is_nan));
        }
    }

    #[test]
    fn lanes_give_what_single_numbers_give() {
        for arithmetic in Arithmetic::all() {
            for (found, approach) in arithmetic.run(Four).into_iter().zip([-0.3, 0.1, 0.0, -2.0]) {
                let expected = law().pressure(approach, 0.2);
                // Round-off of one fused product.
                assert!((found - expected).abs() <= 1e-15 * expected, "{approach}");
            }
        }
    }
}
