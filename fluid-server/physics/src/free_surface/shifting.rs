//! Particle regularisation: shifting toward an even distribution, tensile control where pressure is negative, and the
//! volume correction.
//!
//! All need the place of the free surface, and sums that the gradient pass computes only where the case asks for them.
//!
//! - Shifting (Lind et al. 2012; Sun et al. 2017, 2019) moves positions. A particle that is shifted by δu takes the
//!   velocity of the fluid at its new place: dv/dt gains δu·∇v, which the ledger counts among the stabilisers.
//! - Tensile control (Sun et al. 2018) replaces p_i + p_j by p_j − p_i where p_i is negative, inside the fluid. It is
//!   not antisymmetric: the ledger counts its force among the stabilisers.
//! - The volume correction ([`crate::equations::volume`]) changes densities alone, inside the fluid.

use sph::lanes::Lanes;
use sph::setup::OrderControl;
use sph::space::Space;
use sph::space::geometry::Geometry;
use sph::space::tensors::{SpaceSymmetric, SpaceVector};

use super::detection::outward;
use crate::equations::neighbour_sums::NeighbourSums;
use crate::equations::volume::{lone_relaxation, volume_rate};
use crate::neighbours::scene::Scene;
use crate::system::model::FluidModel;
use crate::system::packed_particle::{FluidSpace, NeighbourFields, Packed};

/// Sums of a particle that its regularisation needs.
#[derive(Clone, Copy, Debug)]
pub struct RegularisationSums<S: Space> {
    /// Σ V_j ∇W \[1/m\].
    pub concentration: S::Vector,
    /// Σ V_j [1 + R (W/W(Δx))⁴] ∇W \[1/m\].
    shifting_gradient: S::Vector,
    /// Largest relative speed of neighbours U_i \[m/s\].
    speed: f64,
    /// Half the curl of the velocity, the antisymmetric part of ∇v corrected by L_i; zero where too few neighbours define
    /// it \[1/s\].
    spin: S::Spin,
}

impl<S: Space> Default for RegularisationSums<S> {
    #[inline(always)]
    fn default() -> Self {
        let zero = S::Vector::zeros();
        Self { concentration: zero, shifting_gradient: zero, speed: 0.0, spin: S::Spin::default() }
    }
}

