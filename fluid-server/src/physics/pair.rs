//! What a pair sum reads of a particle, the separation of a pair, and the pair laws Eq. (17)-(19) and (22)-(24).

use sph::domain::Domain;
use sph::kernel::CubicSpline;
use sph::lanes::{Lanes, WIDTH};
use sph::vector::Vector;

use super::viscosity::drag;

/// Distances below this fraction of h count as this fraction: keeps 1/r finite at r = 0, where the factor of x_ij
/// stays right to 1e-8.
const SMALLEST_RATIO: f64 = 1e-8;

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
    /// L_i in Eq. (17).
    const CORRECTION: bool;
    /// A viscous pair force.
    const VISCOUS: bool;
}

/// [`Terms`] by flags.
#[derive(Clone, Copy, Debug)]
pub struct With<const FOUND: bool, const TENSOR: bool, const CORRECTION: bool, const VISCOUS: bool>;

impl<const FOUND: bool, const TENSOR: bool, const CORRECTION: bool, const VISCOUS: bool> Terms
    for With<FOUND, TENSOR, CORRECTION, VISCOUS>
{
    const FOUND: bool = FOUND;
    const TENSOR: bool = TENSOR;
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
        let flux = if T::CORRECTION {
            let l = &own.correction;
            let (l_x, l_y) = ((l[0] * x).plus_product(l[1], y), (l[1] * x).plus_product(l[2], y));
            (v_x * l_x).plus_product(v_y, l_y)
        } else {
            approach
        };
        self.continuity = self.continuity.plus_product(weight, flux);

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
    use sph::lanes::{Arithmetic, Kernel};

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
