//! What the rates of a stage are computed of, and the sums of one particle.

use std::ops::Range;

use sph::lanes::{Lanes, WIDTH};
use sph::space::Plane;
use sph::space::geometry::Geometry;

use super::energy::{EnergyInput, ForcePowers};
use super::gradients::Gradients;
use super::particle_rates::StagePart;
use crate::equations::pair::{CentreParticle, LawLanes, NeighbourData, PairSums, PairViscosity};
use crate::equations::stress::{mirrored_stress, momentum_tensor};
use crate::equations::terms::PairTerms;
use crate::neighbours::batch::{NeighbourBatch, each, gather, of_each};
use crate::neighbours::scene::Scene;
use crate::system::packed_particle::{FluidSpace, NeighbourFields, Packed};
use crate::system::state::FluidState;
use crate::system::walls::WallField;

/// Input of the rates.
#[derive(Clone, Copy)]
pub struct StageFields<'a, G, S: FluidSpace = Plane> {
    /// Fluid and walls.
    pub scene: Scene<'a, G, S>,
    /// State.
    pub state: &'a FluidState<S>,
    /// Kinematics of the walls.
    pub field: &'a WallField<S>,
    /// Results of the gradient pass.
    pub gradients: &'a Gradients<S>,
    /// Time of the stage state \[s\].
    pub time: f64,
    /// Part of the rates.
    pub part: StagePart,
    /// What the energy budget needs, in a corrector.
    pub energy: Option<EnergyInput<'a, S>>,
}

