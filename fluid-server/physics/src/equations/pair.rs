//! The pair laws Eq. (17)-(19) and (22)-(24).

use std::ops::AddAssign;

use sph::kernel::KernelLanes;
use sph::lanes::Lanes;
use sph::laws::artificial_viscosity::ArtificialViscosity;
use sph::space::Space;

use super::artificial_pressure::ArtificialPressure;
use super::diffusion::{bracketed, plain};
use super::residual_approach::ResidualApproach;
use super::terms::PairTerms;
use super::viscosity::drag;
use crate::neighbours::batch::NeighbourBatch;
use crate::system::model::FluidModel;
use crate::system::packed_particle::{FluidSpace, LaneMotion};

/// The pair laws of a fluid in lanes.
#[derive(Clone, Copy, Debug)]
pub struct LawLanes<L> {
    kernel: KernelLanes<L>,
    viscosity: ArtificialViscosity<L>,
    residual_approach: ResidualApproach<L>,
    artificial_pressure: ArtificialPressure<L>,
}

impl<L: Lanes> LawLanes<L> {
    /// The laws of `model`.
    #[inline(always)]
    pub fn new<S: FluidSpace>(model: &FluidModel<S>) -> Self {
        Self {
            kernel: model.law.kernel.lanes(),
            viscosity: model.law.viscosity.lanes(),
            residual_approach: ResidualApproach::new(model),
            artificial_pressure: ArtificialPressure::new(model),
        }
    }
}

/// Particle i of all pairs, the same in each lane.
#[derive(Clone, Copy, Debug)]
pub struct CentreParticle<S: Space, L: Lanes> {
    /// Position and velocity.
    pub motion: LaneMotion<S, L>,
    /// ρ \[kg/m³\].
    pub density: L,
    /// 2ρ \[kg/m³\].
    pub twice_density: L,
    /// p with damper \[Pa\].
    pub pressure: L,
    /// ∇ρ of Eq. (20) \[kg/m⁴\].
    pub density_gradient: S::Of<L>,
    /// T = −σ·L \[Pa\].
    pub tensor: S::Matrix<L>,
    /// L_i of Eq. (21) in (17), or the unit matrix.
    pub correction: S::Symmetric<L>,
    /// Rate of strain D, where artificial viscosity takes it \[1/s\].
    pub strain_rate: S::Symmetric<L>,
}

/// Input of the viscous pair force for a batch; zero where there is none.
#[derive(Clone, Copy, Debug)]
pub struct PairViscosity<S: Space, L: Lanes> {
    /// μ_i + μ_j \[Pa s\].
    pub viscosity: L,
    /// The part of v_ij that viscosity resists \[m/s\].
    pub relative_velocity: S::Of<L>,
}

/// Results of the gradient pass for a batch of neighbours.
#[derive(Clone, Copy, Debug)]
pub struct NeighbourData<S: Space, L: Lanes> {
    /// ∇ρ \[kg/m⁴\].
    pub density_gradient: S::Of<L>,
    /// T_j \[Pa\].
    pub tensor: S::Matrix<L>,
    /// Viscosity.
    pub viscosity: PairViscosity<S, L>,
    /// Rate of strain \[1/s\].
    pub strain_rate: S::Symmetric<L>,
}

impl<S: Space, L: Lanes> NeighbourData<S, L> {
    /// Nothing.
    #[inline(always)]
    pub fn nothing() -> Self {
        let zero = S::splat(L::zero());
        let viscosity = PairViscosity { viscosity: L::zero(), relative_velocity: zero };
        Self { density_gradient: zero, tensor: S::zero_matrix(), viscosity, strain_rate: S::zero_symmetric() }
    }
}

/// The sums (17), (18) and (22) of one particle i, batch by batch.
#[derive(Clone, Copy, Debug)]
pub struct PairSums<S: Space, L: Lanes> {
    continuity: L,
    diffusion: L,
    stress_divergence: S::Of<L>,
    artificial: S::Of<L>,
    drag: S::Of<L>,
    clumping: S::Of<L>,
}

/// [`PairSums`] over all batches.
#[derive(Clone, Copy, Debug, Default)]
pub struct PairTotals<S: Space> {
    /// Σ V_j v_ij·∇W \[1/s\].
    pub continuity: f64,
    /// Σ V_j ψ_ij·∇W \[kg/m⁵\].
    pub diffusion: f64,
    /// Σ V_j [T_i + T_j + ρ_i ρ_j Π_ij]·∇W \[Pa/m\]: −ρ_i times the acceleration.
    pub stress_divergence: S::Vector,
}

