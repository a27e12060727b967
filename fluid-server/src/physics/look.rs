//! What is made of each particle of a new state at once, while it is at hand: its record and whether it is healthy.

use sph::equation_of_state::Tait;
use sph::vector::Vector;

use super::checks::{Findings, Limits, Values};
use super::model::FluidModel;
use super::record::Record;
use super::state::ListOrigin;

/// A look at the particles of one state.
#[derive(Clone, Copy, Debug)]
pub struct Look<'a> {
    equation_of_state: Tait,
    limits: Limits,
    origin: Option<&'a [Vector]>,
}

impl<'a> Look<'a> {
    /// A look at a state whose lists were built from `origin`, if there are any.
    pub fn new(model: &FluidModel, origin: Option<&'a ListOrigin>) -> Self {
        Self {
            equation_of_state: model.equation_of_state,
            limits: Limits::of(model),
            origin: origin.map(|origin| &origin.position[..]),
        }
    }

    /// The record of particle `i` of `mass` per depth \[kg/m\], with what is found of it added to `found`.
    ///
    /// It shows `velocity` \[m/s\] to its neighbours, or else its own.
    #[inline(always)]
    pub fn at(
        &self,
        i: usize,
        values: Values<'_>,
        mass: f64,
        velocity: Option<Vector>,
        found: &mut Findings,
    ) -> Record {
        let (x, v, density) = values;
        found.add(&self.limits, i, values, self.origin.map(|origin| &origin[i]));
        let pressure = self.equation_of_state.pressure(density);
        Record::new(x, &velocity.unwrap_or(*v), density, pressure, mass / density)
    }
}
