//! The pass before the rates: moments, renormalised density gradient and viscous stress, Eq. (4), (20)-(21).

use rayon::prelude::*;

use super::lists::Lists;
use super::model::{FluidModel, Passes};
use super::pair::{Geometry, IDENTITY, Matrix, PairKernel, Record, Symmetric};
use super::rates::TASK;

/// Below this determinant of the moment matrix the density gradient counts as zero: too few neighbours define it.
const SMALLEST_GRADIENT_DETERMINANT: f64 = 1e-3;

/// Below this determinant L_i is the unit matrix: at spray a large L_i does more harm than the error it cures.
const SMALLEST_CORRECTION_DETERMINANT: f64 = 0.3;

/// Raw sums over the neighbours of one particle.
#[derive(Clone, Copy, Debug, Default)]
pub struct MomentSums {
    /// Σ V_j (x_j − x_i) ⊗ ∇W \[-\], the inverse of L_i in Eq. (21).
    moment: Symmetric,
    /// Σ V_j (ρ_j − ρ_i) ∇W \[kg/m⁴\].
    density: [f64; 2],
    /// Σ V_j (v_j − v_i) ⊗ ∇W \[1/s\].
    velocity: Matrix,
}

impl MomentSums {
    /// Adds a neighbour at separation `d` = x_ij with ρ_j − ρ_i and v_j − v_i.
    #[inline(always)]
    pub fn add<const MOMENTS: bool, const VISCOUS: bool>(
        &mut self,
        kernel: &PairKernel,
        d: [f64; 2],
        volume: f64,
        density: f64,
        velocity: [f64; 2],
    ) {
        let [x, y] = d;
        let weight = volume * kernel.gradient_factor(x * x + y * y);
        if MOMENTS {
            self.moment[0] -= weight * x * x;
            self.moment[1] -= weight * x * y;
            self.moment[2] -= weight * y * y;
            self.density[0] += weight * density * x;
            self.density[1] += weight * density * y;
        }
        if VISCOUS {
            let [v_x, v_y] = velocity;
            self.velocity[0] += weight * v_x * x;
            self.velocity[1] += weight * v_x * y;
            self.velocity[2] += weight * v_y * x;
            self.velocity[3] += weight * v_y * y;
        }
    }

    /// Adds the sums over another owner's particles.
    pub fn merge(&mut self, other: &Self) {
        let add = |own: &mut [f64], other: &[f64]| own.iter_mut().zip(other).for_each(|(a, b)| *a += b);
        add(&mut self.moment, &other.moment);
        add(&mut self.density, &other.density);
        add(&mut self.velocity, &other.velocity);
    }

    /// Inverse of the moment matrix; `None` below the `smallest` determinant.
    fn inverse(&self, smallest: f64) -> Option<Symmetric> {
        let [xx, xy, yy] = self.moment;
        let determinant = xx * yy - xy * xy;
        (determinant >= smallest).then(|| [yy / determinant, -xy / determinant, xx / determinant])
    }
}

/// What the pass makes for each fluid particle; arrays a scene does not need stay empty.
#[derive(Debug, Default)]
pub struct Gradients {
    /// Raw sums.
    pub sums: Vec<MomentSums>,
    /// ∇ρ of Eq. (20) \[kg/m⁴\].
    pub density: Vec<[f64; 2]>,
    /// L_i of Eq. (21), or the unit matrix where it is not asked for.
    pub correction: Vec<Symmetric>,
    /// Viscous stress τ of Eq. (4) \[Pa\].
    pub viscous_stress: Vec<Symmetric>,
    /// T = −σ·L \[Pa\].
    pub tensor: Vec<Matrix>,
}

impl Gradients {
    /// Sums over fluid and walls.
    ///
    /// Walls enter with their density by Eq. (28) and their velocity by Eq. (27).
    pub fn accumulate<G: Geometry>(
        &mut self,
        geometry: G,
        model: &FluidModel,
        lists: &Lists,
        fluid: &[Record],
        walls: &[Record],
    ) {
        let Passes { viscosity, .. } = model.passes;
        match (model.passes.moments(), viscosity) {
            (false, false) => {}
            (true, false) => self.gather::<G, true, false>(geometry, model, lists, fluid, walls),
            (false, true) => self.gather::<G, false, true>(geometry, model, lists, fluid, walls),
            (true, true) => self.gather::<G, true, true>(geometry, model, lists, fluid, walls),
        }
    }

    fn gather<G: Geometry, const MOMENTS: bool, const VISCOUS: bool>(
        &mut self,
        geometry: G,
        model: &FluidModel,
        lists: &Lists,
        fluid: &[Record],
        walls: &[Record],
    ) {
        let kernel = &model.law.kernel;
        self.sums.resize(fluid.len(), MomentSums::default());
        self.sums.par_iter_mut().with_min_len(TASK).enumerate().for_each(|(i, sums)| {
            let i_record = &fluid[i];
            let mut gathered = MomentSums::default();
            let mut add = |j: &Record| {
                let d = geometry.separation(i_record, j);
                let velocity = [j.v_x - i_record.v_x, j.v_y - i_record.v_y];
                let density = j.density - i_record.density;
                gathered.add::<MOMENTS, VISCOUS>(kernel, d, j.volume, density, velocity);
            };
            lists.fluid.of(i).iter().for_each(|j| add(&fluid[*j as usize]));
            lists.walls.of(i).iter().for_each(|w| add(&walls[*w as usize]));
            *sums = gathered;
        });
    }

