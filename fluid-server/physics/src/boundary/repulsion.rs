//! Repulsion of fluid particles by the faces of walls.

use sph::space::geometry::Geometry;
use sph::space::tensors::SpaceVector;

use crate::neighbours::scene::Scene;
use crate::system::packed_particle::{FluidSpace, Packed};
use crate::system::walls::WallField;

/// Repulsion \[m/s²\] of the particle at place `i` by the faces of `wall`, or of all walls.
///
/// ```text
/// a = Σ_w (1 − |t_w|/Δx)₊ · a(z_w, v_n) · n_w
/// ```
/// a is [`sph::laws::repulsion::Repulsion`], v_n the normal velocity relative to the wall, z_w the height over a particle w
/// of the first layer, half a spacing behind the face, and t_w the tangential distance to it. The weights add up to
/// one along a face, so that it is smooth; a particle at rest on the lattice (z = Δx) feels nothing. The pair forces
/// vanish where a particle coincides with a wall particle, so that they alone can not hold a particle that has been
/// pressed into the layer.
pub fn wall_repulsion<S: FluidSpace, G: Geometry<S>>(
    scene: &Scene<G, S>,
    field: &WallField<S>,
    i: usize,
    wall: Option<u32>,
) -> S::Vector {
    let Scene { geometry, model, fluid, walls, .. } = *scene;
    if !model.wall_repulsion.acts() {
        return S::Vector::zeros();
    }
    let spacing = model.constants.particle_spacing;
    let velocity = fluid[i].velocity();
    let mut acceleration = S::Vector::zeros();
    for w in scene.wall_neighbours(i) {
        let included = wall.is_none_or(|wall| model.walls.wall[w] == wall);
        // A wall particle without volume does not act.
        if !model.walls.first_layer[w] || walls[w].volume() == 0.0 || !included {
            continue;
        }
        let d = geometry.separation(&fluid[i].position(), &walls[w].position());
        let normal = &field.face_normal[w];
        let height = d.dot(normal);
        let beside = (d - *normal * height).norm() / spacing;
        // Deeper than a layer it is the next face that counts, such as the far side of a thin wall.
        if height >= model.wall_repulsion.distance() || height < -spacing || beside >= 1.0 {
            continue;
        }
        let leaving = (velocity - field.velocity(w)).dot(normal);
        let repulsion = model.wall_repulsion.acceleration(height, leaving);
        acceleration += *normal * ((1.0 - beside) * repulsion);
    }
    acceleration
}
