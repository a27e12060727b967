//! The pass before the rates: moments, renormalised density gradient and viscous stress, Eq. (4), (20)-(21).

use rayon::prelude::*;
use sph::vector::Vector;

use super::lanes::Lanes;
use super::lists::Lists;
use super::model::FluidModel;
use super::pair::{Batch, Geometry, IDENTITY, Matrix, PairKernel, Record, Symmetric, for_each_batch};
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
    /// Share of another owner's particles in the moments: ½ Σ V_j (x_j − x_i)·∇W over them \[-\].
    solid_share: f64,
}

/// [`MomentSums`] being gathered, batch by batch.
#[derive(Clone, Copy, Debug, Default)]
pub struct MomentBatches {
    moment: [Lanes; 3],
    density: [Lanes; 2],
    velocity: [Lanes; 4],
}

impl MomentBatches {
    /// Adds the neighbours of `batch` of a particle of density `rho`.
    #[inline(always)]
    pub fn add<const MOMENTS: bool, const VELOCITY: bool>(
        &mut self,
        kernel: &PairKernel,
        rho: f64,
        batch: &Batch,
    ) {
        let Batch { x, y, v_x, v_y, density, volume, .. } = *batch;
        let weight = volume * kernel.gradient_factor(batch.square());
        let (weight_x, weight_y) = (weight * x, weight * y);
        if MOMENTS {
            self.moment[0] -= weight_x * x;
            self.moment[1] -= weight_x * y;
            self.moment[2] -= weight_y * y;
            let difference = density - Lanes::splat(rho);
            self.density[0] += difference * weight_x;
            self.density[1] += difference * weight_y;
        }
        if VELOCITY {
            // v_j − v_i = −v_ij
            self.velocity[0] -= v_x * weight_x;
            self.velocity[1] -= v_x * weight_y;
            self.velocity[2] -= v_y * weight_x;
            self.velocity[3] -= v_y * weight_y;
        }
    }

    /// The sums over all batches.
    #[inline(always)]
    pub fn total(&self) -> MomentSums {
        MomentSums {
            moment: self.moment.map(Lanes::sum),
            density: self.density.map(Lanes::sum),
            velocity: self.velocity.map(Lanes::sum),
            solid_share: 0.0,
        }
    }
}

impl MomentSums {
    /// Adds one neighbour of another owner at separation `d` = x_ij \[m\], with `weight` = V_j (dW/dr)/r \[1/m²\],
    /// ρ_j − ρ_i \[kg/m³\] and v_j − v_i \[m/s\].
    pub fn add_pair(&mut self, d: &Vector, weight: f64, density: f64, velocity: &Vector) {
        let w = d * weight;
        for (sum, term) in self.moment.iter_mut().zip([w.x * d.x, w.x * d.y, w.y * d.y]) {
            *sum -= term;
        }
        self.solid_share -= 0.5 * w.dot(d);
        let v = velocity;
        add(&mut self.density, &[density * w.x, density * w.y]);
        add(&mut self.velocity, &[v.x * w.x, v.x * w.y, v.y * w.x, v.y * w.y]);
    }

    /// Adds the sums over another owner's particles.
    pub fn merge(&mut self, other: &Self) {
        add(&mut self.moment, &other.moment);
        add(&mut self.density, &other.density);
        add(&mut self.velocity, &other.velocity);
        self.solid_share += other.solid_share;
    }

    /// Half the trace of the moment matrix: 1 for complete and even neighbours \[-\].
    pub fn mean_moment(&self) -> f64 {
        0.5 * (self.moment[0] + self.moment[2])
    }

    /// ∇·v \[1/s\], by L_i where the neighbours define it.
    fn divergence(&self) -> f64 {
        let [xx, xy, yx, yy] = self.velocity;
        match self.inverse(SMALLEST_CORRECTION_DETERMINANT) {
            Some(l) => xx * l[0] + (xy + yx) * l[1] + yy * l[2],
            None => xx + yy,
        }
    }

