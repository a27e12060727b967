//! Constants of each particle.

use crate::space::SolidSpace;

/// Constants of each particle throughout a run.
pub struct ParticleConstants<S: SolidSpace> {
    pub id: Vec<u32>,
    /// Index of the body.
    pub body: Vec<u32>,
    /// 0 free, k the body's support k−1.
    pub support: Vec<u32>,
    /// Mass per depth \[kg/m\].
    pub mass: Vec<f64>,
    /// Position in the undeformed body \[m\].
    pub reference_position: Vec<S::Vector>,
}

impl<S: SolidSpace> ParticleConstants<S> {
    /// Number of particles.
    pub fn len(&self) -> usize {
        self.mass.len()
    }
}
