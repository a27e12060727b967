//! What a pair sum reads of a particle, the separation of a pair, and the pair laws Eq. (17)-(19) and (22)-(24).

use sph::domain::Domain;
use sph::kernel::CubicSpline;

use super::lanes::{LANES, Lanes};
use super::viscosity::drag;

/// Distances below this fraction of h count as this fraction: keeps 1/r finite at r = 0, where the factor of x_ij
/// stays right to 1e-8.
const SMALLEST_RATIO: f64 = 1e-8;

/// State of a particle as its neighbours read it: one cache line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(align(64))]
pub struct Record {
    /// Position x \[m\].
    pub x: f64,
    /// Position y \[m\].
    pub y: f64,
    /// Velocity x \[m/s\].
    pub v_x: f64,
    /// Velocity y \[m/s\].
    pub v_y: f64,
    /// Density ρ \[kg/m³\].
    pub density: f64,
    /// Pressure p \[Pa\].
    pub pressure: f64,
    /// Volume per depth V = m/ρ \[m²\]; zero for a particle that does not act.
    pub volume: f64,
}

/// Nearest images; open and periodic boxes are different types, so that open ones pay nothing.
pub trait Geometry: Copy + Send + Sync {
    /// Difference of coordinates along `axis` \[m\], to the nearest image.
    fn nearest(self, difference: Lanes, axis: usize) -> Lanes;

    /// x_ij = x_i − x_j \[m\] of the nearest images.
    fn separation(self, i: &Record, j: &Record) -> [f64; 2];
}

/// A box without periodic directions.
#[derive(Clone, Copy, Debug)]
pub struct Open;

impl Geometry for Open {
    #[inline(always)]
    fn nearest(self, difference: Lanes, _axis: usize) -> Lanes {
        difference
    }

