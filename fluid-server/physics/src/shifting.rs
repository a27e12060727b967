//! Control of the particles' order: shifting away from crowded places, and pair repulsion where pressure is negative.
//!
//! Both need the concentration gradient Σ V_j ∇W and where the free surface is; one pass over the neighbours makes
//! them, only when the case names either.
//!
//! - Shifting (Lind et al. 2012; Sun et al. 2017, 2019) moves positions. A particle that is shifted by δu takes the
//!   velocity of the fluid where it comes to: dv/dt gains δu·∇v, which stands in the ledger under the stabilisers.
//! - Tensile control (Sun et al. 2018) replaces p_i + p_j by p_j − p_i where p_i is negative, inside the fluid. It is
//!   not antisymmetric: its force stands in the ledger under the stabilisers.

use sph::geometry::Geometry;
use sph::lanes::Lanes;
use sph::setup::OrderControl;
use sph::vector::Vector;

use super::gradients::Scene;
use super::model::FluidModel;
use super::moments::NeighbourSums;
use super::pair::{Matrix, Symmetric};
use super::record::{Batch, Record, gather_columns};
use super::rows::Rows;

/// Smallest eigenvalue of the moment matrix below which a particle lies at the free surface (Marrone et al. 2010).
const SURFACE: f64 = 0.75;

/// Below this eigenvalue a particle is spray: it has too few neighbours for a shift to mean anything.
const SPRAY: f64 = 0.3;

/// R and n of the anti-pairing term R (W/W(Δx))ⁿ (Monaghan 2000).
const PAIRING: f64 = 0.2;

/// p/(ρ U_i²) up to which a particle is shifted in full; at twice of it no more. Such a pressure orders particles by
/// itself, and the two would work against each other: shifting moves them without their densities knowing, pressure
/// moves them back with the densities following, and so water that rings would draw together.
const ORDERED_BY_PRESSURE: f64 = 100.0;

/// Largest tension −p that the tensile control takes away, of ρ₀c₀². It is not conservative: the tension of a void that
/// closes would come back as motion. Flows of a tenth of c₀ stay below a few thousandths.
const LARGEST_TENSION: f64 = 1e-3;

/// Mark of a particle at the free surface: its eigenvalue, which lies within ±2, less this.
const SURFACE_MARK: f64 = 16.0;

/// Mark of a particle in a scene without order control.
pub const NO_ORDER: f64 = 0.0;

/// What a particle keeps of its sums until its place is known.
#[derive(Clone, Copy, Debug, Default)]
pub struct OrderLocal {
    /// Σ V_j ∇W \[1/m\].
    pub concentration: Vector,
    /// Σ V_j [1 + R (W/W(Δx))⁴] ∇W \[1/m\].
    crowding: Vector,
    /// Largest relative speed of neighbours U_i \[m/s\].
    speed: f64,
    /// ∇v corrected by L_i; zero where too few neighbours define it \[1/s\].
    velocity_gradient: Matrix,
}

#[cfg(test)]
impl OrderLocal {
    /// U_i² \[m²/s²\].
    pub fn square_speed(&self) -> f64 {
        self.speed * self.speed
    }
}

/// What follows for one particle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Control {
    /// Velocity by which the position is shifted \[m/s\].
    pub shift: Vector,
    /// Acceleration by the tensile control and by the shift through a velocity gradient \[m/s²\].
    pub acceleration: Vector,
}

/// The kernel beside its gradient, for W/W(Δx).
#[derive(Clone, Copy, Debug)]
pub struct Ratio<L> {
    /// 1/4 and 1 over (2−s)³/4 − (1−s)³ at s = Δx/h.
    outer: L,
    inner: L,
}

impl<L: Lanes> Ratio<L> {
    /// The ratio of `model`'s kernel.
    #[inline(always)]
    pub fn new(model: &FluidModel) -> Self {
        let c = &model.constants;
        let s = c.particle_spacing / c.smoothing_length;
        let value = 0.25 * (2.0 - s).max(0.0).powi(3) - (1.0 - s).max(0.0).powi(3);
        Self { outer: L::splat(0.25 / value), inner: L::splat(1.0 / value) }
    }

