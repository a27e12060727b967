//! The pass before the rates: moments, renormalised density gradient and viscous stress, Eq. (4), (20)-(21), and the
//! sums of the order control.

use std::marker::PhantomData;

use rayon::prelude::*;
use sph::geometry::Geometry;
use sph::lanes::{Kernel, Lanes};

use super::lists::Lists;
use super::model::{FluidModel, Passes};
use super::moments::{Batches, Kernels, NeighbourSums, Sums, Wanted};
use super::pair::{IDENTITY, Matrix, Symmetric};
use super::rates::Rates;
use super::record::{Batch, Record};
use super::shifting::{NO_ORDER, OrderLocal, Ratio, Surroundings};
use super::tasks::{Split, for_each_task};
use super::viscosity::corrected;

/// Particles per task of a merge.
const MERGE_TASK: usize = 64;

/// Below this determinant of the moment matrix the density gradient counts as zero: too few neighbours define it.
const SMALLEST_GRADIENT_DETERMINANT: f64 = 1e-3;

/// Below this determinant L_i is the unit matrix: at spray a large L_i does more harm than the error it cures.
const SMALLEST_CORRECTION_DETERMINANT: f64 = 0.3;

/// Determinants between which L_i fades into Eq. (22). At a surface it belongs to few neighbours on one side: pressure
/// forces by it tear splashes apart, and raise the frequency of sound above what steps allow that are stable elsewhere.
const MOMENTUM_DETERMINANTS: (f64, f64) = (0.4, 0.7);

/// Largest share of L_i in Eq. (22). The rest, the plain sum, restores the order of the particles under pressure: with
/// L_i alone no arrangement is better than another, and still water goes on creeping and draws together.
const LARGEST_SHARE: f64 = 0.8;

/// What the pass makes for each fluid particle; arrays that a scene does not need stay empty.
#[derive(Debug, Default)]
pub struct Gradients {
    /// Raw sums, where there is a partner.
    sums: Vec<NeighbourSums>,
    /// What neighbours read: q of the damper \[Pa\], mark of the order control, ∇ρ of Eq. (20) \[kg/m⁴\].
    pub shown: Vec<[f64; 4]>,
    /// L_i of Eq. (21), or the unit matrix where few neighbours define it.
    pub correction: Vec<Symmetric>,
    /// What the order control keeps.
    pub order: Vec<OrderLocal>,
    /// Viscous stress τ of Eq. (4), or the part of it that the viscous pair force leaves out \[Pa\].
    pub viscous_stress: Vec<Matrix>,
    /// T = −σ·L \[Pa\].
    pub tensor: Vec<Matrix>,
    /// Viscosity in the viscous pair force \[Pa s\].
    pub viscosity: Vec<f64>,
    /// What follows for particles that meet a partner's, until it is put in place.
    merged: Vec<(NeighbourSums, Finished)>,
}

/// A task's part of [`Gradients`].
struct Results<'a> {
    sums: &'a mut [NeighbourSums],
    shown: &'a mut [[f64; 4]],
    correction: &'a mut [Symmetric],
    order: &'a mut [OrderLocal],
    viscous_stress: &'a mut [Matrix],
    tensor: &'a mut [Matrix],
    viscosity: &'a mut [f64],
    /// Whose density rates the pass makes, with leapfrog.
    rates: &'a mut [Rates],
}

impl Split for Results<'_> {
    fn split(self, at: usize) -> (Self, Self) {
        let (sums, shown) = (self.sums.split(at), self.shown.split(at));
        let correction = self.correction.split(at);
        let (order, viscous_stress) = (self.order.split(at), self.viscous_stress.split(at));
        let (tensor, viscosity) = (self.tensor.split(at), self.viscosity.split(at));
        let rates = self.rates.split(at);
        (
            Self {
                sums: sums.0,
                shown: shown.0,
                correction: correction.0,
                order: order.0,
                viscous_stress: viscous_stress.0,
                tensor: tensor.0,
                viscosity: viscosity.0,
                rates: rates.0,
            },
            Self {
                sums: sums.1,
                shown: shown.1,
                correction: correction.1,
                order: order.1,
                viscous_stress: viscous_stress.1,
                tensor: tensor.1,
                viscosity: viscosity.1,
                rates: rates.1,
            },
        )
    }
}

