//! The pair laws Eq. (17)-(19) and (22)-(24).

use sph::kernel::KernelLanes;
use sph::lanes::Lanes;
use sph::laws::artificial_viscosity::ArtificialViscosity;
use sph::space::Vector;

use super::diffusion::{bracketed, plain};
use super::terms::PairTerms;
use super::viscosity::drag;
use crate::neighbours::batch::NeighbourBatch;
use crate::system::model::PairLaw;

/// [`PairLaw`] in lanes.
#[derive(Clone, Copy, Debug)]
pub struct LawLanes<L> {
    kernel: KernelLanes<L>,
    viscosity: ArtificialViscosity<L>,
}

impl<L: Lanes> LawLanes<L> {
    /// The constants of `law` in each lane.
    #[inline(always)]
    pub fn new(law: &PairLaw) -> Self {
        Self { kernel: law.kernel.lanes(), viscosity: law.viscosity.lanes() }
    }
}

/// Particle i of all pairs, the same in each lane.
#[derive(Clone, Copy, Debug)]
pub struct CentreParticle<L> {
    /// x, y \[m\], v_x, v_y \[m/s\].
    pub motion: [L; 4],
    /// ρ \[kg/m³\].
    pub density: L,
    /// 2ρ \[kg/m³\].
    pub twice_density: L,
    /// p with damper \[Pa\].
    pub pressure: L,
    /// ∇ρ of Eq. (20) \[kg/m⁴\].
    pub density_gradient: [L; 2],
    /// T = −σ·L \[Pa\].
    pub tensor: [L; 4],
    /// L_i of Eq. (21) in (17), or the unit matrix.
    pub correction: [L; 3],
}

/// Input of the viscous pair force for a batch; zero where there is none.
#[derive(Clone, Copy, Debug)]
pub struct PairViscosity<L> {
    /// μ_i + μ_j \[Pa s\].
    pub viscosity: L,
    /// The part of v_ij that viscosity resists \[m/s\].
    pub relative_velocity: [L; 2],
}

/// Results of the gradient pass for a batch of neighbours.
#[derive(Clone, Copy, Debug)]
pub struct NeighbourData<L> {
    /// ∇ρ \[kg/m⁴\].
    pub density_gradient: [L; 2],
    /// T_j \[Pa\].
    pub tensor: [L; 4],
    /// Viscosity.
    pub viscosity: PairViscosity<L>,
}

impl<L: Lanes> NeighbourData<L> {
    /// Nothing.
    #[inline(always)]
    pub fn nothing() -> Self {
        let zero = L::zero();
        let viscosity = PairViscosity { viscosity: zero, relative_velocity: [zero; 2] };
        Self { density_gradient: [zero; 2], tensor: [zero; 4], viscosity }
    }
}

/// The sums (17), (18) and (22) of one particle i, batch by batch.
#[derive(Clone, Copy, Debug)]
pub struct PairSums<L> {
    continuity: L,
    diffusion: L,
    stress_divergence: [L; 2],
}

/// [`PairSums`] over all batches.
#[derive(Clone, Copy, Debug, Default)]
pub struct PairTotals {
    /// Σ V_j v_ij·∇W \[1/s\].
    pub continuity: f64,
    /// Σ V_j ψ_ij·∇W \[kg/m⁵\].
    pub diffusion: f64,
    /// Σ V_j [T_i + T_j + ρ_i ρ_j Π_ij]·∇W \[Pa/m\]: −ρ_i times the acceleration.
    pub stress_divergence: Vector,
}

impl<L: Lanes> PairSums<L> {
    /// Sums over nothing.
    #[inline(always)]
    pub fn zero() -> Self {
        let zero = L::zero();
        Self { continuity: zero, diffusion: zero, stress_divergence: [zero; 2] }
    }

    /// Adds the neighbours of `batch`.
    #[inline(always)]
    pub fn add<T: PairTerms>(
        &mut self,
        law: &LawLanes<L>,
        own: &CentreParticle<L>,
        batch: &NeighbourBatch<L>,
        data: &NeighbourData<L>,
    ) {
        let NeighbourBatch { x, y, square, v_x, v_y, density, pressure, volume } = *batch;
        let rho = own.density;
        let approach = (v_x * x).plus_product(v_y, y);

        // One division for 1/s of the kernel, 1/(x² + λh²) and 1/(ρ_i + ρ_j).
        let (s, slope) = law.kernel.slope(square);
        let (regularised, density_sum) = (law.viscosity.regularised(square), rho + density);
        let both = regularised * density_sum;
        let inverse = L::splat(1.0) / (s * both);
        let weight = volume * slope * (both * inverse);
        let inverse = s * inverse;
        let regular = inverse * density_sum;

        // ρ_i ρ_j Π_ij of Eq. (23), with ρ_i ρ_j/ρ̄ = 2 ρ_i ρ_j/(ρ_i + ρ_j).
        let twice_reduced = own.twice_density * density * (inverse * regularised);
        let viscosity = law.viscosity.pressure_over_density(approach * regular) * twice_reduced;

        let [s_x, s_y] = &mut self.stress_divergence;
        if T::TENSOR {
            let t = |k: usize| own.tensor[k] + data.tensor[k];
            *s_x = s_x.plus_product(weight, (t(0) * x).plus_product(t(1), y).plus_product(viscosity, x));
            *s_y = s_y.plus_product(weight, (t(2) * x).plus_product(t(3), y).plus_product(viscosity, y));
        } else {
            let factor = weight * (own.pressure + pressure + viscosity);
            *s_x = s_x.plus_product(factor, x);
            *s_y = s_y.plus_product(factor, y);
        }
        if T::VISCOUS {
            let [x, y] = drag(data.viscosity.viscosity, weight, data.viscosity.relative_velocity);
            *s_x = *s_x + x;
            *s_y = *s_y + y;
        }
        if T::CONTINUITY {
            let flux = if T::CORRECTION {
                let l = &own.correction;
                let (l_x, l_y) = ((l[0] * x).plus_product(l[1], y), (l[1] * x).plus_product(l[2], y));
                (v_x * l_x).plus_product(v_y, l_y)
            } else {
                approach
            };
            self.continuity = self.continuity.plus_product(weight, flux);
        }

        let mut psi = plain(own.twice_density, density, square * regular);
        if T::NEIGHBOUR_FIELDS {
            let [g_x, g_y] = own.density_gradient;
            let [g_xj, g_yj] = data.density_gradient;
            psi = bracketed(psi, [g_x + g_xj, g_y + g_yj], [x, y]);
        }
        self.diffusion = self.diffusion.plus_product(weight, psi);
    }

    /// The sums over all batches.
    #[inline(always)]
    pub fn total(&self) -> PairTotals {
        let [x, y] = self.stress_divergence;
        let [continuity, diffusion, x, y] = L::sums([self.continuity, self.diffusion, x, y]);
        PairTotals { continuity, diffusion, stress_divergence: Vector::new(x, y) }
    }
}
