//! Which particles lie at the free surface, and its normal (Marrone et al. 2010).

use sph::geometry::Geometry;
use sph::lanes::Lanes;
use sph::vector::Vector;

use crate::equations::neighbour_sums::NeighbourSums;
use crate::equations::tensors::Symmetric;
use crate::neighbours::batch::{Batch, gather_columns};
use crate::neighbours::rows::Rows;
use crate::neighbours::scene::Scene;
use crate::system::packed_particle::Record;

/// Smallest eigenvalue of the moment matrix below which a particle lies at the free surface (Marrone et al. 2010).
const SURFACE: f64 = 0.75;

/// Mark of a particle at the free surface: its eigenvalue, which lies within ±2, less this.
const SURFACE_MARK: f64 = 16.0;

/// Mark of a particle in a scene without order control.
pub const NO_ORDER: f64 = 0.0;

/// The mark by which neighbours of particle `i` see whether it lies at the free surface.
#[inline(always)]
pub fn surface_mark<G: Geometry>(scene: &Scene<G>, i: usize, sums: &NeighbourSums) -> f64 {
    let eigenvalue = smallest_eigenvalue(&sums.moment);
    if eigenvalue < SURFACE && cone_is_empty(scene, i, sums) { eigenvalue - SURFACE_MARK } else { eigenvalue }
}

/// Whether no neighbour lies in the cone of half-angle 45° along −Σ V_j ∇W, away from the crowd.
///
/// Tells the surface from disorder inside, which lowers the eigenvalue too (Marrone et al. 2010).
fn cone_is_empty<G: Geometry>(scene: &Scene<G>, i: usize, sums: &NeighbourSums) -> bool {
    let Scene { geometry, model, lists, fluid, walls } = *scene;
    let crowd = Vector::from(sums.concentration);
    let Some(outward) = (-crowd).try_normalize(1e-12) else { return false };
    let support = model.kernel.support_radius();
    let outside = |other: &Record| {
        let d = geometry.separation(&other.position(), &fluid[i].position());
        let r = d.norm();
        r >= support || d.dot(&outward) < std::f64::consts::FRAC_1_SQRT_2 * r
    };
    let all_outside = |rows: &Rows, others: &[Record]| rows.neighbours(i).all(|j| outside(&others[j]));
    all_outside(&lists.fluid, fluid) && all_outside(&lists.walls, walls)
}

/// Smallest eigenvalue of a moment matrix.
fn smallest_eigenvalue(moment: &Symmetric) -> f64 {
    let [xx, xy, yy] = *moment;
    0.5 * (xx + yy) - (0.25 * (xx - yy).powi(2) + xy * xy).sqrt()
}

/// Whether a mark is that of a particle at the surface, and its eigenvalue.
#[inline(always)]
pub fn read_mark(mark: f64) -> (bool, f64) {
    if mark < -0.5 * SURFACE_MARK { (true, mark + SURFACE_MARK) } else { (false, mark) }
}

/// r² of the nearest neighbour at the surface \[m²\], batch by batch.
#[inline(always)]
pub fn nearest_surface<L: Lanes>(nearest: L, marks: L, square: L) -> L {
    let beyond = L::splat(f64::INFINITY);
    nearest.min(marks.choose_below(L::splat(-0.5 * SURFACE_MARK), square, beyond))
}

/// Unit normal out of the fluid, −∇λ: the eigenvalue falls toward the surface.
#[inline(always)]
pub fn outward<L: Lanes, G: Geometry>(
    scene: &Scene<G>,
    i: usize,
    shown: &[[f64; 4]],
    eigenvalue: f64,
) -> Vector {
    let Scene { geometry, model, lists, fluid, .. } = *scene;
    let motion = L::splat_each(fluid[i].motion);
    let (own, limit, marked) = (L::splat(eigenvalue), L::splat(-0.5 * SURFACE_MARK), L::splat(SURFACE_MARK));
    let kernel = model.law.kernel.lanes();
    let (mut x, mut y) = (L::zero(), L::zero());
    for indices in lists.fluid.of(i) {
        let batch = Batch::gather(geometry, &motion, fluid, *indices);
        let [_, mark, ..]: [L; 4] = gather_columns(*indices, shown);
        let other = mark.choose_below(limit, mark + marked, mark);
        let weight = batch.volume * kernel.gradient_factor(batch.square) * (other - own);
        x = x.minus_product(weight, batch.x);
        y = y.minus_product(weight, batch.y);
    }
    let [x, y, ..] = L::sums([x, y, L::zero(), L::zero()]);
    Vector::new(x, y).try_normalize(1e-12).unwrap_or_else(Vector::zeros)
}
