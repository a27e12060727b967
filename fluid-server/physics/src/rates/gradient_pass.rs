//! The pass before the rates: moments, renormalised density gradient and viscous stress, Eq. (4), (20)-(21), and the
//! sums of the order control.

use std::marker::PhantomData;

use rayon::prelude::*;
use sph::geometry::Geometry;
use sph::lanes::{Kernel, Lanes};

use super::gradients::{Finished, Gradients, Results};
use super::particle_rates::Rates;
use crate::equations::anti_pairing::Ratio;
use crate::equations::correction::{
    SMALLEST_CORRECTION_DETERMINANT, SMALLEST_GRADIENT_DETERMINANT, in_momentum,
};
use crate::equations::damper::damper;
use crate::equations::neighbour_sums::{Batches, Kernels, NeighbourSums, Sums, Wanted};
use crate::equations::stress::{momentum_tensor, transposed_stress, viscous_stress};
use crate::equations::tensors::{IDENTITY, Matrix, Symmetric, times};
use crate::equations::viscosity::corrected;
use crate::free_surface::detection::{NO_ORDER, surface_mark};
use crate::free_surface::shifting::OrderLocal;
use crate::neighbours::batch::Batch;
use crate::neighbours::scene::Scene;
use crate::system::model::FluidModel;
use crate::system::tasks::for_each_task;

/// Particles per task of a merge.
const MERGE_TASK: usize = 64;

impl Gradients {
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
        (OrderLocal::new(sums, trusted), surface_mark(scene, i, sums))
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
    let viscosity = if passes.pair_viscosity { corrected(viscosity, sums.mean_moment()) } else { 0.0 };
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