/// The fluid and its surroundings in one stage.
#[derive(Clone, Copy)]
pub struct Scene<'a, G> {
    /// Nearest images.
    pub geometry: G,
    /// Constants.
    pub model: &'a FluidModel,
    /// Neighbours.
    pub lists: &'a Lists,
    /// Fluid as neighbours read it.
    pub fluid: &'a [Record],
    /// Walls as neighbours read them, and one that does not act.
    pub walls: &'a [Record],
}

impl Gradients {
    /// Arrays for `particles`, as far as the scene needs them.
    fn resize(&mut self, passes: Passes, particles: usize, partner: bool) {
        let of = |needed: bool| if needed { particles } else { 0 };
        self.sums.resize(of(partner), NeighbourSums::default());
        self.shown.resize(of(passes.shown()), [0.0; 4]);
        self.correction.resize(of(passes.correction), Symmetric::default());
        self.order.resize(of(passes.order), OrderLocal::default());
        self.viscous_stress.resize(of(passes.viscosity || passes.pair_viscosity), Matrix::default());
        self.tensor.resize(of(passes.tensor()), Matrix::default());
        self.viscosity.resize(of(passes.pair_viscosity), 0.0);
    }

    /// Sums over fluid and walls, and what follows from them.
    ///
    /// Walls enter with their density by Eq. (28) and their velocity by Eq. (27). With a `partner` the sums are kept, so
    /// that its particles can be added. With leapfrog the density rates go to `rates`.
    pub fn accumulate<G: Geometry>(&mut self, scene: &Scene<G>, partner: bool, rates: &mut Vec<Rates>) {
        let passes = scene.model.passes;
        if !passes.any() {
            return;
        }
        self.resize(passes, scene.fluid.len(), partner);
        rates.resize(scene.fluid.len(), Rates::default());
        match (passes.order, passes.moments(), passes.velocity_gradient()) {
            (true, ..) => self.gather(scene, Sums::<true, true, true>, rates),
            (false, true, true) => self.gather(scene, Sums::<true, true, false>, rates),
            (false, true, false) => self.gather(scene, Sums::<true, false, false>, rates),
            (false, false, _) => self.gather(scene, Sums::<false, true, false>, rates),
        }
    }

    fn results<'a>(&'a mut self, passes: Passes, rates: &'a mut [Rates]) -> Results<'a> {
        let Self { sums, shown, correction, order, viscous_stress, tensor, viscosity, .. } = self;
        let rates = if passes.leapfrog { rates } else { &mut [] };
        Results { sums, shown, correction, order, viscous_stress, tensor, viscosity, rates }
    }

    fn gather<G: Geometry, W: Wanted>(&mut self, scene: &Scene<G>, _: W, rates: &mut [Rates]) {
        let arithmetic = scene.model.arithmetic;
        for_each_task(scene.fluid.len(), self.results(scene.model.passes, rates), &|particles, results| {
            let wanted = PhantomData::<W>;
            arithmetic.run(Gather { scene, wanted, first: particles.start, count: particles.len(), results });
        });
    }

    /// Adds the sums over a partner's particles to those of `members`, and makes anew what follows from them.
    ///
    /// `density_meets` tells whether the partner's density means something to ∇ρ.
    pub fn merge<G: Geometry>(
        &mut self,
        scene: &Scene<G>,
        members: &[u32],
        partner: &[NeighbourSums],
        density_meets: bool,
        rates: &mut [Rates],
    ) {
        let mut merged = std::mem::take(&mut self.merged);
        let each = members.par_iter().zip(partner).with_min_len(MERGE_TASK);
        let of_both = each.map(|(i, added)| {
            let i = *i as usize;
            let mut sums = self.sums[i];
            sums.merge(added);
            let mut finished = finish(scene, i, &sums);
            if let (false, Some([.., x, y])) = (density_meets, self.shown.get(i)) {
                [finished.shown[2], finished.shown[3]] = [*x, *y];
            }
            (sums, finished)
        });
        of_both.collect_into_vec(&mut merged);
        for (i, (sums, finished)) in members.iter().zip(&merged) {
            let i = *i as usize;
            self.sums[i] = *sums;
            self.results(scene.model.passes, rates).put(i, finished);
        }
        self.merged = merged;
    }

    /// q of the acoustic damper of particle `i` \[Pa\].
    #[inline(always)]
    pub fn damper(&self, i: usize) -> f64 {
        self.shown.get(i).map_or(0.0, |shown| shown[0])
    }