    /// ∇ρ from the present sums, Eq. (20).
    pub fn finish_density(&mut self, model: &FluidModel) {
        if !model.passes.density_gradient {
            return;
        }
        self.density.resize(self.sums.len(), [0.0; 2]);
        self.density.par_iter_mut().zip(&self.sums).with_min_len(TASK).for_each(|(gradient, sums)| {
            *gradient = match sums.inverse(SMALLEST_GRADIENT_DETERMINANT) {
                Some(l) => {
                    let [x, y] = sums.density;
                    [l[0] * x + l[1] * y, l[1] * x + l[2] * y]
                }
                None => [0.0; 2],
            };
        });
    }

    /// L_i, viscous stress and T from the present sums, Eq. (4) and (21).
    ///
    /// ```text
    /// τ = μ [∇v + (∇v)ᵀ − ⅔ (∇·v) I],  T = (p I − τ)·L
    /// ```
    pub fn finish_tensors(&mut self, model: &FluidModel, fluid: &[Record]) {
        let passes = model.passes;
        if !passes.tensor() {
            return;
        }
        let n = fluid.len();
        self.correction.resize(n, IDENTITY);
        self.viscous_stress.resize(n, Symmetric::default());
        self.tensor.resize(n, Matrix::default());
        let viscosity = model.constants.dynamic_viscosity;
        let results = (&mut self.correction, &mut self.viscous_stress, &mut self.tensor);
        results.into_par_iter().with_min_len(TASK).enumerate().for_each(
            |(i, (correction, stress, tensor))| {
                let sums = &self.sums[i];
                let inverse = || sums.inverse(SMALLEST_CORRECTION_DETERMINANT);
                *correction = passes.correction.then(inverse).flatten().unwrap_or(IDENTITY);
                *stress = if passes.viscosity {
                    viscous_stress(viscosity, &times(&sums.velocity, correction))
                } else {
                    Symmetric::default()
                };
                *tensor = momentum_tensor(fluid[i].pressure, stress, correction);
            },
        );
    }
}

/// τ of Eq. (4) \[Pa\] from the velocity gradient ∂v_a/∂x_b \[1/s\].
fn viscous_stress(viscosity: f64, gradient: &Matrix) -> Symmetric {
    let [xx, xy, yx, yy] = *gradient;
    let third = 2.0 / 3.0 * (xx + yy);
    [viscosity * (2.0 * xx - third), viscosity * (xy + yx), viscosity * (2.0 * yy - third)]
}

/// T = (p I − τ)·L \[Pa\].
pub fn momentum_tensor(pressure: f64, stress: &Symmetric, correction: &Symmetric) -> Matrix {
    times(&[pressure - stress[0], -stress[1], -stress[1], pressure - stress[2]], correction)
}

/// `stress` mirrored at a plane of unit `normal`; unchanged for a zero normal.
///
/// A slip wall shows the mirror image and so no shear; a wall that reverses the velocity shows the stress itself.
pub fn mirrored_stress(stress: &Symmetric, normal: [f64; 2]) -> Symmetric {
    let [n_x, n_y] = normal;
    // R = I − 2 n nᵀ
    let (a, b, d) = (1.0 - 2.0 * n_x * n_x, -2.0 * n_x * n_y, 1.0 - 2.0 * n_y * n_y);
    let [xx, xy, yy] = *stress;
    let (u, v) = (a * xx + b * xy, a * xy + b * yy);
    let (s, t) = (b * xx + d * xy, b * xy + d * yy);
    [u * a + v * b, u * b + v * d, s * b + t * d]
}

fn times(m: &Matrix, l: &Symmetric) -> Matrix {
    [
        m[0] * l[0] + m[1] * l[1],
        m[0] * l[1] + m[1] * l[2],
        m[2] * l[0] + m[3] * l[1],
        m[2] * l[1] + m[3] * l[2],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_wall_mirrors_shear_away() {
        // Mirrored at a plane of normal y, the shear changes sign; along 45° the axes swap.
        assert_eq!(mirrored_stress(&[1.0, 2.0, 3.0], [0.0, 1.0]), [1.0, -2.0, 3.0]);
        let n = std::f64::consts::FRAC_1_SQRT_2;
        let swapped = mirrored_stress(&[1.0, 2.0, 3.0], [n, n]);
        for (found, expected) in swapped.iter().zip([3.0, 2.0, 1.0]) {
            // Round-off of n² = 1/2.
            assert!((found - expected).abs() < 1e-14);
        }
        assert_eq!(mirrored_stress(&[1.0, 2.0, 3.0], [0.0, 0.0]), [1.0, 2.0, 3.0]);
    }

    #[test]
    fn viscous_stress_of_expansion_and_shear() {
        // Simple shear ∂v_x/∂y = 5: τ_xy = μ·5, no normal stress.
        assert_eq!(viscous_stress(2.0, &[0.0, 5.0, 0.0, 0.0]), [0.0, 10.0, 0.0]);
        // Expansion ∂v_x/∂x = ∂v_y/∂y = 3: 2μ·3 − ⅔μ·6 = μ·2.
        let [xx, xy, yy] = viscous_stress(2.0, &[3.0, 0.0, 0.0, 3.0]);
        assert!((xx - 4.0).abs() < 1e-14 && xy == 0.0 && (yy - 4.0).abs() < 1e-14);
        assert_eq!(viscous_stress(2.0, &[0.0, 4.0, -4.0, 0.0]), [0.0, 0.0, 0.0]);
    }
}
