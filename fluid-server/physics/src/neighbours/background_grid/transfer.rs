//! Transfer of sums and means between particles and nodes, with cubic B-splines as weights.

use std::marker::PhantomData;

use sph::lanes::{Arithmetic, LanePass, Lanes, WIDTH};
use sph::space::Space;
use sph::space::algebra::Algebra;

use super::{Axis, BackgroundGrid, STENCIL, floor};

/// Coefficients of the weights on four nodes, by powers of t: the particle lies the fraction t of the spacing behind the
/// second node.
const CUBIC: [[f64; WIDTH]; 4] = [
    [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0, 0.0],
    [-0.5, 0.0, 0.5, 0.0],
    [0.5, -1.0, 0.5, 0.0],
    [-1.0 / 6.0, 0.5, -0.5, 1.0 / 6.0],
];

impl BackgroundGrid {
    /// Adds to `nodes`, the first of which has the index `origin`, the value of each particle by its weights.
    /// `particles` are positions \[m\], inside the box along periodic axes, and values. Particles far from all fluid
    /// have no weight.
    pub fn spread<S: Space>(
        &self,
        arithmetic: Arithmetic,
        particles: impl Iterator<Item = (S::Vector, f64)>,
        nodes: &mut [f64],
        origin: usize,
    ) {
        if let Some(stencils) = Stencils::<S>::of(self) {
            arithmetic.run(Spread { stencils, particles, nodes, origin });
        }
    }

    /// The means of `nodes` by the weights of particles at `positions` \[m\], in `means`; zero far from all fluid.
    pub fn read<'a, S: Space>(
        &self,
        arithmetic: Arithmetic,
        positions: impl Iterator<Item = S::Vector>,
        nodes: &[f64],
        means: impl Iterator<Item = &'a mut f64>,
    ) {
        if let Some(stencils) = Stencils::<S>::of(self) {
            arithmetic.run(Read { stencils, particles: positions.zip(means), nodes });
        }
    }

    /// Marks the nodes, the first of which has the index `origin`, on which particles at `positions` \[m\] have weights.
    pub fn mark<S: Space>(
        &self,
        positions: impl Iterator<Item = S::Vector>,
        nodes: &mut [bool],
        origin: usize,
    ) {
        let Some(stencils) = Stencils::<S>::of(self) else { return };
        for x in positions {
            let Some((first, _)) = stencils.locate(&x) else { continue };
            for k in 0..Stencils::<S>::ROWS {
                nodes[first + stencils.offset(k) - origin..][..STENCIL].fill(true);
            }
        }
    }
}

/// Where the weights of particles lie.
#[derive(Clone, Copy)]
struct Stencils<'a, S: Space> {
    axes: <S as Algebra>::Of<AxisView>,
    /// The entries of [`Axis::shifts`] of each axis.
    shifts: &'a [Axis],
    space: PhantomData<S>,
}

/// What the search for nodes reads of an [`Axis`].
#[derive(Clone, Copy, Debug)]
struct AxisView {
    origin: f64,
    inverse_spacing: f64,
    stride: usize,
}

impl<'a, S: Space> Stencils<'a, S> {
    /// Rows of [`STENCIL`] nodes that follow each other along the first axis.
    const ROWS: usize = STENCIL.pow(S::DIMENSIONS as u32 - 1);

    /// `None` where `grid` has no nodes.
    fn of(grid: &'a BackgroundGrid) -> Option<Self> {
        let shifts = &grid.axes[..];
        let view = |axis: &Axis| AxisView {
            origin: axis.origin,
            inverse_spacing: axis.inverse_spacing,
            stride: axis.stride,
        };
        (shifts.len() == S::DIMENSIONS).then(|| Self {
            axes: S::axes(|axis| view(&shifts[axis])),
            shifts,
            space: PhantomData,
        })
    }

    /// The first of the nodes of a particle at `x` \[m\], and the fraction of the spacing by which it lies behind the
    /// second along each axis; `None` where no fluid is near.
    #[inline(always)]
    fn locate(&self, x: &S::Vector) -> Option<(usize, S::Of<f64>)> {
        let (mut first, mut fractions) = (0, S::splat(0.0));
        // A loop: the closure of `S::axes` is not compiled for the instructions of the lanes.
        for axis in 0..S::DIMENSIONS {
            let AxisView { origin, inverse_spacing, stride } = self.axes[axis];
            let position = (x[axis] - origin) * inverse_spacing;
            let below = floor(position);
            first += (below - 1 + self.shifts[axis].shift(x[axis])?) as usize * stride;
            fractions[axis] = position - below as f64;
        }
        Some((first, fractions))
    }