    #[inline(always)]
    fn separation(self, i: &Record, j: &Record) -> [f64; 2] {
        [i.x - j.x, i.y - j.y]
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
    fn nearest(self, difference: Lanes, axis: usize) -> Lanes {
        difference.wrapped(self.half[axis], self.period[axis])
    }

    #[inline(always)]
    fn separation(self, i: &Record, j: &Record) -> [f64; 2] {
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
        [nearest(i.x - j.x, 0), nearest(i.y - j.y, 1)]
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

    /// (dW/dr)/r \[1/m⁴\] at r² \[m²\], so that ∇_i W_ij is this times x_ij; exactly zero from 2h on.
    ///
    /// ```text
    /// h⁴·7π/10·(dW/dr)/r = [3·max(1−s, 0)² − 3/4·max(2−s, 0)²]/s,  s = r/h
    /// ```
    #[inline(always)]
    pub fn gradient_factor(&self, square: Lanes) -> Lanes {
        let s = (self.inverse_h * square.sqrt()).at_least(SMALLEST_RATIO);
        let outer = (Lanes::splat(2.0) - s).at_least(0.0);
        let inner = (Lanes::splat(1.0) - s).at_least(0.0);
        (3.0 * self.norm * (inner * inner) - 0.75 * self.norm * (outer * outer)) / s
    }
}

/// A batch of neighbours as particle i meets them.
#[derive(Clone, Copy, Debug, Default)]
pub struct Batch {
    /// x_ij \[m\].
    pub x: Lanes,
    /// y_ij \[m\].
    pub y: Lanes,
    /// Velocity v_ij \[m/s\].
    pub v_x: Lanes,
    /// Velocity v_ij \[m/s\].
    pub v_y: Lanes,
    /// Density of the neighbours \[kg/m³\].
    pub density: Lanes,
    /// Pressure of the neighbours \[Pa\].
    pub pressure: Lanes,
    /// Volume per depth of the neighbours \[m²\].
    pub volume: Lanes,
}

impl Batch {
    /// The neighbours `indices` of `own` among `others`; lanes from `count` on have no volume.
    #[inline(always)]
    pub fn gather<G: Geometry>(
        geometry: G,
        own: &Record,
        others: &[Record],
        indices: [u32; LANES],
        count: usize,
    ) -> Self {
        let records = indices.map(|j| &others[j as usize]);
        let counted = Lanes::from_fn(|l| if l < count { 1.0 } else { 0.0 });
        Self {
            x: geometry.nearest(Lanes::splat(own.x) - Lanes::from_fn(|l| records[l].x), 0),
            y: geometry.nearest(Lanes::splat(own.y) - Lanes::from_fn(|l| records[l].y), 1),
            v_x: Lanes::splat(own.v_x) - Lanes::from_fn(|l| records[l].v_x),
            v_y: Lanes::splat(own.v_y) - Lanes::from_fn(|l| records[l].v_y),
            density: Lanes::from_fn(|l| records[l].density),
            pressure: Lanes::from_fn(|l| records[l].pressure),
            volume: counted * Lanes::from_fn(|l| records[l].volume),
        }
    }

    /// r² \[m²\].
    #[inline(always)]
    pub fn square(&self) -> Lanes {
        self.x * self.x + self.y * self.y
    }
}

/// One vector or matrix per neighbour of a batch.
#[inline(always)]
pub fn gather<const N: usize>(indices: [u32; LANES], values: impl Fn(usize) -> [f64; N]) -> [Lanes; N] {
    let mut rows = [[0.0; N]; LANES];
    for (row, j) in rows.iter_mut().zip(indices) {
        *row = values(j as usize);
    }
    std::array::from_fn(|k| Lanes::from_fn(|l| rows[l][k]))
}

/// Calls `visit` for each batch of `neighbours`, with how many of its lanes count; the last one repeats an index.
#[inline(always)]
pub fn for_each_batch(neighbours: &[u32], mut visit: impl FnMut([u32; LANES], usize)) {
    // One call, so that it is inlined.
    for batch in neighbours.chunks(LANES) {
        let indices = batch.first_chunk().copied().unwrap_or_else(|| {
            let mut indices = [batch[0]; LANES];
            indices[..batch.len()].copy_from_slice(batch);
            indices
        });
        visit(indices, batch.len());
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
    /// Whether there is a viscous pair force.
    pub viscous: bool,
}

/// Symmetric 2 × 2 matrix: components 11, 12, 22.
pub type Symmetric = [f64; 3];

/// 2 × 2 matrix by rows.
pub type Matrix = [f64; 4];

/// Unit matrix.
pub const IDENTITY: Symmetric = [1.0, 0.0, 1.0];

/// What particle i brings into its pairs besides its record.
#[derive(Clone, Copy, Debug)]
pub struct Own<'a> {
    /// State.
    pub record: &'a Record,
    /// ∇ρ of Eq. (20) \[kg/m⁴\].
    pub density_gradient: [f64; 2],
    /// T = −σ·L \[Pa\].
    pub tensor: Matrix,
    /// L_i of Eq. (21) in (17), or the unit matrix.
    pub correction: Symmetric,
}

/// What the viscous pair force needs of a batch; zero where there is none.
#[derive(Clone, Copy, Debug, Default)]
pub struct Friction {
    /// μ_i + μ_j \[Pa s\].
    pub viscosity: Lanes,
    /// The part of v_ij that viscosity resists \[m/s\].
    pub slip: [Lanes; 2],
}

/// The sums (17), (18) and (22) of one particle i, batch by batch.
///
/// With `GRADIENT`, ψ of Eq. (19) has its bracket; without, it is that of Molteni & Colagrossi (2009). With
/// `TENSOR`, each particle carries T = −σ·L instead of a pressure.
#[derive(Clone, Copy, Debug, Default)]
pub struct PairSums<const GRADIENT: bool, const TENSOR: bool> {
    continuity: Lanes,
    diffusion: Lanes,
    stress_divergence: [Lanes; 2],
}

impl<const GRADIENT: bool, const TENSOR: bool> PairSums<GRADIENT, TENSOR> {
    /// Adds the neighbours of `batch` with their density gradients, T_j and viscosity.
    #[inline(always)]
    pub fn add(
        &mut self,
        law: &PairLaw,
        own: &Own,
        batch: &Batch,
        density_gradient: [Lanes; 2],
        tensor: [Lanes; 4],
        friction: Friction,
    ) {
        let Batch { x, y, v_x, v_y, density, pressure, volume } = *batch;
        let rho = Lanes::splat(own.record.density);
        let square = batch.square();
        let weight = volume * law.kernel.gradient_factor(square);
        let approach = v_x * x + v_y * y;

        // One division for 1/(x² + λh²) and 1/(ρ_i + ρ_j).
        let (regularised, density_sum) = (square + Lanes::splat(law.regularisation), rho + density);
        let inverse = Lanes::splat(1.0) / (regularised * density_sum);
        let regular = inverse * density_sum;

        // Π_ij of Eq. (23)-(24) times ρ_i ρ_j; θ is zero for receding pairs.
        let theta = law.smoothing_length * (approach.at_most(0.0) * regular);
        let twice_reduced = 2.0 * (rho * density) * (inverse * regularised);
        let viscosity = theta * (law.viscosity_b * theta - Lanes::splat(law.viscosity_a)) * twice_reduced;

        if TENSOR {
            let t: [Lanes; 4] = std::array::from_fn(|k| Lanes::splat(own.tensor[k]) + tensor[k]);
            self.stress_divergence[0] += weight * (t[0] * x + t[1] * y + viscosity * x);
            self.stress_divergence[1] += weight * (t[2] * x + t[3] * y + viscosity * y);
        } else {
            let factor = weight * (Lanes::splat(own.record.pressure) + pressure + viscosity);
            self.stress_divergence[0] += factor * x;
            self.stress_divergence[1] += factor * y;
        }
        if law.viscous {
            let [x, y] = drag(friction.viscosity, weight, friction.slip);
            self.stress_divergence[0] += x;
            self.stress_divergence[1] += y;
        }
        let l = &own.correction;
        self.continuity += weight * (v_x * (l[0] * x + l[1] * y) + v_y * (l[1] * x + l[2] * y));

        let mut psi = 2.0 * (rho - density) * (square * regular);
        if GRADIENT {
            let [g_x, g_y] = own.density_gradient;
            psi -=
                (Lanes::splat(g_x) + density_gradient[0]) * x + (Lanes::splat(g_y) + density_gradient[1]) * y;
        }
        self.diffusion += weight * psi;
    }

    /// Σ V_j v_ij·∇W \[1/s\].
    #[inline(always)]
    pub fn continuity(&self) -> f64 {
        self.continuity.sum()
    }

    /// Σ V_j ψ_ij·∇W \[kg/m⁵\].
    #[inline(always)]
    pub fn diffusion(&self) -> f64 {
        self.diffusion.sum()
    }

    /// Σ V_j [T_i + T_j + ρ_i ρ_j Π_ij]·∇W \[Pa/m\]: −ρ_i times the acceleration.
    #[inline(always)]
    pub fn stress_divergence(&self) -> [f64; 2] {
        self.stress_divergence.map(Lanes::sum)
    }
}

#[cfg(test)]
mod tests {
    use sph::vector::Vector;

    use super::*;

    #[test]
    fn the_branchless_gradient_is_that_of_the_kernel() {
        let kernel = CubicSpline::new(0.036);
        let pair_kernel = PairKernel::new(&kernel, 0.5);
        for k in 0..300 {
            let r = 3e-4 * f64::from(k);
            let expected = 0.5 * kernel.gradient_factor(r);
            let found = pair_kernel.gradient_factor(Lanes::splat(r * r)).sum() / LANES as f64;
            // Round-off of a difference of two terms of size 1/s; 1e-8 at r = 0 by the floor of s.
            let allowed = if k == 0 { 1e-7 } else { 1e-11 };
            assert!((found - expected).abs() <= allowed * kernel.gradient_factor(0.0).abs(), "at {r}");
            if r >= 0.072 {
                assert_eq!(found, 0.0);
            }
        }
    }

    #[test]
    fn periodic_separation_is_that_of_the_domain() {
        let domain =
            Domain { lower: Vector::new(-0.3, 0.0), upper: Vector::new(0.7, 0.5), periodic: [true, false] };
        let geometry = Periodic::new(&domain);
        for (x, y) in [(-0.29, 0.1), (0.69, 0.4), (0.2, 0.0), (0.71, 0.9), (-0.31, 0.3)] {
            for (u, w) in [(-0.28, 0.49), (0.68, 0.0), (0.1, 0.2)] {
                let i = Record { x, y, ..Record::default() };
                let j = Record { x: u, y: w, ..Record::default() };
                let expected = domain.separation(&Vector::new(x, y), &Vector::new(u, w));
                assert_eq!(geometry.separation(&i, &j), [expected.x, expected.y]);
                let batch = Batch::gather(geometry, &i, &[j], [0; LANES], LANES);
                assert_eq!((batch.x, batch.y), (Lanes::splat(expected.x), Lanes::splat(expected.y)));
            }
        }
    }
}
