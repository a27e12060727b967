//! Separations of pairs of particles, to the nearest image in periodic boxes.

use crate::lanes::Lanes;
use crate::space::domain::Domain;
use crate::space::tensors::SpaceVector;
use crate::space::{Plane, Space};

/// Nearest images; open and periodic boxes are different types, so that open ones pay nothing.
pub trait Geometry<S: Space = Plane>: Copy + Send + Sync {
    /// Difference of positions \[m\], to the nearest image.
    fn nearest<L: Lanes>(self, difference: S::Of<L>) -> S::Of<L>;

    /// x_ij = x_i − x_j \[m\] of the nearest images.
    fn separation(self, x_i: &S::Vector, x_j: &S::Vector) -> S::Vector;
}

/// A box without periodic directions.
#[derive(Clone, Copy, Debug)]
pub struct Open;

impl<S: Space> Geometry<S> for Open {
    #[inline(always)]
    fn nearest<L: Lanes>(self, difference: S::Of<L>) -> S::Of<L> {
        difference
    }

    #[inline(always)]
    fn separation(self, x_i: &S::Vector, x_j: &S::Vector) -> S::Vector {
        *x_i - *x_j
    }
}

/// A box with periodic directions; positions lie less than half a period outside.
#[derive(Clone, Copy, Debug)]
pub struct Periodic<S: Space = Plane> {
    period: S::Vector,
    /// Half a period; infinite along open directions.
    half: S::Vector,
}

impl<S: Space> Periodic<S> {
    /// The periods of `domain`.
    pub fn new(domain: &Domain<S>) -> Self {
        let (period, mut half) = (domain.size(), S::Vector::repeat(f64::INFINITY));
        for axis in (0..S::DIMENSIONS).filter(|axis| domain.periodic[*axis]) {
            half[axis] = 0.5 * period[axis];
        }
        Self { period, half }
    }
}

impl<S: Space> Geometry<S> for Periodic<S> {
    #[inline(always)]
    fn nearest<L: Lanes>(self, mut difference: S::Of<L>) -> S::Of<L> {
        for axis in 0..S::DIMENSIONS {
            let (half, period) = (L::splat(self.half[axis]), L::splat(self.period[axis]));
            let along = difference[axis];
            let d = half.choose_below(along, along - period, along);
            difference[axis] = along.choose_below(L::zero() - half, along + period, d);
        }
        difference
    }

    #[inline(always)]
    fn separation(self, x_i: &S::Vector, x_j: &S::Vector) -> S::Vector {
        let mut d = *x_i - *x_j;
        for axis in 0..S::DIMENSIONS {
            let (half, period) = (self.half[axis], self.period[axis]);
            if d[axis] > half {
                d[axis] -= period;
            } else if d[axis] < -half {
                d[axis] += period;
            }
        }
        d
    }
}

#[cfg(test)]
mod tests {
    use crate::lanes::{Arithmetic, LanePass, WIDTH};
    use crate::space::Vector;
    use crate::space::algebra::Algebra;

    use super::*;

    /// Separations from four positions.
    struct Nearest(Periodic, Vector, [Vector; WIDTH]);

    impl LanePass for Nearest {
        type Output = [[f64; WIDTH]; 2];

        #[inline(always)]
        fn run<L: Lanes>(self) -> [[f64; WIDTH]; 2] {
            let (own, others) = (Plane::splat_vector::<L>(&self.1), Plane::lanes(self.2.each_ref()));
            self.0.nearest(Plane::minus(own, others)).map(L::to_array)
        }
    }

    #[test]
    fn periodic_separation_is_that_of_the_domain() {
        let domain =
            Domain { lower: Vector::new(-0.3, 0.0), upper: Vector::new(0.7, 0.5), periodic: [true, false] };
        let geometry = Periodic::new(&domain);
        let others = [(-0.28, 0.49), (0.68, 0.0), (0.1, 0.2), (0.2, 0.3)].map(|(x, y)| Vector::new(x, y));
        for (x, y) in [(-0.29, 0.1), (0.69, 0.4), (0.2, 0.0), (0.71, 0.9), (-0.31, 0.3)] {
            let x_i = Vector::new(x, y);
            for arithmetic in Arithmetic::all() {
                let [x, y] = arithmetic.run(Nearest(geometry, x_i, others));
                for (l, other) in others.iter().enumerate() {
                    let expected = domain.separation(&x_i, other);
                    assert_eq!(geometry.separation(&x_i, other), expected);
                    assert_eq!(Vector::new(x[l], y[l]), expected);
                }
            }
        }
    }
}