    /// R (W(r)/W(Δx))⁴ and how much a neighbour at s = r/h counts for the speed.
    #[inline(always)]
    pub fn pairing(&self, s: L) -> (L, L) {
        let outer = (L::splat(2.0) - s).max(L::zero());
        let inner = (L::splat(1.0) - s).max(L::zero());
        let outer_cube = self.outer * outer * (outer * outer);
        let ratio = outer_cube.minus_product(self.inner * inner, inner * inner);
        let square_ratio = ratio * ratio;
        (L::splat(PAIRING) * (square_ratio * square_ratio), outer.min(L::splat(1.0)))
    }
}

/// R (W/W(Δx))⁴ of one pair, where `ratio` is W/W(Δx).
pub fn pairing_of(ratio: f64) -> f64 {
    PAIRING * ratio.powi(4)
}

/// One particle and the sums over its neighbours.
pub struct Surroundings<'a, G> {
    /// Fluid and walls.
    pub scene: &'a Scene<'a, G>,
    /// The particle.
    pub i: usize,
    /// Its sums.
    pub sums: &'a NeighbourSums,
    /// L_i, where enough neighbours define it.
    pub inverse: Option<Symmetric>,
}

impl<G: Geometry> Surroundings<'_, G> {
    /// What the particle keeps, and the mark by which its neighbours tell whether it lies at the free surface.
    #[inline(always)]
    pub fn order(&self) -> (OrderLocal, f64) {
        let Self { sums, inverse, .. } = self;
        let eigenvalue = smallest_eigenvalue(&sums.moment);
        let mark =
            if eigenvalue < SURFACE && self.cone_is_empty() { eigenvalue - SURFACE_MARK } else { eigenvalue };
        let velocity_gradient = inverse.map_or([0.0; 4], |[xx, xy, yy]| {
            let v = &sums.velocity;
            let row = |a: f64, b: f64| (a * xx + b * xy, a * xy + b * yy);
            let ((a, b), (c, d)) = (row(v[0], v[1]), row(v[2], v[3]));
            [a, b, c, d]
        });
        let concentration = Vector::from(sums.concentration);
        let local = OrderLocal {
            concentration,
            crowding: concentration + Vector::from(sums.pairing),
            speed: sums.square_speed.sqrt(),
            velocity_gradient,
        };
        (local, mark)
    }

    /// Whether no neighbour lies in the cone of half-angle 45° along −Σ V_j ∇W, away from the crowd.
    ///
    /// Tells the surface from disorder inside, which lowers the eigenvalue too (Marrone et al. 2010).
    fn cone_is_empty(&self) -> bool {
        let Scene { geometry, model, lists, fluid, walls } = *self.scene;
        let crowd = Vector::from(self.sums.concentration);
        let Some(outward) = (-crowd).try_normalize(1e-12) else { return false };
        let support = model.kernel.support_radius();
        let outside = |other: &Record| {
            let d = geometry.separation(&other.position(), &fluid[self.i].position());
            let r = d.norm();
            r >= support || d.dot(&outward) < std::f64::consts::FRAC_1_SQRT_2 * r
        };
        let all_outside =
            |rows: &Rows, others: &[Record]| rows.neighbours(self.i).all(|j| outside(&others[j]));
        all_outside(&lists.fluid, fluid) && all_outside(&lists.walls, walls)
    }
}

/// Smallest eigenvalue of a moment matrix.
fn smallest_eigenvalue(moment: &Symmetric) -> f64 {
    let [xx, xy, yy] = *moment;
    0.5 * (xx + yy) - (0.25 * (xx - yy).powi(2) + xy * xy).sqrt()
}

/// Where a particle lies relative to the free surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    /// No surface within the support.
    Inside,
    /// At the surface, or one of its particles lies within the support.
    Surface,
    /// Spray.
    Alone,
}

/// Whether a mark is that of a particle at the surface, and its eigenvalue.
#[inline(always)]
fn read_mark(mark: f64) -> (bool, f64) {
    if mark < -0.5 * SURFACE_MARK { (true, mark + SURFACE_MARK) } else { (false, mark) }
}

