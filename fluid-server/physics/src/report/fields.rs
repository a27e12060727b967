//! Particle fields for snapshots and final states.

use sph::coupling::solver::{Field, ParticleFields};

use crate::system::model::FluidModel;
use crate::system::packed_particle::{Packed, PackedParticle};
use crate::system::state::FluidState;
use crate::system::walls::WallField;

/// All fluid particles by ascending id, then all wall particles, whose ids and groups follow the fluid's.
///
/// `walls` holds the state of the wall particles as the fluid sees it; their velocity is that of Eq. (27).
pub fn particle_fields(
    model: &FluidModel,
    state: &FluidState,
    field: &WallField,
    walls: &[PackedParticle],
    step: u64,
    time: f64,
) -> ParticleFields {
    let mut order: Vec<usize> = (0..state.len()).collect();
    order.sort_unstable_by_key(|i| state.id[*i]);
    // Both counts come from arrays indexed by u32.
    let first_wall_group = model.regions.len() as u32;
    let wall_ids = (0u32..).take(model.walls.len()).map(|w| model.first_wall_id.saturating_add(w));
    let scalar = |name: &str, unit: &str, fluid: &dyn Fn(usize) -> f64, wall: &dyn Fn(usize) -> f64| Field {
        name: name.into(),
        unit: unit.into(),
        components: 1,
        values: order.iter().map(|i| fluid(*i)).chain((0..model.walls.len()).map(wall)).collect(),
    };
    let vector = |name: &str,
                  unit: &str,
                  fluid: &dyn Fn(usize) -> [f64; 2],
                  wall: &dyn Fn(usize) -> [f64; 2]| Field {
        name: name.into(),
        unit: unit.into(),
        components: 2,
        values: order.iter().flat_map(|i| fluid(*i)).chain((0..model.walls.len()).flat_map(wall)).collect(),
    };
    let wall_particle = |w: usize| walls.get(w).copied().unwrap_or_default();
    let equation_of_state = &model.equation_of_state;
    let fields = vec![
        vector("position", "m", &|i| state.position[i].into(), &|w| field.position[w].into()),
        vector("velocity", "m/s", &|i| state.velocity[i].into(), &|w| wall_particle(w).velocity().into()),
        scalar("density", "kg/m3", &|i| state.density[i], &|w| wall_particle(w).density()),
        scalar("pressure", "Pa", &|i| state.pressure(equation_of_state, i), &|w| wall_particle(w).pressure()),
        scalar("mass", "kg/m", &|i| state.mass[i], &|_| model.walls.mass),
    ];
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
