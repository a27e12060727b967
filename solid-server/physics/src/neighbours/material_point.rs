//! Reading fields at a material point of a body.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use sph::kernel::CubicSpline;
use sph::space::Space;
use sph::space::tensors::{Linear, SpaceVector};

/// A material point as a weighted mean of particles near it in the undeformed body.
///
/// Weights come from a linear moving-least-squares fit, so that fields linear in the reference position are met exactly,
/// also at the edge of the body, half a spacing beyond the outermost particles.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialPoint {
    /// (index of the particle, weight).
    pub weights: Vec<(usize, f64)>,
}

sph::constants! {
    const SINGULAR: f64 = 1e-9, "probes.fit_singular",
        "eigenvalue over the largest below which the particles of a fit lie on one line [-]";
    const FIT_RADIUS: f64 = 2.0, "probes.fit_radius",
        "first radius of the fit at a material point, in spacings [-]";
    /// Three fix a linear fit, six make it robust.
    const FIT_PARTICLES: usize = 6, "probes.fit_particles",
        "particles needed for that fit [-]";
    const FIT_GROWTH: f64 = 1.5, "probes.fit_growth",
        "factor by which its radius grows while there are too few [-]";
    const FIT_ROUNDS: usize = 3, "probes.fit_rounds",
        "most radii tried [-]";
}

impl MaterialPoint {
    /// The point at reference position `at` \[m\] of a body whose particles start at index `first`.
    ///
    /// # Errors
    /// The distance \[m\] to the nearest particle, when that is more than one `spacing` \[m\].
    pub fn new<S: Space>(
        at: &S::Vector,
        first: usize,
        reference: &[S::Vector],
        spacing: f64,
    ) -> Result<Self, f64> {
        let distance = |k: usize| (reference[k] - *at).norm();
        let nearest = (0..reference.len()).map(distance).fold(f64::INFINITY, f64::min);
        if nearest > spacing {
            return Err(nearest);
        }
        let mut radius = FIT_RADIUS * spacing;
        let mut near: Vec<usize> = Vec::new();
        // A tiny body may have fewer.
        for _ in 0..FIT_ROUNDS {
            near = (0..reference.len()).filter(|k| distance(*k) < radius).collect();
            if near.len() >= FIT_PARTICLES {
                break;
            }
            radius *= FIT_GROWTH;
        }
        let kernel = CubicSpline::<S>::new(0.5 * radius);
        let nearness = |k: usize| kernel.value(distance(k));
        let total: f64 = near.iter().map(|k| nearness(*k)).sum();
        let middle: S::Vector = near.iter().map(|k| reference[*k] * (nearness(*k) / total)).sum();
        // About the middle of the particles, a direction in which they do not extend gets no slope.
        let basis = |x: &S::Vector| {
            let linear = (0..S::DIMENSIONS).map(|axis| (x[axis] - middle[axis]) / spacing);
            DVector::from_iterator(1 + S::DIMENSIONS, std::iter::once(1.0).chain(linear))
        };
        let mut moment = DMatrix::zeros(1 + S::DIMENSIONS, 1 + S::DIMENSIONS);
        for &k in &near {
            moment += basis(&reference[k]) * basis(&reference[k]).transpose() * nearness(k);
        }
        let functional = pseudo_inverse(moment) * basis(at);
        let weights =
            near.iter().map(|&k| (first + k, nearness(k) * functional.dot(&basis(&reference[k])))).collect();
        Ok(Self { weights })
    }

    /// Weighted mean of `value` over the particles.
    pub fn mean<T: Linear>(&self, value: impl Fn(usize) -> T) -> T {
        self.weights.iter().map(|(i, weight)| value(*i) * *weight).sum()
    }
}

fn pseudo_inverse(moment: DMatrix<f64>) -> DMatrix<f64> {
    let eigen = SymmetricEigen::new(moment);
    let bound = SINGULAR * eigen.eigenvalues.max();
    let inverse = eigen.eigenvalues.map(|value| if value > bound { 1.0 / value } else { 0.0 });
    &eigen.eigenvectors * DMatrix::from_diagonal(&inverse) * eigen.eigenvectors.transpose()
}

#[cfg(test)]
mod tests {
    use sph::space::{Plane, Vector};

    use super::*;

    fn plate(columns: u32, rows: u32) -> Vec<Vector> {
        (0..columns * rows)
            .map(|k| Vector::new(f64::from(k % columns) + 0.5, f64::from(k / columns) + 0.5) * 0.01)
            .collect()
    }

    #[test]
    fn linear_fields_are_exact_inside_at_edges_and_at_corners() {
        let field = |x: &Vector| Vector::new(0.3 + 2.0 * x.x - 5.0 * x.y, 1.0 - 0.7 * x.x + x.y);
        for (columns, rows) in [(20, 6), (20, 2), (3, 3), (2, 2)] {
            let reference = plate(columns, rows);
            let (length, height) = (0.01 * f64::from(columns), 0.01 * f64::from(rows));
            for at in [
                Vector::new(length, 0.5 * height),
                Vector::new(0.0, 0.0),
                Vector::new(0.4 * length, 0.61 * height),
                Vector::new(length, height),
            ] {
                let point = MaterialPoint::new::<Plane>(&at, 0, &reference, 0.01).unwrap();
                let value = point.mean(|i| field(&reference[i]));
                assert!((value - field(&at)).norm() < 1e-12, "{columns} x {rows} at {at}");
            }
        }
    }

    #[test]
    fn a_single_row_is_exact_along_itself() {
        let reference = plate(20, 1);
        let point = MaterialPoint::new::<Plane>(&Vector::new(0.2, 0.007), 0, &reference, 0.01).unwrap();
        let value = point.mean(|i| Vector::new(3.0 * reference[i].x, 1.0));
        assert!((value - Vector::new(0.6, 1.0)).norm() < 1e-12);
    }

    #[test]
    fn a_point_beside_the_body_is_refused_with_its_distance() {
        let distance =
            MaterialPoint::new::<Plane>(&Vector::new(0.23, 0.03), 0, &plate(20, 6), 0.01).unwrap_err();
        assert!((distance - 0.0354).abs() < 1e-4);
    }
}
