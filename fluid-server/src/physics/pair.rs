//! The pair laws Eq. (17)-(19) and (22)-(24).

use sph::kernel::CubicSpline;
use sph::lanes::Lanes;
use sph::vector::Vector;

use super::record::Batch;
use super::viscosity::drag;

/// Distances below this fraction of h count as this fraction: keeps 1/r finite at r = 0, where the factor of x_ij
/// stays right to 1e-8.
const SMALLEST_RATIO: f64 = 1e-8;

/// The gradient of the cubic spline, Eq. (11), in a form without branches.
#[derive(Clone, Copy, Debug)]
pub struct PairKernel {
    inverse_h: f64,
    norm: f64,
}

impl PairKernel {
    /// The gradient of `kernel` times `scale`, which is 1/M where the lattice moment M corrects it.
    pub fn new(kernel: &CubicSpline, scale: f64) -> Self {
        let inverse_h = 1.0 / kernel.smoothing_length();
        let norm = scale * 10.0 / (7.0 * std::f64::consts::PI) * inverse_h.powi(4);
        Self { inverse_h, norm }
    }

    /// Its constants in lanes.
    #[inline(always)]
    pub fn lanes<L: Lanes>(&self) -> KernelLanes<L> {
        KernelLanes {
            inverse_h: L::splat(self.inverse_h),
            smallest: L::splat(SMALLEST_RATIO),
            inner: L::splat(3.0 * self.norm),
            outer: L::splat(0.75 * self.norm),
        }
    }
}

/// [`PairKernel`] in lanes.
#[derive(Clone, Copy, Debug)]
pub struct KernelLanes<L> {
    inverse_h: L,
    smallest: L,
    inner: L,
    outer: L,
}

impl<L: Lanes> KernelLanes<L> {
    /// s and s h⁴·7π/10·(dW/dr)/r at r² \[m²\]; the second is exactly zero from 2h on.
    ///
    /// ```text
    /// h⁴·7π/10·(dW/dr)/r = [3·max(1−s, 0)² − 3/4·max(2−s, 0)²]/s,  s = r/h
    /// ```
    #[inline(always)]
    pub fn slope(&self, square: L) -> (L, L) {
        let s = (self.inverse_h * square.sqrt()).max(self.smallest);
        let outer = (L::splat(2.0) - s).max(L::zero());
        let inner = (L::splat(1.0) - s).max(L::zero());
        let slope = self.inner * (inner * inner);
        (s, slope.minus_product(self.outer * outer, outer))
    }

    /// (dW/dr)/r \[1/m⁴\] at r² \[m²\], so that ∇_i W_ij is this times x_ij; exactly zero from 2h on.
    #[inline(always)]
    pub fn gradient_factor(&self, square: L) -> L {
        let (s, slope) = self.slope(square);
        slope / s
    }
}

/// Constants of the pair laws between fluid particles.
#[derive(Clone, Copy, Debug)]
pub struct PairLaw {
    /// Kernel gradient.
    pub kernel: PairKernel,
    /// Smoothing length h \[m\].
    pub smoothing_length: f64,
    /// λh² \[m²\].
    pub regularisation: f64,
    /// A c₀ \[m/s\].
    pub viscosity_a: f64,
    /// B \[-\].
    pub viscosity_b: f64,
}

impl PairLaw {
    /// The constants in lanes.
    #[inline(always)]
    pub fn lanes<L: Lanes>(&self) -> LawLanes<L> {
        LawLanes {
            kernel: self.kernel.lanes(),
            smoothing_length: L::splat(self.smoothing_length),
            regularisation: L::splat(self.regularisation),
            viscosity_a: L::splat(self.viscosity_a),
            viscosity_b: L::splat(self.viscosity_b),
        }
    }
}

/// [`PairLaw`] in lanes.
#[derive(Clone, Copy, Debug)]
pub struct LawLanes<L> {
    kernel: KernelLanes<L>,
    smoothing_length: L,
    regularisation: L,
    viscosity_a: L,
    viscosity_b: L,
}

/// Symmetric 2 × 2 matrix: components 11, 12, 22.
pub type Symmetric = [f64; 3];

/// 2 × 2 matrix by rows.
pub type Matrix = [f64; 4];

/// Unit matrix.
pub const IDENTITY: Symmetric = [1.0, 0.0, 1.0];

