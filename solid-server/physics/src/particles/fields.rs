//! Stress of the particles and rates of their variables.

use std::ops::Range;

use sph::space::tensors::SpaceTensor;

use crate::materials::hooke::deviatoric_stress;
use crate::space::SolidSpace;

/// Stress of all particles.
#[derive(Debug, Default)]
pub struct StressFields<S: SolidSpace> {
    /// Pressure \[Pa\].
    pub pressure: Vec<f64>,
    /// Cauchy stress \[Pa\].
    pub cauchy: Vec<S::SymmetricTensor>,
    /// Artificial stress R_i of Eq. (25) \[m⁵/(kg s²)\].
    pub artificial: Vec<S::SymmetricTensor>,
    /// Deformation gradient F \[-\]; of total-Lagrangian bodies only.
    pub deformation: Vec<S::Tensor>,
    /// Tensor N of the pair forces \[-\], see `Reference::pair_tensor`; of total-Lagrangian bodies only.
    pub pair_tensor: Vec<S::Matrix<f64>>,
}

/// Rates of all particles' own variables.
#[derive(Debug, Default)]
pub struct Rates<S: SolidSpace> {
    /// dρ/dt \[kg/(m³ s)\].
    pub density: Vec<f64>,
    /// ds/dt \[Pa/s\].
    pub deviatoric_stress: Vec<S::SymmetricTensor>,
}

/// Stress of a body's particles at one stage.
#[derive(Clone, Copy)]
pub struct StressView<'a, S: SolidSpace> {
    /// Pressure \[Pa\].
    pub pressure: &'a [f64],
    /// Cauchy stress \[Pa\].
    pub cauchy: &'a [S::SymmetricTensor],
    /// Artificial stress R_i of Eq. (25) \[m⁵/(kg s²)\].
    pub artificial: &'a [S::SymmetricTensor],
    /// Deformation gradient F \[-\]; used by total-Lagrangian bodies alone.
    pub deformation: &'a [S::Tensor],
    /// Tensor N of the pair forces \[-\], see `Reference::pair_tensor`; likewise.
    pub pair_tensor: &'a [S::Matrix<f64>],
}

/// As [`StressView`], to be written.
pub struct StressViewMut<'a, S: SolidSpace> {
    /// Pressure \[Pa\].
    pub pressure: &'a mut [f64],
    pub cauchy: &'a mut [S::SymmetricTensor],
    pub artificial: &'a mut [S::SymmetricTensor],
    pub deformation: &'a mut [S::Tensor],
    pub pair_tensor: &'a mut [S::Matrix<f64>],
}

/// Rates of a body's own variables.
#[derive(Clone, Copy)]
pub struct RateView<'a, S: SolidSpace> {
    /// dρ/dt \[kg/(m³ s)\].
    pub density: &'a [f64],
    /// ds/dt \[Pa/s\].
    pub deviatoric_stress: &'a [S::SymmetricTensor],
}

/// As [`RateView`], to be written.
pub struct RateViewMut<'a, S: SolidSpace> {
    pub density: &'a mut [f64],
    pub deviatoric_stress: &'a mut [S::SymmetricTensor],
}

impl<S: SolidSpace> StressFields<S> {
    /// Fields of `count` particles.
    pub fn new(count: usize) -> Self {
        Self {
            pressure: vec![0.0; count],
            cauchy: vec![S::SymmetricTensor::default(); count],
            artificial: vec![S::SymmetricTensor::default(); count],
            deformation: vec![S::Tensor::identity(); count],
            pair_tensor: vec![S::zero_matrix(); count],
        }
    }

    /// The part of one body.
    pub fn view(&self, range: &Range<usize>) -> StressView<'_, S> {
        StressView {
            pressure: &self.pressure[range.clone()],
            cauchy: &self.cauchy[range.clone()],
            artificial: &self.artificial[range.clone()],
            deformation: &self.deformation[range.clone()],
            pair_tensor: &self.pair_tensor[range.clone()],
        }
    }

    /// As [`StressFields::view`], to be written.
    pub fn view_mut(&mut self, range: &Range<usize>) -> StressViewMut<'_, S> {
        StressViewMut {
            pressure: &mut self.pressure[range.clone()],
            cauchy: &mut self.cauchy[range.clone()],
            artificial: &mut self.artificial[range.clone()],
            deformation: &mut self.deformation[range.clone()],
            pair_tensor: &mut self.pair_tensor[range.clone()],
        }
    }

    /// Deviator of the stress of particle `i` \[Pa\].
    pub fn deviator(&self, i: usize) -> S::SymmetricTensor {
        deviatoric_stress::<S>(self.pressure[i], &self.cauchy[i])
    }
}

impl<S: SolidSpace> Rates<S> {
    /// Rates of `count` particles.
    pub fn new(count: usize) -> Self {
        Self { density: vec![0.0; count], deviatoric_stress: vec![S::SymmetricTensor::default(); count] }
    }

    /// The part of one body.
    pub fn view(&self, range: &Range<usize>) -> RateView<'_, S> {
        RateView {
            density: &self.density[range.clone()],
            deviatoric_stress: &self.deviatoric_stress[range.clone()],
        }
    }

    /// As [`Rates::view`], to be written.
    pub fn view_mut(&mut self, range: &Range<usize>) -> RateViewMut<'_, S> {
        RateViewMut {
            density: &mut self.density[range.clone()],
            deviatoric_stress: &mut self.deviatoric_stress[range.clone()],
        }
    }
}
