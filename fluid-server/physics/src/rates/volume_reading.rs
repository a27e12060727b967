//! The volume that the particles claim, against the volume that is there.
//!
//! ```text
//! φ_n = Σ_j V_j w_nj / V_n over the fluid, σ_n the same over fluid, walls and solids,   ε_i = Σ_n w_ni (σ_n − 1)/φ_n
//! ```
//! with the weights w_nj of particle j on the node n of a background grid, and V_n the volume of the cell of the node.
//! Where fluid, walls and solids fill all that has a weight on a node, σ_n − 1 is how much more volume their densities
//! claim than there is; other nodes are left out of ε_i. A node hands its excess to the fluid that claims it:
//! Σ_i V_i ε_i = Σ_n V_n (σ_n − 1), whatever the arrangement of the particles. In a full vessel that is all the volume
//! that is claimed in excess, since Σ_n w_nj = 1. A sum with the kernel at the particles themselves has a bias: 0.2 % too
//! much inside disordered fluid, 0.8 % too little along walls, since the places of particles are not independent of each
//! other.
//!
//! The lattice of the particles shows on the nodes, the more the wider it is stretched: the particles spread V_j ε_j on the
//! nodes and read it once more, ε_i ← Σ_n w_ni (Σ_j V_j ε_j w_nj/V_n)/φ_n. Over the nodes that
//! count this keeps the sum, and takes from what alternates between neighbours all but its square. The share on other nodes
//! is lost: the correction is that much slower there, and zero where there is no excess.
//!
//! Volume parts from density slowly: it is read in every fourth step, and each particle keeps its ε_i until the next reading.

use sph::coupling::stage::{Stage, StepStage};
use sph::lanes::Arithmetic;
use sph::space::geometry::Geometry;

use crate::interface::fluid_interface::FluidInterface;
use crate::neighbours::background_grid::BackgroundGrid;
use crate::neighbours::scene::Scene;
use crate::rates::particle_rates::StagePart;
use crate::system::packed_particle::{FluidSpace, Packed};
use crate::system::tasks::for_each_task;
use crate::system::walls::WallField;

sph::constants! {
    /// At its largest speed the correction takes up to two thirds of an excess in this time.
    const READING_STEPS: u32 = 4, "volume_correction.reading_steps",
        "steps from one reading of the volume to the next [-]";
}

/// Whether the volume is read in a stage that computes `part` of the rates: once in a step in which it is read at all.
pub fn is_read(at: StepStage, part: StagePart) -> bool {
    let computes = part == StagePart::Momentum || (part == StagePart::Whole && at.stage == Stage::Predictor);
    computes && at.step.is_multiple_of(READING_STEPS.into())
}

/// Claims on the nodes; buffers are reused.
#[derive(Clone, Debug, Default)]
pub struct VolumeReading {
    /// φ of each node \[-\].
    fluid: Vec<f64>,
    /// Claim of walls and solids on each node, then σ, then what is handed back \[-\].
    all: Vec<f64>,
    /// Claim of walls that stand on each node \[-\], and the placement of the nodes to which it belongs.
    standing: (Option<u64>, Vec<f64>),
    /// Whether each node does not count.
    left_out: Vec<bool>,
    /// Mean claim around each particle of a partner \[-\].
    around_solids: Vec<f64>,
}

