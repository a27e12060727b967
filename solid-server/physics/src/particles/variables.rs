//! Variables that the time scheme advances, of particles and of rigid bodies.

use std::ops::Range;

use sph::space::domain::Domain;

use crate::space::SolidSpace;

/// Quantities φ of Eq. (29), one entry per particle of all bodies.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Particles<S: SolidSpace> {
    /// Position \[m\], inside the box along periodic directions.
    pub position: Vec<S::Vector>,
    /// Velocity \[m/s\].
    pub velocity: Vec<S::Vector>,
    /// Density \[kg/m³\].
    pub density: Vec<f64>,
    /// Deviatoric stress s \[Pa\].
    pub deviatoric_stress: Vec<S::SymmetricTensor>,
}

/// The particles of one body.
#[derive(Clone, Copy)]
pub struct ParticleView<'a, S: SolidSpace> {
    pub position: &'a [S::Vector],
    pub velocity: &'a [S::Vector],
    pub density: &'a [f64],
    pub deviatoric_stress: &'a [S::SymmetricTensor],
}

/// The particles of one body, to be written.
pub struct ParticleViewMut<'a, S: SolidSpace> {
    pub position: &'a mut [S::Vector],
    pub velocity: &'a mut [S::Vector],
    pub density: &'a mut [f64],
    pub deviatoric_stress: &'a mut [S::SymmetricTensor],
}

impl<S: SolidSpace> Particles<S> {
    /// Number of particles.
    pub fn len(&self) -> usize {
        self.position.len()
    }

    /// Takes over `other`, keeping the allocations.
    pub fn copy_from(&mut self, other: &Self) {
        self.position.clone_from(&other.position);
        self.velocity.clone_from(&other.velocity);
        self.density.clone_from(&other.density);
        self.deviatoric_stress.clone_from(&other.deviatoric_stress);
    }

    /// Particles of the body that holds `range`.
    pub fn view(&self, range: &Range<usize>) -> ParticleView<'_, S> {
        ParticleView {
            position: &self.position[range.clone()],
            velocity: &self.velocity[range.clone()],
            density: &self.density[range.clone()],
            deviatoric_stress: &self.deviatoric_stress[range.clone()],
        }
    }

    /// As [`Particles::view`], to be written.
    pub fn view_mut(&mut self, range: &Range<usize>) -> ParticleViewMut<'_, S> {
        ParticleViewMut {
            position: &mut self.position[range.clone()],
            velocity: &mut self.velocity[range.clone()],
            density: &mut self.density[range.clone()],
            deviatoric_stress: &mut self.deviatoric_stress[range.clone()],
        }
    }
}

/// Vector by which a particle wrapped by `image_counts` whole periods has been moved \[m\].
///
/// Positions stay inside the box; adding this gives the path of the material.
#[inline]
pub fn image_offset<S: SolidSpace>(domain: &Domain<S>, image_counts: &S::Of<i32>) -> S::Vector {
    let mut offset = domain.size();
    for axis in 0..S::DIMENSIONS {
        let count = image_counts[axis];
        offset[axis] = if count == 0 { 0.0 } else { f64::from(count) * offset[axis] };
    }
    offset
}

/// Motion of a rigid body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RigidState<S: SolidSpace> {
    /// Centre of mass \[m\], not wrapped along periodic directions.
    pub centre: S::Vector,
    /// Its velocity \[m/s\].
    pub velocity: S::Vector,
    /// Rotation since the start.
    pub rotation: S::Rotation,
    /// Angular velocity \[rad/s\].
    pub angular_velocity: S::Spin,
}