/// Parts of the stress divergence \[Pa/m\]; the rest is that of pressure and viscous stress.
#[derive(Clone, Copy, Debug, Default)]
pub struct PairParts<S: Space> {
    /// Artificial viscosity.
    pub artificial: S::Vector,
    /// The viscous pair force.
    pub drag: S::Vector,
    /// Artificial pressure.
    pub clumping: S::Vector,
}

impl<S: Space> AddAssign for PairParts<S> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        self.artificial += other.artificial;
        self.drag += other.drag;
        self.clumping += other.clumping;
    }
}

impl<S: FluidSpace, L: Lanes> PairSums<S, L> {
    /// Sums over nothing.
    #[inline(always)]
    pub fn zero() -> Self {
        let (zero, none) = (L::zero(), S::splat(L::zero()));
        Self {
            continuity: zero,
            diffusion: zero,
            stress_divergence: none,
            artificial: none,
            drag: none,
            clumping: none,
        }
    }

    /// Adds the neighbours of `batch`.
    #[inline(always)]
    pub fn add<T: PairTerms>(
        &mut self,
        law: &LawLanes<L>,
        own: &CentreParticle<S, L>,
        batch: &NeighbourBatch<S, L>,
        data: &NeighbourData<S, L>,
    ) {
        let NeighbourBatch { x, square, v, density, pressure, volume } = *batch;
        let rho = own.density;
        let approach = S::dot(v, x);

        // One division for 1/s of the kernel, 1/(x² + λh²) and 1/(ρ_i + ρ_j).
        let (s, slope) = law.kernel.slope(square);
        let (softened, density_sum) = (law.viscosity.softened(square), rho + density);
        let both = softened * density_sum;
        let inverse = L::splat(1.0) / (s * both);
        let weight = volume * slope * (both * inverse);
        let inverse = s * inverse;
        let regular = inverse * density_sum;

        // ρ_i ρ_j Π_ij of Eq. (23), with ρ_i ρ_j/ρ̄ = 2 ρ_i ρ_j/(ρ_i + ρ_j).
        let twice_reduced = own.twice_density * density * (inverse * softened);
        let of_viscosity = if law.residual_approach.acts() {
            let strain = S::symmetric_plus(own.strain_rate, data.strain_rate);
            let residual = law.residual_approach.of::<S>(approach, strain, x, square);
            law.viscosity.of_residual(approach * regular, residual * regular)
        } else {
            law.viscosity.pressure_over_density(approach * regular)
        };
        let mut isotropic = of_viscosity * twice_reduced;
        self.artificial = S::plus_product(self.artificial, weight * isotropic, x);
        if law.artificial_pressure.acts() {
            let clumping = law.artificial_pressure.at(s, own.pressure, pressure);
            isotropic = isotropic + clumping;
            self.clumping = S::plus_product(self.clumping, weight * clumping, x);
        }

        let mut divergence = self.stress_divergence;
        divergence = if T::TENSOR {
            let stress = S::matrix_times(S::matrix_plus(own.tensor, data.tensor), x);
            S::plus_product(divergence, weight, S::plus_product(stress, isotropic, x))
        } else {
            S::plus_product(divergence, weight * (own.pressure + pressure + isotropic), x)
        };
        if T::VISCOUS {
            let PairViscosity { viscosity, relative_velocity } = data.viscosity;
            let drag = drag::<S, L>(viscosity, weight, relative_velocity);
            divergence = S::plus(divergence, drag);
            self.drag = S::plus(self.drag, drag);
        }
        self.stress_divergence = divergence;
        if T::CONTINUITY {
            let flux = S::dot(v, S::symmetric_times(own.correction, x));
            self.continuity = self.continuity.plus_product(weight, flux);
        }

        let mut psi = plain(own.twice_density, density, square * regular);
        if T::NEIGHBOUR_FIELDS {
            psi = bracketed::<S, L>(psi, S::plus(own.density_gradient, data.density_gradient), x);
        }
        self.diffusion = self.diffusion.plus_product(weight, psi);
    }

    /// The sums over all batches.
    #[inline(always)]
    pub fn total(&self) -> PairTotals<S> {
        let (divergence, [continuity, diffusion]) =
            S::sums_with(self.stress_divergence, [self.continuity, self.diffusion]);
        PairTotals { continuity, diffusion, stress_divergence: S::vector(divergence) }
    }

    /// The parts of the stress divergence over all batches, by the `law` that made them.
    #[inline(always)]
    pub fn parts(&self, law: &LawLanes<L>) -> PairParts<S> {
        let [artificial, drag] = S::vector_sums(self.artificial, self.drag);
        let mut parts =
            PairParts { artificial: S::vector(artificial), drag: S::vector(drag), ..Default::default() };
        if law.artificial_pressure.acts() {
            let [clumping, _] = S::vector_sums(self.clumping, S::splat(L::zero()));
            parts.clumping = S::vector(clumping);
        }
        parts
    }
}