impl<S: Space> RegularisationSums<S> {
    /// Of the sums over the neighbours, and of ∇v \[1/s\], zero where too few of them define it.
    #[inline(always)]
    pub fn new(sums: &NeighbourSums<S>, velocity_gradient: &S::Tensor) -> Self {
        let concentration = S::vector(sums.concentration);
        Self {
            concentration,
            shifting_gradient: concentration + S::vector(sums.pairing),
            speed: sums.square_speed.sqrt(),
            spin: spin::<S>(velocity_gradient),
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
pub struct Regularisation<S: Space> {
    /// Velocity by which the position is shifted \[m/s\].
    pub shift: S::Vector,
    /// Acceleration by the tensile control and by the shift through a velocity gradient \[m/s²\].
    pub acceleration: S::Vector,
    /// The part of it by the shift \[m/s²\].
    pub advection: S::Vector,
    /// Density rate by the volume correction \[kg/(m³ s)\].
    pub density: f64,
}

impl<S: Space> Regularisation<S> {
    /// The same with δu·∇v, of the rate of strain \[1/s\] and the spin among `sums`.
    #[inline(always)]
    pub fn advected(self, sums: &RegularisationSums<S>, strain_rate: &S::SymmetricTensor) -> Self {
        let advection = strain_rate.dot(&self.shift) + S::spin_cross(sums.spin, &self.shift);
        Self { acceleration: self.acceleration + advection, advection, ..self }
    }
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

/// Shift of the particle at place `i`, and its acceleration without that of the shift; `neighbour_fields` are those of all
/// particles, `near_surface` is whether it lies near the free surface, `excess` ε of the volume correction.
#[inline(always)]
pub fn regularise<S: FluidSpace, L: Lanes, G: Geometry<S>>(
    order: &OrderControl,
    scene: &Scene<G, S>,
    i: usize,
    neighbour_fields: &[S::Fields],
    near_surface: bool,
    sums: &RegularisationSums<S>,
    excess: f64,
) -> Regularisation<S> {
    let fields = &neighbour_fields[i];
    let eigenvalue = fields.eigenvalue();
    let place = if eigenvalue < S::SPRAY_EIGENVALUE {
        Place::Alone
    } else if near_surface {
        Place::Surface
    } else {
        Place::Inside
    };
    let fluid = &scene.fluid[i];
    let share = shift_share::<S>(scene.model, sums, fluid);
    let shift = if place == Place::Alone || share == 0.0 {
        S::Vector::zeros()
    } else {
        let normal = if place == Place::Surface {
            outward::<S, L, G>(scene, i, neighbour_fields, eigenvalue)
        } else {
            S::Vector::zeros()
        };
        shift(order, scene.model, sums, &normal) * share
    };
    let largest_tension = S::LARGEST_TENSION * scene.model.bulk_modulus();
    let pressure = (fluid.pressure() + fields.damper()).max(-largest_tension);
    let mut density = 0.0;
    if order.volume_correction > 0.0 {
        // Walls and solids on both sides of a lone particle leave no sign of a surface.
        density = lone_relaxation(scene, i);
        if place == Place::Inside {
            density += fluid.density() * excess * volume_rate(scene.model, sums.speed, eigenvalue);
        }
    }
    let acceleration = tensile(order, sums, place, pressure, fluid.density());
    Regularisation { shift, acceleration, advection: S::Vector::zeros(), density }
}

/// Half the curl of a velocity of this gradient \[1/s\].
#[inline(always)]
fn spin<S: Space>(velocity_gradient: &S::Tensor) -> S::Spin {
    let along = |axis: usize| {
        let mut unit = S::Vector::zeros();
        unit[axis] = 1.0;
        S::cross(&unit, &(*velocity_gradient * unit))
    };
    (0..S::DIMENSIONS).fold(S::Spin::default(), |curl, axis| curl + along(axis)) * 0.5
}

/// Velocity of the shift \[m/s\]; `normal` is zero away from the surface.
///
/// ```text
/// δu_i = −C 2h U_i Σ_j V_j [1 + R (W_ij/W(Δx))⁴] ∇W,  |δu_i| ≤ U_i/2      Sun et al. 2017, 2019
/// ```
/// U_i is the largest relative speed of neighbours: rigid motion causes no shift. At the surface and near it the part
/// along its normal is removed.
fn shift<S: FluidSpace>(
    order: &OrderControl,
    model: &FluidModel<S>,
    sums: &RegularisationSums<S>,
    normal: &S::Vector,
) -> S::Vector {
    let RegularisationSums { speed, shifting_gradient, .. } = *sums;
    let scale = -order.shifting * 2.0 * model.constants.smoothing_length() * speed;
    let shift = shifting_gradient * scale;
    (shift - *normal * shift.dot(normal)).cap_magnitude(0.5 * speed)
}

/// Share of the shift that a particle takes: none where pressure orders it.
///
/// ```text
/// min(1, (2 − p_i/(k ρ_i U_i²))₊),  k = ORDERED_BY_PRESSURE, or ORDERED_BY_PRESSURE_AT_VOLUME
/// ```
#[inline(always)]
fn shift_share<S: FluidSpace>(
    model: &FluidModel<S>,
    sums: &RegularisationSums<S>,
    fluid: &S::Particle,
) -> f64 {
    let enough = model.ordered_by_pressure * fluid.density() * sums.speed * sums.speed;
    // Without relative motion there is no shift either.
    if enough > 0.0 { (2.0 - fluid.pressure() / enough).clamp(0.0, 1.0) } else { 0.0 }
}

/// Acceleration \[m/s²\] that turns p_i + p_j into p_j − p_i where p_i is negative, inside the fluid.
///
/// ```text
/// 2 p_i/ρ_i Σ_j V_j ∇W                                                     Sun et al. 2018
/// ```
fn tensile<S: Space>(
    order: &OrderControl,
    sums: &RegularisationSums<S>,
    place: Place,
    pressure: f64,
    density: f64,
) -> S::Vector {
    if !order.tensile_control || pressure >= 0.0 || place != Place::Inside {
        return S::Vector::zeros();
    }
    sums.concentration * (2.0 * pressure / density)
}
