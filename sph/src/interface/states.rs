//! States of one side's interface particles in the vectors of the space.

use serde::{Deserialize, Serialize};

use crate::coupling::exchange::StateColumns;
use crate::space::{Plane, Space};

/// States of the particles of one side that may lie within support of the other, ids ascending.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(bound(serialize = "", deserialize = ""))]
pub struct InterfaceStates<S: Space = Plane> {
    /// Identity among the owner's particles, strictly ascending.
    pub id: Vec<u32>,
    /// Region (fluid) or body (solid) of each particle.
    pub group: Vec<u32>,
    /// Mass \[kg\], in the plane per depth.
    pub mass: Vec<f64>,
    /// Position \[m\].
    pub position: Vec<S::Vector>,
    /// Velocity \[m/s\].
    pub velocity: Vec<S::Vector>,
    /// Density \[kg/m³\].
    pub density: Vec<f64>,
    /// Pressure \[Pa\]; of a solid, −σ_kk/3 by Eq. (5).
    pub pressure: Vec<f64>,
    /// Cauchy stress σ \[Pa\]; empty unless the law needs it.
    pub stress: Vec<S::SymmetricTensor>,
}

impl<S: Space> InterfaceStates<S> {
    /// Number of particles.
    pub fn len(&self) -> usize {
        self.id.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.id.is_empty()
    }

    /// Volume of particle `i` \[m³\], in the plane per depth.
    pub fn volume(&self, i: usize) -> f64 {
        self.mass[i] / self.density[i]
    }

    /// The particles of `parts`, each ids ascending, ids ascending; and of each its part and its index there.
    pub fn joined(parts: &[Self]) -> (Self, Vec<(usize, usize)>) {
        let indices = |(part, states): (usize, &Self)| (0..states.len()).map(move |i| (part, i));
        let mut origins: Vec<_> = parts.iter().enumerate().flat_map(indices).collect();
        origins.sort_by_key(|(part, i)| parts[*part].id[*i]);
        let each = || origins.iter().map(|(part, i)| (&parts[*part], *i));
        let states = Self {
            id: each().map(|(states, i)| states.id[i]).collect(),
            group: each().map(|(states, i)| states.group[i]).collect(),
            mass: each().map(|(states, i)| states.mass[i]).collect(),
            position: each().map(|(states, i)| states.position[i]).collect(),
            velocity: each().map(|(states, i)| states.velocity[i]).collect(),
            density: each().map(|(states, i)| states.density[i]).collect(),
            pressure: each().map(|(states, i)| states.pressure[i]).collect(),
            stress: each().filter_map(|(states, i)| states.stress.get(i).copied()).collect(),
        };
        (states, origins)
    }

    /// Removes all particles, keeping the allocations.
    pub fn clear(&mut self) {
        self.read(&StateColumns::default());
    }

    /// Takes over the states of `columns`.
    pub fn read(&mut self, columns: &StateColumns) {
        let Self { id, group, mass, position, velocity, density, pressure, stress } = self;
        id.clone_from(&columns.id);
        group.clone_from(&columns.group);
        mass.clone_from(&columns.mass);
        columns.position.read_into(position);
        columns.velocity.read_into(velocity);
        density.clone_from(&columns.density);
        pressure.clone_from(&columns.pressure);
        columns.stress.read_into(stress);
    }

    /// Writes the states to `columns`.
    pub fn write(&self, columns: &mut StateColumns) {
        columns.id.clone_from(&self.id);
        columns.group.clone_from(&self.group);
        columns.mass.clone_from(&self.mass);
        columns.position.fill(self.position.iter().copied());
        columns.velocity.fill(self.velocity.iter().copied());
        columns.density.clone_from(&self.density);
        columns.pressure.clone_from(&self.pressure);
        columns.stress.fill(self.stress.iter().copied());
    }
}

impl<S: Space> From<&StateColumns> for InterfaceStates<S> {
    fn from(columns: &StateColumns) -> Self {
        let mut states = Self::default();
        states.read(columns);
        states
    }
}

impl<S: Space> From<&InterfaceStates<S>> for StateColumns {
    fn from(states: &InterfaceStates<S>) -> Self {
        let mut columns = Self::default();
        states.write(&mut columns);
        columns
    }
}
