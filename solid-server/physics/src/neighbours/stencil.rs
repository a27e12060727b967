//! Sums of a total-Lagrangian body over its fixed neighbours, four at a time.

use sph::lanes::{LanePass, Lanes, WIDTH};
use sph::space::geometry::Geometry;
use sph::space::{Tensor, Vector};

/// Four neighbours of one particle; entries that fill up the last batch have no weight.
#[derive(Clone, Copy, Debug)]
pub struct Batch {
    pub neighbours: [u32; WIDTH],
    /// a_ij \[-\].
    pub weight: [f64; WIDTH],
    /// a_ij X_ij \[m\], by axis.
    pub arm: [[f64; WIDTH]; 2],
}

/// Neighbours of each particle of a body, in batches.
#[derive(Debug)]
pub struct Stencils {
    /// End of each row.
    ends: Vec<u32>,
    batches: Vec<Batch>,
}

/// A neighbour with its weight a_ij \[-\] and reference separation X_ij \[m\].
pub type Neighbour = (u32, f64, Vector);

impl Stencils {
    /// No particles yet.
    pub fn new() -> Self {
        Self { ends: Vec::new(), batches: Vec::new() }
    }

    /// Adds a particle with its neighbours.
    pub fn push(&mut self, mut neighbours: impl Iterator<Item = Neighbour>) {
        // Its own index: a particle that every sum may read.
        let own = self.ends.len() as u32;
        while let Some(first) = neighbours.next() {
            let mut batch = Batch { neighbours: [own; WIDTH], weight: [0.0; WIDTH], arm: [[0.0; WIDTH]; 2] };
            let rest = neighbours.by_ref().take(WIDTH - 1);
            for (lane, (j, weight, separation)) in std::iter::once(first).chain(rest).enumerate() {
                batch.neighbours[lane] = j;
                batch.weight[lane] = weight;
                for axis in 0..2 {
                    batch.arm[axis][lane] = weight * separation[axis];
                }
            }
            self.batches.push(batch);
        }
        // Batches of one body stay far below 2^32.
        self.ends.push(self.batches.len() as u32);
    }

    #[inline(always)]
    pub fn of(&self, i: usize) -> &[Batch] {
        let start = if i == 0 { 0 } else { self.ends[i - 1] };
        &self.batches[start as usize..self.ends[i] as usize]
    }
}

/// Four rows of `values`.
#[inline(always)]
pub fn vectors<L: Lanes>(values: &[Vector], indices: [u32; WIDTH]) -> [L; 2] {
    let [a, b, c, d] = indices.map(|j| &values[j as usize].data.0[0]);
    L::halves([a, b, c, d])
}

/// x_ij \[m\] of the neighbours of a particle at `own`.
#[inline(always)]
pub fn separations<L: Lanes, G: Geometry>(
    geometry: G,
    own: &[L; 2],
    position: &[Vector],
    batch: &Batch,
) -> [L; 2] {
    let [x, y] = vectors::<L>(position, batch.neighbours);
    geometry.nearest([own[0] - x, own[1] - y])
}

/// A vector in each lane.
#[inline(always)]
pub fn splat<L: Lanes>(vector: &Vector) -> [L; 2] {
    [L::splat(vector.x), L::splat(vector.y)]
}

/// Σ_j a_ij x_ij ⊗ X_ij of particles from `first` on.
pub struct MomentPass<'a, G> {
    pub geometry: G,
    pub stencils: &'a Stencils,
    /// Positions of the whole body \[m\].
    pub position: &'a [Vector],
    pub first: usize,
    pub sums: &'a mut [Tensor],
}

impl<G: Geometry> LanePass for MomentPass<'_, G> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        for (k, sum) in self.sums.iter_mut().enumerate() {
            let i = self.first + k;
            let own = splat(&self.position[i]);
            let mut moments = [L::zero(); 4];
            for batch in self.stencils.of(i) {
                let [x, y] = separations(self.geometry, &own, self.position, batch);
                let arm = batch.arm.map(L::from_array);
                let [xx, yx, xy, yy] = &mut moments;
                *xx = xx.plus_product(x, arm[0]);
                *yx = yx.plus_product(y, arm[0]);
                *xy = xy.plus_product(x, arm[1]);
                *yy = yy.plus_product(y, arm[1]);
            }
            let [xx, yx, xy, yy] = L::sums(moments);
            *sum = Tensor::new(xx, xy, yx, yy);
        }
    }
}
