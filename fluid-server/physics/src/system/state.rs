//! The state of the fluid: everything that a checkpoint must hold.

use std::ops::Range;

use serde::{Deserialize, Serialize};
use sph::coupling::ledger::EnergyTally;
use sph::laws::equation_of_state::Tait;
use sph::space::Space;
use sph::space::domain::Domain;
use sph::space::tensors::SpaceVector;
use sph::tasks::for_each;

use super::tasks::TASK;
use crate::time::step_control::StepControl;

/// The fluid at a step boundary; everything else follows from it and the model.
///
/// The order of the particles is part of the state: it decides the order of every sum.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(bound(serialize = "", deserialize = ""))]
pub struct FluidState<S: Space> {
    /// Numbers that ascend in the order of the particles of all parts of the fluid; empty where there is one part.
    pub order: Vec<u64>,
    /// Number of particles of other parts.
    pub others: usize,
    /// Identity of each particle.
    pub id: Vec<u32>,
    /// Region of each particle.
    pub region: Vec<u32>,
    /// Mass per depth \[kg/m\].
    pub mass: Vec<f64>,
    /// Position \[m\].
    pub position: Vec<S::Vector>,
    /// Velocity \[m/s\].
    pub velocity: Vec<S::Vector>,
    /// Density \[kg/m³\].
    pub density: Vec<f64>,
    /// Origin of the neighbour lists; `None` where they must be rebuilt.
    pub list_origin: Option<ListOrigin<S>>,
    /// Skin of the neighbour lists \[m\].
    pub list_skin: f64,
    /// Momentum of the particles removed at the end of the last step \[kg/s\], accounted in the next.
    pub removed_momentum: S::Vector,
    /// Their angular momentum about the domain's torque origin \[kg m/s\].
    pub removed_angular_momentum: S::Spin,
    /// Largest acceleration of the last stage \[m/s²\].
    pub largest_acceleration: f64,
    /// Density rate at the start of the last step \[kg/(m³ s)\]; with leapfrog only.
    pub density_rate: Vec<f64>,
    /// Density rate by diffusion and volume correction in the last step, one half of which the next one applies
    /// \[kg/(m³ s)\]; with leapfrog only.
    pub density_correction: Vec<f64>,
    /// Acceleration in the last step \[m/s²\]; with leapfrog only.
    pub acceleration: Vec<S::Vector>,
    /// Time over which `density_rate` and `density_correction` were applied up to the last boundary: half the last step
    /// \[s\].
    pub density_age: f64,
    /// Pressure q of the acoustic relaxation \[Pa\]; empty without it.
    pub relaxation: Vec<f64>,
    /// Share of its volume that each particle claims in excess, as last read \[-\]; empty without volume correction.
    pub volume_excess: Vec<f64>,
    /// Energy at the start, and works and losses since.
    pub energy: EnergyTally,
    /// What the last steps say of the next.
    pub control: StepControl,
    /// Particles that crossed a wall or a closed side.
    pub escaped: u64,
    /// Particles that left over an open rim or through an outflow side.
    pub outflow: u64,
    /// Neighbour list builds.
    pub list_builds: u64,
}

/// The input that determines content and order of the neighbour lists.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(bound(serialize = "", deserialize = ""))]
pub struct ListOrigin<S: Space> {
    /// Time to which moving walls belong \[s\].
    pub time: f64,
    /// Positions of the fluid \[m\].
    pub position: Vec<S::Vector>,
}

/// The state at the start of a step, from which both stages of Eq. (30)-(31) advance; empty with leapfrog.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(bound(serialize = "", deserialize = ""))]
pub struct StepStart<S: Space> {
    /// Position \[m\].
    pub position: Vec<S::Vector>,
    /// Velocity \[m/s\].
    pub velocity: Vec<S::Vector>,
    /// Density \[kg/m³\].
    pub density: Vec<f64>,
    /// Pressure q of the acoustic relaxation \[Pa\]; empty without it.
    pub relaxation: Vec<f64>,
}

impl<S: Space> StepStart<S> {
    /// Arrays for the particles of `state`.
    pub fn resize(&mut self, state: &FluidState<S>) {
        self.position.resize(state.len(), S::Vector::zeros());
        self.velocity.resize(state.len(), S::Vector::zeros());
        self.density.resize(state.len(), 0.0);
        self.relaxation.resize(state.relaxation.len(), 0.0);
    }

