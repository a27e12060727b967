//! The cubic spline kernel, Eq. (10)-(11).

mod pair;
pub mod shape;

use crate::space::tensors::SpaceVector;
use crate::space::{Plane, Space};
use shape::{Slope, Spline};

pub use pair::{KernelLanes, PairKernel};

crate::constants! {
    /// Keeps 1/r finite at r = 0, where the factor of x_ij stays right to 1e-8.
    const SMALLEST_RATIO: f64 = 1e-8, "kernel.smallest_distance",
        "distance in units of h below which pairs count as this far apart [-]";
}

/// Cubic spline W(r, h) with support radius 2h.
///
/// ```text
/// W = f(s)/hᵈ,  s = r/h, d the number of dimensions                Eq. (10)
/// In the plane:
/// f = 10/(7π)·(1 − 3/2 s² + 3/4 s³)   0 ≤ s < 1
///   =  5/(14π)·(2 − s)³               1 ≤ s < 2                    Eq. (11)
/// ```
/// ```
/// let kernel = sph::kernel::CubicSpline::<sph::space::Plane>::new(0.5);
/// // W(0) = 10/(7π h²)
/// assert!((kernel.value(0.0) - 10.0 / (7.0 * std::f64::consts::PI * 0.25)).abs() < 1e-14);
/// assert_eq!(kernel.value(1.0), 0.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CubicSpline<S = Plane> {
    space: S,
    smoothing_length: f64,
    inverse_h: f64,
    value: Spline<f64>,
    slope: Slope<f64>,
}

/// Name of the kernel as the handshake compares it.
pub const NAME: &str = "cubic-spline";

impl<S: Space> CubicSpline<S> {
    /// A kernel of `smoothing_length` h \[m\].
    pub fn new(smoothing_length: f64) -> Self {
        let inverse_h = 1.0 / smoothing_length;
        let norm = S::kernel_normalised(inverse_h.powi(S::DIMENSIONS as i32));
        let slope = Slope::scaled(norm * inverse_h.powi(2));
        Self { space: S::default(), smoothing_length, inverse_h, value: Spline::scaled(norm), slope }
    }

    /// Smoothing length h \[m\].
    pub fn smoothing_length(&self) -> f64 {
        self.smoothing_length
    }

    /// Support radius 2h \[m\]: the kernel is zero from here on.
    pub fn support_radius(&self) -> f64 {
        2.0 * self.smoothing_length
    }

    /// W \[1/m²\] in the plane at `distance` r \[m\], Eq. (10)-(11).
    #[inline]
    pub fn value(&self, distance: f64) -> f64 {
        self.value.at(distance * self.inverse_h)
    }

    /// (dW/dr)/r \[1/m⁴\] in the plane at `distance` r \[m\], so that ∇_i W_ij = `gradient_factor` · x_ij.
    ///
    /// Finite at r = 0, where it is −3·10/(7π h⁴) to 1e-8 in the plane.
    #[inline]
    pub fn gradient_factor(&self, distance: f64) -> f64 {
        let s = (distance * self.inverse_h).max(SMALLEST_RATIO);
        self.slope.at(s) / s
    }

    /// ∇_i W_ij \[1/m³\] in the plane for x_ij = x_i − x_j at distance r \[m\].
    #[inline]
    pub fn gradient(&self, x_ij: &S::Vector, distance: f64) -> S::Vector {
        *x_ij * self.gradient_factor(distance)
    }

    /// Lattice moment M = −Σ_j V_j ((dW/dr)/r) x_ij² on an undisturbed cubic lattice of `particle_spacing` \[m\].
    ///
    /// The sums (17) and (22) are adjoint, so a static pressure on a near-lattice is ρgz/M; dividing the kernel
    /// gradient by M removes that bias.
    /// ```
    /// let kernel = sph::kernel::CubicSpline::<sph::space::Plane>::new(1.2);
    /// assert!((1.0 / kernel.lattice_moment(1.0) - 1.0 - 0.0093).abs() < 1e-4);
    /// ```
    pub fn lattice_moment(&self, particle_spacing: f64) -> f64 {
        let volume = S::cell_volume(particle_spacing);
        let mut moment = 0.0;
        self.for_lattice(particle_spacing, |x| {
            moment -= volume * self.gradient_factor(x.norm()) * x[0] * x[0]
        });
        moment
    }

    /// Σ_j V_j W \[-\] on an undisturbed cubic lattice of `particle_spacing` \[m\], the particle itself included.
    /// ```
    /// let kernel = sph::kernel::CubicSpline::<sph::space::Plane>::new(1.3);
    /// assert!((kernel.lattice_sum(1.0) - 1.0).abs() < 0.01);
    /// ```
    pub fn lattice_sum(&self, particle_spacing: f64) -> f64 {
        let mut sum = 0.0;
        self.for_lattice(particle_spacing, |x| sum += self.value(x.norm()));
        S::cell_volume(particle_spacing) * sum
    }