/// r² of the nearest neighbour at the surface \[m²\], batch by batch.
#[inline(always)]
pub fn nearest_surface<L: Lanes>(nearest: L, marks: L, square: L) -> L {
    let beyond = L::splat(f64::INFINITY);
    nearest.min(marks.choose_below(L::splat(-0.5 * SURFACE_MARK), square, beyond))
}

/// Shift and acceleration of particle `i`; `shown` are the marks of all, `nearest` is r² of the nearest neighbour at
/// the surface \[m²\].
#[inline(always)]
pub fn control<L: Lanes, G: Geometry>(
    order: &OrderControl,
    scene: &Scene<G>,
    i: usize,
    shown: &[[f64; 4]],
    nearest: f64,
    local: &OrderLocal,
) -> Control {
    let (at_surface, eigenvalue) = read_mark(shown[i][1]);
    let near = nearest < scene.model.kernel.support_radius().powi(2);
    let place = if eigenvalue < SPRAY {
        Place::Alone
    } else if at_surface || near {
        Place::Surface
    } else {
        Place::Inside
    };
    let fluid = &scene.fluid[i];
    let share = disordered(local, fluid);
    let shift = if place == Place::Alone || share == 0.0 {
        Vector::zeros()
    } else {
        let normal = if place == Place::Surface {
            outward::<L, G>(scene, i, shown, eigenvalue)
        } else {
            Vector::zeros()
        };
        shift(order, scene.model, local, &normal) * share
    };
    let v = &local.velocity_gradient;
    let advection = Vector::new(v[0] * shift.x + v[1] * shift.y, v[2] * shift.x + v[3] * shift.y);
    let largest_tension = LARGEST_TENSION * scene.model.bulk_modulus();
    let pressure = (fluid.pressure() + shown[i][0]).max(-largest_tension);
    Control { shift, acceleration: tensile(order, local, place, pressure, fluid.density()) + advection }
}

/// Unit normal out of the fluid, −∇λ: the eigenvalue falls toward the surface.
#[inline(always)]
fn outward<L: Lanes, G: Geometry>(scene: &Scene<G>, i: usize, shown: &[[f64; 4]], eigenvalue: f64) -> Vector {
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

/// Velocity of the shift \[m/s\]; `normal` is zero away from the surface.
///
/// ```text
/// δu_i = −C 2h U_i Σ_j V_j [1 + R (W_ij/W(Δx))⁴] ∇W,  |δu_i| ≤ U_i/2      Sun et al. 2017, 2019
/// ```
/// U_i is the largest relative speed of neighbours: a fluid that moves as one is left alone. No shift at the surface,
/// none along its normal near it.
fn shift(order: &OrderControl, model: &FluidModel, local: &OrderLocal, normal: &Vector) -> Vector {
    let OrderLocal { speed, crowding, .. } = *local;
    let scale = -order.shifting * 2.0 * model.constants.smoothing_length * speed;
    let shift = crowding * scale;
    (shift - normal * shift.dot(normal)).cap_magnitude(0.5 * speed)
}

/// How much of the shift a particle takes: none where pressure orders it.
///
/// ```text
/// min(1, (2 − p_i/(k ρ_i U_i²))₊),  k = 100
/// ```
#[inline(always)]
fn disordered(local: &OrderLocal, fluid: &Record) -> f64 {
    let enough = ORDERED_BY_PRESSURE * fluid.density() * local.speed * local.speed;
    // Without relative motion there is no shift either.
    if enough > 0.0 { (2.0 - fluid.pressure() / enough).clamp(0.0, 1.0) } else { 0.0 }
}

/// Acceleration \[m/s²\] that turns p_i + p_j into p_j − p_i where p_i is negative, inside the fluid.
///
/// ```text
/// 2 p_i/ρ_i Σ_j V_j ∇W                                                     Sun et al. 2018
/// ```
fn tensile(order: &OrderControl, local: &OrderLocal, place: Place, pressure: f64, density: f64) -> Vector {
    if !order.tensile_control || pressure >= 0.0 || place != Place::Inside {
        return Vector::zeros();
    }
    local.concentration * (2.0 * pressure / density)
}
