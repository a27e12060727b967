//! Sums of a particle over one wall alone.

use std::marker::PhantomData;
use std::ops::Range;

use sph::lanes::{LanePass, Lanes};
use sph::prescribed::motion::MotionState;
use sph::space::geometry::Geometry;

use super::energy::ForcePowers;
use super::stage_fields::StageFields;
use crate::boundary::repulsion::wall_repulsion;
use crate::equations::pair::{LawLanes, PairParts};
use crate::equations::terms::{PairTerms, TermsPass};
use crate::system::packed_particle::{FluidSpace, Packed};

/// Stress divergence Σ V_w [...]·∇W of the particle at place `i` over the particles of `wall` \[Pa/m\], and its parts.
pub struct OneWall<'a, G, S: FluidSpace, T> {
    /// Input of the rates.
    pub fields: &'a StageFields<'a, G, S>,
    /// Terms.
    pub terms: PhantomData<T>,
    /// Place of the particle.
    pub i: usize,
    /// Index of the wall.
    pub wall: u32,
}

impl<S: FluidSpace, G: Geometry<S>, T: PairTerms> LanePass for OneWall<'_, G, S, T> {
    type Output = (S::Vector, PairParts<S>);

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let Self { fields, i, wall, .. } = self;
        let mut own = fields.own::<L, T>(i);
        if !T::NEIGHBOUR_FIELDS {
            own.pressure = own.pressure + L::splat(fields.damper(i));
        }
        let law = LawLanes::new(fields.scene.model);
        let sums = fields.wall_sums::<L, T>(&law, i, &own, Some(wall));
        (sums.total().stress_divergence, sums.parts(&law))
    }
}

/// Moves to the account of walls what those that move do by their motion on `particles`: walls that move are rare, so
/// that the pass over all particles is compiled without it.
pub struct WallCredits<'a, G, S: FluidSpace> {
    /// Input of the rates.
    pub fields: &'a StageFields<'a, G, S>,
    /// Motion of each wall, `None` for one at rest.
    pub motions: &'a [Option<MotionState<S>>],
    /// The particles, by their own indices.
    pub particles: Range<usize>,
    /// Powers that are changed.
    pub powers: &'a mut ForcePowers,
}

impl<S: FluidSpace, G: Geometry<S>> TermsPass for WallCredits<'_, G, S> {
    type Output = ();

    fn call<T: PairTerms>(self) {
        let Self { fields, motions, particles, powers } = self;
        let scene = &fields.scene;
        let model = scene.model;
        for i in particles {
            for (wall, motion) in (0..).zip(motions) {
                let near = |w: usize| model.walls.wall[w] == wall;
                let Some(motion) = motion.as_ref().filter(|_| scene.wall_neighbours(i).any(near)) else {
                    continue;
                };
                let particle = &scene.fluid[i];
                let pass = OneWall { fields, terms: PhantomData::<T>, i, wall };
                let (divergence, parts) = model.arithmetic.run(pass);
                let pairs = divergence / -particle.density();
                let repulsion = wall_repulsion(scene, fields.field, i, Some(wall));
                let velocity = motion.velocity_at(&particle.position());
                let extent = (fields.state.mass[i], particle.volume());
                powers.credit_wall(extent, &velocity, &pairs, &parts, &repulsion);
            }
        }
    }
}
