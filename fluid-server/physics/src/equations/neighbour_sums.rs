//! Sums over the neighbours of a particle for Eq. (4), (20)-(21) and the particle regularisation.

use sph::kernel::KernelLanes;
use sph::lanes::Lanes;
use sph::space::tensors::SpaceVector;
use sph::space::{Plane, Space};

use super::anti_pairing::Ratio;
use crate::neighbours::batch::NeighbourBatch;
use crate::system::packed_particle::FluidSpace;

/// Raw sums over the neighbours of one particle.
#[derive(Clone, Copy, Debug)]
pub struct NeighbourSums<S: Space = Plane> {
    /// Σ V_j (x_j − x_i) ⊗ ∇W \[-\], the inverse of L_i in Eq. (21).
    pub moment: S::Symmetric<f64>,
    /// Σ V_j (ρ_j − ρ_i) ∇W \[kg/m⁴\].
    pub density: S::Of<f64>,
    /// Σ V_j (v_j − v_i) ⊗ ∇W over own particles \[1/s\].
    pub velocity: S::Matrix<f64>,
    /// The same over another owner's particles \[1/s\].
    pub solid_velocity: S::Matrix<f64>,
    /// Share of another owner's particles in the mean moment: Σ V_j (x_j − x_i)·∇W/d over them, d the number of
    /// dimensions \[-\].
    pub solid_share: f64,
    /// Σ V_j ∇W \[1/m\].
    pub concentration: S::Of<f64>,
    /// Σ V_j R (W/W(Δx))⁴ ∇W \[1/m\].
    pub pairing: S::Of<f64>,
    /// Largest |v_ij|² of fluid neighbours, fading out between h and 2h \[m²/s²\].
    pub square_speed: f64,
}

/// The sums that a pass computes.
pub trait SumSelection: Copy + Send + Sync {
    /// Moments and density gradient.
    const MOMENTS: bool;
    /// Velocity gradient.
    const VELOCITY: bool;
    /// Sums of the particle regularisation.
    const REGULARISATION: bool;
}

/// [`SumSelection`] by flags.
#[derive(Clone, Copy, Debug)]
pub struct Selected<const MOMENTS: bool, const VELOCITY: bool, const REGULARISATION: bool>;

impl<const MOMENTS: bool, const VELOCITY: bool, const REGULARISATION: bool> SumSelection
    for Selected<MOMENTS, VELOCITY, REGULARISATION>
{
    const MOMENTS: bool = MOMENTS;
    const VELOCITY: bool = VELOCITY;
    const REGULARISATION: bool = REGULARISATION;
}

/// Kind of the neighbours of a batch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NeighbourKind {
    /// Fluid particles.
    Fluid,
    /// Wall particles.
    Wall,
}

/// The kernel and its ratio in lanes.
pub struct SumKernel<L> {
    /// The gradient.
    pub kernel: KernelLanes<L>,
    /// W/W(Δx).
    pub ratio: Ratio<L>,
}

/// Prepared batches at a time.
pub const BATCHES: usize = 16;

/// What sums take of a batch of neighbours.
#[derive(Clone, Copy, Debug)]
pub struct SumBatch<S: Space, L: Lanes> {
    /// x_ij \[m\].
    x: S::Of<L>,
    /// v_ij \[m/s\].
    v: S::Of<L>,
    /// V_j (dW/dr)/r \[1/m²\]: times x_ij it is V_j ∇W.
    weight: L,
    /// ρ_j − ρ_i \[kg/m³\].
    density: L,
    /// R (W/W(Δx))⁴ \[-\].
    pairing: L,
}

impl<S: Space, L: Lanes> SumBatch<S, L> {
    /// Nothing.
    #[inline(always)]
    pub fn nothing() -> Self {
        let zero = S::splat(L::zero());
        Self { x: zero, v: zero, weight: L::zero(), density: L::zero(), pairing: L::zero() }
    }
}

/// [`NeighbourSums`] being gathered, batch by batch.
#[derive(Clone, Copy, Debug)]
pub struct LaneSums<S: Space, L: Lanes> {
    moment: S::Symmetric<L>,
    density: S::Of<L>,
    velocity: S::Matrix<L>,
    concentration: S::Of<L>,
    pairing: S::Of<L>,
    square_speed: L,
}

impl<S: FluidSpace, L: Lanes> LaneSums<S, L> {
    /// Sums over nothing.
    #[inline(always)]
    pub fn zero() -> Self {
        let zero = S::splat(L::zero());
        Self {
            moment: S::zero_symmetric(),
            density: zero,
            velocity: S::zero_matrix(),
            concentration: zero,
            pairing: zero,
            square_speed: L::zero(),
        }
    }

