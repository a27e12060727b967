//! Particle fields for snapshots and final states.

use sph::coupling::exchange::Column;
use sph::coupling::solver::{Field, ParticleFields, RELAXATION_PRESSURE};
use sph::space::components::Components;

use crate::system::model::FluidModel;
use crate::system::packed_particle::{FluidSpace, Packed};
use crate::system::state::FluidState;
use crate::system::walls::WallField;

/// All fluid particles by ascending id, then all wall particles, whose ids and groups follow the fluid's.
///
/// `walls` holds the state of the wall particles as the fluid sees it; their velocity is that of Eq. (27).
pub fn particle_fields<S: FluidSpace>(
    model: &FluidModel<S>,
    state: &FluidState<S>,
    field: &WallField<S>,
    walls: &[S::Particle],
    step: u64,
    time: f64,
) -> ParticleFields {
    let mut order: Vec<usize> = (0..state.len()).collect();
    order.sort_unstable_by_key(|i| state.id[*i]);
    // Both counts come from arrays indexed by u32.
    let first_wall_group = model.regions.len() as u32;
    let wall_ids = (0u32..).take(model.walls.len()).map(|w| model.first_wall_id.saturating_add(w));
    let wall_particle = |w: usize| walls.get(w).copied().unwrap_or_default();
    let pressure = |i: usize| state.pressure(&model.equation_of_state, i);
    let all = All { order: &order, walls: model.walls.len() };
    let mut fields = vec![
        all.field("position", "m", |i| state.position[i], |w| field.position[w]),
        all.field("velocity", "m/s", |i| state.velocity[i], |w| wall_particle(w).velocity()),
        all.field("density", "kg/m3", |i| state.density[i], |w| wall_particle(w).density()),
        all.field("pressure", "Pa", pressure, |w| wall_particle(w).pressure()),
        all.field("mass", "kg/m", |i| state.mass[i], |_| model.walls.mass),
    ];
    if !state.relaxation.is_empty() {
        fields.push(all.field(RELAXATION_PRESSURE, "Pa", |i| state.relaxation[i], |_| 0.0));
    }
    ParticleFields {
        step,
        time,
        id: order.iter().map(|i| state.id[*i]).chain(wall_ids).collect(),
        group: order
            .iter()
            .map(|i| state.region[*i])
            .chain(model.walls.wall.iter().map(|wall| first_wall_group + wall))
            .collect(),
        group_names: model.regions.iter().chain(&model.walls.names).cloned().collect(),
        fields,
    }
}

/// The particles of the fluid in order, and the number of wall particles.
struct All<'a> {
    order: &'a [usize],
    walls: usize,
}

impl All<'_> {
    fn field<C: Components>(
        &self,
        name: &str,
        unit: &str,
        fluid: impl Fn(usize) -> C,
        wall: impl Fn(usize) -> C,
    ) -> Field {
        let all = self.order.iter().map(|i| fluid(*i)).chain((0..self.walls).map(wall));
        let Column { components, values } = all.collect();
        Field { name: name.into(), unit: unit.into(), components, values }
    }
}
