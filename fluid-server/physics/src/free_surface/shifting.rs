//! Particle regularisation: shifting toward an even distribution, and tensile control where pressure is negative.
//!
//! Both need the concentration gradient Σ V_j ∇W and the place of the free surface. The gradient pass computes them
//! only where the case asks for either.
//!
//! - Shifting (Lind et al. 2012; Sun et al. 2017, 2019) moves positions. A particle that is shifted by δu takes the
//!   velocity of the fluid at its new place: dv/dt gains δu·∇v, which the ledger counts among the stabilisers.
//! - Tensile control (Sun et al. 2018) replaces p_i + p_j by p_j − p_i where p_i is negative, inside the fluid. It is
//!   not antisymmetric: the ledger counts its force among the stabilisers.

use sph::lanes::Lanes;
use sph::setup::OrderControl;
use sph::space::Vector;
use sph::space::geometry::Geometry;

use super::detection::{SurfaceFlag, outward, read_surface_flag};
use crate::equations::neighbour_sums::NeighbourSums;
use crate::equations::tensors::{Matrix, Symmetric};
use crate::neighbours::scene::Scene;
use crate::system::model::FluidModel;
use crate::system::packed_particle::{NeighbourFields, PackedParticle};

/// Smallest eigenvalue of the moment matrix below which a particle is spray: with so few neighbours a shift has no
/// meaning \[-\].
const SPRAY_EIGENVALUE: f64 = 0.3;

/// k of p/(k ρ U_i²): up to 1 a particle is shifted in full, from 2 on not at all \[-\]. Such a pressure orders
/// particles by itself, and the two would work against each other: shifting moves particles at constant density,
/// pressure moves them back and changes it, so that fluid with pressure waves would contract.
const ORDERED_BY_PRESSURE: f64 = 100.0;

/// Largest tension −p that the tensile control removes, in ρ₀c₀² \[-\]. It is not conservative: the tension of a
/// closing void would return as motion. Flows of a tenth of c₀ stay below a few thousandths.
const LARGEST_TENSION: f64 = 1e-3;

/// Sums of a particle that its regularisation needs.
#[derive(Clone, Copy, Debug, Default)]
pub struct RegularisationSums {
    /// Σ V_j ∇W \[1/m\].
    pub concentration: Vector,
    /// Σ V_j [1 + R (W/W(Δx))⁴] ∇W \[1/m\].
    shifting_gradient: Vector,
    /// Largest relative speed of neighbours U_i \[m/s\].
    speed: f64,
    /// ∇v corrected by L_i; zero where too few neighbours define it \[1/s\].
    velocity_gradient: Matrix,
}

impl RegularisationSums {
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
            shifting_gradient: concentration + Vector::from(sums.pairing),
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

/// Regularisation of one particle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Regularisation {
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

/// Shift and acceleration of particle `i`; `neighbour_fields` are those of all particles, `nearest` is r² of its
/// nearest neighbour at the surface \[m²\].
#[inline(always)]
pub fn regularise<L: Lanes, G: Geometry>(
    order: &OrderControl,
    scene: &Scene<G>,
    i: usize,
    neighbour_fields: &[NeighbourFields],
    nearest: f64,
    sums: &RegularisationSums,
) -> Regularisation {
    let [damper, flag, ..] = neighbour_fields[i];
    let SurfaceFlag { at_surface, eigenvalue } = read_surface_flag(flag);
    let near = nearest < scene.model.kernel.support_radius().powi(2);
    let place = if eigenvalue < SPRAY_EIGENVALUE {
        Place::Alone
    } else if at_surface || near {
        Place::Surface
    } else {
        Place::Inside
    };
    let fluid = &scene.fluid[i];
    let share = shift_share(sums, fluid);
    let shift = if place == Place::Alone || share == 0.0 {
        Vector::zeros()
    } else {
        let normal = if place == Place::Surface {
            outward::<L, G>(scene, i, neighbour_fields, eigenvalue)
        } else {
            Vector::zeros()
        };
        shift(order, scene.model, sums, &normal) * share
    };
    let v = &sums.velocity_gradient;
    let advection = Vector::new(v[0] * shift.x + v[1] * shift.y, v[2] * shift.x + v[3] * shift.y);
    let largest_tension = LARGEST_TENSION * scene.model.bulk_modulus();
    let pressure = (fluid.pressure() + damper).max(-largest_tension);
    Regularisation { shift, acceleration: tensile(order, sums, place, pressure, fluid.density()) + advection }
}

/// Velocity of the shift \[m/s\]; `normal` is zero away from the surface.
///
/// ```text
/// δu_i = −C 2h U_i Σ_j V_j [1 + R (W_ij/W(Δx))⁴] ∇W,  |δu_i| ≤ U_i/2      Sun et al. 2017, 2019
/// ```
/// U_i is the largest relative speed of neighbours: rigid motion causes no shift. At the surface and near it the part
/// along its normal is removed.
fn shift(order: &OrderControl, model: &FluidModel, sums: &RegularisationSums, normal: &Vector) -> Vector {
    let RegularisationSums { speed, shifting_gradient, .. } = *sums;
    let scale = -order.shifting * 2.0 * model.constants.smoothing_length() * speed;
    let shift = shifting_gradient * scale;
    (shift - normal * shift.dot(normal)).cap_magnitude(0.5 * speed)
}

/// Share of the shift that a particle takes: none where pressure orders it.
///
/// ```text
/// min(1, (2 − p_i/(k ρ_i U_i²))₊),  k = [`ORDERED_BY_PRESSURE`]
/// ```
#[inline(always)]
fn shift_share(sums: &RegularisationSums, fluid: &PackedParticle) -> f64 {
    let enough = ORDERED_BY_PRESSURE * fluid.density() * sums.speed * sums.speed;
    // Without relative motion there is no shift either.
    if enough > 0.0 { (2.0 - fluid.pressure() / enough).clamp(0.0, 1.0) } else { 0.0 }
}

/// Acceleration \[m/s²\] that turns p_i + p_j into p_j − p_i where p_i is negative, inside the fluid.
///
/// ```text
/// 2 p_i/ρ_i Σ_j V_j ∇W                                                     Sun et al. 2018
/// ```
fn tensile(
    order: &OrderControl,
    sums: &RegularisationSums,
    place: Place,
    pressure: f64,
    density: f64,
) -> Vector {
    if !order.tensile_control || pressure >= 0.0 || place != Place::Inside {
        return Vector::zeros();
    }
    sums.concentration * (2.0 * pressure / density)
}