impl<S: FluidSpace, G: Geometry<S>> StageFields<'_, G, S> {
    /// The particle at place `i` in each lane.
    #[inline(always)]
    pub fn own<L: Lanes, T: PairTerms>(&self, i: usize) -> CentreParticle<S, L> {
        let (fluid, gradients) = (&self.scene.fluid[i], self.gradients);
        let fields = if T::NEIGHBOUR_FIELDS { gradients.neighbour_fields[i] } else { S::Fields::default() };
        let corrected = T::CONTINUITY && self.scene.model.corrects_continuity();
        let l = if corrected { gradients.correction[i] } else { S::identity() };
        CentreParticle {
            motion: fluid.splat_motion(),
            density: L::splat(fluid.density()),
            twice_density: L::splat(2.0 * fluid.density()),
            pressure: L::splat(fluid.pressure() + fields.damper()),
            density_gradient: S::splat_each(&fields.density_gradient()),
            tensor: if T::SYMMETRIC {
                let pressure = fluid.pressure() + fields.damper();
                let tensor = S::symmetric_scaled(gradients.momentum_correction[i], pressure);
                S::matrix_of_symmetric(S::splat_symmetric(&tensor))
            } else if T::TENSOR {
                S::splat_matrix(&gradients.tensor[i])
            } else {
                S::zero_matrix()
            },
            correction: S::splat_symmetric(&l),
            strain_rate: match gradients.strain_rate.get(i) {
                Some(strain_rate) => S::splat_symmetric(strain_rate),
                None => S::zero_symmetric(),
            },
        }
    }

    /// Sums of the particle at place `i` over its fluid neighbours.
    #[inline(always)]
    pub fn fluid_sums<L: Lanes, T: PairTerms>(
        &self,
        law: &LawLanes<L>,
        i: usize,
        own: &CentreParticle<S, L>,
    ) -> PairSums<S, L> {
        let Scene { geometry, model, fluid, .. } = self.scene;
        let gradients = self.gradients;
        // The same length, as one check of an index then serves both.
        let neighbour_fields =
            if T::NEIGHBOUR_FIELDS { &gradients.neighbour_fields[..fluid.len()] } else { &[] };
        let tensors = if T::TENSOR && !T::SYMMETRIC { &gradients.tensor[..fluid.len()] } else { &[] };
        let corrections = if T::SYMMETRIC { &gradients.momentum_correction[..fluid.len()] } else { &[] };
        let strain_rates = if model.has_strain_rates() { &gradients.strain_rate[..fluid.len()] } else { &[] };
        let mut sums = PairSums::zero();
        for indices in self.scene.fluid_row(i) {
            let indices = *indices;
            let mut batch = NeighbourBatch::<S, L>::gather(geometry, &own.motion, fluid, indices);
            let mut data = NeighbourData::nothing();
            if T::NEIGHBOUR_FIELDS {
                let (damper, _, gradient) = S::Fields::lanes(of_each(indices, neighbour_fields));
                batch.pressure = batch.pressure + damper;
                data.density_gradient = gradient;
            }
            if !strain_rates.is_empty() {
                data.strain_rate = S::symmetric_component_lanes(of_each(indices, strain_rates));
            }
            if T::SYMMETRIC {
                let correction = S::symmetric_component_lanes(of_each(indices, corrections));
                data.tensor = S::matrix_of_symmetric(S::symmetric_scaled(correction, batch.pressure));
            } else if T::TENSOR {
                data.tensor = S::tensor_lanes(of_each(indices, tensors));
            }
            if T::VISCOUS {
                let viscosity = L::splat(gradients.viscosity[i]) + gather(indices, &gradients.viscosity);
                data.viscosity = PairViscosity { viscosity, relative_velocity: batch.v };
            }
            sums.add::<T>(law, own, &batch, &data);
        }
        sums
    }

    /// Sums of the particle at place `i` over the particles of `wall`, or of all walls.
    ///
    /// A wall takes ∇ρ, L, damper and rate of strain of the particle, and its viscous stress, mirrored where it slips.
    #[inline(always)]
    pub fn wall_sums<L: Lanes, T: PairTerms>(
        &self,
        law: &LawLanes<L>,
        i: usize,
        own: &CentreParticle<S, L>,
        wall: Option<u32>,
    ) -> PairSums<S, L> {
        let Scene { geometry, model, walls, .. } = self.scene;
        let damper = L::splat(self.damper(i));
        let correction = if T::TENSOR { self.gradients.in_momentum(model, i) } else { S::identity() };
        let of_pressure = S::matrix_of_symmetric(S::splat_symmetric::<L>(&correction));
        let inviscid = self.gradients.viscous_stress.is_empty();
        let mut sums = PairSums::zero();
        for indices in self.scene.wall_row(i) {
            let indices = *indices;
            let mut batch = NeighbourBatch::<S, L>::gather(geometry, &own.motion, walls, indices);
            if let Some(wall) = wall {
                let included = |w: u32| f64::from(u8::from(model.walls.wall.get(w as usize) == Some(&wall)));
                batch.volume = batch.volume * L::from_array(each(indices, included));
            }
            batch.pressure = batch.pressure + damper;
            let mut data = NeighbourData {
                density_gradient: own.density_gradient,
                strain_rate: own.strain_rate,
                ..NeighbourData::nothing()
            };
            if T::TENSOR && inviscid {
                data.tensor = S::matrix_scaled(of_pressure, batch.pressure);
            } else if T::TENSOR {
                let tensors = each(indices, |w| self.wall_tensor(i, w as usize, correction));
                data.tensor = S::tensor_lanes(tensors.each_ref());
            }
            if T::VISCOUS {
                let viscosity = L::splat(2.0 * self.gradients.viscosity[i]);
                data.viscosity =
                    PairViscosity { viscosity, relative_velocity: self.resisted(indices, &batch) };
            }
            sums.add::<T>(law, own, &batch, &data);
        }
        sums
    }

    /// q of the acoustic damper of the particle at place `i` \[Pa\].
    pub fn damper(&self, i: usize) -> f64 {
        self.gradients.damper(i)
    }

    /// The part of the velocity relative to walls that viscosity resists: all of it, or where they slip that along
    /// their normal.
    #[inline(always)]
    fn resisted<L: Lanes>(&self, indices: [u32; WIDTH], batch: &NeighbourBatch<S, L>) -> S::Of<L> {
        let normals = each(indices, |w| self.mirror_normal(w as usize));
        let normal = S::lanes::<L>(normals.each_ref());
        let along = L::splat(1.0) - S::dot(normal, normal);
        S::plus_product(S::scaled(batch.v, along), S::dot(batch.v, normal), normal)
    }

    /// Adds what acoustic damper and viscous stress lose at the particles at places `particles`.
    ///
    /// ```text
    /// V q²/(ρ α c₀ h),   V τ:∇v
    /// ```
    pub fn add_losses(&self, powers: &mut ForcePowers, particles: Range<usize>) {
        let (model, fluid) = (&self.scene.model, &self.scene.fluid);
        if model.has_damper() {
            powers.damper += particles
                .clone()
                .map(|i| {
                    let q = self.damper(i);
                    fluid[i].volume() * q * q / (fluid[i].density() * model.acoustic_diffusivity)
                })
                .sum::<f64>();
        }
        if let Some(dissipation) = self.gradients.dissipation.get(particles.clone()) {
            powers.stress += fluid[particles]
                .iter()
                .zip(dissipation)
                .map(|(particle, lost)| particle.volume() * lost)
                .sum::<f64>();
        }
    }

    /// Normal of the mirror of wall particle `w`; none for the one that does not act.
    fn mirror_normal(&self, w: usize) -> S::Vector {
        self.field.mirror_normal.get(w).copied().unwrap_or_default()
    }

    /// T of wall particle `w` in the pair with the particle at place `i`, with L_i as in Eq. (22).
    fn wall_tensor(&self, i: usize, w: usize, correction: S::Symmetric<f64>) -> S::Matrix<f64> {
        let normal = S::components(&self.mirror_normal(w));
        let stress = self.gradients.viscous_stress.get(i);
        let stress = stress.map_or(S::zero_matrix(), |stress| mirrored_stress::<S>(*stress, normal));
        momentum_tensor::<S>(self.scene.walls[w].pressure() + self.damper(i), stress, correction)
    }
}
