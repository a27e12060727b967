//! Variables that the time scheme advances, of particles and of rigid bodies.

use std::ops::Range;

use sph::space::domain::Domain;
use sph::space::{SymmetricTensor, Vector};

/// Quantities φ of Eq. (29), one entry per particle of all bodies.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Particles {
    /// Position \[m\], inside the box along periodic directions.
    pub position: Vec<Vector>,
    /// Velocity \[m/s\].
    pub velocity: Vec<Vector>,
    /// Density \[kg/m³\].
    pub density: Vec<f64>,
    /// Deviatoric stress s \[Pa\].
    pub deviatoric_stress: Vec<SymmetricTensor>,
}

/// The particles of one body.
#[derive(Clone, Copy)]
pub struct ParticleView<'a> {
    pub position: &'a [Vector],
    pub velocity: &'a [Vector],
    pub density: &'a [f64],
    pub deviatoric_stress: &'a [SymmetricTensor],
}

/// The particles of one body, to be written.
pub struct ParticleViewMut<'a> {
    pub position: &'a mut [Vector],
    pub velocity: &'a mut [Vector],
    pub density: &'a mut [f64],
    pub deviatoric_stress: &'a mut [SymmetricTensor],
}

impl Particles {
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
    pub fn view(&self, range: &Range<usize>) -> ParticleView<'_> {
        ParticleView {
            position: &self.position[range.clone()],
            velocity: &self.velocity[range.clone()],
            density: &self.density[range.clone()],
            deviatoric_stress: &self.deviatoric_stress[range.clone()],
        }
    }

    /// As [`Particles::view`], to be written.
    pub fn view_mut(&mut self, range: &Range<usize>) -> ParticleViewMut<'_> {
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
pub fn image_offset(domain: &Domain, image_counts: &[i32; 2]) -> Vector {
    let period = domain.size();
    Vector::from_fn(
        |axis, _| if image_counts[axis] == 0 { 0.0 } else { f64::from(image_counts[axis]) * period[axis] },
    )
}

/// Motion of a rigid body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidState {
    /// Centre of mass \[m\], not wrapped along periodic directions.
    pub centre: Vector,
    /// Its velocity \[m/s\].
    pub velocity: Vector,
    /// Angle turned since the start, counter-clockwise \[rad\].
    pub angle: f64,
    /// Angular velocity \[rad/s\].
    pub angular_velocity: f64,
}

impl Default for RigidState {
    fn default() -> Self {
        Self { centre: Vector::zeros(), velocity: Vector::zeros(), angle: 0.0, angular_velocity: 0.0 }
    }
}
