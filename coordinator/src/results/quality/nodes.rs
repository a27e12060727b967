//! Nodes of a regular grid on which particles are summed with cubic B-splines.

use sph::space::Space;
use sph::space::domain::Domain;
use sph::space::tensors::SpaceVector;

/// Nodes along each axis on which a particle has a weight.
const STENCIL: usize = 4;

/// The nodes over some particles. The weights of a particle on all nodes sum to one, and so do those of others that have a
/// weight on a node together with one of them.
pub struct Nodes<S: Space> {
    /// Place of the first node \[m\].
    lower: S::Vector,
    /// Distance of nodes \[m\].
    spacing: S::Vector,
    counts: S::Of<usize>,
    periodic: S::Of<bool>,
}

impl<S: Space> Nodes<S> {
    /// Nodes about `spacing` \[m\] apart over `positions` \[m\] in `domain`.
    pub fn over(domain: &Domain<S>, positions: &[S::Vector], spacing: f64) -> Self {
        let (mut lower, mut upper) = (S::Vector::repeat(f64::INFINITY), S::Vector::repeat(f64::NEG_INFINITY));
        for x in positions {
            (lower, upper) = (lower.inf(x), upper.sup(x));
        }
        let (mut spacings, mut counts) = (S::Vector::repeat(spacing), S::splat(1));
        for axis in 0..S::DIMENSIONS {
            if domain.periodic[axis] {
                let size = domain.upper[axis] - domain.lower[axis];
                let count = (size / spacing).round().max(1.0);
                (lower[axis], spacings[axis], counts[axis]) =
                    (domain.lower[axis], size / count, count as usize);
            } else {
                // Up to two spacings from a particle to a node, from there to another particle, and on to its nodes.
                // Bounded by the particles, which fill the box.
                let width = ((upper[axis] - lower[axis]) / spacing).max(0.0).ceil() as usize;
                lower[axis] -= 6.0 * spacing;
                counts[axis] = width + 12 + 1;
            }
        }
        Self { lower, spacing: spacings, counts, periodic: domain.periodic }
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        (0..S::DIMENSIONS).map(|axis| self.counts[axis]).product()
    }

    /// Volume of the cell of a node \[m³\], in the plane per depth.
    pub fn volume(&self) -> f64 {
        (0..S::DIMENSIONS).map(|axis| self.spacing[axis]).product()
    }

    /// Calls `take` with each node on which a particle at `x` \[m\] has a weight, and the weight \[-\].
    pub fn for_each(&self, x: &S::Vector, mut take: impl FnMut(usize, f64)) {
        let mut first = [0_i64; 3];
        let mut weights = [[0.0; STENCIL]; 3];
        for axis in 0..S::DIMENSIONS {
            let place = (x[axis] - self.lower[axis]) / self.spacing[axis];
            // A particle far outside has no weight on any node, whatever its index saturates to.
            first[axis] = (place.floor() as i64).saturating_sub(1);
            weights[axis] = std::array::from_fn(|k| spline(place - (first[axis] as f64 + k as f64)));
        }
        for point in 0..STENCIL.pow(S::DIMENSIONS as u32) {
            let (mut rest, mut node, mut stride, mut weight) = (point, 0, 1, 1.0);
            for axis in 0..S::DIMENSIONS {
                let (k, count) = (rest % STENCIL, self.counts[axis]);
                rest /= STENCIL;
                weight *= weights[axis][k];
                let index = first[axis].saturating_add(k as i64);
                let index = if self.periodic[axis] { index.rem_euclid(count as i64) } else { index };
                match usize::try_from(index) {
                    Ok(index) if index < count => node += index * stride,
                    _ => weight = 0.0,
                }
                stride *= count;
            }
            if weight > 0.0 {
                take(node, weight);
            }
        }
    }
}

/// Cubic B-spline at `distance` \[-\].
fn spline(distance: f64) -> f64 {
    let u = distance.abs();
    if u < 1.0 { (4.0 - 6.0 * u * u + 3.0 * u * u * u) / 6.0 } else { (2.0 - u).max(0.0).powi(3) / 6.0 }
}

#[cfg(test)]
mod tests {
    use sph::space::{Plane, Spatial};

    use super::*;

    fn weights_sum_to_one<S: Space>(periodic: S::Of<bool>) {
        let domain = Domain::<S> { lower: S::Vector::zeros(), upper: S::Vector::repeat(1.0), periodic };
        let positions = [S::Vector::repeat(0.03), S::Vector::repeat(0.5), S::Vector::repeat(0.999)];
        let nodes = Nodes::over(&domain, &positions, 0.13);
        for x in &positions {
            let (mut sum, mut farthest) = (0.0, 0);
            nodes.for_each(x, |node, weight| (sum, farthest) = (sum + weight, farthest.max(node)));
            // Round-off of 64 terms.
            assert!((sum - 1.0).abs() < 1e-14 && farthest < nodes.len(), "{sum} {farthest}");
        }
        // Nor is one cut off that shares the outermost node of another.
        let mut sum = 0.0;
        nodes.for_each(&S::Vector::repeat(0.999 + 3.99 * 0.13), |_, weight| sum += weight);
        assert!((sum - 1.0).abs() < 1e-14, "{sum}");
        // Far outside, without a period, there is no node.
        let mut count = 0;
        for far in [1e30, -1e30] {
            nodes.for_each(&S::Vector::repeat(far), |_, _| count += 1);
        }
        assert!(periodic[0] || count == 0, "{count}");
    }

    #[test]
    fn the_weights_of_a_particle_sum_to_one() {
        for periodic in [false, true] {
            weights_sum_to_one::<Plane>([periodic; 2]);
            weights_sum_to_one::<Spatial>([periodic; 3]);
        }
    }
}
