//! Detection of the free surface, and its normal (Marrone et al. 2010).

use std::sync::atomic::{AtomicBool, Ordering};

use sph::lanes::Lanes;
use sph::space::geometry::Geometry;
use sph::space::tensors::{SpaceSymmetric, SpaceVector};
use sph::tasks::for_each_task;

use crate::equations::neighbour_sums::NeighbourSums;
use crate::neighbours::batch::NeighbourBatch;
use crate::neighbours::scene::Scene;
use crate::system::packed_particle::{FluidSpace, NeighbourFields, Packed};

/// Length below which a sum has no direction: of Σ V_j ∇W \[1/m\], or of ∇λ \[1/m\].
const NO_DIRECTION: f64 = 1e-12;

/// Particles of a task of [`mark_near`].
const TASK: usize = 512;

/// What the sums of a particle say of the free surface.
#[derive(Clone, Copy, Debug, Default)]
pub struct Surface {
    /// Whether the particle lies at it.
    pub at_surface: bool,
    /// Smallest eigenvalue of the moment matrix \[-\].
    pub eigenvalue: f64,
}

impl Surface {
    /// Of the particle at place `i`.
    #[inline(always)]
    pub fn of<S: FluidSpace, G: Geometry<S>>(scene: &Scene<G, S>, i: usize, sums: &NeighbourSums<S>) -> Self {
        let [_, eigenvalue] = S::symmetric_tensor(sums.moment).extremes();
        Self { at_surface: eigenvalue < S::SURFACE_EIGENVALUE && cone_is_empty(scene, i, sums), eigenvalue }
    }
}

/// Whether no neighbour lies in the cone of half-angle 45° along −Σ V_j ∇W, which points out of the fluid.
///
/// Distinguishes the surface from disorder inside, which lowers the eigenvalue too.
fn cone_is_empty<S: FluidSpace, G: Geometry<S>>(
    scene: &Scene<G, S>,
    i: usize,
    sums: &NeighbourSums<S>,
) -> bool {
    let Scene { geometry, model, fluid, walls, .. } = *scene;
    let Some(outward) = (-S::vector(sums.concentration)).try_normalize(NO_DIRECTION) else { return false };
    let support = model.kernel.support_radius();
    let outside = |other: &S::Particle| {
        let d = geometry.separation(&other.position(), &fluid[i].position());
        let r = d.norm();
        r >= support || d.dot(&outward) < std::f64::consts::FRAC_1_SQRT_2 * r
    };
    scene.fluid_neighbours(i).all(|j| outside(&fluid[j]))
        && scene.wall_neighbours(i).all(|w| walls[w].volume() == 0.0 || outside(&walls[w]))
}

/// Marks in `near` the particles that lie at the surface or have an own particle of it within their support, by place.
pub fn mark_near<S: FluidSpace, G: Geometry<S>>(
    scene: &Scene<G, S>,
    at_surface: &[bool],
    near: &mut Vec<AtomicBool>,
) {
    near.clear();
    near.resize_with(scene.fluid.len(), AtomicBool::default);
    let marks = &near[..];
    // The order of the marks does not matter.
    let mark = |i: usize| marks[i].store(true, Ordering::Relaxed);
    let meet = meeting(scene);
    let mark_around = |i: usize| {
        mark(i);
        scene.fluid_neighbours(i).filter(|j| meet(i, *j)).for_each(mark);
    };
    let own = scene.own();
    for_each_task(own.len(), TASK, (), &|particles, ()| {
        particles.filter(|i| at_surface[*i]).for_each(mark_around);
    });
}

/// Marks in `near` the own particles that have a copy of a particle at the surface within their support.
pub fn mark_near_copies<S: FluidSpace, G: Geometry<S>>(
    scene: &Scene<G, S>,
    at_surface: &[bool],
    near: &[AtomicBool],
) {
    let (own, meet) = (scene.own(), meeting(scene));
    // There are no rows of copies.
    let is_surface_copy = |j: &usize| at_surface[*j] && !own.contains(j);
    for i in scene.lists.placement().border().iter().map(|i| *i as usize) {
        if scene.fluid_neighbours(i).filter(is_surface_copy).any(|j| meet(i, j)) {
            near[i].store(true, Ordering::Relaxed);
        }
    }
}

/// Whether the particles at two places lie within each other's support.
fn meeting<'a, S: FluidSpace, G: Geometry<S>>(scene: &'a Scene<'a, G, S>) -> impl Fn(usize, usize) -> bool {
    let Scene { geometry, model, fluid, .. } = scene;
    let square_support = model.kernel.support_radius().powi(2);
    move |i: usize, j: usize| {
        geometry.separation(&fluid[j].position(), &fluid[i].position()).norm_squared() < square_support
    }
}

/// Unit normal out of the fluid, −∇λ: the eigenvalue falls toward the surface.
#[inline(always)]
pub fn outward<S: FluidSpace, L: Lanes, G: Geometry<S>>(
    scene: &Scene<G, S>,
    i: usize,
    neighbour_fields: &[S::Fields],
    eigenvalue: f64,
) -> S::Vector {
    let Scene { geometry, model, fluid, .. } = *scene;
    let motion = fluid[i].splat_motion();
    let own = L::splat(eigenvalue);
    let kernel = model.law.kernel.lanes();
    let mut sum = S::splat(L::zero());
    for indices in scene.fluid_row(i) {
        let batch = NeighbourBatch::<S, L>::gather(geometry, &motion, fluid, *indices);
        let (_, other, _) = S::Fields::lanes::<L>(indices.map(|j| &neighbour_fields[j as usize]));
        let weight = batch.volume * kernel.gradient_factor(batch.square) * (other - own);
        sum = S::minus_product(sum, weight, batch.x);
    }
    let [sum, _] = S::vector_sums(sum, S::splat(L::zero()));
    S::vector(sum).try_normalize(NO_DIRECTION).unwrap_or_default()
}
