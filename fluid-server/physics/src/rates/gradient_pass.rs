//! The gradient pass: moments, renormalised density gradient, viscous stress, Eq. (4), (20)-(21), and the sums of the
//! particle regularisation; with leapfrog also the density rate, Eq. (17).

use std::marker::PhantomData;
use std::ops::Range;

use sph::lanes::{LanePass, Lanes};
use sph::space::geometry::Geometry;
use sph::space::tensors::{SpaceSymmetric, SpaceTensor};
use sph::tasks::for_each;

use super::gradients::{GradientSlices, Gradients, ParticleGradients, Partner};
use super::particle_rates::Rates;
use crate::equations::anti_pairing::Ratio;
use crate::equations::continuity::density_rate;
use crate::equations::correction::in_momentum;
use crate::equations::damper::damper;
use crate::equations::neighbour_sums::{
    BATCHES, LaneSums, NeighbourKind, NeighbourSums, Selected, SumBatch, SumKernel, SumSelection,
};
use crate::equations::stress::{dissipation, momentum_tensor, transposed_stress, viscous_stress};
use crate::equations::viscosity::corrected;
use crate::equations::voids::Void;
use crate::free_surface::detection::Surface;
use crate::free_surface::shifting::RegularisationSums;
use crate::neighbours::batch::NeighbourBatch;
use crate::neighbours::placement::Needs;
use crate::neighbours::scene::Scene;
use crate::system::model::{FluidModel, Viscosity};
use crate::system::packed_particle::{FluidSpace, NeighbourFields, Packed};
use crate::system::tasks::for_each_task;

/// Particles per task of a merge.
const MERGE_TASK: usize = 64;

/// Meaning of the density of the partner's particles in ∇ρ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PartnerDensity {
    /// That of an equivalent fluid.
    FluidEquivalent,
    /// That of another material, which ∇ρ leaves out.
    OtherMaterial,
}

impl<S: FluidSpace> Gradients<S> {
    /// Sums of own particles with such `needs` over fluid and walls, and what follows from them.
    ///
    /// Walls enter with their density by Eq. (28) and their velocity by Eq. (27). With a `partner` the sums are kept,
    /// so that its particles can be added. With leapfrog the density rates go to `rates`.
    pub fn accumulate<G: Geometry<S>>(
        &mut self,
        scene: &Scene<G, S>,
        needs: Needs,
        partner: Partner,
        rates: &mut Vec<Rates<S>>,
    ) {
        let model = scene.model;
        if !model.needs_gradient_pass() {
            return;
        }
        self.resize(model, scene.fluid.len(), partner);
        rates.resize(scene.own().len(), Rates::default());
        match (model.regularises(), model.needs_moments(), model.needs_velocity_gradient()) {
            (true, ..) => self.gather(scene, Selected::<true, true, true>, needs, rates),
            (false, true, true) => self.gather(scene, Selected::<true, true, false>, needs, rates),
            (false, true, false) => self.gather(scene, Selected::<true, false, false>, needs, rates),
            (false, false, _) => self.gather(scene, Selected::<false, true, false>, needs, rates),
        }
    }

    fn gather<G: Geometry<S>, W: SumSelection>(
        &mut self,
        scene: &Scene<G, S>,
        _: W,
        needs: Needs,
        rates: &mut [Rates<S>],
    ) {
        let (arithmetic, placement) = (scene.model.arithmetic, scene.lists.placement());
        let results = self.results(scene.model, scene.own(), rates);
        placement.groups().for_each(placement.groups_with(needs), results, &|particles, results| {
            let selection = PhantomData::<W>;
            arithmetic.run(Gather {
                scene,
                selection,
                first: particles.start,
                count: particles.len(),
                results,
            });
        });
    }

