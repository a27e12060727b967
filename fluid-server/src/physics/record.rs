//! What a pair sum reads of a particle, and the separation of a pair.

use sph::domain::Domain;
use sph::lanes::{Lanes, WIDTH};
use sph::vector::Vector;

/// State of a particle as its neighbours read it: one cache line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(align(64))]
pub struct Record {
    /// x, y \[m\], v_x, v_y \[m/s\].
    pub motion: [f64; 4],
    /// Density ρ \[kg/m³\], pressure p \[Pa\], volume per depth V = m/ρ \[m²\], unused.
    pub matter: [f64; 4],
}

impl Record {
    /// A particle; one of zero `volume` does not act.
    #[inline(always)]
    pub fn new(position: &Vector, velocity: &Vector, density: f64, pressure: f64, volume: f64) -> Self {
        Self {
            motion: [position.x, position.y, velocity.x, velocity.y],
            matter: [density, pressure, volume, 0.0],
        }
    }

    /// Position \[m\].
    #[inline(always)]
    pub fn position(&self) -> Vector {
        Vector::new(self.motion[0], self.motion[1])
    }

    /// Velocity \[m/s\].
    #[inline(always)]
    pub fn velocity(&self) -> Vector {
        Vector::new(self.motion[2], self.motion[3])
    }

    /// Density ρ \[kg/m³\].
    #[inline(always)]
    pub fn density(&self) -> f64 {
        self.matter[0]
    }

    /// Pressure p \[Pa\], without damper.
    #[inline(always)]
    pub fn pressure(&self) -> f64 {
        self.matter[1]
    }

    /// Volume per depth V = m/ρ \[m²\]; zero for a particle that does not act.
    #[inline(always)]
    pub fn volume(&self) -> f64 {
        self.matter[2]
    }
}

/// Nearest images; open and periodic boxes are different types, so that open ones pay nothing.
pub trait Geometry: Copy + Send + Sync {
    /// Difference of coordinates along `axis` \[m\], to the nearest image.
    fn nearest<L: Lanes>(self, difference: L, axis: usize) -> L;

    /// x_ij = x_i − x_j \[m\] of the nearest images.
    fn separation(self, i: &Record, j: &Record) -> Vector;
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
    fn separation(self, i: &Record, j: &Record) -> Vector {
        i.position() - j.position()
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
    fn separation(self, i: &Record, j: &Record) -> Vector {
        let d = i.position() - j.position();
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

/// A batch of neighbours as particle i meets them.
#[derive(Clone, Copy, Debug)]
pub struct Batch<L> {
    /// x_ij \[m\].
    pub x: L,
    /// y_ij \[m\].
    pub y: L,
    /// r² \[m²\].
    pub square: L,
    /// Velocity v_ij \[m/s\].
    pub v_x: L,
    /// Velocity v_ij \[m/s\].
    pub v_y: L,
    /// Density of the neighbours \[kg/m³\].
    pub density: L,
    /// Pressure of the neighbours \[Pa\].
    pub pressure: L,
    /// Volume per depth of the neighbours \[m²\].
    pub volume: L,
}

impl<L: Lanes> Batch<L> {
    /// The neighbours `indices` of `own` among `others`.
    #[inline(always)]
    pub fn gather<G: Geometry>(geometry: G, own: &[L; 4], others: &[Record], indices: [u32; WIDTH]) -> Self {
        let [a, b, c, d] = indices.map(|j| &others[j as usize]);
        let [x_j, y_j, v_xj, v_yj] = L::columns([&a.motion, &b.motion, &c.motion, &d.motion]);
        let [density, pressure, volume, _] = L::columns([&a.matter, &b.matter, &c.matter, &d.matter]);
        let [x_i, y_i, v_xi, v_yi] = *own;
        let (x, y) = (geometry.nearest(x_i - x_j, 0), geometry.nearest(y_i - y_j, 1));
        let square = (x * x).plus_product(y, y);
        Self { x, y, square, v_x: v_xi - v_xj, v_y: v_yi - v_yj, density, pressure, volume }
    }
}

/// One number of each neighbour of a batch.
#[inline(always)]
pub fn gather<L: Lanes>(indices: [u32; WIDTH], values: &[f64]) -> L {
    L::from_array(indices.map(|j| values[j as usize]))
}

/// Four numbers of each neighbour of a batch.
#[inline(always)]
pub fn gather_columns<L: Lanes>(indices: [u32; WIDTH], values: &[[f64; 4]]) -> [L; 4] {
    let [a, b, c, d] = indices.map(|j| &values[j as usize]);
    L::columns([a, b, c, d])
}

#[cfg(test)]
mod tests {
    use sph::lanes::{Arithmetic, Kernel};

    use super::*;

    /// Separations of four neighbours in a batch.
    struct Separations(Periodic, Record, [Record; WIDTH]);

    impl Kernel for Separations {
        type Output = [[f64; WIDTH]; 2];

        #[inline(always)]
        fn run<L: Lanes>(self) -> [[f64; WIDTH]; 2] {
            let batch = Batch::gather(self.0, &L::splat_each(self.1.motion), &self.2, [0, 1, 2, 3]);
            [batch.x.to_array(), batch.y.to_array()]
        }
    }

    #[test]
    fn periodic_separation_is_that_of_the_domain() {
        let domain =
            Domain { lower: Vector::new(-0.3, 0.0), upper: Vector::new(0.7, 0.5), periodic: [true, false] };
        let geometry = Periodic::new(&domain);
        let record = |x: &Vector| Record::new(x, &Vector::zeros(), 1.0, 0.0, 1.0);
        let others = [(-0.28, 0.49), (0.68, 0.0), (0.1, 0.2), (0.2, 0.3)].map(|(x, y)| Vector::new(x, y));
        for (x, y) in [(-0.29, 0.1), (0.69, 0.4), (0.2, 0.0), (0.71, 0.9), (-0.31, 0.3)] {
            let x_i = Vector::new(x, y);
            for arithmetic in Arithmetic::all() {
                let [x, y] = arithmetic.run(Separations(geometry, record(&x_i), others.map(|x| record(&x))));
                for (l, other) in others.iter().enumerate() {
                    let expected = domain.separation(&x_i, other);
                    assert_eq!(geometry.separation(&record(&x_i), &record(other)), expected);
                    assert_eq!(Vector::new(x[l], y[l]), expected);
                }
            }
        }
    }
}
