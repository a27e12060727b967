//! The volume correction, which ties the density to the volume that the particles fill.
//!
//! Eq. (17) with L_i follows the flow, not the number of particles: each time that particles change their arrangement a
//! remainder is left, of one sign in shear, and Σ m/ρ parts from the volume that is there.
//! [`crate::rates::volume_reading`] reads by how much, from positions and densities alone.
//!
//! A particle without fluid around it has no volume of its own that could be read. When a body presses it against a wall,
//! Eq. (17) compresses it without end, since a single particle cannot spread along the gap as the water does for which it
//! stands. Its density relaxes toward that at rest.

use sph::space::geometry::Geometry;
use sph::space::tensors::SpaceVector;

use crate::neighbours::scene::Scene;
use crate::system::model::FluidModel;
use crate::system::packed_particle::{FluidSpace, Packed};

/// Rate of the volume correction \[1/s\] for particles that move at U = `speed` \[m/s\] relative to each other, with
/// the smallest `eigenvalue` of the moment matrix \[-\].
///
/// ```text
/// dρ_i/dt gains ρ_i ε_i r_i,   r_i = min(k U_i, 0.2 c₀)/h · clamp((λ_i − 0.87)/0.06, 0, 1)
/// ```
/// Disorder arises as fast as particles pass each other: a rate by U leaves an error in equilibrium that does not depend
/// on spacing, flow or c₀, and leaves rigid motion alone.
#[inline(always)]
pub fn volume_rate<S: FluidSpace>(model: &FluidModel<S>, speed: f64, eigenvalue: f64) -> f64 {
    let c = &model.constants;
    let speed = (c.volume_correction * speed).min(S::LARGEST_VOLUME_SPEED * c.sound_speed);
    let (least, full) = (S::LEAST_VOLUME_EIGENVALUE, S::FULL_VOLUME_EIGENVALUE);
    speed / c.smoothing_length() * ((eigenvalue - least) / (full - least)).clamp(0.0, 1.0)
}

/// Density rate by which a particle at place `i` without fluid around it relaxes \[kg/(m³ s)\].
///
/// ```text
/// −(c₀/h) (ρ_i − ρ_b) clamp((0.1 − Σ_j V_j W_ij)/0.08, 0, 1) over the fluid,   ρ_b = clamp(ρ_i, 0.99 ρ₀, 1.01 ρ₀)
/// ```
/// Pressure from walls and solids then stays of the order ρ₀ c₀ v at a speed of approach v, whatever the way.
#[inline(always)]
pub fn lone_relaxation<S: FluidSpace, G: Geometry<S>>(scene: &Scene<G, S>, i: usize) -> f64 {
    let Scene { geometry, model, fluid, .. } = scene;
    let (c, density) = (&model.constants, fluid[i].density());
    let (lower, upper) = (1.0 - S::LONE_COMPRESSION, 1.0 + S::LONE_COMPRESSION);
    let excess = density - density.clamp(lower * c.rest_density, upper * c.rest_density);
    // Nearly all particles.
    if excess == 0.0 {
        return 0.0;
    }
    let mut around = 0.0;
    for j in scene.fluid_neighbours(i).filter(|j| *j != i) {
        let distance = geometry.separation(&fluid[i].position(), &fluid[j].position()).norm();
        around += fluid[j].volume() * model.kernel.value(distance);
        if around >= S::ACCOMPANIED_SHARE {
            return 0.0;
        }
    }
    let alone = ((S::ACCOMPANIED_SHARE - around) / (S::ACCOMPANIED_SHARE - S::LONE_SHARE)).min(1.0);
    -alone * excess * c.sound_speed / c.smoothing_length()
}
