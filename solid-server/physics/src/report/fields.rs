//! Fields of all particles at a step boundary.

use sph::coupling::solver::{Field, ParticleFields};
use sph::space::tensors::SpaceSymmetric;
use sph::space::{Plane, SymmetricTensor, Vector};

use crate::materials::hooke::von_mises_stress;
use crate::particles::fields::StressFields;
use crate::report::body_sums::{material_position, particle_energy_density};
use crate::system::model::SolidModel;
use crate::system::state::SolidState;

/// Stress of all particles at the step boundary.
pub fn stress_of(model: &SolidModel, state: &SolidState) -> StressFields {
    let mut stress = StressFields::new(model.len());
    for body in &model.bodies {
        let particles = state.particles.view(&body.range);
        body.formulation.update_stress(&model.constants(body), &particles, stress.view_mut(&body.range));
    }
    stress
}

/// All particles with their fields.
pub fn snapshot(model: &SolidModel, state: &SolidState, step: u64, time: f64) -> ParticleFields {
    let stress = stress_of(model, state);
    let n = model.len();
    let scalar = |name: &str, unit: &str, value: &dyn Fn(usize) -> f64| Field {
        name: name.into(),
        unit: unit.into(),
        components: 1,
        values: (0..n).map(value).collect(),
    };
    let vector = |name: &str, unit: &str, value: &dyn Fn(usize) -> Vector| Field {
        name: name.into(),
        unit: unit.into(),
        components: 2,
        values: (0..n).flat_map(|i| [value(i).x, value(i).y]).collect(),
    };
    let tensor = |name: &str, unit: &str, value: &dyn Fn(usize) -> SymmetricTensor| Field {
        name: name.into(),
        unit: unit.into(),
        components: 3,
        values: (0..n).flat_map(|i| [value(i).xx, value(i).yy, value(i).xy]).collect(),
    };
    let (particles, constants) = (&state.particles, &model.particles);
    let reference = &constants.reference_position;
    ParticleFields {
        step,
        time,
        id: constants.id.clone(),
        group: constants.body.clone(),
        group_names: model.bodies.iter().map(|body| body.name.clone()).collect(),
        fields: vec![
            vector("position", "m", &|i| particles.position[i]),
            vector("velocity", "m/s", &|i| particles.velocity[i]),
            scalar("density", "kg/m3", &|i| particles.density[i]),
            scalar("pressure", "Pa", &|i| stress.pressure[i]),
            tensor("stress", "Pa", &|i| stress.cauchy[i]),
            tensor("deviatoric_stress", "Pa", &|i| particles.deviatoric_stress[i]),
            vector("displacement", "m", &|i| material_position(model, state, i) - reference[i]),
            vector("reference_position", "m", &|i| reference[i]),
            scalar("mass", "kg/m", &|i| constants.mass[i]),
            scalar("von_mises", "Pa", &|i| von_mises_stress::<Plane>(&stress.deviator(i))),
            scalar("principal_largest", "Pa", &|i| stress.cauchy[i].extremes()[0]),
            scalar("principal_smallest", "Pa", &|i| stress.cauchy[i].extremes()[1]),
            scalar("strain_energy_density", "J/m3", &|i| particle_energy_density(model, state, i)),
            scalar("support", "1", &|i| f64::from(constants.support[i])),
        ],
    }
}
