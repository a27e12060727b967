//! Results of the gradient pass.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use sph::space::Plane;
use sph::space::geometry::Geometry;

use super::particle_rates::Rates;
use crate::equations::correction::in_momentum;
use crate::equations::neighbour_sums::NeighbourSums;
use crate::free_surface::detection::{mark_near, mark_near_copies};
use crate::free_surface::shifting::RegularisationSums;
use crate::neighbours::scene::Scene;
use crate::parts::halo::put as put_in;
use crate::parts::reach::Reach;
use crate::system::model::{FluidModel, Viscosity};
use crate::system::packed_particle::{FluidSpace, NeighbourFields};
use crate::system::tasks::split_by_field;

/// Whether a solid's particles are still to be added to the sums of a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Partner {
    /// There is no solid.
    Absent,
    /// The sums are kept for it.
    Present,
}

/// Results of the pass for each fluid particle, own ones and copies, by place; arrays that a case does not need stay
/// empty. Of copies only what neighbours read is filled in.
#[derive(Debug)]
pub struct Gradients<S: FluidSpace = Plane> {
    /// Raw sums, kept where there is a partner.
    pub(super) sums: Vec<NeighbourSums<S>>,
    /// Fields that neighbours read.
    pub neighbour_fields: Vec<S::Fields>,
    /// Whether the particle lies at the free surface.
    at_surface: Vec<bool>,
    /// Whether it does, or one of its particles lies within the support.
    near_surface: Vec<AtomicBool>,
    /// L_i of Eq. (21), or the unit matrix where few neighbours define it.
    pub correction: Vec<S::Symmetric<f64>>,
    /// Sums for the particle regularisation.
    pub regularisation: Vec<RegularisationSums<S>>,
    /// Viscous stress τ of Eq. (4), or the part of it that the viscous pair force leaves out \[Pa\].
    pub viscous_stress: Vec<S::Matrix<f64>>,
    /// Dissipation by it, τ:∇v \[W/m³\].
    pub dissipation: Vec<f64>,
    /// T = −σ·L \[Pa\], unless it is made of pressure and L_i pair by pair.
    pub tensor: Vec<S::Matrix<f64>>,
    /// L_i as Eq. (22) takes it, where T is made of it pair by pair.
    pub momentum_correction: Vec<S::Symmetric<f64>>,
    /// Viscosity in the viscous pair force \[Pa s\].
    pub viscosity: Vec<f64>,
    /// Rate of strain D, the symmetric part of ∇v corrected by L_i; zero where few neighbours define it \[1/s\].
    pub strain_rate: Vec<S::Symmetric<f64>>,
    /// Results for particles in contact with the partner, before they are put in place.
    pub(super) merged: Vec<Option<(NeighbourSums<S>, ParticleGradients<S>)>>,
}

/// A task's part of [`Gradients`].
pub struct GradientSlices<'a, S: FluidSpace> {
    /// Raw sums.
    pub sums: &'a mut [NeighbourSums<S>],
    neighbour_fields: &'a mut [S::Fields],
    at_surface: &'a mut [bool],
    correction: &'a mut [S::Symmetric<f64>],
    regularisation: &'a mut [RegularisationSums<S>],
    viscous_stress: &'a mut [S::Matrix<f64>],
    dissipation: &'a mut [f64],
    tensor: &'a mut [S::Matrix<f64>],
    momentum_correction: &'a mut [S::Symmetric<f64>],
    viscosity: &'a mut [f64],
    strain_rate: &'a mut [S::Symmetric<f64>],
    /// Rates whose density rate the pass computes, with leapfrog.
    rates: &'a mut [Rates<S>],
}

split_by_field!(GradientSlices<S> {
    sums,
    neighbour_fields,
    at_surface,
    correction,
    regularisation,
    viscous_stress,
    dissipation,
    tensor,
    momentum_correction,
    viscosity,
    strain_rate,
    rates
});

impl<S: FluidSpace> Default for Gradients<S> {
    fn default() -> Self {
        Self {
            sums: Vec::new(),
            neighbour_fields: Vec::new(),
            at_surface: Vec::new(),
            near_surface: Vec::new(),
            correction: Vec::new(),
            regularisation: Vec::new(),
            viscous_stress: Vec::new(),
            dissipation: Vec::new(),
            tensor: Vec::new(),
            momentum_correction: Vec::new(),
            viscosity: Vec::new(),
            strain_rate: Vec::new(),
            merged: Vec::new(),
        }
    }
}