    /// L_i of particle `i` as Eq. (22) takes it.
    #[inline(always)]
    pub fn in_momentum(&self, model: &FluidModel, i: usize) -> Symmetric {
        self.correction.get(i).map_or(IDENTITY, |correction| in_momentum(model, correction))
    }

    /// T of every particle at its present pressure, with what the pass has found; the order of particles must be the
    /// same. With leapfrog alone, whose predictor makes none.
    pub fn make_tensors<G: Geometry>(&mut self, scene: &Scene<G>) {
        let model = scene.model;
        if !(model.passes.tensor() && model.passes.leapfrog) {
            return;
        }
        let mut tensors = std::mem::take(&mut self.tensor);
        for_each_task(scene.fluid.len(), &mut tensors[..], &|particles, tensors| {
            for (i, of_particle) in particles.zip(tensors) {
                let stress = self.viscous_stress.get(i).copied().unwrap_or_default();
                let correction = self.correction.get(i).unwrap_or(&IDENTITY);
                *of_particle = tensor(model, scene.fluid[i].pressure() + self.damper(i), &stress, correction);
            }
        });
        self.tensor = tensors;
    }

    /// Bytes in use.
    pub fn bytes(&self) -> usize {
        fn bytes<T>(values: &Vec<T>) -> usize {
            values.capacity() * size_of::<T>()
        }
        let Self { sums, shown, correction, order, viscous_stress, tensor, viscosity, merged } = self;
        bytes(sums)
            + bytes(shown)
            + bytes(correction)
            + bytes(order)
            + bytes(viscous_stress)
            + bytes(tensor)
            + bytes(viscosity)
            + bytes(merged)
    }
}

/// The pass over the particles of one task.
struct Gather<'a, G, W> {
    scene: &'a Scene<'a, G>,
    wanted: PhantomData<W>,
    first: usize,
    count: usize,
    results: Results<'a>,
}

impl<G: Geometry, W: Wanted> Kernel for Gather<'_, G, W> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { scene, first, count, mut results, .. } = self;
        let Scene { geometry, model, lists, fluid, walls } = *scene;
        let law = Kernels { kernel: model.law.kernel.lanes(), ratio: Ratio::new(model) };
        for k in 0..count {
            let i = first + k;
            let motion = L::splat_each(fluid[i].motion);
            let rho = L::splat(fluid[i].density());
            let mut batches = Batches::<L>::zero();
            for indices in lists.fluid.of(i) {
                let batch = Batch::gather(geometry, &motion, fluid, *indices);
                batches.add::<W>(&law, rho, &batch, true);
            }
            for indices in lists.walls.of(i) {
                let batch = Batch::gather(geometry, &motion, walls, *indices);
                batches.add::<W>(&law, rho, &batch, false);
            }
            let sums = batches.total::<W>();
            if let Some(kept) = results.sums.get_mut(k) {
                *kept = sums;
            }
            results.put(k, &finish(scene, i, &sums));
        }
    }
}

/// What follows for one particle.
#[derive(Clone, Copy, Debug)]
struct Finished {
    shown: [f64; 4],
    correction: Symmetric,
    order: OrderLocal,
    viscous_stress: Matrix,
    tensor: Matrix,
    viscosity: f64,
    density_rate: f64,
}

impl Results<'_> {
    #[inline(always)]
    fn put(&mut self, k: usize, finished: &Finished) {
        put(self.shown, k, finished.shown);
        put(self.correction, k, finished.correction);
        put(self.order, k, finished.order);
        put(self.viscous_stress, k, finished.viscous_stress);
        put(self.tensor, k, finished.tensor);
        put(self.viscosity, k, finished.viscosity);
        if let Some(rates) = self.rates.get_mut(k) {
            rates.density = finished.density_rate;
        }
    }
}

/// Writes `value` where the array is there.
#[inline(always)]
fn put<T>(values: &mut [T], k: usize, value: T) {
    if let Some(place) = values.get_mut(k) {
        *place = value;
    }
}

