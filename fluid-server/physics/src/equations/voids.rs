//! Continuity next to a void.
//!
//! Eq. (17) takes all of the support for fluid. Where a front comes near a wall, or two surfaces near each other, it counts the
//! gap between them as fluid that is compressed: the front stops about half a spacing too early, and its pressure is up to
//! twice the force on the wall. Where they part, it counts the gap as tension.

use sph::lanes::{LanePass, Lanes};
use sph::space::geometry::Geometry;
use sph::space::tensors::SpaceVector;

use super::continuity::density_rate;
use crate::neighbours::batch::NeighbourBatch;
use crate::neighbours::scene::Scene;
use crate::system::model::FluidModel;
use crate::system::packed_particle::{FluidSpace, Packed};

/// A void in the support of a particle.
#[derive(Clone, Copy, Debug)]
pub struct Void<S: FluidSpace> {
    /// Unit vector toward it, that of −Σ V_j ∇W.
    direction: S::Vector,
    /// Share of it in the rates: 1 from a width of about two thirds of a spacing on \[-\].
    share: f64,
}

impl<S: FluidSpace> Void<S> {
    /// The void that `concentration`, Σ V_j ∇W over all neighbours \[1/m\], shows; `None` where it is within disorder, or the
    /// case computes no such sums.
    ///
    /// ```text
    /// share = clamp((h |Σ V_j ∇W| − 0.2)/0.2, 0, 1)
    /// ```
    #[inline(always)]
    pub fn shown_by(model: &FluidModel<S>, concentration: &S::Vector) -> Option<Self> {
        let length = concentration.norm();
        let gradient = model.constants.smoothing_length() * length;
        if gradient <= S::LEAST_VOID_GRADIENT || !model.corrects_continuity() {
            return None;
        }
        let share = (gradient - S::LEAST_VOID_GRADIENT) / (S::FULL_VOID_GRADIENT - S::LEAST_VOID_GRADIENT);
        Some(Self { direction: *concentration / -length, share: share.min(1.0) })
    }

    /// Density rate of the particle at place `i` by fluid and walls, which is `plain` without the void \[kg/(m³ s)\].
    #[inline(always)]
    pub fn density_rate<G: Geometry<S>>(&self, scene: &Scene<G, S>, i: usize, plain: f64) -> f64 {
        let particle = &scene.fluid[i];
        let divergence = scene.model.arithmetic.run(NearDivergence { scene, i, void: *self });
        let change = self.share * (density_rate(particle.density(), divergence) - plain);
        plain + lossy(change, particle.pressure())
    }

    /// Divergence \[1/s\] by a particle of a solid at `separation` = x_ij \[m\], which is `plain` without the void: the part
    /// share · clamp(2 cos θ, 0, 1) of it lies beyond, θ being the angle between its direction and that of the void.
    pub fn of_solid(&self, separation: &S::Vector, plain: f64) -> f64 {
        let (r, along) = (separation.norm(), -separation.dot(&self.direction));
        let beyond = if r > 0.0 { (along / (S::VOID_COSINE * r)).clamp(0.0, 1.0) } else { 0.0 };
        plain * (1.0 - self.share * beyond)
    }
}

/// A `change` of the density rate that takes energy from a fluid at `pressure`, or nothing.
///
/// The force across a void is that without it. A void that opens under pressure, or closes under tension, would gain energy.
#[inline(always)]
pub fn lossy(change: f64, pressure: f64) -> f64 {
    if change * pressure < 0.0 { change } else { 0.0 }
}

/// ∇·v \[1/s\] of a particle by its neighbours on this side of a void alone, with the L_i that belongs to them.
struct NearDivergence<'a, G, S: FluidSpace> {
    scene: &'a Scene<'a, G, S>,
    i: usize,
    void: Void<S>,
}

impl<S: FluidSpace, G: Geometry<S>> LanePass for NearDivergence<'_, G, S> {
    type Output = f64;

    #[inline(always)]
    fn run<L: Lanes>(self) -> f64 {
        let Self { scene, i, void } = self;
        let Scene { geometry, model, fluid, walls, .. } = *scene;
        let kernel = model.law.kernel.lanes();
        let motion = fluid[i].splat_motion();
        let direction = S::splat_each(&S::components(&void.direction));
        let scale = L::splat(-1.0 / (S::VOID_COSINE * model.constants.smoothing_length()));
        let (zero, one) = (L::zero(), L::splat(1.0));
        let (mut moment, mut velocity) = (S::zero_symmetric(), S::zero_matrix());
        for (row, others) in [(scene.fluid_row(i), fluid), (scene.wall_row(i), walls)] {
            for indices in row {
                let batch = NeighbourBatch::<S, L>::gather(geometry, &motion, others, *indices);
                let (s, slope) = kernel.slope(batch.square);
                let beyond = (scale * S::dot(batch.x, direction) / s).max(zero).min(one);
                let weighted = S::scaled(batch.x, batch.volume * slope / s * (one - beyond));
                moment = S::symmetric_minus_outer(moment, weighted, batch.x);
                velocity = S::minus_outer(velocity, batch.v, weighted);
            }
        }
        let (moment, gradient) = (S::symmetric_sums(moment), S::matrix_sums(velocity));
        let determinant = S::symmetric_determinant(moment);
        let corrected = if determinant >= S::SMALLEST_CORRECTION_DETERMINANT {
            S::matrix_times_symmetric(gradient, S::symmetric_inverse(moment, determinant))
        } else {
            gradient
        };
        S::trace(corrected)
    }
}