    /// Adds the sums over a partner's particles to those of `members`, own indices, and updates their results.
    pub fn merge<G: Geometry<S>>(
        &mut self,
        scene: &Scene<G, S>,
        members: &[u32],
        partner: &[NeighbourSums<S>],
        density: PartnerDensity,
        rates: &mut [Rates<S>],
    ) {
        let mut merged = std::mem::take(&mut self.merged);
        merged.clear();
        merged.resize(members.len(), None);
        for_each(&mut merged[..], MERGE_TASK, |k, merged| {
            let i = members[k] as usize;
            let mut sums = self.sums[i];
            sums.merge(&partner[k]);
            let mut finished = finish(scene, i, &sums);
            if let (PartnerDensity::OtherMaterial, Some(own)) = (density, self.neighbour_fields.get(i)) {
                let fields = finished.neighbour_fields;
                finished.neighbour_fields =
                    S::Fields::new(fields.damper(), fields.eigenvalue(), own.density_gradient());
            }
            *merged = Some((sums, finished));
        });
        for (k, (sums, finished)) in members.iter().zip(merged.iter().flatten()) {
            let k = *k as usize;
            self.sums[k] = *sums;
            self.results(scene.model, scene.own(), rates).put(k, finished);
        }
        self.merged = merged;
    }

    /// T of every own particle, at the places `own`, at its present pressure, from the results of the pass; the order of
    /// particles must be the same. With leapfrog only, whose predictor computes none.
    pub fn make_tensors(&mut self, model: &FluidModel<S>, own: Range<usize>, fluid: &[S::Particle]) {
        if !(model.has_tensors() && model.is_leapfrog()) || model.has_symmetric_tensors() {
            return;
        }
        let mut tensors = std::mem::take(&mut self.tensor);
        for_each_task(own.len(), &mut tensors[own.clone()], &|particles, tensors| {
            for (i, of_particle) in particles.map(|k| own.start + k).zip(tensors) {
                let stress = self.viscous_stress.get(i).copied().unwrap_or(S::zero_matrix());
                let correction = self.correction.get(i).copied().unwrap_or(S::identity());
                *of_particle = tensor(model, fluid[i].pressure() + self.damper(i), stress, correction);
            }
        });
        self.tensor = tensors;
    }
}

/// The pass over the particles of one task.
struct Gather<'a, G, S: FluidSpace, W> {
    scene: &'a Scene<'a, G, S>,
    selection: PhantomData<W>,
    first: usize,
    count: usize,
    results: GradientSlices<'a, S>,
}

impl<S: FluidSpace, G: Geometry<S>, W: SumSelection> LanePass for Gather<'_, G, S, W> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { scene, first, count, mut results, .. } = self;
        let Scene { geometry, model, fluid, walls, .. } = *scene;
        let law = SumKernel { kernel: model.law.kernel.lanes(), ratio: Ratio::new(model) };
        // A round of its own for square roots and divisions: many of them are under way at a time.
        let mut prepared = [SumBatch::<S, L>::nothing(); BATCHES];
        for k in 0..count {
            let i = first + k;
            let motion = fluid[i].splat_motion();
            let rho = L::splat(fluid[i].density());
            let mut sums = LaneSums::<S, L>::zero();
            for rows in scene.fluid_row(i).chunks(BATCHES) {
                for (batch, indices) in prepared.iter_mut().zip(rows) {
                    let gathered = NeighbourBatch::gather(geometry, &motion, fluid, *indices);
                    *batch = sums.prepare::<W>(&law, rho, &gathered, NeighbourKind::Fluid);
                }
                sums.add::<W>(&prepared[..rows.len()]);
            }
            for rows in scene.wall_row(i).chunks(BATCHES) {
                for (batch, indices) in prepared.iter_mut().zip(rows) {
                    let gathered = NeighbourBatch::gather(geometry, &motion, walls, *indices);
                    *batch = sums.prepare::<W>(&law, rho, &gathered, NeighbourKind::Wall);
                }
                sums.add::<W>(&prepared[..rows.len()]);
            }
            let sums = sums.total::<W>();
            if let Some(kept) = results.sums.get_mut(k) {
                *kept = sums;
            }
            results.put(k, &finish(scene, i, &sums));
        }
    }
}

