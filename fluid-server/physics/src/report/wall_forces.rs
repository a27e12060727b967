//! Force of the fluid on each wall.

use std::marker::PhantomData;
use std::ops::AddAssign;

use sph::lanes::{LanePass, Lanes};
use sph::space::Vector;
use sph::space::geometry::{Geometry, Open, Periodic};

use crate::boundary::repulsion::wall_repulsion;
use crate::equations::pair::LawLanes;
use crate::equations::terms::{PairTerms, TermsPass};
use crate::neighbours::scene::Scene;
use crate::rates::particle_rates::StagePart;
use crate::rates::rate_pass::{StageFields, force_terms};
use crate::system::model::FluidModel;
use crate::system::packed_particle::Packed;
use crate::system::state::FluidState;
use crate::time::stage::Workspace;

/// Force of the fluid on each wall \[N/m\] as of the last evaluation in `workspace`, at `time` \[s\].
pub fn wall_forces(model: &FluidModel, state: &FluidState, workspace: &Workspace, time: f64) -> Vec<Vector> {
    if model.domain.is_periodic() {
        forces(Periodic::new(&model.domain), model, state, workspace, time)
    } else {
        forces(Open, model, state, workspace, time)
    }
}

fn forces<G: Geometry>(
    geometry: G,
    model: &FluidModel,
    state: &FluidState,
    workspace: &Workspace,
    time: f64,
) -> Vec<Vector> {
    let Workspace { lists, fluid, walls, gradients, .. } = workspace;
    let scene = Scene { geometry, model, lists, fluid, walls: &walls.particles };
    let fields =
        StageFields { scene, state, field: &walls.field, gradients, time, part: StagePart::Momentum };
    force_terms(model).call(WallForces { fields: &fields })
}

/// The pass over all particles.
struct WallForces<'a, G> {
    fields: &'a StageFields<'a, G>,
}

impl<G: Geometry> TermsPass for WallForces<'_, G> {
    type Output = Vec<Vector>;

    fn call<T: PairTerms>(self) -> Vec<Vector> {
        let fields = self.fields;
        let Scene { model, lists, fluid, .. } = fields.scene;
        let walls = &model.walls;
        let mut forces: PerWall = sph::sums::ordered_sum(fluid.len(), |i| {
            // Most particles are near no wall, and few near more than one.
            let mut near: Vec<u32> = Vec::new();
            for w in lists.walls.neighbours(i) {
                if !near.contains(&walls.wall[w]) {
                    near.push(walls.wall[w]);
                }
            }
            let mut forces = PerWall::default();
            for wall in near {
                let kernel = WallForce { fields, terms: PhantomData::<T>, i, wall };
                let divergence = model.arithmetic.run(kernel);
                let repulsion = wall_repulsion(&fields.scene, fields.field, i, Some(wall));
                *forces.of(wall as usize) = divergence * fluid[i].volume() - repulsion * fields.state.mass[i];
            }
            forces
        });
        forces.0.resize(walls.names.len(), Vector::zeros());
        forces.0
    }
}

/// Force on each wall \[N/m\]; zero on those beyond the end.
#[derive(Debug, Default)]
struct PerWall(Vec<Vector>);

impl PerWall {
    fn of(&mut self, wall: usize) -> &mut Vector {
        if self.0.len() <= wall {
            self.0.resize(wall + 1, Vector::zeros());
        }
        &mut self.0[wall]
    }
}

impl AddAssign for PerWall {
    fn add_assign(&mut self, other: Self) {
        for (wall, force) in other.0.into_iter().enumerate() {
            *self.of(wall) += force;
        }
    }
}

/// Σ V_w [...]·∇W of particle `i` over one wall \[Pa/m\].
struct WallForce<'a, G, T> {
    fields: &'a StageFields<'a, G>,
    terms: PhantomData<T>,
    i: usize,
    wall: u32,
}

impl<G: Geometry, T: PairTerms> LanePass for WallForce<'_, G, T> {
    type Output = Vector;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Vector {
        let mut own = self.fields.own::<L, T>(self.i);
        own.pressure = own.pressure + L::splat(self.fields.damper(self.i));
        let law = LawLanes::new(self.fields.scene.model);
        self.fields.wall_sums::<L, T>(&law, self.i, &own, Some(self.wall)).total().stress_divergence
    }
}
