//! Fields of all particles at a step boundary.

use sph::coupling::exchange::Column;
use sph::coupling::solver::{Field, ParticleFields};
use sph::space::components::Components;
use sph::space::tensors::SpaceSymmetric;

use crate::materials::hooke::von_mises_stress;
use crate::particles::fields::StressFields;
use crate::report::body_sums::{material_position, particle_energy_density};
use crate::space::SolidSpace;
use crate::system::model::SolidModel;
use crate::system::state::SolidState;

/// Stress of all particles at the step boundary.
pub fn stress_of<S: SolidSpace>(model: &SolidModel<S>, state: &SolidState<S>) -> StressFields<S> {
    let mut stress = StressFields::new(model.len());
    for body in &model.bodies {
        let particles = state.particles.view(&body.range);
        body.formulation.update_stress(&model.constants(body), &particles, stress.view_mut(&body.range));
    }
    stress
}

/// The field of `value` for each of `count` particles.
fn field<C: Components>(name: &str, unit: &str, count: usize, value: impl Fn(usize) -> C) -> Field {
    let Column { components, values } = (0..count).map(value).collect();
    Field { name: name.into(), unit: unit.into(), components, values }
}

/// All particles with their fields.
pub fn snapshot<S: SolidSpace>(
    model: &SolidModel<S>,
    state: &SolidState<S>,
    step: u64,
    time: f64,
) -> ParticleFields {
    let stress = stress_of(model, state);
    let n = model.len();
    let (particles, constants) = (&state.particles, &model.particles);
    let reference = &constants.reference_position;
    ParticleFields {
        step,
        time,
        id: constants.id.clone(),
        group: constants.body.clone(),
        group_names: model.bodies.iter().map(|body| body.name.clone()).collect(),
        fields: vec![
            field("position", "m", n, |i| particles.position[i]),
            field("velocity", "m/s", n, |i| particles.velocity[i]),
            field("density", "kg/m3", n, |i| particles.density[i]),
            field("pressure", "Pa", n, |i| stress.pressure[i]),
            field("stress", "Pa", n, |i| stress.cauchy[i]),
            field("deviatoric_stress", "Pa", n, |i| particles.deviatoric_stress[i]),
            field("displacement", "m", n, |i| material_position(model, state, i) - reference[i]),
            field("reference_position", "m", n, |i| reference[i]),
            field("mass", "kg/m", n, |i| constants.mass[i]),
            field("von_mises", "Pa", n, |i| von_mises_stress::<S>(&stress.deviator(i))),
            field("principal_largest", "Pa", n, |i| stress.cauchy[i].extremes()[0]),
            field("principal_smallest", "Pa", n, |i| stress.cauchy[i].extremes()[1]),
            field("strain_energy_density", "J/m3", n, |i| particle_energy_density(model, state, i)),
            field("support", "1", n, |i| f64::from(constants.support[i])),
        ],
    }
}