impl<S: FluidSpace> Gradients<S> {
    /// Arrays for as many `places`, as far as `model` needs them.
    pub fn resize(&mut self, model: &FluidModel<S>, places: usize, partner: Partner) {
        let of = |needed: bool| if needed { places } else { 0 };
        self.sums.resize(of(partner == Partner::Present), NeighbourSums::default());
        self.neighbour_fields.resize(of(model.has_neighbour_fields()), S::Fields::default());
        self.at_surface.resize(of(model.regularises()), false);
        self.regularisation.resize(of(model.regularises()), RegularisationSums::default());
        self.viscous_stress.resize(of(model.viscosity != Viscosity::Inviscid), S::zero_matrix());
        self.dissipation.resize(of(model.viscosity != Viscosity::Inviscid), 0.0);
        let symmetric = model.has_symmetric_tensors();
        // With leapfrog only T is made of it.
        let kept = model.corrects_continuity() && !(symmetric && model.is_leapfrog());
        self.correction.resize(of(kept), S::zero_symmetric());
        self.tensor.resize(of(model.has_tensors() && !symmetric), S::zero_matrix());
        self.momentum_correction.resize(of(symmetric), S::zero_symmetric());
        self.viscosity.resize(of(model.viscosity == Viscosity::Pairwise), 0.0);
        self.strain_rate.resize(of(model.has_strain_rates() || model.regularises()), S::zero_symmetric());
    }

    /// The parts of the arrays at the places `own`, which the pass fills; `rates` with leapfrog.
    pub fn results<'a>(
        &'a mut self,
        model: &FluidModel<S>,
        own: Range<usize>,
        rates: &'a mut [Rates<S>],
    ) -> GradientSlices<'a, S> {
        fn part<'a, T>(values: &'a mut [T], own: &Range<usize>) -> &'a mut [T] {
            if values.is_empty() { &mut [] } else { &mut values[own.clone()] }
        }
        let rates = if model.is_leapfrog() { rates } else { &mut [] };
        GradientSlices {
            sums: part(&mut self.sums, &own),
            neighbour_fields: part(&mut self.neighbour_fields, &own),
            at_surface: part(&mut self.at_surface, &own),
            correction: part(&mut self.correction, &own),
            regularisation: part(&mut self.regularisation, &own),
            viscous_stress: part(&mut self.viscous_stress, &own),
            dissipation: part(&mut self.dissipation, &own),
            tensor: part(&mut self.tensor, &own),
            momentum_correction: part(&mut self.momentum_correction, &own),
            viscosity: part(&mut self.viscosity, &own),
            strain_rate: part(&mut self.strain_rate, &own),
            rates,
        }
    }

    /// Sends what neighbours read of own particles to the parts that hold copies of them.
    pub fn send_copies<G: Geometry<S>>(&self, scene: &Scene<G, S>) {
        let Some(halo) = scene.lists.placement().halo() else { return };
        let Self { neighbour_fields, at_surface, tensor, momentum_correction, viscosity, .. } = self;
        let strain_rate = if scene.model.has_strain_rates() { &self.strain_rate[..] } else { &[] };
        halo.send(&scene.model.team, Reach::Neighbours, |i, message| {
            if let Some(fields) = neighbour_fields.get(i) {
                put_in(message, [fields.damper(), fields.eigenvalue()]);
                put_in(message, S::vector(fields.density_gradient()));
            }
            if let Some(is_at_surface) = at_surface.get(i) {
                message.push(u8::from(*is_at_surface));
            }
            if let Some(tensor) = tensor.get(i) {
                put_in(message, S::tensor(*tensor));
            }
            if let Some(correction) = momentum_correction.get(i) {
                put_in(message, S::symmetric_tensor(*correction));
            }
            if let Some(viscosity) = viscosity.get(i) {
                put_in(message, *viscosity);
            }
            if let Some(strain_rate) = strain_rate.get(i) {
                put_in(message, S::symmetric_tensor(*strain_rate));
            }
        });
    }

    /// Waits for what neighbours read of copies.
    pub fn receive_copies<G: Geometry<S>>(&mut self, scene: &Scene<G, S>) {
        let Self { neighbour_fields, at_surface, tensor, momentum_correction, viscosity, .. } = self;
        let strain_rate = if scene.model.has_strain_rates() { &mut self.strain_rate[..] } else { &mut [] };
        let Some(halo) = scene.lists.placement().halo() else { return };
        halo.receive(&scene.model.team, Reach::Neighbours, |place, message| {
            if let Some(fields) = neighbour_fields.get_mut(place) {
                let [damper, eigenvalue] = message.take();
                let gradient: S::Vector = message.take();
                *fields = S::Fields::new(damper, eigenvalue, S::components(&gradient));
            }
            if let Some(is_at_surface) = at_surface.get_mut(place) {
                *is_at_surface = message.flag();
            }
            if let Some(tensor) = tensor.get_mut(place) {
                *tensor = S::tensor_components(&message.take());
            }
            if let Some(correction) = momentum_correction.get_mut(place) {
                *correction = S::symmetric_components(&message.take());
            }
            if let Some(viscosity) = viscosity.get_mut(place) {
                *viscosity = message.number();
            }
            if let Some(strain_rate) = strain_rate.get_mut(place) {
                *strain_rate = S::symmetric_components(&message.take());
            }
        });
    }

    /// Learns of all copies which of them lie at the free surface, not of those alone that are neighbours.
    pub fn exchange_surface<G: Geometry<S>>(&mut self, scene: &Scene<G, S>) {
        let Some(halo) = scene.lists.placement().halo() else { return };
        let (team, at_surface) = (&scene.model.team, &mut self.at_surface);
        if !at_surface.is_empty() {
            halo.send(team, Reach::Nodes, |i, message| message.push(u8::from(at_surface[i])));
            halo.receive(team, Reach::Nodes, |place, message| at_surface[place] = message.flag());
        }
    }

    /// Finds the particles near own ones at the free surface, at their present positions, in a case with particle
    /// regularisation.
    pub fn find_near_surface<G: Geometry<S>>(&mut self, scene: &Scene<G, S>) {
        if scene.model.regularises() {
            mark_near(scene, &self.at_surface, &mut self.near_surface);
        }
    }

    /// Finds the particles near copies at the free surface, once these have arrived.
    pub fn find_near_surface_copies<G: Geometry<S>>(&mut self, scene: &Scene<G, S>) {
        if scene.model.regularises() {
            mark_near_copies(scene, &self.at_surface, &self.near_surface);
        }
    }

    /// Whether the particle at place `i` lies at the free surface, or one of its particles within the support.
    #[inline(always)]
    pub fn is_near_surface(&self, i: usize) -> bool {
        self.near_surface.get(i).is_some_and(|is| is.load(Ordering::Relaxed))
    }

    /// Whether the particle at place `i` lies at the free surface.
    #[inline(always)]
    pub fn is_at_surface(&self, i: usize) -> bool {
        self.at_surface.get(i).copied().unwrap_or_default()
    }

    /// q of the acoustic damper of the particle at place `i` \[Pa\].
    #[inline(always)]
    pub fn damper(&self, i: usize) -> f64 {
        self.neighbour_fields.get(i).map_or(0.0, S::Fields::damper)
    }

    /// L_i of the particle at place `i` as Eq. (22) takes it.
    #[inline(always)]
    pub fn in_momentum(&self, model: &FluidModel<S>, i: usize) -> S::Symmetric<f64> {
        if let Some(correction) = self.momentum_correction.get(i) {
            return *correction;
        }
        self.correction.get(i).map_or(S::identity(), |correction| in_momentum(model, *correction))
    }

    /// Bytes in use.
    pub fn bytes(&self) -> usize {
        fn bytes<T>(values: &Vec<T>) -> usize {
            values.capacity() * size_of::<T>()
        }
        bytes(&self.sums)
            + bytes(&self.neighbour_fields)
            + bytes(&self.at_surface)
            + bytes(&self.near_surface)
            + bytes(&self.correction)
            + bytes(&self.regularisation)
            + bytes(&self.viscous_stress)
            + bytes(&self.dissipation)
            + bytes(&self.tensor)
            + bytes(&self.momentum_correction)
            + bytes(&self.viscosity)
            + bytes(&self.strain_rate)
            + bytes(&self.merged)
    }
}