impl VolumeReading {
    /// Reads ε of each fluid particle within limits \[-\] into `excess`, in `scene` with the walls in `field` at `time`
    /// \[s\] and the particles of a partner, by its `interface`.
    ///
    /// A node counts where the claim of the fluid is not small beside that of walls and solids, and where no particle at
    /// the surface of the fluid has a weight, nor one of a solid that is not surrounded or stands between disconnected
    /// regions of the fluid, of which one would read the volume of the other. Walls and solids stand for their own volume.
    pub fn read<S: FluidSpace, G: Geometry<S>>(
        &mut self,
        scene: &Scene<G, S>,
        field: &WallField<S>,
        time: f64,
        interface: Option<&FluidInterface<S>>,
        at_surface: impl Fn(usize) -> bool + Sync,
        excess: &mut [f64],
    ) {
        let Scene { lists, fluid, model, .. } = *scene;
        let own = scene.own();
        let (grid, arithmetic) = (lists.background(), model.arithmetic);
        let partner = interface.map(FluidInterface::partner);
        // Particles of a solid along periodic axes may lie outside the box.
        let solids = || {
            let wrapped = |x| model.domain.wrapped(x);
            partner.into_iter().flat_map(move |solids| solids.position.iter().map(wrapped))
        };
        self.sum_walls(grid, scene, field, time);
        if let Some(states) = partner {
            let claims = solids().zip((0..).map(|s| states.volume(s) / grid.node_volume()));
            grid.spread::<S>(arithmetic, claims, &mut self.all, 0);
        }
        grid.fold(&mut self.all, |a, b| a + b);
        let claim = |i: usize| fluid[i].volume() / grid.node_volume();
        Self::sum(scene, &claim, &mut self.fluid);
        self.all.iter_mut().zip(&self.fluid).for_each(|(all, fluid)| *all += fluid);
        self.around_solids.resize(partner.map_or(0, |states| states.len()), 0.0);
        grid.read::<S>(arithmetic, solids(), &self.all, self.around_solids.iter_mut());
        self.agree_around_solids(scene, solids());
        let is_left_out = |s: usize| {
            let separates = interface.is_some_and(|interface| interface.separates(s));
            separates || self.around_solids[s] < S::LEAST_CLAIM_AROUND_SOLIDS
        };
        let left_out = solids().enumerate().filter(|(s, _)| is_left_out(*s)).map(|(_, x)| x);
        self.left_out.clear();
        self.left_out.resize(grid.len(), false);
        grid.for_each_band(&mut self.left_out, &|particles, nodes, origin| {
            let particles = particles.map(|place| lists.in_cell_order(place));
            let positions = particles.filter(|i| at_surface(*i)).map(|i| fluid[i].position());
            grid.mark::<S>(positions, nodes, origin);
        });
        grid.mark::<S>(left_out, &mut self.left_out, 0);
        grid.fold(&mut self.left_out, |a, b| a || b);
        for ((all, fluid), left_out) in self.all.iter_mut().zip(&self.fluid).zip(&mut self.left_out) {
            *left_out |= *fluid <= S::LEAST_FLUID_CLAIM * (*all - fluid);
            *all = if *left_out { 0.0 } else { (*all - 1.0) / fluid };
        }
        self.hand_back::<S>(grid, arithmetic, &fluid[own.clone()], excess);
        excess.iter_mut().for_each(|excess| {
            *excess = excess.clamp(-S::LARGEST_VOLUME_EXCESS, S::LARGEST_VOLUME_EXCESS);
        });
        // Once more by way of the nodes.
        let copied;
        let with_copies = match lists.placement().halo() {
            None => &excess[..],
            Some(halo) => {
                copied = halo.with_copies(&model.team, excess);
                &copied[..]
            }
        };
        let claimed = |i: usize| fluid[i].volume() * with_copies[i] / grid.node_volume();
        Self::sum(scene, &claimed, &mut self.all);
        for ((all, fluid), left_out) in self.all.iter_mut().zip(&self.fluid).zip(&self.left_out) {
            *all = if *left_out { 0.0 } else { *all / fluid };
        }
        self.hand_back::<S>(grid, arithmetic, &fluid[own], excess);
    }

    /// Takes the mean claim around each particle of a partner, at `positions` \[m\], from the part that answers for it.
    fn agree_around_solids<S: FluidSpace, G: Geometry<S>>(
        &mut self,
        scene: &Scene<G, S>,
        positions: impl Iterator<Item = S::Vector>,
    ) {
        let team = &scene.model.team;
        if team.is_alone() {
            return;
        }
        let answered = positions.map(|x| scene.lists.placement().answers_for(scene.model, &x));
        let own = self.around_solids.iter().zip(answered).map(|(claim, own)| own.then_some(*claim));
        self.around_solids = team.complete(own.collect());
    }

    /// The means of `all` around own particles.
    fn hand_back<S: FluidSpace>(
        &self,
        grid: &BackgroundGrid,
        arithmetic: Arithmetic,
        fluid: &[S::Particle],
        means: &mut [f64],
    ) {
        for_each_task(fluid.len(), means, &|particles, means: &mut [f64]| {
            let positions = fluid[particles].iter().map(Packed::position);
            grid.read::<S>(arithmetic, positions, &self.all, means.iter_mut());
        });
    }

    /// Bytes in use.
    pub fn bytes(&self) -> usize {
        let Self { fluid, all, standing: (_, standing), left_out, around_solids } = self;
        8 * [fluid, all, standing, around_solids].map(Vec::capacity).iter().sum::<usize>()
            + left_out.capacity()
    }

    /// Sums a `value` of each particle on the nodes.
    fn sum<S: FluidSpace, G: Geometry<S>>(
        scene: &Scene<G, S>,
        value: &(impl Fn(usize) -> f64 + Sync),
        nodes: &mut Vec<f64>,
    ) {
        let Scene { lists, fluid, model, .. } = *scene;
        let grid = lists.background();
        nodes.clear();
        nodes.resize(grid.len(), 0.0);
        grid.for_each_band(nodes, &|particles, nodes, origin| {
            let particles = particles.map(|place| lists.in_cell_order(place));
            let particles = particles.map(|i| (fluid[i].position(), value(i)));
            grid.spread::<S>(model.arithmetic, particles, nodes, origin);
        });
        grid.fold(nodes, |a, b| a + b);
    }

    /// Sums the claims of walls.
    fn sum_walls<S: FluidSpace, G: Geometry<S>>(
        &mut self,
        grid: &BackgroundGrid,
        scene: &Scene<G, S>,
        field: &WallField<S>,
        time: f64,
    ) {
        let walls = &scene.model.walls;
        let claim = walls.mass / scene.model.constants.rest_density / grid.node_volume();
        let Self { all, standing: (placement, standing), .. } = self;
        let sum = |nodes: &mut Vec<f64>| {
            nodes.clear();
            nodes.resize(grid.len(), 0.0);
            let acting = field.position.iter().zip(&walls.wall).filter(|(_, wall)| walls.acts(**wall, time));
            grid.spread::<S>(scene.model.arithmetic, acting.map(|(x, _)| (*x, claim)), nodes, 0);
        };
        if walls.stand() {
            if *placement != Some(grid.placements()) {
                sum(standing);
                *placement = Some(grid.placements());
            }
            all.clone_from(standing);
        } else {
            sum(all);
        }
    }
}
