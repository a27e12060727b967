//! Rates of change of every fluid particle, Eq. (17)-(19), (22)-(24).

use rayon::prelude::*;
use sph::vector::Vector;

use super::gradients::{Gradients, mirrored_stress, momentum_tensor};
use super::lanes::{LANES, Lanes};
use super::lists::Lists;
use super::model::FluidModel;
use super::pair::{
    Batch, Friction, Geometry, IDENTITY, Matrix, Own, PairSums, Record, for_each_batch, gather,
};
use super::state::FluidState;
use super::walls::WallStates;

/// Fluid particles per task.
pub const TASK: usize = 256;

/// Rates of one particle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rates {
    /// Acceleration \[m/s²\].
    pub acceleration: Vector,
    /// Part of it by walls \[m/s²\].
    pub walls: Vector,
    /// Part of it by the body force \[m/s²\].
    pub body: Vector,
    /// Part of it by stabilisers that are not antisymmetric \[m/s²\].
    pub stabilisers: Vector,
    /// Velocity by which the position is shifted besides \[m/s\].
    pub shift: Vector,
    /// Density rate \[kg/(m³ s)\].
    pub density: f64,
}

/// What the rates are computed from.
#[derive(Clone, Copy)]
pub struct StageFields<'a> {
    /// Constants.
    pub model: &'a FluidModel,
    /// State.
    pub state: &'a FluidState,
    /// Neighbours.
    pub lists: &'a Lists,
    /// Fluid as neighbours read it.
    pub fluid: &'a [Record],
    /// Walls as neighbours read them.
    pub walls: &'a WallStates,
    /// Results of the gradient pass.
    pub gradients: &'a Gradients,
    /// Time of the stage state \[s\].
    pub time: f64,
}