    /// Index of the first node of row `k` less that of the stencil.
    #[inline(always)]
    fn offset(&self, k: usize) -> usize {
        let (mut offset, mut rest) = (0, k);
        for axis in 1..S::DIMENSIONS {
            offset += rest % STENCIL * self.axes[axis].stride;
            rest /= STENCIL;
        }
        offset
    }

    /// Weights along the first axis, and the products of those along the others for each row.
    #[inline(always)]
    fn weights<L: Lanes>(fractions: S::Of<f64>) -> (L, S::Of<[f64; STENCIL]>) {
        let mut across = S::splat([0.0; STENCIL]);
        for axis in 1..S::DIMENSIONS {
            across[axis] = cubic::<L>(fractions[axis]).to_array();
        }
        (cubic(fractions[0]), across)
    }

    /// Product of the weights `across` the first axis of row `k`.
    #[inline(always)]
    fn weight(across: &S::Of<[f64; STENCIL]>, k: usize) -> f64 {
        let (mut weight, mut rest) = (1.0, k);
        for axis in 1..S::DIMENSIONS {
            weight *= across[axis][rest % STENCIL];
            rest /= STENCIL;
        }
        weight
    }
}

/// The cubic B-spline at four nodes, see [`CUBIC`].
#[inline(always)]
fn cubic<L: Lanes>(t: f64) -> L {
    let [constant, linear, square, cube] = CUBIC;
    let t = L::splat(t);
    let inner = L::from_array(square).plus_product(t, L::from_array(cube));
    L::from_array(constant).plus_product(t, L::from_array(linear).plus_product(t, inner))
}

struct Spread<'a, S: Space, I> {
    stencils: Stencils<'a, S>,
    particles: I,
    nodes: &'a mut [f64],
    origin: usize,
}

impl<S: Space, I: Iterator<Item = (S::Vector, f64)>> LanePass for Spread<'_, S, I> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { stencils, particles, nodes, origin } = self;
        for (x, value) in particles {
            let Some((first, fractions)) = stencils.locate(&x) else { continue };
            let (along, across) = Stencils::<S>::weights::<L>(fractions);
            let along = along * L::splat(value);
            for k in 0..Stencils::<S>::ROWS {
                if let Some(row) = nodes[first + stencils.offset(k) - origin..].first_chunk_mut::<STENCIL>() {
                    let weight = L::splat(Stencils::<S>::weight(&across, k));
                    *row = L::from_array(*row).plus_product(along, weight).to_array();
                }
            }
        }
    }
}

struct Read<'a, S: Space, I> {
    stencils: Stencils<'a, S>,
    particles: I,
    nodes: &'a [f64],
}

impl<'m, S: Space, I: Iterator<Item = (S::Vector, &'m mut f64)>> LanePass for Read<'_, S, I> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { stencils, particles, nodes } = self;
        for (x, mean) in particles {
            *mean = 0.0;
            let Some((first, fractions)) = stencils.locate(&x) else { continue };
            let (along, across) = Stencils::<S>::weights::<L>(fractions);
            let mut sum = L::zero();
            for k in 0..Stencils::<S>::ROWS {
                if let Some(row) = nodes[first + stencils.offset(k)..].first_chunk::<STENCIL>() {
                    sum = sum.plus_product(L::from_array(*row), L::splat(Stencils::<S>::weight(&across, k)));
                }
            }
            let [a, b, c, d] = (sum * along).to_array();
            *mean = (a + b) + (c + d);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Weights(f64);

    impl LanePass for Weights {
        type Output = [f64; WIDTH];

        fn run<L: Lanes>(self) -> [f64; WIDTH] {
            cubic::<L>(self.0).to_array()
        }
    }

    #[test]
    fn weights_sum_to_one_and_have_the_place_of_the_particle_as_their_mean() {
        for t in [0.0, 0.25, 0.7, 0.999] {
            let weights = Arithmetic::best().run(Weights(t));
            let mean: f64 = weights.iter().zip(-1..).map(|(weight, k)| weight * f64::from(k)).sum();
            assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-15 && (mean - t).abs() < 1e-15, "{t}");
        }
    }
}