    /// Bytes in use.
    pub fn bytes(&self) -> usize {
        8 * (self.density.capacity() + self.relaxation.capacity())
            + size_of::<S::Vector>() * (self.position.capacity() + self.velocity.capacity())
    }
}

impl<S: Space> FluidState<S> {
    /// Bytes in use.
    pub fn bytes(&self) -> usize {
        let Self {
            id,
            region,
            mass,
            position,
            velocity,
            density,
            list_origin,
            density_rate,
            density_correction,
            acceleration,
            relaxation,
            volume_excess,
            ..
        } = self;
        let origin = list_origin.as_ref().map_or(0, |origin| origin.position.capacity());
        4 * (id.capacity() + region.capacity())
            + 8 * [mass, density, density_rate, density_correction, relaxation, volume_excess]
                .map(Vec::capacity)
                .iter()
                .sum::<usize>()
            + size_of::<S::Vector>()
                * (position.capacity() + velocity.capacity() + acceleration.capacity() + origin)
    }

    /// Pressure of particle `i` \[Pa\]: Eq. (3), and with acoustic relaxation q beside it.
    pub fn pressure(&self, equation_of_state: &Tait, i: usize) -> f64 {
        let pressure = equation_of_state.pressure(self.density[i]);
        self.relaxation.get(i).map_or(pressure, |q| pressure + q)
    }

    /// Number of particles.
    pub fn len(&self) -> usize {
        self.id.len()
    }

    /// Sorts the particles, with `base` where it is in use, by `order`: entry k is the old index.
    ///
    /// Positions of the last list build are overwritten: their memory is used for sorting.
    pub fn reorder(&mut self, base: &mut StepStart<S>, order: &[u32], scratch: Scratch) {
        let Self {
            order: numbers,
            id,
            region,
            mass,
            position,
            velocity,
            density,
            list_origin,
            density_rate,
            density_correction,
            acceleration,
            relaxation,
            volume_excess,
            ..
        } = self;
        reorder(numbers, order, &mut Vec::new());
        let vectors = &mut list_origin.get_or_insert_default().position;
        for values in [id, region] {
            reorder(values, order, scratch.integers);
        }
        let own = [mass, density, density_rate, density_correction, relaxation, volume_excess];
        for values in own.into_iter().chain([&mut base.density, &mut base.relaxation]) {
            reorder(values, order, scratch.numbers);
        }
        for values in [position, velocity, acceleration, &mut base.position, &mut base.velocity] {
            reorder(values, order, vectors);
        }
    }

    /// Moves particles back into the box along periodic directions, with their positions in `base`.
    pub fn wrap(&mut self, base: &mut StepStart<S>, domain: &Domain<S>) {
        if !domain.is_periodic() {
            return;
        }
        let has_base = base.position.len() == self.position.len();
        for (i, x) in self.position.iter_mut().enumerate() {
            let wrapped = domain.wrapped(x);
            if has_base {
                base.position[i] += wrapped - *x;
            }
            *x = wrapped;
        }
    }

    /// A number of particle `i` that is larger than those of all before it, of whatever part.
    pub fn place(&self, i: usize) -> u64 {
        self.order.get(i).copied().unwrap_or(i as u64)
    }

    /// Number of particles of all parts.
    pub fn total(&self) -> usize {
        self.len() + self.others
    }

    /// The particles `range` as the state of the part that owns them.
    pub fn part(&self, range: Range<usize>) -> Self {
        let indices: Vec<u32> = (0u32..).take(range.end).skip(range.start).collect();
        let (copies, _) = self.some(&StepStart::default(), &indices);
        let origin = |origin: &ListOrigin<S>| ListOrigin {
            position: origin.position[range.clone()].to_vec(),
            ..*origin
        };
        Self {
            order: indices.iter().map(|i| u64::from(*i)).collect(),
            others: self.len() - range.len(),
            list_origin: self.list_origin.as_ref().map(origin),
            list_skin: self.list_skin,
            removed_momentum: self.removed_momentum,
            removed_angular_momentum: self.removed_angular_momentum,
            largest_acceleration: self.largest_acceleration,
            density_age: self.density_age,
            energy: self.energy.clone(),
            control: self.control,
            escaped: self.escaped,
            outflow: self.outflow,
            list_builds: self.list_builds,
            ..copies
        }
    }

