//! Results of the gradient pass.

use super::particle_rates::Rates;
use crate::equations::correction::in_momentum;
use crate::equations::neighbour_sums::NeighbourSums;
use crate::equations::tensors::{IDENTITY, Matrix, Symmetric};
use crate::free_surface::shifting::OrderLocal;
use crate::system::model::{FluidModel, Passes};
use crate::system::tasks::Split;

/// What the pass makes for each fluid particle; arrays that a scene does not need stay empty.
#[derive(Debug, Default)]
pub struct Gradients {
    /// Raw sums, where there is a partner.
    pub(super) sums: Vec<NeighbourSums>,
    /// What neighbours read: q of the damper \[Pa\], mark of the order control, ∇ρ of Eq. (20) \[kg/m⁴\].
    pub shown: Vec<[f64; 4]>,
    /// L_i of Eq. (21), or the unit matrix where few neighbours define it.
    pub correction: Vec<Symmetric>,
    /// What the order control keeps.
    pub order: Vec<OrderLocal>,
    /// Viscous stress τ of Eq. (4), or the part of it that the viscous pair force leaves out \[Pa\].
    pub viscous_stress: Vec<Matrix>,
    /// T = −σ·L \[Pa\].
    pub tensor: Vec<Matrix>,
    /// Viscosity in the viscous pair force \[Pa s\].
    pub viscosity: Vec<f64>,
    /// What follows for particles that meet a partner's, until it is put in place.
    pub(super) merged: Vec<(NeighbourSums, Finished)>,
}

/// A task's part of [`Gradients`].
pub struct Results<'a> {
    /// Raw sums.
    pub sums: &'a mut [NeighbourSums],
    shown: &'a mut [[f64; 4]],
    correction: &'a mut [Symmetric],
    order: &'a mut [OrderLocal],
    viscous_stress: &'a mut [Matrix],
    tensor: &'a mut [Matrix],
    viscosity: &'a mut [f64],
    /// Whose density rates the pass makes, with leapfrog.
    rates: &'a mut [Rates],
}

impl Split for Results<'_> {
    fn split(self, at: usize) -> (Self, Self) {
        let (sums, shown) = (self.sums.split(at), self.shown.split(at));
        let correction = self.correction.split(at);
        let (order, viscous_stress) = (self.order.split(at), self.viscous_stress.split(at));
        let (tensor, viscosity) = (self.tensor.split(at), self.viscosity.split(at));
        let rates = self.rates.split(at);
        (
            Self {
                sums: sums.0,
                shown: shown.0,
                correction: correction.0,
                order: order.0,
                viscous_stress: viscous_stress.0,
                tensor: tensor.0,
                viscosity: viscosity.0,
                rates: rates.0,
            },
            Self {
                sums: sums.1,
                shown: shown.1,
                correction: correction.1,
                order: order.1,
                viscous_stress: viscous_stress.1,
                tensor: tensor.1,
                viscosity: viscosity.1,
                rates: rates.1,
            },
        )
    }
}

impl Gradients {
    /// Arrays for `particles`, as far as the scene needs them.
    pub fn resize(&mut self, passes: Passes, particles: usize, partner: bool) {
        let of = |needed: bool| if needed { particles } else { 0 };
        self.sums.resize(of(partner), NeighbourSums::default());
        self.shown.resize(of(passes.shown()), [0.0; 4]);
        self.correction.resize(of(passes.correction), Symmetric::default());
        self.order.resize(of(passes.order), OrderLocal::default());
        self.viscous_stress.resize(of(passes.viscosity || passes.pair_viscosity), Matrix::default());
        self.tensor.resize(of(passes.tensor()), Matrix::default());
        self.viscosity.resize(of(passes.pair_viscosity), 0.0);
    }

    /// The arrays that the pass fills; `rates` with leapfrog.
    pub fn results<'a>(&'a mut self, passes: Passes, rates: &'a mut [Rates]) -> Results<'a> {
        let Self { sums, shown, correction, order, viscous_stress, tensor, viscosity, .. } = self;
        let rates = if passes.leapfrog { rates } else { &mut [] };
        Results { sums, shown, correction, order, viscous_stress, tensor, viscosity, rates }
    }

    /// q of the acoustic damper of particle `i` \[Pa\].
    #[inline(always)]
    pub fn damper(&self, i: usize) -> f64 {
        self.shown.get(i).map_or(0.0, |shown| shown[0])
    }

    /// L_i of particle `i` as Eq. (22) takes it.
    #[inline(always)]
    pub fn in_momentum(&self, model: &FluidModel, i: usize) -> Symmetric {
        self.correction.get(i).map_or(IDENTITY, |correction| in_momentum(model, correction))
    }

    /// Bytes in use.
    pub fn bytes(&self) -> usize {
        fn bytes<T>(values: &Vec<T>) -> usize {
            values.capacity() * size_of::<T>()
        }
        let Self { sums, shown, correction, order, viscous_stress, tensor, viscosity, merged } = self;
        bytes(sums)
            + bytes(shown)
            + bytes(correction)
            + bytes(order)
            + bytes(viscous_stress)
            + bytes(tensor)
            + bytes(viscosity)
            + bytes(merged)
    }
}

/// What follows for one particle.
#[derive(Clone, Copy, Debug)]
pub struct Finished {
    /// What neighbours read.
    pub shown: [f64; 4],
    /// L_i.
    pub correction: Symmetric,
    /// Order control.
    pub order: OrderLocal,
    /// Viscous stress \[Pa\].
    pub viscous_stress: Matrix,
    /// T \[Pa\].
    pub tensor: Matrix,
    /// Viscosity \[Pa s\].
    pub viscosity: f64,
    /// Density rate with leapfrog \[kg/(m³ s)\].
    pub density_rate: f64,
}

impl Results<'_> {
    /// Puts the results of particle `k` in place.
    #[inline(always)]
    pub fn put(&mut self, k: usize, finished: &Finished) {
        put(self.shown, k, finished.shown);
        put(self.correction, k, finished.correction);
        put(self.order, k, finished.order);
        put(self.viscous_stress, k, finished.viscous_stress);
        put(self.tensor, k, finished.tensor);
        put(self.viscosity, k, finished.viscosity);
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
