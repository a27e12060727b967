//! What a pair sum reads of a particle, the separation of a pair, and the pair laws Eq. (17)-(19) and (22)-(24).

use sph::domain::Domain;
use sph::kernel::CubicSpline;

/// Distances below this fraction of h count as this fraction: keeps 1/r finite at r = 0, where the factor of x_ij
/// stays right to 1e-8.
const SMALLEST_RATIO: f64 = 1e-8;

/// The larger of `value` and zero; unlike `f64::max` one instruction, as NaN needs no care here.
#[inline(always)]
fn positive(value: f64) -> f64 {
    if value > 0.0 { value } else { 0.0 }
}

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

/// Separation of two particles; open and periodic boxes are different types, so that open ones pay nothing.
pub trait Geometry: Copy + Send + Sync {
    /// x_ij = x_i − x_j \[m\] of the nearest images.
    fn separation(self, i: &Record, j: &Record) -> [f64; 2];
}

/// A box without periodic directions.
#[derive(Clone, Copy, Debug)]
pub struct Open;

impl Geometry for Open {
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

    #[inline(always)]
    fn nearest(self, d: f64, axis: usize) -> f64 {
        let period = self.period[axis];
        if d > self.half[axis] {
            d - period
        } else if d < -self.half[axis] {
            d + period
        } else {
            d
        }
    }
}

impl Geometry for Periodic {
    #[inline(always)]
    fn separation(self, i: &Record, j: &Record) -> [f64; 2] {
        [self.nearest(i.x - j.x, 0), self.nearest(i.y - j.y, 1)]
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
    pub fn gradient_factor(&self, square: f64) -> f64 {
        let ratio = square.sqrt() * self.inverse_h;
        let s = if ratio > SMALLEST_RATIO { ratio } else { SMALLEST_RATIO };
        let outer = positive(2.0 - s);
        let inner = positive(1.0 - s);
        self.norm * (3.0 * inner * inner - 0.75 * outer * outer) / s
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

/// Symmetric 2 × 2 matrix: components 11, 12, 22.
pub type Symmetric = [f64; 3];

/// 2 × 2 matrix by rows.
pub type Matrix = [f64; 4];

/// Unit matrix.
pub const IDENTITY: Symmetric = [1.0, 0.0, 1.0];

/// The sums (17), (18) and (22) of one particle i, neighbour by neighbour.
///
/// With `GRADIENT`, ψ of Eq. (19) has its bracket; without, it is that of Molteni & Colagrossi (2009). With
/// `TENSOR`, each particle carries T = −σ·L instead of a pressure and (17) uses L_i.
pub struct PairSums<'a, const GRADIENT: bool, const TENSOR: bool> {
    law: &'a PairLaw,
    own: &'a Record,
    density_gradient: [f64; 2],
    tensor: Matrix,
    correction: Symmetric,
    /// Σ V_j v_ij·∇W \[1/s\].
    pub continuity: f64,
    /// Σ V_j ψ_ij·∇W \[kg/m⁵\].
    pub diffusion: f64,
    /// Σ V_j [T_i + T_j + ρ_i ρ_j Π_ij]·∇W \[Pa/m\]: −ρ_i times the acceleration.
    pub stress_divergence: [f64; 2],
}

impl<'a, const GRADIENT: bool, const TENSOR: bool> PairSums<'a, GRADIENT, TENSOR> {
    /// Empty sums of the particle `own` with its density gradient, T_i and L_i.
    #[inline(always)]
    pub fn new(
        law: &'a PairLaw,
        own: &'a Record,
        density_gradient: [f64; 2],
        tensor: Matrix,
        correction: Symmetric,
    ) -> Self {
        Self {
            law,
            own,
            density_gradient,
            tensor,
            correction,
            continuity: 0.0,
            diffusion: 0.0,
            stress_divergence: [0.0; 2],
        }
    }

    /// Adds neighbour `other` at separation `d` = x_ij with its density gradient and T_j.
    #[inline(always)]
    pub fn add(&mut self, d: [f64; 2], other: &Record, density_gradient: [f64; 2], tensor: Matrix) {
        let (i, j, law) = (self.own, other, self.law);
        let [x, y] = d;
        let square = x * x + y * y;
        let weight = j.volume * law.kernel.gradient_factor(square);
        let regular = 1.0 / (square + law.regularisation);
        let (v_x, v_y) = (i.v_x - j.v_x, i.v_y - j.v_y);
        let approach = v_x * x + v_y * y;

        // Π_ij of Eq. (23)-(24) times ρ_i ρ_j; θ is zero for receding pairs.
        let theta = if approach < 0.0 { approach * law.smoothing_length * regular } else { 0.0 };
        let viscosity = theta * (law.viscosity_b * theta - law.viscosity_a) * 2.0 * i.density * j.density
            / (i.density + j.density);

        if TENSOR {
            let t: [f64; 4] = std::array::from_fn(|k| self.tensor[k] + tensor[k]);
            self.stress_divergence[0] += weight * (t[0] * x + t[1] * y + viscosity * x);
            self.stress_divergence[1] += weight * (t[2] * x + t[3] * y + viscosity * y);
            let l = &self.correction;
            self.continuity += weight * (v_x * (l[0] * x + l[1] * y) + v_y * (l[1] * x + l[2] * y));
        } else {
            let factor = weight * (i.pressure + j.pressure + viscosity);
            self.stress_divergence[0] += factor * x;
            self.stress_divergence[1] += factor * y;
            self.continuity += weight * approach;
        }

        let mut psi = 2.0 * (i.density - j.density) * square * regular;
        if GRADIENT {
            let own = self.density_gradient;
            psi -= (own[0] + density_gradient[0]) * x + (own[1] + density_gradient[1]) * y;
        }
        self.diffusion += weight * psi;
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
            let found = pair_kernel.gradient_factor(r * r);
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
            }
        }
    }
}
