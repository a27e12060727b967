//! Particles of solids at the start of a run.

use std::ops::Range;

use crate::space::tensors::{SpaceSymmetric, SpaceTensor};
use crate::space::{Plane, Space, Spatial, SymmetricTensor3};

/// Solid particles, one entry per particle in each array; particles of a body are contiguous, bodies in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SolidParticles<S: Space = Plane> {
    /// Identity, unique among the solid's particles, ascending.
    pub id: Vec<u32>,
    /// Index of the body.
    pub body: Vec<u32>,
    /// 0 free, k the body's support k−1.
    pub support: Vec<u32>,
    /// Mass \[kg\], in the plane per depth.
    pub mass: Vec<f64>,
    /// Position in the undeformed body \[m\]: displacements and material points refer to it.
    pub reference_position: Vec<S::Vector>,
    /// Position \[m\].
    pub position: Vec<S::Vector>,
    /// Velocity \[m/s\].
    pub velocity: Vec<S::Vector>,
    /// Density \[kg/m³\].
    pub density: Vec<f64>,
    /// Deviatoric stress s \[Pa\].
    pub deviatoric_stress: Vec<S::SymmetricTensor>,
}

impl<S: Space> SolidParticles<S> {
    /// The particles of body `k`.
    pub fn of_body(&self, k: u32) -> BodyParticles<'_, S> {
        let start = self.body.partition_point(|body| *body < k);
        let end = self.body.partition_point(|body| *body <= k);
        BodyParticles { particles: self, range: start..end }
    }
}

/// The particles of one body.
#[derive(Clone, Debug)]
pub struct BodyParticles<'a, S: Space = Plane> {
    particles: &'a SolidParticles<S>,
    range: Range<usize>,
}

impl<S: Space> BodyParticles<'_, S> {
    /// Mass Σ m \[kg\], in the plane per depth.
    pub fn mass(&self) -> f64 {
        self.range.clone().map(|i| self.particles.mass[i]).sum()
    }

    /// Moment of inertia of the particles' cells about their own centres and any axis \[kg m²\], in the plane per depth.
    pub fn cell_inertia(&self) -> f64 {
        let SolidParticles { mass, density, .. } = self.particles;
        self.range.clone().map(|i| S::cell_inertia(mass[i], density[i])).sum()
    }

    /// Indices of the particles, and their centre of mass \[m\].
    fn about_centre(&self) -> (Range<usize>, S::Vector) {
        let SolidParticles { mass, reference_position: x, .. } = self.particles;
        let own = || self.range.clone();
        (own(), own().map(|i| x[i] * mass[i]).sum::<S::Vector>() / self.mass())
    }
}

impl BodyParticles<'_, Plane> {
    /// Moment of inertia per depth of a rigid body about its centre of mass, Σ m (|r|² + V/6) \[kg m\].
    pub fn inertia(&self) -> f64 {
        let SolidParticles { mass, reference_position: x, .. } = self.particles;
        let (own, centre) = self.about_centre();
        own.map(|i| mass[i] * (x[i] - centre).norm_squared()).sum::<f64>() + self.cell_inertia()
    }
}

impl BodyParticles<'_, Spatial> {
    /// Moment of inertia of a rigid body about its centre of mass, Σ m ((|r|² + a²/6) I − r ⊗ r) \[kg m²\].
    pub fn inertia(&self) -> SymmetricTensor3 {
        let SolidParticles { mass, reference_position: x, .. } = self.particles;
        let (own, centre) = self.about_centre();
        let second: <Spatial as Space>::Tensor = own
            .map(|i| <Spatial as Space>::Tensor::outer(&(x[i] - centre), &(x[i] - centre)) * mass[i])
            .sum();
        let isotropic = SymmetricTensor3::isotropic(second.trace() + self.cell_inertia());
        isotropic.plus(&SymmetricTensor3::of(&-second))
    }
}