    /// Appends the state of another part.
    pub fn extend(&mut self, mut following: Self) {
        if let (Some(origin), Some(more)) = (&mut self.list_origin, &mut following.list_origin) {
            origin.position.append(&mut more.position);
        }
        self.append(&mut StepStart::default(), following, StepStart::default());
    }

    /// The state of all particles, of whatever part, in their order.
    pub fn in_order(mut self) -> Self {
        let mut order: Vec<u32> = (0u32..).take(self.len()).collect();
        order.sort_by_key(|i| self.order[*i as usize]);
        let origin = self.list_origin.take().map(|origin| {
            let position = order.iter().map(|i| origin.position[*i as usize]).collect();
            ListOrigin { position, ..origin }
        });
        let scratch = Scratch { integers: &mut Vec::new(), numbers: &mut Vec::new() };
        self.reorder(&mut StepStart::default(), &order, scratch);
        Self { order: Vec::new(), others: 0, list_origin: origin, ..self }
    }

    /// Copies of the particles with these `indices`, and of their start of the step where `base` is in use.
    pub fn some(&self, base: &StepStart<S>, indices: &[u32]) -> (Self, StepStart<S>) {
        fn some<T: Copy>(values: &[T], indices: &[u32]) -> Vec<T> {
            if values.is_empty() { Vec::new() } else { indices.iter().map(|i| values[*i as usize]).collect() }
        }
        let copies = Self {
            order: some(&self.order, indices),
            id: some(&self.id, indices),
            region: some(&self.region, indices),
            mass: some(&self.mass, indices),
            position: some(&self.position, indices),
            velocity: some(&self.velocity, indices),
            density: some(&self.density, indices),
            density_rate: some(&self.density_rate, indices),
            density_correction: some(&self.density_correction, indices),
            acceleration: some(&self.acceleration, indices),
            relaxation: some(&self.relaxation, indices),
            volume_excess: some(&self.volume_excess, indices),
            ..Self::default()
        };
        let base = StepStart {
            position: some(&base.position, indices),
            velocity: some(&base.velocity, indices),
            density: some(&base.density, indices),
            relaxation: some(&base.relaxation, indices),
        };
        (copies, base)
    }

    /// Appends `others`, with their start of the step.
    pub fn append(&mut self, base: &mut StepStart<S>, mut others: Self, mut others_base: StepStart<S>) {
        self.order.append(&mut others.order);
        self.id.append(&mut others.id);
        self.region.append(&mut others.region);
        for (values, more) in [
            (&mut self.mass, &mut others.mass),
            (&mut self.density, &mut others.density),
            (&mut self.density_rate, &mut others.density_rate),
            (&mut self.density_correction, &mut others.density_correction),
            (&mut self.relaxation, &mut others.relaxation),
            (&mut self.volume_excess, &mut others.volume_excess),
            (&mut base.density, &mut others_base.density),
            (&mut base.relaxation, &mut others_base.relaxation),
        ] {
            values.append(more);
        }
        for (values, more) in [
            (&mut self.position, &mut others.position),
            (&mut self.velocity, &mut others.velocity),
            (&mut self.acceleration, &mut others.acceleration),
            (&mut base.position, &mut others_base.position),
            (&mut base.velocity, &mut others_base.velocity),
        ] {
            values.append(more);
        }
    }

    /// Keeps the particles for which `keep` is true; neighbour lists must be rebuilt afterwards.
    pub fn retain(&mut self, keep: impl Fn(usize) -> bool) {
        let order: Vec<u32> = (0u32..).zip(0..self.len()).filter(|(_, i)| keep(*i)).map(|(k, _)| k).collect();
        self.reorder(
            &mut StepStart::default(),
            &order,
            Scratch { integers: &mut Vec::new(), numbers: &mut Vec::new() },
        );
        self.list_origin = None;
    }
}

/// Memory for sorting.
#[derive(Debug)]
pub struct Scratch<'a> {
    /// For ids.
    pub integers: &'a mut Vec<u32>,
    /// For numbers.
    pub numbers: &'a mut Vec<f64>,
}

/// Sorts `values`, unless the scheme leaves them empty.
fn reorder<T: Copy + Default + Send + Sync>(values: &mut Vec<T>, order: &[u32], scratch: &mut Vec<T>) {
    if values.is_empty() {
        return;
    }
    scratch.resize(order.len(), T::default());
    for_each(&mut scratch[..], TASK, |k, value| *value = values[order[k] as usize]);
    std::mem::swap(values, scratch);
}
