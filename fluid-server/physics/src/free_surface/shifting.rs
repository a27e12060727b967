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

use super::detection::{outward, read_mark};
use crate::equations::neighbour_sums::NeighbourSums;
use crate::equations::tensors::{Matrix, Symmetric};
use crate::neighbours::scene::Scene;
use crate::system::model::FluidModel;
use crate::system::packed_particle::Record;

/// Below this eigenvalue a particle is spray: it has too few neighbours for a shift to mean anything.
const SPRAY: f64 = 0.3;

/// p/(ρ U_i²) up to which a particle is shifted in full; at twice of it no more. Such a pressure orders particles by
/// itself, and the two would work against each other: shifting moves them without their densities knowing, pressure
/// moves them back with the densities following, and so water that rings would draw together.
const ORDERED_BY_PRESSURE: f64 = 100.0;

/// Largest tension −p that the tensile control takes away, of ρ₀c₀². It is not conservative: the tension of a void that
/// closes would come back as motion. Flows of a tenth of c₀ stay below a few thousandths.
const LARGEST_TENSION: f64 = 1e-3;

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

impl OrderLocal {
    /// Of the sums over the neighbours; `inverse` is L_i, where enough of them define it.
    #[inline(always)]
    pub fn new(sums: &NeighbourSums, inverse: Option<Symmetric>) -> Self {
        let velocity_gradient = inverse.map_or([0.0; 4], |[xx, xy, yy]| {
            let v = &sums.velocity;
            let row = |a: f64, b: f64| (a * xx + b * xy, a * xy + b * yy);
            let ((a, b), (c, d)) = (row(v[0], v[1]), row(v[2], v[3]));
            [a, b, c, d]
        });
        let concentration = Vector::from(sums.concentration);
        Self {
            concentration,
            crowding: concentration + Vector::from(sums.pairing),
            speed: sums.square_speed.sqrt(),
            velocity_gradient,
        }
    }

    /// U_i² \[m²/s²\].
    #[cfg(test)]
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
