//! Sums of a total-Lagrangian body over its fixed neighbours, four at a time.

use sph::lanes::{LanePass, Lanes, WIDTH};
use sph::space::Space;
use sph::space::geometry::Geometry;

use crate::space::SolidSpace;

/// Four neighbours of one particle; entries that fill up the last batch have no weight.
#[derive(Clone, Copy, Debug)]
pub struct Batch<S: SolidSpace> {
    pub neighbours: [u32; WIDTH],
    /// a_ij \[-\].
    pub weight: [f64; WIDTH],
    /// a_ij X_ij \[m\], by axis.
    pub arm: S::Of<[f64; WIDTH]>,
}

/// Neighbours of each particle of a body, in batches.
#[derive(Debug)]
pub struct Stencils<S: SolidSpace> {
    /// End of each row.
    ends: Vec<u32>,
    batches: Vec<Batch<S>>,
}

/// A neighbour with its weight a_ij \[-\] and reference separation X_ij \[m\].
pub type Neighbour<S> = (u32, f64, <S as Space>::Vector);

impl<S: SolidSpace> Stencils<S> {
    /// No particles yet.
    pub fn new() -> Self {
        Self { ends: Vec::new(), batches: Vec::new() }
    }

    /// Adds a particle with its neighbours.
    pub fn push(&mut self, mut neighbours: impl Iterator<Item = Neighbour<S>>) {
        // Its own index: a particle that every sum may read.
        let own = self.ends.len() as u32;
        while let Some(first) = neighbours.next() {
            let mut batch =
                Batch::<S> { neighbours: [own; WIDTH], weight: [0.0; WIDTH], arm: S::splat([0.0; WIDTH]) };
            let rest = neighbours.by_ref().take(WIDTH - 1);
            for (lane, (j, weight, separation)) in std::iter::once(first).chain(rest).enumerate() {
                batch.neighbours[lane] = j;
                batch.weight[lane] = weight;
                for axis in 0..S::DIMENSIONS {
                    batch.arm[axis][lane] = weight * separation[axis];
                }
            }
            self.batches.push(batch);
        }
        // Batches of one body stay far below 2^32.
        self.ends.push(self.batches.len() as u32);
    }

    #[inline(always)]
    pub fn of(&self, i: usize) -> &[Batch<S>] {
        let start = if i == 0 { 0 } else { self.ends[i - 1] };
        &self.batches[start as usize..self.ends[i] as usize]
    }
}

impl<S: SolidSpace> Batch<S> {
    /// a_ij X_ij \[m\].
    #[inline(always)]
    pub fn arms<L: Lanes>(&self) -> S::Of<L> {
        let mut arms = S::splat(L::zero());
        for axis in 0..S::DIMENSIONS {
            arms[axis] = L::from_array(self.arm[axis]);
        }
        arms
    }
}

/// Four of `values`.
#[inline(always)]
pub fn four<S: SolidSpace, L: Lanes>(values: &[S::Vector], indices: [u32; WIDTH]) -> S::Of<L> {
    S::lanes(indices.map(|j| &values[j as usize]))
}

/// Σ_j a_ij x_ij ⊗ X_ij of particles from `first` on.
pub struct MomentPass<'a, G, S: SolidSpace> {
    pub geometry: G,
    pub stencils: &'a Stencils<S>,
    /// Positions of the whole body \[m\].
    pub position: &'a [S::Vector],
    pub first: usize,
    pub sums: &'a mut [S::Tensor],
}

impl<G: Geometry<S>, S: SolidSpace> LanePass for MomentPass<'_, G, S> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        for (k, sum) in self.sums.iter_mut().enumerate() {
            let i = self.first + k;
            let own = S::splat_vector(&self.position[i]);
            let mut moment = S::zero_matrix::<L>();
            for batch in self.stencils.of(i) {
                let x_ij =
                    self.geometry.nearest(S::minus(own, four::<S, L>(self.position, batch.neighbours)));
                moment = S::plus_outer(moment, x_ij, batch.arms());
            }
            *sum = S::tensor(S::matrix_sums(moment));
        }
    }
}