    /// Σ_j V_j W \[-\] over a half-space of a cubic lattice of `particle_spacing` \[m\], at `height` \[m\] over a particle of
    /// its outer row. At the face, half a spacing high, it is one half.
    /// ```
    /// let kernel = sph::kernel::CubicSpline::<sph::space::Plane>::new(1.3);
    /// assert!((kernel.half_space_sum(1.0, 0.5) - 0.5).abs() < 1e-3);
    /// ```
    pub fn half_space_sum(&self, particle_spacing: f64, height: f64) -> f64 {
        let mut sum = 0.0;
        self.for_lattice(particle_spacing, |mut x| {
            // Whole multiples of the spacing.
            if x[0] <= 0.0 {
                x[0] -= height;
                sum += self.value(x.norm());
            }
        });
        S::cell_volume(particle_spacing) * sum
    }

    /// Calls `add` for each point within the support on a cubic lattice of `particle_spacing` \[m\] about the origin.
    fn for_lattice(&self, particle_spacing: f64, mut add: impl FnMut(S::Vector)) {
        // Rows within the support radius; truncation is exact, the count is far below 2^31.
        let rows = (self.support_radius() / particle_spacing).ceil() as i32;
        let width = 2 * rows + 1;
        for point in 0..width.pow(S::DIMENSIONS as u32) {
            // Digits of the point's number, x counting fastest.
            let (mut x, mut rest) = (S::Vector::zeros(), point);
            for axis in 0..S::DIMENSIONS {
                x[axis] = f64::from(rest % width - rows);
                rest /= width;
            }
            add(x * particle_spacing);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::Spatial;

    /// Integral over the support of `f` of the distance, by the midpoint rule: error of the sums below 1e-6 at 2000 rings.
    /// `sphere` is the area of a sphere of a radius, 2πr in the plane.
    fn radial_integral<S: Space>(
        kernel: &CubicSpline<S>,
        sphere: fn(f64) -> f64,
        f: impl Fn(f64) -> f64,
    ) -> f64 {
        let rings = 2000;
        let dr = kernel.support_radius() / f64::from(rings);
        (0..rings)
            .map(|k| {
                let r = (f64::from(k) + 0.5) * dr;
                f(r) * sphere(r) * dr
            })
            .sum()
    }

    fn is_normalised<S: Space>(sphere: fn(f64) -> f64) {
        for h in [0.3, 1.0, 2.5] {
            let kernel = CubicSpline::<S>::new(h);
            assert!((radial_integral(&kernel, sphere, |r| kernel.value(r)) - 1.0).abs() < 1e-6);
            // ∫ x ∂W/∂x dV = −1, one part in as many as there are dimensions of ∫ r ∂W/∂r dV by symmetry.
            let moment = radial_integral(&kernel, sphere, |r| kernel.gradient_factor(r) * r * r);
            assert!((moment / S::DIMENSIONS as f64 + 1.0).abs() < 1e-5, "{moment}");
        }
    }

    #[test]
    fn kernel_is_normalised_and_its_gradient_has_unit_first_moment() {
        is_normalised::<Plane>(|r| std::f64::consts::TAU * r);
        is_normalised::<Spatial>(|r| 2.0 * std::f64::consts::TAU * r * r);
    }

    fn gradient_is_the_derivative<S: Space>() {
        let kernel = CubicSpline::<S>::new(0.7);
        for k in 1..140 {
            let r = 0.01 * f64::from(k);
            let step = 1e-6;
            let difference = (kernel.value(r + step) - kernel.value(r - step)) / (2.0 * step);
            // Central difference: truncation 1e-12 of a third derivative of 1e2, round-off 1e-16/1e-6.
            assert!((kernel.gradient_factor(r) * r - difference).abs() < 1e-7, "at {r}");
        }
    }

    #[test]
    fn gradient_factor_is_the_derivative_of_the_value() {
        gradient_is_the_derivative::<Plane>();
        gradient_is_the_derivative::<Spatial>();
    }

    #[test]
    fn sums_over_a_lattice_in_space_are_near_their_integrals() {
        for ratio in [1.0, 1.2, 1.3, 1.5, 2.0] {
            let kernel = CubicSpline::<Spatial>::new(ratio);
            // Sums over a lattice miss the integral by about a per cent, by two at h/dx = 1.
            for (sum, expected) in [
                (kernel.lattice_sum(1.0), 1.0),
                (kernel.lattice_moment(1.0), 1.0),
                (kernel.half_space_sum(1.0, 0.5), 0.5),
            ] {
                assert!((sum - expected).abs() < 0.025 * expected, "h/dx = {ratio}: {sum}");
            }
        }
    }

    #[test]
    fn kernel_vanishes_at_and_beyond_the_support_radius() {
        let kernel = CubicSpline::<Plane>::new(0.5);
        for r in [1.0, 1.1, 5.0] {
            assert_eq!(kernel.value(r), 0.0);
            assert_eq!(kernel.gradient_factor(r), 0.0);
        }
    }

    #[test]
    fn lattice_moment_matches_the_measured_table() {
        // 1/M − 1 in percent, shared numerics table for the cubic spline.
        for (ratio, percent) in [(1.0, -1.29), (1.1, 0.34), (1.3, -1.04), (1.5, -0.67), (2.0, 0.09)] {
            let moment = CubicSpline::<Plane>::new(ratio).lattice_moment(1.0);
            assert!((100.0 * (1.0 / moment - 1.0) - percent).abs() < 0.006, "h/dx = {ratio}");
        }
    }
}
