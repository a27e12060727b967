//! Stress of the particles and rates of their variables.

use std::ops::Range;

use sph::space::tensors::SpaceSymmetric;
use sph::space::{SymmetricTensor, Tensor};

/// Stress of all particles.
#[derive(Debug, Default)]
pub struct StressFields {
    /// Pressure \[Pa\].
    pub pressure: Vec<f64>,
    /// Cauchy stress \[Pa\].
    pub cauchy: Vec<SymmetricTensor>,
    /// Artificial stress R_i of Eq. (25) \[m⁵/(kg s²)\].
    pub artificial: Vec<SymmetricTensor>,
    /// Deformation gradient F \[-\]; of total-Lagrangian bodies only.
    pub deformation: Vec<Tensor>,
    /// Tensor N of the pair forces \[-\], see `Reference::pair_tensor`; of total-Lagrangian bodies only.
    pub pair_tensor: Vec<Tensor>,
}

/// Rates of all particles' own variables.
#[derive(Debug, Default)]
pub struct Rates {
    /// dρ/dt \[kg/(m³ s)\].
    pub density: Vec<f64>,
    /// ds/dt \[Pa/s\].
    pub deviatoric_stress: Vec<SymmetricTensor>,
}

/// Stress of a body's particles at one stage.
#[derive(Clone, Copy)]
pub struct StressView<'a> {
    /// Pressure \[Pa\].
    pub pressure: &'a [f64],
    /// Cauchy stress \[Pa\].
    pub cauchy: &'a [SymmetricTensor],
    /// Artificial stress R_i of Eq. (25) \[m⁵/(kg s²)\].
    pub artificial: &'a [SymmetricTensor],
    /// Deformation gradient F \[-\]; used by total-Lagrangian bodies alone.
    pub deformation: &'a [Tensor],
    /// Tensor N of the pair forces \[-\], see `Reference::pair_tensor`; likewise.
    pub pair_tensor: &'a [Tensor],
}

/// As [`StressView`], to be written.
pub struct StressViewMut<'a> {
    /// Pressure \[Pa\].
    pub pressure: &'a mut [f64],
    pub cauchy: &'a mut [SymmetricTensor],
    pub artificial: &'a mut [SymmetricTensor],
    pub deformation: &'a mut [Tensor],
    pub pair_tensor: &'a mut [Tensor],
}

/// Rates of a body's own variables.
#[derive(Clone, Copy)]
pub struct RateView<'a> {
    /// dρ/dt \[kg/(m³ s)\].
    pub density: &'a [f64],
    /// ds/dt \[Pa/s\].
    pub deviatoric_stress: &'a [SymmetricTensor],
}

/// As [`RateView`], to be written.
pub struct RateViewMut<'a> {
    pub density: &'a mut [f64],
    pub deviatoric_stress: &'a mut [SymmetricTensor],
}

impl StressFields {
    /// Fields of `count` particles.
    pub fn new(count: usize) -> Self {
        Self {
            pressure: vec![0.0; count],
            cauchy: vec![SymmetricTensor::default(); count],
            artificial: vec![SymmetricTensor::default(); count],
            deformation: vec![Tensor::identity(); count],
            pair_tensor: vec![Tensor::zeros(); count],
        }
    }

    /// The part of one body.
    pub fn view(&self, range: &Range<usize>) -> StressView<'_> {
        StressView {
            pressure: &self.pressure[range.clone()],
            cauchy: &self.cauchy[range.clone()],
            artificial: &self.artificial[range.clone()],
            deformation: &self.deformation[range.clone()],
            pair_tensor: &self.pair_tensor[range.clone()],
        }
    }

    /// As [`StressFields::view`], to be written.
    pub fn view_mut(&mut self, range: &Range<usize>) -> StressViewMut<'_> {
        StressViewMut {
            pressure: &mut self.pressure[range.clone()],
            cauchy: &mut self.cauchy[range.clone()],
            artificial: &mut self.artificial[range.clone()],
            deformation: &mut self.deformation[range.clone()],
            pair_tensor: &mut self.pair_tensor[range.clone()],
        }
    }

    /// Deviator of the stress of particle `i` \[Pa\].
    pub fn deviator(&self, i: usize) -> SymmetricTensor {
        self.cauchy[i].plus(&SymmetricTensor::isotropic(self.pressure[i]))
    }
}

impl Rates {
    /// Rates of `count` particles.
    pub fn new(count: usize) -> Self {
        Self { density: vec![0.0; count], deviatoric_stress: vec![SymmetricTensor::default(); count] }
    }

    /// The part of one body.
    pub fn view(&self, range: &Range<usize>) -> RateView<'_> {
        RateView {
            density: &self.density[range.clone()],
            deviatoric_stress: &self.deviatoric_stress[range.clone()],
        }
    }

    /// As [`Rates::view`], to be written.
    pub fn view_mut(&mut self, range: &Range<usize>) -> RateViewMut<'_> {
        RateViewMut {
            density: &mut self.density[range.clone()],
            deviatoric_stress: &mut self.deviatoric_stress[range.clone()],
        }
    }
}
