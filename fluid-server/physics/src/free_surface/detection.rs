//! Detection of the free surface, and its normal (Marrone et al. 2010).
//!
//! The surface flag of a particle is one number, which carries two facts: the smallest eigenvalue λ of its moment
//! matrix inside, λ − 16 at the surface. So neighbours read both in the line that they load anyway; only this file
//! knows the form.

use sph::lanes::Lanes;
use sph::space::geometry::Geometry;
use sph::space::tensors::{SpaceSymmetric, SpaceVector};

use crate::equations::neighbour_sums::NeighbourSums;
use crate::neighbours::batch::NeighbourBatch;
use crate::neighbours::rows::Rows;
use crate::neighbours::scene::Scene;
use crate::system::packed_particle::{FluidSpace, NeighbourFields, Packed};

/// Offset of the flag of a particle at the surface from its eigenvalue, which lies within ±2 \[-\].
const SURFACE_OFFSET: f64 = 16.0;

/// Flags below this are those of particles at the surface.
const LARGEST_SURFACE_FLAG: f64 = -0.5 * SURFACE_OFFSET;

/// Length below which a sum has no direction: of Σ V_j ∇W \[1/m\], or of ∇λ \[1/m\].
const NO_DIRECTION: f64 = 1e-12;

/// Flag of a particle in a case without particle regularisation.
pub const NO_SURFACE_FLAG: f64 = 0.0;

/// Surface flag of particle `i`.
#[inline(always)]
pub fn surface_flag<S: FluidSpace, G: Geometry<S>>(
    scene: &Scene<G, S>,
    i: usize,
    sums: &NeighbourSums<S>,
) -> f64 {
    let [_, eigenvalue] = S::symmetric_tensor(sums.moment).extremes();
    if eigenvalue < S::SURFACE_EIGENVALUE && cone_is_empty(scene, i, sums) {
        eigenvalue - SURFACE_OFFSET
    } else {
        eigenvalue
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
    let Scene { geometry, model, lists, fluid, walls } = *scene;
    let Some(outward) = (-S::vector(sums.concentration)).try_normalize(NO_DIRECTION) else { return false };
    let support = model.kernel.support_radius();
    let outside = |other: &S::Particle| {
        let d = geometry.separation(&other.position(), &fluid[i].position());
        let r = d.norm();
        r >= support || d.dot(&outward) < std::f64::consts::FRAC_1_SQRT_2 * r
    };
    let all_outside = |rows: &Rows, others: &[S::Particle]| rows.neighbours(i).all(|j| outside(&others[j]));
    all_outside(&lists.fluid, fluid) && all_outside(&lists.walls, walls)
}

/// A surface flag that has been read.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceFlag {
    /// Whether the particle lies at the free surface.
    pub at_surface: bool,
    /// Smallest eigenvalue of its moment matrix \[-\].
    pub eigenvalue: f64,
}

/// Reads a surface flag.
#[inline(always)]
pub fn read_surface_flag(flag: f64) -> SurfaceFlag {
    if flag < LARGEST_SURFACE_FLAG {
        SurfaceFlag { at_surface: true, eigenvalue: flag + SURFACE_OFFSET }
    } else {
        SurfaceFlag { at_surface: false, eigenvalue: flag }
    }
}

/// r² of the nearest neighbour at the surface \[m²\], batch by batch.
#[inline(always)]
pub fn nearest_surface<L: Lanes>(nearest: L, flags: L, square: L) -> L {
    let beyond = L::splat(f64::INFINITY);
    nearest.min(flags.choose_below(L::splat(LARGEST_SURFACE_FLAG), square, beyond))
}

/// Unit normal out of the fluid, −∇λ: the eigenvalue falls toward the surface.
#[inline(always)]
pub fn outward<S: FluidSpace, L: Lanes, G: Geometry<S>>(
    scene: &Scene<G, S>,
    i: usize,
    neighbour_fields: &[S::Fields],
    eigenvalue: f64,
) -> S::Vector {
    let Scene { geometry, model, lists, fluid, .. } = *scene;
    let motion = fluid[i].splat_motion();
    let (own, limit, offset) =
        (L::splat(eigenvalue), L::splat(LARGEST_SURFACE_FLAG), L::splat(SURFACE_OFFSET));
    let kernel = model.law.kernel.lanes();
    let mut sum = S::splat(L::zero());
    for indices in lists.fluid.of(i) {
        let batch = NeighbourBatch::<S, L>::gather(geometry, &motion, fluid, *indices);
        let (_, flag, _) = S::Fields::lanes::<L>(indices.map(|j| &neighbour_fields[j as usize]));
        let other = flag.choose_below(limit, flag + offset, flag);
        let weight = batch.volume * kernel.gradient_factor(batch.square) * (other - own);
        sum = S::minus_product(sum, weight, batch.x);
    }
    let [sum, _] = S::vector_sums(sum, S::splat(L::zero()));
    S::vector(sum).try_normalize(NO_DIRECTION).unwrap_or_default()
}