/// What particle i brings into its pairs, the same in each lane.
#[derive(Clone, Copy, Debug)]
pub struct Own<L> {
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

/// What the viscous pair force needs of a batch; zero where there is none.
#[derive(Clone, Copy, Debug)]
pub struct Friction<L> {
    /// μ_i + μ_j \[Pa s\].
    pub viscosity: L,
    /// The part of v_ij that viscosity resists \[m/s\].
    pub slip: [L; 2],
}

/// What the pass before the rates has found of a batch.
#[derive(Clone, Copy, Debug)]
pub struct Found<L> {
    /// ∇ρ \[kg/m⁴\].
    pub density_gradient: [L; 2],
    /// T_j \[Pa\].
    pub tensor: [L; 4],
    /// Viscosity.
    pub friction: Friction<L>,
}

impl<L: Lanes> Found<L> {
    /// Nothing.
    #[inline(always)]
    pub fn nothing() -> Self {
        let zero = L::zero();
        let friction = Friction { viscosity: zero, slip: [zero; 2] };
        Self { density_gradient: [zero; 2], tensor: [zero; 4], friction }
    }
}

/// What a pair sum computes besides its plain terms.
pub trait Terms: Copy + Send + Sync {
    /// Results of the pass before the rates that neighbours read: ψ of Eq. (19) has its bracket. Without, ψ is that
    /// of Molteni & Colagrossi (2009).
    const FOUND: bool;
    /// Each particle carries T = −σ·L instead of a pressure.
    const TENSOR: bool;
    /// Eq. (17).
    const CONTINUITY: bool;
    /// L_i in it.
    const CORRECTION: bool;
    /// A viscous pair force.
    const VISCOUS: bool;
}

/// [`Terms`] by flags.
#[derive(Clone, Copy, Debug)]
pub struct With<
    const FOUND: bool,
    const TENSOR: bool,
    const CONTINUITY: bool,
    const CORRECTION: bool,
    const VISCOUS: bool,
>;

impl<
    const FOUND: bool,
    const TENSOR: bool,
    const CONTINUITY: bool,
    const CORRECTION: bool,
    const VISCOUS: bool,
> Terms for With<FOUND, TENSOR, CONTINUITY, CORRECTION, VISCOUS>
{
    const FOUND: bool = FOUND;
    const TENSOR: bool = TENSOR;
    const CONTINUITY: bool = CONTINUITY;
    const CORRECTION: bool = CORRECTION;
    const VISCOUS: bool = VISCOUS;
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
    pub fn add<T: Terms>(&mut self, law: &LawLanes<L>, own: &Own<L>, batch: &Batch<L>, found: &Found<L>) {
        let Batch { x, y, square, v_x, v_y, density, pressure, volume } = *batch;
        let rho = own.density;
        let approach = (v_x * x).plus_product(v_y, y);

        // One division for 1/s of the kernel, 1/(x² + λh²) and 1/(ρ_i + ρ_j).
        let (s, slope) = law.kernel.slope(square);
        let (regularised, density_sum) = (square + law.regularisation, rho + density);
        let both = regularised * density_sum;
        let inverse = L::splat(1.0) / (s * both);
        let weight = volume * slope * (both * inverse);
        let inverse = s * inverse;
        let regular = inverse * density_sum;

        // Π_ij of Eq. (23)-(24) times ρ_i ρ_j; θ is zero for receding pairs.
        let theta = law.smoothing_length * (approach.min(L::zero()) * regular);
        let twice_reduced = own.twice_density * density * (inverse * regularised);
        let slowed = law.viscosity_a.minus_product(law.viscosity_b, theta);
        let viscosity = theta * slowed * twice_reduced;

        let [s_x, s_y] = &mut self.stress_divergence;
        if T::TENSOR {
            let t = |k: usize| own.tensor[k] + found.tensor[k];
            *s_x = s_x.plus_product(weight, (t(0) * x).plus_product(t(1), y).minus_product(viscosity, x));
            *s_y = s_y.plus_product(weight, (t(2) * x).plus_product(t(3), y).minus_product(viscosity, y));
        } else {
            let factor = weight * (own.pressure + pressure - viscosity);
            *s_x = s_x.plus_product(factor, x);
            *s_y = s_y.plus_product(factor, y);
        }
        if T::VISCOUS {
            let [x, y] = drag(found.friction.viscosity, weight, found.friction.slip);
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

        let mut psi = own.twice_density.minus_product(L::splat(2.0), density) * (square * regular);
        if T::FOUND {
            let [g_x, g_y] = own.density_gradient;
            let [g_xj, g_yj] = found.density_gradient;
            psi = psi.minus_product(g_x + g_xj, x).minus_product(g_y + g_yj, y);
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

#[cfg(test)]
mod tests {
    use sph::lanes::{Arithmetic, Kernel, WIDTH};

    use super::*;

    /// (dW/dr)/r at four distances.
    struct Factor(PairKernel, [f64; WIDTH]);

    impl Kernel for Factor {
        type Output = [f64; WIDTH];

        #[inline(always)]
        fn run<L: Lanes>(self) -> [f64; WIDTH] {
            self.0.lanes().gradient_factor(L::from_array(self.1.map(|r| r * r))).to_array()
        }
    }

    #[test]
    fn the_branchless_gradient_is_that_of_the_kernel() {
        let kernel = CubicSpline::new(0.036);
        for (arithmetic, k) in Arithmetic::all().flat_map(|arithmetic| (0..300).map(move |k| (arithmetic, k)))
        {
            let r = 3e-4 * f64::from(k);
            let expected = 0.5 * kernel.gradient_factor(r);
            let [found, others @ ..] = arithmetic.run(Factor(PairKernel::new(&kernel, 0.5), [r; WIDTH]));
            assert_eq!(others, [found; 3]);
            // Round-off of a difference of two terms of size 1/s; 1e-8 at r = 0 by the floor of s.
            let allowed = if k == 0 { 1e-7 } else { 1e-11 };
            assert!((found - expected).abs() <= allowed * kernel.gradient_factor(0.0).abs(), "at {r}");
            if r >= 0.072 {
                assert_eq!(found, 0.0);
            }
        }
    }
}
