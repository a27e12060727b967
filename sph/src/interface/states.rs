//! States of one side's interface particles in the vectors of the space.

use crate::coupling::exchange::{Column, StateColumns};
use crate::space::{SymmetricTensor, Vector};

/// States of the particles of one side that may lie within support of the other, ids ascending.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InterfaceStates {
    /// Identity among the owner's particles, strictly ascending.
    pub id: Vec<u32>,
    /// Region (fluid) or body (solid) of each particle.
    pub group: Vec<u32>,
    /// Mass \[kg\].
    pub mass: Vec<f64>,
    /// Position \[m\].
    pub position: Vec<Vector>,
    /// Velocity \[m/s\].
    pub velocity: Vec<Vector>,
    /// Density \[kg/m³\].
    pub density: Vec<f64>,
    /// Pressure \[Pa\]; of a solid, −σ_kk/3 by Eq. (5).
    pub pressure: Vec<f64>,
    /// Cauchy stress σ \[Pa\]; empty unless the law needs it.
    pub stress: Vec<SymmetricTensor>,
}

impl InterfaceStates {
    /// Number of particles.
    pub fn len(&self) -> usize {
        self.id.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.id.is_empty()
    }

    /// Volume of particle `i` \[m³\].
    pub fn volume(&self, i: usize) -> f64 {
        self.mass[i] / self.density[i]
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
        read_vectors(&columns.position, position);
        read_vectors(&columns.velocity, velocity);
        density.clone_from(&columns.density);
        pressure.clone_from(&columns.pressure);
        stress.clear();
        stress.extend(columns.stress.arrays().map(|[xx, yy, xy]| SymmetricTensor { xx, yy, xy }));
    }

    /// Writes the states to `columns`.
    pub fn write(&self, columns: &mut StateColumns) {
        columns.id.clone_from(&self.id);
        columns.group.clone_from(&self.group);
        columns.mass.clone_from(&self.mass);
        write_vectors(self.position.iter().copied(), &mut columns.position);
        write_vectors(self.velocity.iter().copied(), &mut columns.velocity);
        columns.density.clone_from(&self.density);
        columns.pressure.clone_from(&self.pressure);
        columns.stress.fill(self.stress.iter().map(|stress| [stress.xx, stress.yy, stress.xy]));
    }
}

impl From<&StateColumns> for InterfaceStates {
    fn from(columns: &StateColumns) -> Self {
        let mut states = Self::default();
        states.read(columns);
        states
    }
}

impl From<&InterfaceStates> for StateColumns {
    fn from(states: &InterfaceStates) -> Self {
        let mut columns = Self::default();
        states.write(&mut columns);
        columns
    }
}

/// Takes over the vectors of `column` in place of what `vectors` held.
pub fn read_vectors(column: &Column, vectors: &mut Vec<Vector>) {
    vectors.clear();
    vectors.extend(column.arrays().map(|row: [f64; 2]| Vector::from(row)));
}

/// Writes `vectors` to `column`.
pub fn write_vectors(vectors: impl IntoIterator<Item = Vector>, column: &mut Column) {
    column.fill(vectors.into_iter().map(<[f64; 2]>::from));
}
