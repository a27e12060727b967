//! The volume that the particles claim, against the volume that is there.
//!
//! ```text
//! φ_n = Σ_j V_j w_nj / V_n over the fluid, σ_n the same over fluid, walls and solids,   ε_i = Σ_n w_ni (σ_n − 1)/φ_n
//! ```
//! with the weights w_nj of particle j on the node n of a background grid, and V_n the volume of the cell of the node.
//! Where fluid, walls and solids fill all that has a weight on a node, σ_n − 1 is how much more volume their densities
//! claim than there is; other nodes are left out of ε_i. A node hands its excess to the fluid that claims it:
//! Σ_i V_i ε_i = Σ_n V_n (σ_n − 1), whatever the arrangement of the particles. In a full vessel that is all the volume
//! that is claimed in excess, since Σ_n w_nj = 1. A sum with the kernel at the particles themselves has a bias: 0.2 % too much inside disordered fluid,
//! 0.8 % too little along walls, since the places of particles are not independent of each other.

use std::ops::Range;

use rayon::prelude::*;
use sph::interface::states::InterfaceStates;
use sph::lanes::{LanePass, Lanes};
use sph::space::geometry::Geometry;

use crate::neighbours::background_grid::BackgroundGrid;
use crate::neighbours::scene::Scene;
use crate::system::packed_particle::{FluidSpace, Packed};
use crate::system::tasks::{TASK, for_each_task};
use crate::system::walls::WallField;

/// Claims on the nodes, and what follows for each particle; buffers are reused.
#[derive(Clone, Debug, Default)]
pub struct VolumeReading {
    /// φ of each node \[-\], then (σ − 1)/φ.
    fluid: Vec<f64>,
    /// Claim of walls and solids on each node, σ − φ \[-\].
    others: Vec<f64>,
    /// Claim of walls that stand on each node \[-\], and the placement of the nodes to which it belongs.
    standing: (Option<u64>, Vec<f64>),
    /// ε of each fluid particle \[-\].
    excess: Vec<f64>,
}

impl VolumeReading {
    /// Reads the volumes of `scene`, with the walls in `field` at `time` \[s\] and the particles of a `partner`.
    ///
    /// A node counts where the claim of the fluid is not small beside that of walls and solids, and where no particle at
    /// the surface has a weight. Walls and solids stand for their own volume.
    pub fn read<S: FluidSpace, G: Geometry<S>>(
        &mut self,
        scene: &Scene<G, S>,
        field: &WallField<S>,
        time: f64,
        partner: Option<&InterfaceStates<S>>,
        at_surface: impl Fn(usize) -> bool + Sync,
    ) {
        let Scene { lists, fluid, .. } = *scene;
        let (grid, arithmetic) = (lists.background(), scene.model.arithmetic);
        self.sum_others(grid, scene, field, time, partner);
        let per_volume = 1.0 / grid.node_volume();
        self.fluid.clear();
        self.fluid.resize(grid.len(), 0.0);
        grid.for_each_band(&mut self.fluid, &|particles, nodes, origin| {
            arithmetic.run(Claim::<S, _> {
                grid,
                per_volume,
                fluid,
                particles,
                at_surface: &at_surface,
                nodes,
                origin,
            });
        });
        grid.fold(&mut self.fluid);
        let each = self.fluid.par_iter_mut().zip(&self.others).with_min_len(TASK);
        each.for_each(|(fluid, others)| {
            let counts = *fluid > S::LEAST_FLUID_CLAIM * others;
            *fluid = if counts { (*fluid + others - 1.0) / *fluid } else { 0.0 };
        });
        self.excess.resize(fluid.len(), 0.0);
        let nodes = &self.fluid;
        for_each_task(fluid.len(), &mut self.excess[..], &|particles, excess| {
            arithmetic.run(HandBack::<S> { grid, nodes, fluid: &fluid[particles], excess });
        });
    }

    /// ε of particle `i` within limits \[-\].
    #[inline(always)]
    pub fn excess(&self, i: usize) -> f64 {
        self.excess.get(i).copied().unwrap_or_default()
    }

    /// Bytes in use.
    pub fn bytes(&self) -> usize {
        let Self { fluid, others, standing: (_, standing), excess } = self;
        8 * [fluid, others, standing, excess].map(Vec::capacity).iter().sum::<usize>()
    }

    /// Sums the claims of walls and solids.
    fn sum_others<S: FluidSpace, G: Geometry<S>>(
        &mut self,
        grid: &BackgroundGrid,
        scene: &Scene<G, S>,
        field: &WallField<S>,
        time: f64,
        partner: Option<&InterfaceStates<S>>,
    ) {
        let model = scene.model;
        let per_volume = 1.0 / grid.node_volume();
        let of_wall = per_volume * model.walls.mass / model.constants.rest_density;
        let Self { others, standing: (placement, standing), .. } = self;
        let sum_walls = |nodes: &mut Vec<f64>| {
            nodes.clear();
            nodes.resize(grid.len(), 0.0);
            for (x, wall) in field.position.iter().zip(&model.walls.wall) {
                if let (true, Some(stencil)) = (model.walls.acts(*wall, time), grid.stencil::<S>(x)) {
                    grid.add(&stencil, of_wall, nodes, 0);
                }
            }
        };
        if model.walls.stand() {
            if *placement != Some(grid.placement()) {
                sum_walls(standing);
                *placement = Some(grid.placement());
            }
            others.clone_from(standing);
        } else {
            sum_walls(others);
        }
        if let Some(solids) = partner {
            for (s, x) in solids.position.iter().enumerate() {
                if let Some(stencil) = grid.stencil::<S>(&model.domain.wrapped(x)) {
                    grid.add(&stencil, solids.volume(s) * per_volume, others, 0);
                }
            }
        }
        grid.fold(others);
    }
}

/// Adds the claims of some particles to nodes. The instructions of the lanes serve the rows of a stencil.
struct Claim<'a, S: FluidSpace, F> {
    grid: &'a BackgroundGrid,
    per_volume: f64,
    fluid: &'a [S::Particle],
    particles: Range<usize>,
    at_surface: &'a F,
    nodes: &'a mut [f64],
    origin: usize,
}

impl<S: FluidSpace, F: Fn(usize) -> bool> LanePass for Claim<'_, S, F> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { grid, per_volume, fluid, particles, at_surface, nodes, origin } = self;
        for i in particles {
            let Some(stencil) = grid.stencil::<S>(&fluid[i].position()) else { continue };
            if at_surface(i) {
                grid.set(&stencil, f64::NEG_INFINITY, nodes, origin);
            } else {
                grid.add(&stencil, fluid[i].volume() * per_volume, nodes, origin);
            }
        }
    }
}

/// Hands the excess of the nodes to the particles of a task.
struct HandBack<'a, S: FluidSpace> {
    grid: &'a BackgroundGrid,
    nodes: &'a [f64],
    fluid: &'a [S::Particle],
    excess: &'a mut [f64],
}

impl<S: FluidSpace> LanePass for HandBack<'_, S> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { grid, nodes, fluid, excess } = self;
        for (particle, excess) in fluid.iter().zip(excess) {
            let stencil = grid.stencil::<S>(&particle.position());
            let mean = stencil.map_or(0.0, |stencil| grid.mean(&stencil, nodes));
            *excess = mean.clamp(-S::LARGEST_VOLUME_EXCESS, S::LARGEST_VOLUME_EXCESS);
        }
    }
}
