//! Sums over the neighbours of a particle for Eq. (4), (20)-(21) and the particle regularisation.

use sph::kernel::KernelLanes;
use sph::lanes::Lanes;
use sph::space::Vector;

use super::anti_pairing::Ratio;
use super::tensors::{Matrix, Symmetric};
use crate::neighbours::batch::NeighbourBatch;

/// Raw sums over the neighbours of one particle.
#[derive(Clone, Copy, Debug, Default)]
pub struct NeighbourSums {
    /// Σ V_j (x_j − x_i) ⊗ ∇W \[-\], the inverse of L_i in Eq. (21).
    pub moment: Symmetric,
    /// Σ V_j (ρ_j − ρ_i) ∇W \[kg/m⁴\].
    pub density: [f64; 2],
    /// Σ V_j (v_j − v_i) ⊗ ∇W over own particles \[1/s\].
    pub velocity: Matrix,
    /// The same over another owner's particles \[1/s\].
    pub solid_velocity: Matrix,
    /// Share of another owner's particles in the moments: ½ Σ V_j (x_j − x_i)·∇W over them \[-\].
    pub solid_share: f64,
    /// Σ V_j ∇W \[1/m\].
    pub concentration: [f64; 2],
    /// Σ V_j R (W/W(Δx))⁴ ∇W \[1/m\].
    pub pairing: [f64; 2],
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

/// [`NeighbourSums`] being gathered, batch by batch.
#[derive(Clone, Copy, Debug)]
pub struct LaneSums<L> {
    moment: [L; 3],
    density: [L; 2],
    velocity: [L; 4],
    concentration: [L; 2],
    pairing: [L; 2],
    square_speed: L,
}

impl<L: Lanes> LaneSums<L> {
    /// Sums over nothing.
    #[inline(always)]
    pub fn zero() -> Self {
        let zero = L::zero();
        Self {
            moment: [zero; 3],
            density: [zero; 2],
            velocity: [zero; 4],
            concentration: [zero; 2],
            pairing: [zero; 2],
            square_speed: zero,
        }
    }

    /// Adds the neighbours of `batch`, all of one `kind`, to a particle of density `rho`.
    #[inline(always)]
    pub fn add<W: SumSelection>(
        &mut self,
        law: &SumKernel<L>,
        rho: L,
        batch: &NeighbourBatch<L>,
        kind: NeighbourKind,
    ) {
        let NeighbourBatch { x, y, square, v_x, v_y, density, volume, .. } = *batch;
        let (s, slope) = law.kernel.slope(square);
        let weight = volume * slope / s;
        let (weight_x, weight_y) = (weight * x, weight * y);
        if W::MOMENTS {
            let [xx, xy, yy] = &mut self.moment;
            *xx = xx.minus_product(weight_x, x);
            *xy = xy.minus_product(weight_x, y);
            *yy = yy.minus_product(weight_y, y);
            let difference = density - rho;
            let [d_x, d_y] = &mut self.density;
            *d_x = d_x.plus_product(difference, weight_x);
            *d_y = d_y.plus_product(difference, weight_y);
        }
        if W::VELOCITY {
            // v_j − v_i = −v_ij
            let [xx, xy, yx, yy] = &mut self.velocity;
            *xx = xx.minus_product(v_x, weight_x);
            *xy = xy.minus_product(v_x, weight_y);
            *yx = yx.minus_product(v_y, weight_x);
            *yy = yy.minus_product(v_y, weight_y);
        }
        if W::REGULARISATION {
            let factor = law.ratio.pairing(s);
            self.concentration = [self.concentration[0] + weight_x, self.concentration[1] + weight_y];
            let [p_x, p_y] = &mut self.pairing;
            *p_x = p_x.plus_product(factor, weight_x);
            *p_y = p_y.plus_product(factor, weight_y);
            if kind == NeighbourKind::Fluid {
                // 1 up to r = h, from there falling to 0 at 2h.
                let nearness = (L::splat(2.0) - s).max(L::zero()).min(L::splat(1.0));
                let square_speed = (v_x * v_x).plus_product(v_y, v_y);
                self.square_speed = self.square_speed.max(nearness * nearness * square_speed);
            }
        }
    }

    /// The sums over all batches.
    #[inline(always)]
    pub fn total<W: SumSelection>(&self) -> NeighbourSums {
        let mut sums = NeighbourSums::default();
        if W::MOMENTS {
            let [a, b, c] = self.moment;
            let [d, e] = self.density;
            let [xx, xy, yy, d_x] = L::sums([a, b, c, d]);
            sums.moment = [xx, xy, yy];
            let [p_x, p_y] = self.pairing;
            let [d_y, p_x, p_y, _] = L::sums([e, p_x, p_y, L::zero()]);
            (sums.density, sums.pairing) = ([d_x, d_y], [p_x, p_y]);
        }
        if W::VELOCITY {
            sums.velocity = L::sums(self.velocity);
        }
        if W::REGULARISATION {
            let [x, y] = self.concentration;
            let [x, y, _, _] = L::sums([x, y, L::zero(), L::zero()]);
            sums.concentration = [x, y];
            sums.square_speed = self.square_speed.to_array().into_iter().fold(0.0, f64::max);
        }
        sums
    }
}

impl NeighbourSums {
    /// Adds one neighbour of another owner at separation `d` = x_ij \[m\], with `weight` = V_j (dW/dr)/r \[1/m²\],
    /// ρ_j − ρ_i \[kg/m³\], v_j − v_i \[m/s\] and the factor R (W/W(Δx))⁴.
    pub fn add_pair(&mut self, d: &Vector, weight: f64, density: f64, velocity: &Vector, pairing: f64) {
        let w = d * weight;
        for (sum, term) in self.moment.iter_mut().zip([w.x * d.x, w.x * d.y, w.y * d.y]) {
            *sum -= term;
        }
        self.solid_share -= 0.5 * w.dot(d);
        let v = velocity;
        add(&mut self.density, &[density * w.x, density * w.y]);
        add(&mut self.solid_velocity, &[v.x * w.x, v.x * w.y, v.y * w.x, v.y * w.y]);
        add(&mut self.concentration, &[w.x, w.y]);
        add(&mut self.pairing, &[pairing * w.x, pairing * w.y]);
    }

    /// Adds the sums over another owner's particles.
    pub fn merge(&mut self, other: &Self) {
        add(&mut self.moment, &other.moment);
        add(&mut self.density, &other.density);
        add(&mut self.solid_velocity, &other.solid_velocity);
        add(&mut self.concentration, &other.concentration);
        add(&mut self.pairing, &other.pairing);
        self.solid_share += other.solid_share;
    }

    /// Half the trace of the moment matrix: 1 for complete and even neighbours \[-\].
    pub fn mean_moment(&self) -> f64 {
        0.5 * (self.moment[0] + self.moment[2])
    }

    /// Determinant of the moment matrix, and its inverse where that is not zero.
    pub fn inverse(&self) -> (f64, Symmetric) {
        let [xx, xy, yy] = self.moment;
        let determinant = xx * yy - xy * xy;
        let inverse = 1.0 / determinant;
        (determinant, [yy * inverse, -xy * inverse, xx * inverse])
    }

    /// ∇v before correction, another owner's particles included \[1/s\].
    pub fn velocity_gradient(&self) -> Matrix {
        let mut gradient = self.velocity;
        add(&mut gradient, &self.solid_velocity);
        gradient
    }
}

fn add(own: &mut [f64], other: &[f64]) {
    own.iter_mut().zip(other).for_each(|(a, b)| *a += b);
}
