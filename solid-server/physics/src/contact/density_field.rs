//! Penetration depth of a particle in another body by a smoothed density, and the force of that depth.

use sph::setup::SolidSetup;
use sph::space::tensors::SpaceVector;

use crate::neighbours::lists::PairRadii;
use crate::space::SolidSpace;

sph::constants! {
    const SAMPLES: u32 = 16, "solid.contact.samples",
        "places along a row at which the density of a half-space is sampled [-]";
    /// More than the way by which two bodies approach in a step, see `solid.rigid.travel`.
    pub const IMMINENT: f64 = 0.6, "solid.contact.imminent",
        "distance beyond that of contact from which the sub-steps of a rigid body allow for it, in particle spacings [-]";
}

/// Density field of a half-space of particles as a measure of depth.
///
/// ```text
/// D_i = Σ_j ΔX² W(r_ij),  δ = d (D − D(d))/(D(0) − D(d)),  W ∝ (1 − q)⁴ (1 + 4q), q = r/H (Wendland C²)
/// ```
///
/// j are the particles of the other body, d is the contact distance of two rows, D(y) the density at height y over the
/// outer row of a half-space of particles at rest. So δ is 0 where rows are d apart and d where they coincide. Along a
/// row δ varies by less than a thousandth of a spacing, so bodies do not interlock.
#[derive(Clone, Copy, Debug)]
pub struct DensityField {
    /// Radius H within which particles count \[m\].
    pub support: f64,
    scale: f64,
    /// D(d) \[-\].
    at_contact: f64,
    /// dδ/dD \[m\].
    pub gain: f64,
    /// Contact distance d \[m\].
    pub distance: f64,
    /// Depth 0.6 Δx before contact \[m\], negative.
    pub imminent: f64,
}

impl DensityField {
    /// Density field of a body of particle spacing `spacing` \[m\], in contact from the distance `distance` \[m\].
    pub fn new<S: SolidSpace>(spacing: f64, distance: f64) -> Self {
        let support = S::CONTACT_REACH.max(S::CONTACT_REACH - 1.0 + distance / spacing) * spacing;
        let scale = S::wendland_weight(spacing, support);
        let bare = Self { support, scale, at_contact: 0.0, gain: 0.0, distance, imminent: 0.0 };
        let heights = |height: f64| {
            (0..SAMPLES)
                .map(move |k| bare.over_half_space::<S>(spacing, f64::from(k) / f64::from(SAMPLES), height))
        };
        // The largest over the phases: lattices laid side by side start without force.
        let at_contact = heights(distance).fold(0.0, f64::max);
        let mean = |height: f64| heights(height).sum::<f64>() / f64::from(SAMPLES);
        let gain = distance / (mean(0.0) - at_contact);
        let imminent = gain * (mean(distance + IMMINENT * spacing) - at_contact);
        Self { at_contact, gain, imminent, ..bare }
    }

    /// D at `height` \[m\] over the outer row, `phase` spacings along it.
    fn over_half_space<S: SolidSpace>(&self, spacing: f64, phase: f64, height: f64) -> f64 {
        S::over_half_space(self.support / spacing, phase, height, spacing, |r| self.weight(r))
    }

    /// ΔX² W at distance `r` \[m\].
    #[inline]
    pub fn weight(&self, r: f64) -> f64 {
        let rest = (1.0 - r / self.support).max(0.0);
        self.scale * rest.powi(4) * (5.0 - 4.0 * rest)
    }

    /// ΔX² (dW/dr)/r at distance `r` \[1/m²\]: times x_ij it is the gradient of D_i by x_i.
    #[inline]
    pub fn gradient_factor(&self, r: f64) -> f64 {
        let rest = (1.0 - r / self.support).max(0.0);
        -20.0 * self.scale * rest.powi(3) / (self.support * self.support)
    }

    /// Depth δ \[m\] where the density is `density` \[-\].
    #[inline]
    pub fn depth(&self, density: f64) -> f64 {
        self.gain * (density - self.at_contact)
    }
}

/// Density fields of bodies and walls.
#[derive(Clone, Copy, Debug)]
pub struct DensityFields {
    /// Of bodies.
    pub bodies: DensityField,
    /// Of walls, whose particles may have another spacing.
    pub walls: DensityField,
    /// Of bodies, for the depth of wall particles in them.
    pub bodies_from_walls: DensityField,
    /// Spacing of the wall particles \[m\].
    pub wall_spacing: f64,
}

