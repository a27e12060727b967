//! Principal values and directions of symmetric tensors.

use nalgebra::Vector2;

use super::SymmetricTensor;

/// A symmetric tensor by its principal values and directions.
///
/// ```text
/// λ = (σ_xx + σ_yy)/2 ± √(((σ_xx − σ_yy)/2)² + σ_xy²),  tan 2θ = 2σ_xy/(σ_xx − σ_yy)
/// ```
/// ```
/// use sph::space::SymmetricTensor;
/// // Pure shear: ±τ at 45°.
/// let shear = SymmetricTensor { xx: 0.0, yy: 0.0, xy: 3.0 }.principal();
/// assert_eq!([shear.major, shear.minor], [3.0, -3.0]);
/// assert!((shear.major_direction().x - 0.5f64.sqrt()).abs() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Principal {
    /// Larger value.
    pub major: f64,
    /// Smaller value.
    pub minor: f64,
    /// cos 2θ and sin 2θ of the angle θ from x to the direction of the larger value; 1 and 0 where both are equal.
    double_angle: [f64; 2],
}

impl SymmetricTensor {
    /// Principal values and directions.
    #[inline]
    pub fn principal(&self) -> Principal {
        let mean = 0.5 * (self.xx + self.yy);
        let half_difference = 0.5 * (self.xx - self.yy);
        let radius = (half_difference * half_difference + self.xy * self.xy).sqrt();
        let double_angle =
            if radius > 0.0 { [half_difference / radius, self.xy / radius] } else { [1.0, 0.0] };
        Principal { major: mean + radius, minor: mean - radius, double_angle }
    }
}

impl Principal {
    /// The tensor of the same directions with `major` and `minor` in place of the values.
    #[inline]
    pub fn with_values(&self, major: f64, minor: f64) -> SymmetricTensor {
        let [cosine, sine] = self.double_angle;
        let (centre, half_span) = (0.5 * (major + minor), 0.5 * (major - minor));
        SymmetricTensor {
            xx: centre + half_span * cosine,
            yy: centre - half_span * cosine,
            xy: half_span * sine,
        }
    }

    /// Unit vector along the direction of the larger value, with x ≥ 0.
    pub fn major_direction(&self) -> Vector2<f64> {
        let [cosine, sine] = self.double_angle;
        let angle = 0.5 * sine.atan2(cosine);
        Vector2::new(angle.cos(), angle.sin())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::tensors::SpaceSymmetric;

    #[test]
    fn the_tensor_follows_from_its_values_and_directions() {
        for (xx, yy, xy) in [(1.0, 2.0, 0.5), (-3.0, 4.0, -2.0), (2.0, 2.0, 0.0), (0.0, 0.0, 1e-9)] {
            let tensor = SymmetricTensor { xx, yy, xy };
            let principal = tensor.principal();
            let again = principal.with_values(principal.major, principal.minor);
            // Round-off of sums of order one.
            for (found, expected) in [(again.xx, xx), (again.yy, yy), (again.xy, xy)] {
                assert!((found - expected).abs() < 1e-15 * (1.0 + xx.abs() + yy.abs()), "{tensor:?}");
            }
            let direction = principal.major_direction();
            let residual = tensor.dot(&direction) - direction * principal.major;
            assert!(residual.norm() < 1e-14, "{tensor:?}");
        }
    }

    #[test]
    fn trace_and_determinant_are_invariants() {
        let tensor = SymmetricTensor { xx: 1.3, yy: -0.4, xy: 0.9 };
        let Principal { major, minor, .. } = tensor.principal();
        assert!((major + minor - 0.9).abs() < 1e-15);
        assert!((major * minor - (1.3 * -0.4 - 0.81)).abs() < 1e-15);
    }
}