    /// Inverse of the moment matrix; `None` below the `smallest` determinant.
    fn inverse(&self, smallest: f64) -> Option<Symmetric> {
        let [xx, xy, yy] = self.moment;
        let determinant = xx * yy - xy * xy;
        (determinant >= smallest).then(|| [yy / determinant, -xy / determinant, xx / determinant])
    }
}

fn add(own: &mut [f64], other: &[f64]) {
    own.iter_mut().zip(other).for_each(|(a, b)| *a += b);
}

/// What the pass makes for each fluid particle; arrays a scene does not need stay empty.
#[derive(Debug, Default)]
pub struct Gradients {
    /// Raw sums.
    pub sums: Vec<MomentSums>,
    /// ∇ρ of Eq. (20) \[kg/m⁴\].
    pub density: Vec<[f64; 2]>,
    /// q of the acoustic damper \[Pa\].
    pub damper: Vec<f64>,
    /// L_i of Eq. (21), or the unit matrix where it is not asked for.
    pub correction: Vec<Symmetric>,
    /// Viscous stress τ of Eq. (4) \[Pa\].
    pub viscous_stress: Vec<Symmetric>,
    /// T = −σ·L \[Pa\].
    pub tensor: Vec<Matrix>,
    /// Viscosity in the viscous pair force \[Pa s\].
    pub viscosity: Vec<f64>,
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
        match (model.passes.moments(), model.passes.velocity_gradient()) {
            (false, false) => {}
            (true, false) => self.gather::<G, true, false>(geometry, model, lists, fluid, walls),
            (false, true) => self.gather::<G, false, true>(geometry, model, lists, fluid, walls),
            (true, true) => self.gather::<G, true, true>(geometry, model, lists, fluid, walls),
        }
    }

    fn gather<G: Geometry, const MOMENTS: bool, const VELOCITY: bool>(
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
            let own = &fluid[i];
            let mut batches = MomentBatches::default();
            for (list, others) in [(&lists.fluid, fluid), (&lists.walls, walls)] {
                for_each_batch(list.of(i), |indices, count| {
                    let batch = Batch::gather(geometry, own, others, indices, count);
                    batches.add::<MOMENTS, VELOCITY>(kernel, own.density, &batch);
                });
            }
            *sums = batches.total();
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

    /// Adds the pressure of the acoustic damper to that of each particle in `fluid`, for the momentum equation alone.
    ///
    /// ```text
    /// q_i = −α ρ_i c₀ h (∇·v)_i (1 − 4 s_i)₊
    /// ```
    /// A bulk viscosity: it damps sound and leaves vortices alone, as the term of Sun, Pilloton, Antuono & Colagrossi
    /// (2023). s_i is the share of solids in the support; near them it fades, since what a solid particle would have
    /// to answer follows from states of this stage that are not exchanged.
    pub fn add_damper(&mut self, model: &FluidModel, fluid: &mut [Record]) {
        if !model.passes.damper {
            return;
        }
        self.damper.resize(fluid.len(), 0.0);
        let results = (fluid, &mut self.damper, &self.sums);
        results.into_par_iter().with_min_len(TASK).for_each(|(record, damper, sums)| {
            let divergence = sums.divergence();
            let clear = (1.0 - 4.0 * sums.solid_share).max(0.0);
            *damper = -model.acoustic_diffusivity * record.density * divergence * clear;
            record.pressure += *damper;
        });
    }

    /// L_i, viscous stress and T from the present sums, Eq. (4) and (21).
    ///
    /// ```text
    /// τ = μ [∇v + (∇v)ᵀ − ⅔ (∇·v) I],  T = (p I − τ)·L
    /// ```
    pub fn finish_tensors(&mut self, model: &FluidModel, fluid: &[Record]) {
        let passes = model.passes;
        if !passes.tensor() && !passes.correction {
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
                let in_momentum = if passes.momentum_correction { *correction } else { IDENTITY };
                *tensor = momentum_tensor(fluid[i].pressure, stress, &in_momentum);
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