impl DensityFields {
    /// Density fields of the bodies and walls of `setup`, in contact from `distance` mean spacings \[-\].
    pub fn new<S: SolidSpace>(setup: &SolidSetup<S>, distance: f64) -> Self {
        let (spacing, wall_spacing) = (setup.particle_spacing, wall_spacing(setup));
        let to_walls = distance * 0.5 * (spacing + wall_spacing);
        Self {
            bodies: DensityField::new::<S>(spacing, distance * spacing),
            walls: DensityField::new::<S>(wall_spacing, to_walls),
            bodies_from_walls: DensityField::new::<S>(spacing, to_walls),
            wall_spacing,
        }
    }

    /// Undeformed distance \[m\] from which parts of one body can be in contact.
    pub fn self_contact_distance<S: SolidSpace>(&self) -> f64 {
        S::SELF_CONTACT_DISTANCE * self.bodies.support
    }

    /// Distances within which particles count.
    pub fn radii(&self) -> PairRadii {
        PairRadii {
            bodies: self.bodies.support,
            walls: self.walls.support.max(self.bodies_from_walls.support),
        }
    }
}

/// Spacing of the wall particles \[m\]: the smallest distance of consecutive particles of a wall; that of the bodies
/// without walls.
fn wall_spacing<S: SolidSpace>(setup: &SolidSetup<S>) -> f64 {
    let walls = &setup.wall_particles;
    let distance = |k: usize| {
        let next = (k + 1..walls.position.len()).take(1).filter(|next| walls.wall[*next] == walls.wall[k]);
        next.map(|next| (walls.position[next] - walls.position[k]).norm()).fold(f64::INFINITY, f64::min)
    };
    let smallest = (0..walls.position.len()).map(distance).fold(f64::INFINITY, f64::min);
    if smallest.is_finite() && smallest > 0.0 { smallest } else { setup.particle_spacing }
}

/// Force against the depth of a particle, in the plane per metre of depth of the scene, and its slope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring {
    /// Force \[N/m\].
    pub force: f64,
    /// Slope \[Pa\].
    pub slope: f64,
}

impl Spring {
    /// f = κ δ d/(d − δ) of stiffness κ `stiffness` \[Pa\]; beyond 0.95 d by its tangent, so that it stays finite.
    #[inline]
    pub fn new<S: SolidSpace>(stiffness: f64, depth: f64, distance: f64) -> Self {
        let curved = depth.min(S::STIFFEST_DEPTH * distance);
        let ratio = distance / (distance - curved);
        let slope = stiffness * ratio * ratio;
        Self { force: stiffness * curved * ratio + slope * (depth - curved), slope }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sph::space::{Plane, Spatial};

    fn check_depth<S: SolidSpace>() {
        let field = DensityField::new::<S>(0.01, 0.01);
        for (height, allowed) in [(1.0, 3e-4), (0.9, 1e-3), (0.7, 3e-3)] {
            for k in 0..10 {
                let found = field.depth(field.over_half_space::<S>(0.01, 0.1 * f64::from(k), 0.01 * height));
                let flat = field.depth(field.over_half_space::<S>(0.01, 0.0, 0.01 * height));
                // Measured: the corrugation grows from 1e-4 to 2e-3 spacings as rows approach.
                assert!((found - flat).abs() < allowed * 0.01, "{height} {k}: {found} {flat}");
                // The chord from contact to coincidence: D(y) bends by less than a tenth of a spacing.
                assert!((found - 0.01 * (1.0 - height)).abs() < 1e-3, "{height}: {found}");
            }
        }
    }

    #[test]
    fn depth_is_that_of_rows_and_hardly_depends_on_the_lattice() {
        check_depth::<Plane>();
        check_depth::<Spatial>();
    }

    #[test]
    fn the_gradient_is_that_of_the_level() {
        let field = DensityField::new::<Plane>(1.0, 1.0);
        for r in [0.0, 0.3, 1.0, 2.2, 2.999, 3.1] {
            let slope = (field.weight(r + 1e-6) - field.weight((r - 1e-6).abs())) / 2e-6;
            assert!((field.gradient_factor(r) * r - slope).abs() < 1e-9, "{r}");
        }
    }

    #[test]
    fn the_spring_sets_in_gently_stiffens_and_stays_smooth() {
        assert_eq!(Spring::new::<Plane>(2.0, 0.0, 1.0), Spring { force: 0.0, slope: 2.0 });
        assert!((Spring::new::<Plane>(2.0, 0.5, 1.0).force - 2.0).abs() < 1e-12);
        for depth in [0.2, 0.9, 0.95, 1.0, 2.0] {
            let at = |x: f64| Spring::new::<Plane>(2.0, x, 1.0);
            let slope = (at(depth + 1e-7).force - at(depth - 1e-7).force) / 2e-7;
            assert!((slope / at(depth).slope - 1.0).abs() < 1e-4, "{depth}");
        }
    }
}
