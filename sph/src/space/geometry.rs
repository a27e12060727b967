//! Separations of pairs of particles, to the nearest image in periodic boxes.

use crate::lanes::Lanes;
use crate::space::Vector;
use crate::space::domain::Domain;

/// Nearest images; open and periodic boxes are different types, so that open ones pay nothing.
pub trait Geometry: Copy + Send + Sync {
    /// Difference of coordinates along `axis` \[m\], to the nearest image.
    fn nearest<L: Lanes>(self, difference: L, axis: usize) -> L;

    /// x_ij = x_i − x_j \[m\] of the nearest images.
    fn separation(self, x_i: &Vector, x_j: &Vector) -> Vector;
}

/// A box without periodic directions.
#[derive(Clone, Copy, Debug)]
pub struct Open;

impl Geometry for Open {
    #[inline(always)]
    fn nearest<L: Lanes>(self, difference: L, _axis: usize) -> L {
        difference
    }

    #[inline(always)]
    fn separation(self, x_i: &Vector, x_j: &Vector) -> Vector {
        x_i - x_j
    }
}

/// A box with periodic directions; positions lie less than half a period outside.
#[derive(Clone, Copy, Debug)]
pub struct Periodic {
    period: [f64; 2],
    /// Half a period; infinite along open directions.
    half: [f64; 2],
}

impl Periodic {
    /// The periods of `domain`.
    pub fn new(domain: &Domain) -> Self {
        let size = domain.size();
        let half = |axis: usize| if domain.periodic[axis] { 0.5 * size[axis] } else { f64::INFINITY };
        Self { period: [size.x, size.y], half: [half(0), half(1)] }
    }
}

impl Geometry for Periodic {
    #[inline(always)]
    fn nearest<L: Lanes>(self, difference: L, axis: usize) -> L {
        let (half, period) = (L::splat(self.half[axis]), L::splat(self.period[axis]));
        let d = half.choose_below(difference, difference - period, difference);
        difference.choose_below(L::zero() - half, difference + period, d)
    }

    #[inline(always)]
    fn separation(self, x_i: &Vector, x_j: &Vector) -> Vector {
        let d = x_i - x_j;
        let nearest = |d: f64, axis: usize| {
            let (half, period) = (self.half[axis], self.period[axis]);
            if d > half {
                d - period
            } else if d < -half {
                d + period
            } else {
                d
            }
        };
        Vector::new(nearest(d.x, 0), nearest(d.y, 1))
    }
}

#[cfg(test)]
mod tests {
    use crate::lanes::{Arithmetic, LanePass, WIDTH};

    use super::*;

    /// Differences along an axis in a batch.
    struct Nearest(Periodic, usize, [f64; WIDTH]);

    impl LanePass for Nearest {
        type Output = [f64; WIDTH];

        #[inline(always)]
        fn run<L: Lanes>(self) -> [f64; WIDTH] {
            self.0.nearest(L::from_array(self.2), self.1).to_array()
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
                let along = |axis: usize| {
                    arithmetic.run(Nearest(geometry, axis, others.map(|other| x_i[axis] - other[axis])))
                };
                let (x, y) = (along(0), along(1));
                for (l, other) in others.iter().enumerate() {
                    let expected = domain.separation(&x_i, other);
                    assert_eq!(geometry.separation(&x_i, other), expected);
                    assert_eq!(Vector::new(x[l], y[l]), expected);
                }
            }
        }
    }
}