/// ∇ρ, damper, L_i, viscous stress, T and regularisation of the particle at place `i` from its sums, Eq. (4) and (20)-(21).
#[inline(always)]
fn finish<S: FluidSpace, G: Geometry<S>>(
    scene: &Scene<G, S>,
    i: usize,
    sums: &NeighbourSums<S>,
) -> ParticleGradients<S> {
    let model = scene.model;
    let viscosity = model.constants.dynamic_viscosity;
    let (determinant, inverse) = sums.inverse();
    let well_placed = determinant >= S::SMALLEST_CORRECTION_DETERMINANT;
    let correction = if model.corrects_continuity() && well_placed { inverse } else { S::identity() };
    let trusted = well_placed.then_some(inverse);
    let damper = damper(model, sums, trusted, scene.fluid[i].density());
    let pressure = scene.fluid[i].pressure() + damper;
    let has_gradient = model.needs_density_gradient() && determinant >= S::SMALLEST_GRADIENT_DETERMINANT;
    let density_gradient =
        if has_gradient { S::symmetric_times(inverse, sums.density) } else { S::splat(0.0) };
    let velocity_gradient = match trusted {
        Some(inverse) if model.regularises() || model.has_strain_rates() => {
            S::tensor(S::matrix_times_symmetric(sums.velocity_gradient(), inverse))
        }
        _ => S::Tensor::zeros(),
    };
    let (regularisation, surface) = if model.regularises() {
        (RegularisationSums::new(sums, &velocity_gradient), Surface::of(scene, i, sums))
    } else {
        (RegularisationSums::default(), Surface::default())
    };
    let (viscous_stress, dissipation) = match model.viscosity {
        Viscosity::Inviscid => (S::zero_matrix(), 0.0),
        Viscosity::Stress => {
            let gradient = S::matrix_times_symmetric(sums.velocity_gradient(), correction);
            let stress = viscous_stress::<S>(viscosity, gradient);
            (stress, dissipation::<S>(stress, gradient))
        }
        Viscosity::Pairwise => {
            let gradient = sums.velocity_gradient();
            let corrected = trusted.map_or(gradient, |l| S::matrix_times_symmetric(gradient, l));
            let stress = transposed_stress::<S>(viscosity, corrected);
            (stress, dissipation::<S>(stress, corrected))
        }
    };
    // With leapfrog the pressure is not known yet.
    let symmetric = model.has_symmetric_tensors();
    let tensor = if model.has_tensors() && !model.is_leapfrog() && !symmetric {
        tensor(model, pressure, viscous_stress, correction)
    } else {
        S::zero_matrix()
    };
    let momentum_correction = if symmetric { in_momentum(model, correction) } else { S::zero_symmetric() };
    let viscosity = if model.viscosity == Viscosity::Pairwise {
        corrected::<S>(viscosity, sums.mean_moment())
    } else {
        0.0
    };
    let density_rate = if model.is_leapfrog() {
        let divergence = S::trace(S::matrix_times_symmetric(sums.velocity, correction));
        let plain = density_rate(scene.fluid[i].density(), divergence);
        let void = Void::shown_by(model, &regularisation.concentration);
        void.map_or(plain, |void| void.density_rate(scene, i, plain))
    } else {
        0.0
    };
    let neighbour_fields = S::Fields::new(damper, surface.eigenvalue, density_gradient);
    ParticleGradients {
        neighbour_fields,
        at_surface: surface.at_surface,
        correction,
        regularisation,
        viscous_stress,
        dissipation,
        tensor,
        momentum_correction,
        viscosity,
        strain_rate: S::symmetric_components(&S::SymmetricTensor::of(&velocity_gradient)),
        density_rate,
    }
}

/// T \[Pa\] of a particle of `pressure` with damper \[Pa\], viscous `stress` \[Pa\] and L_i.
#[inline(always)]
fn tensor<S: FluidSpace>(
    model: &FluidModel<S>,
    pressure: f64,
    stress: S::Matrix<f64>,
    correction: S::Symmetric<f64>,
) -> S::Matrix<f64> {
    momentum_tensor::<S>(pressure, stress, in_momentum(model, correction))
}