/// ∇ρ, damper, L_i, viscous stress, T and order of particle `i` from its sums, Eq. (4) and (20)-(21).
///
/// ```text
/// τ = μ [∇v + (∇v)ᵀ − ⅔ (∇·v) I],  T = (p I − τ)·L
/// ```
#[inline(always)]
fn finish<G: Geometry>(scene: &Scene<G>, i: usize, sums: &NeighbourSums) -> Finished {
    let model = scene.model;
    let (passes, viscosity) = (model.passes, model.constants.dynamic_viscosity);
    let (determinant, inverse) = sums.inverse();
    let well_placed = determinant >= SMALLEST_CORRECTION_DETERMINANT;
    let correction = if passes.correction && well_placed { inverse } else { IDENTITY };
    let trusted = well_placed.then_some(inverse);
    let damper = damper(model, sums, trusted, scene.fluid[i].density());
    let pressure = scene.fluid[i].pressure() + damper;
    let ([x, y], [xx, xy, yy]) = (sums.density, inverse);
    let [g_x, g_y] = if passes.density_gradient && determinant >= SMALLEST_GRADIENT_DETERMINANT {
        [xx * x + xy * y, xy * x + yy * y]
    } else {
        [0.0; 2]
    };
    let (order, mark) = if passes.order {
        let around = Surroundings { scene, i, sums, inverse: trusted };
        around.order()
    } else {
        (OrderLocal::default(), NO_ORDER)
    };
    let viscous_stress = if passes.viscosity {
        viscous_stress(viscosity, &times(&sums.velocity_gradient(), &correction))
    } else if passes.pair_viscosity {
        let gradient = sums.velocity_gradient();
        transposed_stress(viscosity, &trusted.map_or(gradient, |l| times(&gradient, &l)))
    } else {
        Matrix::default()
    };
    // With leapfrog the pressure is still to come.
    let tensor = if passes.tensor() && !passes.leapfrog {
        tensor(model, pressure, &viscous_stress, &correction)
    } else {
        Matrix::default()
    };
    let viscosity = if passes.pair_viscosity { corrected(viscosity, sums) } else { 0.0 };
    let density_rate = if passes.leapfrog {
        let [v_xx, .., v_yy] = times(&sums.velocity, &correction);
        -scene.fluid[i].density() * (v_xx + v_yy)
    } else {
        0.0
    };
    let shown = [damper, mark, g_x, g_y];
    Finished { shown, correction, order, viscous_stress, tensor, viscosity, density_rate }
}

/// T \[Pa\] of a particle of `pressure` with damper \[Pa\], viscous `stress` \[Pa\] and L_i.
#[inline(always)]
fn tensor(model: &FluidModel, pressure: f64, stress: &Matrix, correction: &Symmetric) -> Matrix {
    momentum_tensor(pressure, stress, &in_momentum(model, correction))
}

/// Pressure of the acoustic damper \[Pa\], which acts in the momentum equation alone.
///
/// ```text
/// q_i = −α ρ_i c₀ h (∇·v)_i (1 − 4 s_i)₊
/// ```
/// A bulk viscosity: it damps sound and leaves vortices alone, as the term of Sun, Pilloton, Antuono & Colagrossi
/// (2023). s_i is the share of solids in the support; near them it fades, since what a solid particle would have to
/// answer follows from states of this stage that are not exchanged.
///
/// ∇·v is read through `inverse` = L_i: on disordered particles the plain sum does not vanish for a solenoidal field.
fn damper(model: &FluidModel, sums: &NeighbourSums, inverse: Option<Symmetric>, density: f64) -> f64 {
    if !model.passes.damper {
        return 0.0;
    }
    let [v_xx, v_xy, v_yx, v_yy] = sums.velocity_gradient();
    let [xx, xy, yy] = inverse.unwrap_or(IDENTITY);
    let divergence = v_xx * xx + (v_xy + v_yx) * xy + v_yy * yy;
    let clear = (1.0 - 4.0 * sums.solid_share).max(0.0);
    -model.acoustic_diffusivity * density * divergence * clear
}

/// τ of Eq. (4) \[Pa\] from the velocity gradient ∂v_a/∂x_b \[1/s\].
fn viscous_stress(viscosity: f64, gradient: &Matrix) -> Matrix {
    let [xx, xy, yx, yy] = *gradient;
    let third = 2.0 / 3.0 * (xx + yy);
    let shear = viscosity * (xy + yx);
    [viscosity * (2.0 * xx - third), shear, shear, viscosity * (2.0 * yy - third)]
}