/// Results for one particle.
#[derive(Clone, Copy, Debug)]
pub struct ParticleGradients<S: FluidSpace> {
    /// Fields that neighbours read.
    pub neighbour_fields: S::Fields,
    /// Whether the particle lies at the free surface.
    pub at_surface: bool,
    /// L_i.
    pub correction: S::Symmetric<f64>,
    /// Sums for the particle regularisation.
    pub regularisation: RegularisationSums<S>,
    /// Viscous stress \[Pa\].
    pub viscous_stress: S::Matrix<f64>,
    /// Dissipation by it \[W/m³\].
    pub dissipation: f64,
    /// T \[Pa\].
    pub tensor: S::Matrix<f64>,
    /// L_i as Eq. (22) takes it, where T is symmetric.
    pub momentum_correction: S::Symmetric<f64>,
    /// Viscosity \[Pa s\].
    pub viscosity: f64,
    /// Rate of strain \[1/s\].
    pub strain_rate: S::Symmetric<f64>,
    /// Density rate with leapfrog \[kg/(m³ s)\].
    pub density_rate: f64,
}

impl<S: FluidSpace> GradientSlices<'_, S> {
    /// Puts the results of particle `k` in place.
    #[inline(always)]
    pub fn put(&mut self, k: usize, finished: &ParticleGradients<S>) {
        put(self.neighbour_fields, k, finished.neighbour_fields);
        put(self.at_surface, k, finished.at_surface);
        put(self.correction, k, finished.correction);
        put(self.regularisation, k, finished.regularisation);
        put(self.viscous_stress, k, finished.viscous_stress);
        put(self.dissipation, k, finished.dissipation);
        put(self.tensor, k, finished.tensor);
        put(self.momentum_correction, k, finished.momentum_correction);
        put(self.viscosity, k, finished.viscosity);
        put(self.strain_rate, k, finished.strain_rate);
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