impl StageFields<'_> {
    /// Rates by the fluid itself, walls, body force and damping into `rates`.
    pub fn rates<G: Geometry>(&self, geometry: G, rates: &mut Vec<Rates>) {
        let passes = self.model.passes;
        rates.resize(self.fluid.len(), Rates::default());
        match (passes.density_gradient, passes.tensor()) {
            (false, false) => self.gather::<G, false, false>(geometry, rates),
            (true, false) => self.gather::<G, true, false>(geometry, rates),
            (false, true) => self.gather::<G, false, true>(geometry, rates),
            (true, true) => self.gather::<G, true, true>(geometry, rates),
        }
    }

    fn gather<G: Geometry, const GRADIENT: bool, const TENSOR: bool>(
        &self,
        geometry: G,
        rates: &mut [Rates],
    ) {
        let Self { model, state, lists, fluid, gradients, .. } = self;
        let damping = model.damping_rate(self.time);
        let body_force = model.body_force.at(self.time);
        rates.par_iter_mut().with_min_len(TASK).enumerate().for_each(|(i, rates)| {
            let own = self.own::<GRADIENT, TENSOR>(i);
            let mut sums = PairSums::<GRADIENT, TENSOR>::default();
            for_each_batch(lists.fluid.of(i), |indices, count| {
                let batch = Batch::gather(geometry, own.record, fluid, indices, count);
                let gradient =
                    if GRADIENT { gather(indices, |j| gradients.density[j]) } else { Default::default() };
                let tensor =
                    if TENSOR { gather(indices, |j| gradients.tensor[j]) } else { Default::default() };
                let friction = if model.law.viscous {
                    let [viscosity] = gather(indices, |j| [gradients.viscosity[j]]);
                    let viscosity = Lanes::splat(gradients.viscosity[i]) + viscosity;
                    Friction { viscosity, slip: [batch.v_x, batch.v_y] }
                } else {
                    Friction::default()
                };
                sums.add(&model.law, &own, &batch, gradient, tensor, friction);
            });
            let walls = self.wall_sums(geometry, i, &own, |_| true);
            let repulsion = self.wall_repulsion(geometry, i, |_| true);
            let [by_fluid, by_walls] = [&sums, &walls].map(|sums| {
                let [x, y] = sums.stress_divergence();
                Vector::new(x, y) / -own.record.density
            });
            let by_walls = by_walls + repulsion;
            let body = body_force.acceleration(&state.position[i]);
            *rates = Rates {
                acceleration: by_fluid + by_walls + body - state.velocity[i] * damping,
                walls: by_walls,
                body,
                density: own.record.density * (sums.continuity() + walls.continuity())
                    + model.diffusion * (sums.diffusion() + walls.diffusion()),
                ..Rates::default()
            };
        });
    }

    #[inline(always)]
    fn own<const GRADIENT: bool, const TENSOR: bool>(&self, i: usize) -> Own<'_> {
        let gradients = self.gradients;
        Own {
            record: &self.fluid[i],
            density_gradient: if GRADIENT { gradients.density[i] } else { [0.0; 2] },
            tensor: if TENSOR { gradients.tensor[i] } else { [0.0; 4] },
            correction: if self.model.passes.correction { gradients.correction[i] } else { IDENTITY },
        }
    }

    /// Sums of particle `i` over the wall particles for which `include` says so.
    ///
    /// A wall takes ∇ρ, L and damper of the particle, and its viscous stress, mirrored where it slips.
    #[inline(always)]
    fn wall_sums<G: Geometry, const GRADIENT: bool, const TENSOR: bool>(
        &self,
        geometry: G,
        i: usize,
        own: &Own,
        include: impl Fn(usize) -> bool,
    ) -> PairSums<GRADIENT, TENSOR> {
        let mut sums = PairSums::default();
        let gradient = own.density_gradient.map(Lanes::splat);
        let damper = Lanes::splat(self.damper(i));
        for_each_batch(self.lists.walls.of(i), |indices, count| {
            let mut batch = Batch::gather(geometry, own.record, &self.walls.records, indices, count);
            let included = gather(indices, |w| [f64::from(u8::from(include(w)))]);
            batch.volume = batch.volume * included[0];
            batch.pressure += damper;
            let tensor =
                if TENSOR { gather(indices, |w| self.wall_tensor(i, w)) } else { Default::default() };
            let friction = if self.model.law.viscous {
                let viscosity = Lanes::splat(2.0 * self.gradients.viscosity[i]);
                Friction { viscosity, slip: self.resisted(indices, &batch) }
            } else {
                Friction::default()
            };
            sums.add(&self.model.law, own, &batch, gradient, tensor, friction);
        });
        sums
    }

    /// q of the acoustic damper of particle `i` \[Pa\].
    fn damper(&self, i: usize) -> f64 {
        if self.model.passes.damper { self.gradients.damper[i] } else { 0.0 }
    }

    /// The part of the velocity relative to walls that viscosity resists: all of it, or where they slip that along
    /// their normal.
    #[inline(always)]
    fn resisted(&self, indices: [u32; LANES], batch: &Batch) -> [Lanes; 2] {
        let [n_x, n_y] = gather(indices, |w| self.walls.field.mirror_normal[w].into());
        let slips = n_x * n_x + n_y * n_y;
        let across = batch.v_x * n_x + batch.v_y * n_y;
        let along = Lanes::splat(1.0) - slips;
        [along * batch.v_x + across * n_x, along * batch.v_y + across * n_y]
    }

    fn wall_tensor(&self, i: usize, w: usize) -> Matrix {
        let normal = &self.walls.field.mirror_normal[w];
        let stress = mirrored_stress(&self.gradients.viscous_stress[i], [normal.x, normal.y]);
        let passes = self.model.passes;
        let correction = if passes.momentum_correction { self.gradients.correction[i] } else { IDENTITY };
        momentum_tensor(self.walls.records[w].pressure + self.damper(i), &stress, &correction)
    }

    /// Repulsion \[m/s²\] of particle `i` by the faces of the walls for which `include` says so.
    ///
    /// ```text
    /// a = Σ_w (1 − |t_w|/Δx)₊ · a(z_w, v_n) · n_w
    /// ```
    /// a is [`sph::repulsion::Repulsion`], v_n the normal velocity relative to the wall, z_w the height over a particle
    /// w of the first layer, half a spacing behind the face, and t_w the distance beside it. The weights add up to one
    /// along a face, so that it is smooth; a particle at rest on the lattice (z = Δx) feels nothing. The pair forces
    /// vanish where a particle meets a wall particle, so that they alone can not hold a particle that has been pressed
    /// into the layer.
    fn wall_repulsion<G: Geometry>(&self, geometry: G, i: usize, include: impl Fn(usize) -> bool) -> Vector {
        let Self { model, fluid, walls, .. } = self;
        if !model.wall_repulsion.acts() {
            return Vector::zeros();
        }
        let spacing = model.constants.particle_spacing;
        let velocity = Vector::new(fluid[i].v_x, fluid[i].v_y);
        let mut acceleration = Vector::zeros();
        for &w in self.lists.walls.of(i) {
            let w = w as usize;
            // A wall particle without volume does not act.
            if !model.walls.first_layer[w] || walls.records[w].volume == 0.0 || !include(w) {
                continue;
            }
            let [x, y] = geometry.separation(&fluid[i], &walls.records[w]);
            let d = Vector::new(x, y);
            let normal = &walls.field.face_normal[w];
            let height = d.dot(normal);
            let beside = (d - normal * height).norm() / spacing;
            // Deeper than a layer it is the next face that counts, such as the far side of a thin wall.
            if height >= model.wall_repulsion.distance() || height < -spacing || beside >= 1.0 {
                continue;
            }
            let leaving = (velocity - walls.field.velocity[w]).dot(normal);
            let repulsion = model.wall_repulsion.acceleration(height, leaving);
            acceleration += normal * ((1.0 - beside) * repulsion);
        }
        acceleration
    }

    /// Force of the fluid on wall `wall` (index) \[N/m\].
    pub fn wall_force<G: Geometry>(&self, geometry: G, wall: u32) -> Vector {
        let part_of_wall = |w: usize| self.model.walls.wall[w] == wall;
        let force = |i: usize| {
            let [x, y] = if self.model.passes.tensor() {
                let own = self.own::<false, true>(i);
                self.wall_sums::<G, false, true>(geometry, i, &own, part_of_wall).stress_divergence()
            } else {
                let own = self.own::<false, false>(i);
                self.wall_sums::<G, false, false>(geometry, i, &own, part_of_wall).stress_divergence()
            };
            let repulsion = self.wall_repulsion(geometry, i, part_of_wall);
            Vector::new(x, y) * self.fluid[i].volume - repulsion * self.state.mass[i]
        };
        sph::sums::ordered_sum(self.fluid.len(), force)
    }
}