/// The viscous stress \[Pa\] less that of the pair force, from the velocity gradient ∂v_a/∂x_b \[1/s\].
///
/// ```text
/// μ [(∇v)ᵀ − (∇·v) I]
/// ```
/// It has no divergence, but it pulls at a free surface: the pair force alone leaves ∂v/∂n = 0 there instead of no
/// traction, and so half of the dissipation of a wave (Colagrossi et al. 2011).
fn transposed_stress(viscosity: f64, gradient: &Matrix) -> Matrix {
    let [xx, xy, yx, yy] = *gradient;
    [-viscosity * yy, viscosity * yx, viscosity * xy, -viscosity * xx]
}

/// L_i as Eq. (22) takes it: most of it where the neighbours surround the particle, none of it at a surface; the unit
/// matrix where the case does not correct momentum.
///
/// The rest is that of the plain sum, 1/M I.
#[inline(always)]
fn in_momentum(model: &FluidModel, correction: &Symmetric) -> Symmetric {
    if !model.passes.momentum_correction {
        return IDENTITY;
    }
    let [xx, xy, yy] = *correction;
    let determinant = 1.0 / (xx * yy - xy * xy);
    let (least, enough) = MOMENTUM_DETERMINANTS;
    let share = LARGEST_SHARE * ((determinant - least) / (enough - least)).clamp(0.0, 1.0);
    let rest = (1.0 - share) * model.cross_gradient_scale;
    [share * xx + rest, share * xy, share * yy + rest]
}

/// T = (p I − τ)·L \[Pa\].
pub fn momentum_tensor(pressure: f64, stress: &Matrix, correction: &Symmetric) -> Matrix {
    times(&[pressure - stress[0], -stress[1], -stress[2], pressure - stress[3]], correction)
}

/// `stress` mirrored at a plane of unit `normal`; unchanged for a zero normal.
///
/// A slip wall shows the mirror image and so no shear; a wall that reverses the velocity shows the stress itself.
pub fn mirrored_stress(stress: &Matrix, normal: [f64; 2]) -> Matrix {
    let [n_x, n_y] = normal;
    // R = I − 2 n nᵀ
    let (a, b, d) = (1.0 - 2.0 * n_x * n_x, -2.0 * n_x * n_y, 1.0 - 2.0 * n_y * n_y);
    let [xx, xy, yx, yy] = *stress;
    times(&[a * xx + b * yx, a * xy + b * yy, b * xx + d * yx, b * xy + d * yy], &[a, b, d])
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
        assert_eq!(mirrored_stress(&[1.0, 2.0, 4.0, 3.0], [0.0, 1.0]), [1.0, -2.0, -4.0, 3.0]);
        let n = std::f64::consts::FRAC_1_SQRT_2;
        let swapped = mirrored_stress(&[1.0, 2.0, 4.0, 3.0], [n, n]);
        for (found, expected) in swapped.iter().zip([3.0, 4.0, 2.0, 1.0]) {
            // Round-off of n² = 1/2.
            assert!((found - expected).abs() < 1e-14);
        }
        assert_eq!(mirrored_stress(&[1.0, 2.0, 4.0, 3.0], [0.0, 0.0]), [1.0, 2.0, 4.0, 3.0]);
    }

    #[test]
    fn viscous_stress_of_expansion_and_shear() {
        // Simple shear ∂v_x/∂y = 5: τ_xy = μ·5, no normal stress.
        assert_eq!(viscous_stress(2.0, &[0.0, 5.0, 0.0, 0.0]), [0.0, 10.0, 10.0, 0.0]);
        // Expansion ∂v_x/∂x = ∂v_y/∂y = 3: 2μ·3 − ⅔μ·6 = μ·2.
        let [xx, xy, _, yy] = viscous_stress(2.0, &[3.0, 0.0, 0.0, 3.0]);
        assert!((xx - 4.0).abs() < 1e-14 && xy == 0.0 && (yy - 4.0).abs() < 1e-14);
        assert_eq!(viscous_stress(2.0, &[0.0, 4.0, -4.0, 0.0]), [0.0; 4]);
    }

    #[test]
    fn pair_force_and_transposed_stress_make_up_the_viscous_stress() {
        // Of the pair force the stress is μ ∇v. Together they are that of Eq. (4) where ∇·v = 0.
        let gradient = [3.0, 5.0, -2.0, -3.0];
        let rest = transposed_stress(2.0, &gradient);
        let whole: Vec<f64> = gradient.iter().zip(rest).map(|(g, rest)| 2.0 * g + rest).collect();
        assert_eq!(whole, viscous_stress(2.0, &gradient));
    }
}