    /// What the sums take of the neighbours of `batch`, all of one `kind`, for a particle of density `rho`.
    #[inline(always)]
    pub fn prepare<W: SumSelection>(
        &mut self,
        law: &SumKernel<L>,
        rho: L,
        batch: &NeighbourBatch<S, L>,
        kind: NeighbourKind,
    ) -> SumBatch<S, L> {
        let NeighbourBatch { x, square, v, density, volume, .. } = *batch;
        let (s, slope) = law.kernel.slope(square);
        let mut pairing = L::zero();
        if W::REGULARISATION {
            pairing = law.ratio.pairing(S::PAIRING, s);
            if kind == NeighbourKind::Fluid {
                // 1 up to r = h, from there falling to 0 at 2h.
                let nearness = (L::splat(2.0) - s).max(L::zero()).min(L::splat(1.0));
                self.square_speed = self.square_speed.max(nearness * nearness * S::dot(v, v));
            }
        }
        SumBatch { x, v, weight: volume * slope / s, density: density - rho, pairing }
    }

    /// Adds prepared batches, in two rounds: in one there would be more sums than registers.
    #[inline(always)]
    pub fn add<W: SumSelection>(&mut self, batches: &[SumBatch<S, L>]) {
        if W::MOMENTS || W::REGULARISATION {
            for batch in batches {
                let weighted = S::scaled(batch.x, batch.weight);
                if W::MOMENTS {
                    self.moment = S::symmetric_minus_outer(self.moment, weighted, batch.x);
                    self.density = S::plus_product(self.density, batch.density, weighted);
                }
                if W::REGULARISATION {
                    self.concentration = S::plus(self.concentration, weighted);
                    self.pairing = S::plus_product(self.pairing, batch.pairing, weighted);
                }
            }
        }
        if W::VELOCITY {
            for batch in batches {
                // v_j − v_i = −v_ij
                let weighted = S::scaled(batch.x, batch.weight);
                self.velocity = S::minus_outer(self.velocity, batch.v, weighted);
            }
        }
    }

    /// The sums over all batches.
    #[inline(always)]
    pub fn total<W: SumSelection>(&self) -> NeighbourSums<S> {
        let mut sums = NeighbourSums::default();
        if W::MOMENTS {
            sums.moment = S::symmetric_sums(self.moment);
            [sums.density, sums.pairing] = S::vector_sums(self.density, self.pairing);
        }
        if W::VELOCITY {
            sums.velocity = S::matrix_sums(self.velocity);
        }
        if W::REGULARISATION {
            [sums.concentration, _] = S::vector_sums(self.concentration, S::splat(L::zero()));
            sums.square_speed = self.square_speed.to_array().into_iter().fold(0.0, f64::max);
        }
        sums
    }
}

impl<S: Space> Default for NeighbourSums<S> {
    #[inline(always)]
    fn default() -> Self {
        Self {
            moment: S::zero_symmetric(),
            density: S::splat(0.0),
            velocity: S::zero_matrix(),
            solid_velocity: S::zero_matrix(),
            solid_share: 0.0,
            concentration: S::splat(0.0),
            pairing: S::splat(0.0),
            square_speed: 0.0,
        }
    }
}

impl<S: Space> NeighbourSums<S> {
    /// Adds one neighbour of another owner at separation `d` = x_ij \[m\], with `weight` = V_j (dW/dr)/r \[1/m²\],
    /// ρ_j − ρ_i \[kg/m³\], v_j − v_i \[m/s\] and the factor R (W/W(Δx))⁴.
    pub fn add_pair(&mut self, d: &S::Vector, weight: f64, density: f64, velocity: &S::Vector, pairing: f64) {
        let weighted = *d * weight;
        self.solid_share -= weighted.dot(d) / S::DIMENSIONS as f64;
        let w = S::components(&weighted);
        self.moment = S::symmetric_minus_outer(self.moment, w, S::components(d));
        self.density = S::plus_product(self.density, density, w);
        self.solid_velocity = S::plus_outer(self.solid_velocity, S::components(velocity), w);
        self.concentration = S::plus(self.concentration, w);
        self.pairing = S::plus_product(self.pairing, pairing, w);
    }

    /// Adds the sums over another owner's particles.
    pub fn merge(&mut self, other: &Self) {
        self.moment = S::symmetric_plus(self.moment, other.moment);
        self.density = S::plus(self.density, other.density);
        self.solid_velocity = S::matrix_plus(self.solid_velocity, other.solid_velocity);
        self.concentration = S::plus(self.concentration, other.concentration);
        self.pairing = S::plus(self.pairing, other.pairing);
        self.solid_share += other.solid_share;
    }

    /// Mean of the diagonal of the moment matrix: 1 for complete and even neighbours \[-\].
    pub fn mean_moment(&self) -> f64 {
        S::symmetric_trace(self.moment) / S::DIMENSIONS as f64
    }

    /// Determinant of the moment matrix, and its inverse where that is not zero.
    #[inline(always)]
    pub fn inverse(&self) -> (f64, S::Symmetric<f64>) {
        let determinant = S::symmetric_determinant(self.moment);
        (determinant, S::symmetric_inverse(self.moment, determinant))
    }

    /// ∇v before correction, another owner's particles included \[1/s\].
    pub fn velocity_gradient(&self) -> S::Matrix<f64> {
        S::matrix_plus(self.velocity, self.solid_velocity)
    }
}
