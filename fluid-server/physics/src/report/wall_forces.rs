//! Force of the fluid on each wall.

use std::marker::PhantomData;

use sph::space::geometry::{Geometry, Open, Periodic};
use sph::space::tensors::SpaceVector;
use sph::sums::{Numbers, each_of};

use crate::boundary::repulsion::wall_repulsion;
use crate::equations::terms::{PairTerms, TermsPass};
use crate::neighbours::scene::Scene;
use crate::rates::particle_rates::StagePart;
use crate::rates::rate_pass::force_terms;
use crate::rates::stage_fields::StageFields;
use crate::rates::wall_pass::OneWall;
use crate::system::model::FluidModel;
use crate::system::packed_particle::{FluidSpace, Packed};
use crate::system::state::FluidState;
use crate::system::tasks::sum_over_particles;
use crate::time::stage::Workspace;

/// Force of the fluid on each wall that is `read` \[N/m\] as of the last evaluation in `workspace`, at `time` \[s\]; zero on
/// the others.
pub fn wall_forces<S: FluidSpace>(
    model: &FluidModel<S>,
    state: &FluidState<S>,
    workspace: &Workspace<S>,
    time: f64,
    read: &[bool],
) -> Vec<S::Vector> {
    if model.domain.is_periodic() {
        forces(Periodic::new(&model.domain), model, state, workspace, time, read)
    } else {
        forces(Open, model, state, workspace, time, read)
    }
}

fn forces<S: FluidSpace, G: Geometry<S>>(
    geometry: G,
    model: &FluidModel<S>,
    state: &FluidState<S>,
    workspace: &Workspace<S>,
    time: f64,
    read: &[bool],
) -> Vec<S::Vector> {
    let Workspace { lists, fluid, walls, gradients, .. } = workspace;
    let scene = Scene { geometry, model, lists, fluid, walls: &walls.particles };
    let fields = StageFields {
        scene,
        state,
        field: &walls.field,
        gradients,
        time,
        part: StagePart::Momentum,
        energy: None,
    };
    force_terms(model).call(WallForces { fields: &fields, read })
}

/// The pass over all particles.
struct WallForces<'a, G, S: FluidSpace> {
    fields: &'a StageFields<'a, G, S>,
    read: &'a [bool],
}

impl<S: FluidSpace, G: Geometry<S>> TermsPass for WallForces<'_, G, S> {
    type Output = Vec<S::Vector>;

    fn call<T: PairTerms>(self) -> Vec<S::Vector> {
        let fields = self.fields;
        let Scene { model, fluid, .. } = fields.scene;
        let (walls, state) = (&model.walls, fields.state);
        let none = PerWall(vec![S::Vector::zeros(); walls.names.len()]);
        let forces = sum_over_particles(&model.team, state.len(), none.clone(), |i| {
            // Most particles are near no wall, and few near more than one.
            let mut near: Vec<u32> = Vec::new();
            for w in fields.scene.wall_neighbours(i) {
                let wall = walls.wall[w];
                if self.read[wall as usize] && !near.contains(&wall) {
                    near.push(wall);
                }
            }
            let mut forces = PerWall::<S>(Vec::new());
            for wall in near {
                let pass = OneWall { fields, terms: PhantomData::<T>, i, wall };
                let (divergence, _) = model.arithmetic.run(pass);
                let repulsion = wall_repulsion(&fields.scene, fields.field, i, Some(wall));
                if forces.0.is_empty() {
                    forces = none.clone();
                }
                forces.0[wall as usize] = divergence * fluid[i].volume() - repulsion * state.mass[i];
            }
            forces
        });
        forces.0
    }
}

/// Force on each wall \[N/m\]; none at all where all are zero.
#[derive(Clone, Debug)]
struct PerWall<S: FluidSpace>(Vec<S::Vector>);

impl<S: FluidSpace> Numbers for PerWall<S> {
    fn each(&mut self, visit: &mut dyn FnMut(&mut f64)) {
        self.0.iter_mut().for_each(|force| each_of(force, visit));
    }
}
